//! Validation cases, shipped with the program or read from a file, and checked before the first
//! run.

use std::path::{Path, PathBuf};

use include_dir::{Dir, include_dir};
use miette::Diagnostic;

use super::check;
use super::schema::{CaseFile, RunFile, Tier};
use sphecs_run::memory;
use sphecs_scene::constants;
use sphecs_scene::expression::Constants;
use sphecs_scene::faults::{Fault, SceneErrors, advice};
use sphecs_scene::meshes::MeshFile;
use sphecs_scene::model::Scene;
use sphecs_scene::notation::{reader, typed};

/// Shipped cases with their tables, part of the program.
static CASES: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/../../assets/validation");
/// Scenes of the shipped cases, part of the program.
static SCENES: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/../../scenes");

/// Checked case.
#[derive(Clone, Debug)]
pub struct Case {
    /// Name, the stem of its file.
    pub name: String,
    /// Contents of the file.
    pub file: CaseFile,
    /// Constants.
    pub constants: Constants,
    /// Folder of its scenes and tables; None for a shipped case.
    folder: Option<PathBuf>,
}

/// Faults of a case file, with their places.
#[derive(Debug, thiserror::Error, Diagnostic)]
#[error(transparent)]
#[diagnostic(transparent)]
pub struct CaseFaults(SceneErrors);

impl CaseFaults {
    fn new(name: &str, text: &str, faults: Vec<Fault>) -> Self {
        Self(SceneErrors::new(name, text, faults))
    }

    /// Returns the faults in the order of the text.
    pub fn faults(&self) -> &[Fault] {
        self.0.faults()
    }
}

/// Returns the names of the shipped cases, sorted.
pub fn shipped() -> Vec<String> {
    let ron = CASES.files().filter(|file| file.path().extension().is_some_and(|found| found == "ron"));
    let mut names: Vec<String> =
        ron.filter_map(|file| Some(file.path().file_stem()?.to_str()?.to_owned())).collect();
    names.sort();
    names
}

/// Returns name and title of each shipped case, without checking its scenes.
///
/// # Errors
/// All faults of the text of a case.
pub fn titles() -> Result<Vec<(String, String)>, CaseFaults> {
    let titled = |name: String| shipped_text(&name).map(|case| (name, case.file.title));
    shipped().into_iter().map(titled).collect()
}

/// Returns a shipped case without checking its scenes.
///
/// # Errors
/// All faults of its text.
pub(crate) fn shipped_text(name: &str) -> Result<Case, CaseFaults> {
    let file = CASES.get_file(format!("{name}.ron"));
    let text = file.and_then(|file| file.contents_utf8()).unwrap_or_default();
    Case::parse(name, text, None)
}

/// Returns the shipped files of meshes and outlines that the text of a scene names.
fn shipped_meshes(text: &str) -> impl Iterator<Item = MeshFile> {
    let folder = SCENES.get_dir("meshes").map_or(&[][..], |folder| folder.entries());
    let files = folder.iter().filter_map(|entry| entry.as_file());
    files.filter_map(move |file| {
        let path = file.path().to_str()?.to_owned();
        text.contains(&path).then(|| MeshFile { path, bytes: file.contents().into() })
    })
}

impl Case {
    /// Returns the case of a name, or of a path that ends in `.ron`.
    ///
    /// # Errors
    /// All faults of the case and of its scenes.
    pub fn load(name: &str) -> Result<Self, CaseFaults> {
        let refused = |fault: Fault| CaseFaults::new(name, "", vec![fault]);
        if let Some(stem) = name.strip_suffix(".ron") {
            let path = Path::new(name);
            let text = std::fs::read_to_string(path)
                .map_err(|error| refused(Fault::placeless(format!("{name}: {error}"))))?;
            let stem = Path::new(stem).file_name().map_or("case".into(), |stem| stem.to_string_lossy());
            let folder = path.parent().unwrap_or(Path::new(".")).to_path_buf();
            return Self::read(&stem, &text, Some(folder));
        }
        let file = CASES.get_file(format!("{name}.ron"));
        let Some(text) = file.and_then(|file| file.contents_utf8()) else {
            let names = shipped();
            let fault = Fault::placeless(format!("there is no case `{name}`"))
                .help(advice(name, names.iter().map(String::as_str)));
            return Err(refused(fault));
        };
        Self::read(name, text, None)
    }

    /// Returns the case of a text; `folder` has its scenes and tables.
    ///
    /// # Errors
    /// All faults of the case and of its scenes.
    pub(crate) fn read(name: &str, text: &str, folder: Option<PathBuf>) -> Result<Self, CaseFaults> {
        let case = Self::parse(name, text, folder)?;
        let faults = check::faults(&case);
        if faults.is_empty() { Ok(case) } else { Err(CaseFaults::new(&format!("{name}.ron"), text, faults)) }
    }

    /// Returns the case of a text, neither its figures nor its scenes checked.
    fn parse(name: &str, text: &str, folder: Option<PathBuf>) -> Result<Self, CaseFaults> {
        let reader::Parsed { root, mut faults, unbalanced } = reader::read(text);
        let shown = format!("{name}.ron");
        if unbalanced {
            return Err(CaseFaults::new(&shown, text, faults));
        }
        let constants = constants::read(&root, &mut faults);
        let (file, typed_faults) = typed::read::<CaseFile>(&root, &constants);
        faults.extend(typed_faults);
        let Some(file) = file.filter(|_| faults.is_empty()) else {
            return Err(CaseFaults::new(&shown, text, faults));
        };
        Ok(Self { name: name.to_owned(), file, constants, folder })
    }

    /// Returns the scene of a run with its values applied.
    ///
    /// # Errors
    /// All faults of the scene.
    pub fn scene(&self, run: &RunFile) -> Result<Scene, SceneErrors> {
        self.member_scene(run, &run.members(Tier::Quick)[0])
    }

    /// Returns the scene of a run with the values of one of its members applied.
    ///
    /// # Errors
    /// All faults of the scene.
    pub fn member_scene(&self, run: &RunFile, sets: &[(String, String)]) -> Result<Scene, SceneErrors> {
        let name = &run.scene.value;
        if let Some(folder) = self.folder.as_ref().filter(|_| name.ends_with(".ron")) {
            return Scene::from_file(folder.join(name)).sets(sets).memory(memory::available()).load();
        }
        let file = SCENES.get_file(format!("{name}.ron"));
        match file.and_then(|file| file.contents_utf8()) {
            Some(text) => {
                let scene = Scene::from_text(name, text).meshes(shipped_meshes(text));
                scene.sets(sets).memory(memory::available()).load()
            }
            None => {
                let known = SCENES.files().filter_map(|file| file.path().file_stem()?.to_str());
                let fault = Fault::placeless(format!("there is no scene `{name}`"))
                    .help(advice(name, known.collect::<Vec<_>>()));
                Err(SceneErrors::new(name, "", vec![fault]))
            }
        }
    }

    /// Returns the text of a table in the folder of the case.
    ///
    /// # Errors
    /// Reason why it cannot be read.
    pub fn table(&self, name: &str) -> Result<String, String> {
        match &self.folder {
            Some(folder) => {
                std::fs::read_to_string(folder.join(name)).map_err(|error| format!("{name}: {error}"))
            }
            None => CASES
                .get_file(name)
                .and_then(|file| file.contents_utf8())
                .map(str::to_owned)
                .ok_or_else(|| format!("there is no table `{name}`")),
        }
    }
}

#[cfg(test)]
mod tests {
    use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

    use super::*;

    #[test]
    fn shipped_cases_have_no_faults() {
        assert!(!shipped().is_empty());
        // Several at once: not all parts of filling a domain are parallel.
        let fault = |name: &String| Some(format!("{name}: {:#?}", Case::load(name).err()?.faults()));
        let faults: Vec<String> = shipped().par_iter().filter_map(fault).collect();
        assert!(faults.is_empty(), "{}", faults.join("\n"));
    }

    #[test]
    fn all_faults_of_a_case_are_reported() {
        let text = r#"Case(
            title: "", source: "", setting: "",
            runs: [(name: "a", scene: "poiseuille"), (name: "a", scene: "nowhere")],
            figures: [
                (name: "first", what: "", value: Profile(
                    run: "b", probe: "across", field: u, when: At(0.1), reference: Formula("q"), norm: Largest)),
                (name: "second", what: "", value: Profile(
                    run: "a", probe: "acros", field: u, when: At(0.1), reference: Formula(0.0), norm: Largest)),
                (name: "third", what: "", value: Formula("first + later")),
                (name: "sin", what: "", value: Order(figures: ["first"], spacings: [1.0, 2.0])),
            ],
        )"#;
        let faults = Case::read("bad", text, None).expect_err("faults");
        let titles: Vec<String> = faults.faults().iter().map(ToString::to_string).collect();
        for words in
            ["named `a`", "no scene `nowhere`", "no run `b`", "no probe `acros`", "as many spacings", "`sin`"]
        {
            assert!(
                titles.iter().any(|title| title.contains(words)),
                "no fault about {words} in {titles:#?}"
            );
        }
        assert_eq!(titles.len(), 8, "{titles:#?}");
    }

    #[test]
    fn faults_of_ensembles_features_and_pictures_are_reported() {
        let text = r#"Case(
            title: "", source: "", setting: "",
            runs: [
                (name: "a", scene: "poiseuille", again: (set: "fluid.nothing", to: ["1"])),
                (name: "b", scene: "poiseuille"),
            ],
            figures: [
                (name: "first", what: "", value: Profile(
                    run: "b", probe: "nowhere*", field: u, when: At(0.1), reference: Members, norm: Largest)),
                (name: "second", what: "", value: Feature(
                    run: "b", probe: "acr*", field: Along((1.0, 1.0)), when: Every(0.0, 1.0), take: PlaceOfLargest)),
                (name: "third", what: "", value: Feature(
                    run: "b", probe: "across", field: speed, when: At(0.1), take: Width(1.5))),
                (name: "fourth", what: "", value: Formula("second/second_error")),
                (name: "fifth", what: "", value: Body(run: "b", body: "cylinder", take: Strouhal)),
            ],
            plots: [(name: "p", title: "", across: "", upward: "", curves: [
                Distance(run: "b", probe: "across", field: v, reference: Run("a"), norm: Largest, label: "b"),
            ])],
            pictures: [(name: "p", title: "", run: "b", field: "sped", times: [1.0], range: (2.0, 1.0), width: 10)],
        )"#;
        let faults = Case::read("bad", text, None).expect_err("faults");
        let titles: Vec<String> = faults.faults().iter().map(ToString::to_string).collect();
        for words in [
            "run `a.2` has faults",
            "no probe `nowhere*`",
            "no other members",
            "not a unit vector",
            "needs one profile",
            "fraction of a width",
            "no coefficients of a body `cylinder`",
            "compared with another run",
            "drawings of the case are named `p`",
            "`sped` is not a field",
            "is not ascending",
            "width of a picture",
        ] {
            assert!(
                titles.iter().any(|title| title.contains(words)),
                "no fault about {words} in {titles:#?}"
            );
        }
        assert_eq!(titles.len(), 12, "{titles:#?}");
    }
}
