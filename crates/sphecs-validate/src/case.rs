//! Cases: shipped with the program or read from a file, checked before anything runs.

use std::path::{Path, PathBuf};

use include_dir::{Dir, include_dir};

use super::check;
use super::schema::{CaseFile, RunFile, Tier};
use sphecs_run::memory;
use sphecs_scene::constants;
use sphecs_scene::expression::Constants;
use sphecs_scene::faults::{Fault, SceneErrors, advice};
use sphecs_scene::model::Scene;
use sphecs_scene::notation::{reader, typed};

/// The cases with their tables, part of the program.
static CASES: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/../../assets/validation");
/// The scenes that they run.
static SCENES: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/../../scenes");

/// A checked case.
#[derive(Clone, Debug)]
pub struct Case {
    /// Name: stem of its file.
    pub name: String,
    /// What stands in the file.
    pub file: CaseFile,
    /// Its constants.
    pub constants: Constants,
    /// Folder of its scenes and tables; None for a shipped case.
    folder: Option<PathBuf>,
}

/// Names of the shipped cases, sorted.
pub fn shipped() -> Vec<String> {
    let ron = CASES.files().filter(|file| file.path().extension().is_some_and(|found| found == "ron"));
    let mut names: Vec<String> =
        ron.filter_map(|file| Some(file.path().file_stem()?.to_str()?.to_owned())).collect();
    names.sort();
    names
}

impl Case {
    /// The case of a name, or of a path that ends in `.ron`.
    ///
    /// # Errors
    /// All faults of the case, those of its scenes too.
    pub fn load(name: &str) -> Result<Self, SceneErrors> {
        let refused = |fault: Fault| SceneErrors::new(name, "", vec![fault]);
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

    fn read(name: &str, text: &str, folder: Option<PathBuf>) -> Result<Self, SceneErrors> {
        let reader::Reading { root, mut faults, lost } = reader::read(text);
        let shown = format!("{name}.ron");
        if lost {
            return Err(SceneErrors::new(&shown, text, faults));
        }
        let constants = constants::read(&root, &mut faults);
        let (file, typed_faults) = typed::read::<CaseFile>(&root, &constants);
        faults.extend(typed_faults);
        let Some(file) = file.filter(|_| faults.is_empty()) else {
            return Err(SceneErrors::new(&shown, text, faults));
        };
        let case = Self { name: name.to_owned(), file, constants, folder };
        let faults = check::faults(&case);
        if faults.is_empty() { Ok(case) } else { Err(SceneErrors::new(&shown, text, faults)) }
    }

    /// The scene of a run, with its values put in.
    ///
    /// # Errors
    /// All faults of the scene.
    pub fn scene(&self, run: &RunFile) -> Result<Scene, SceneErrors> {
        self.member_scene(run, &run.members(Tier::Quick)[0])
    }

    /// The scene of a run, with the values of one of its members put in.
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
            Some(text) => Scene::from_text(name, text).sets(sets).memory(memory::available()).load(),
            None => {
                let known = SCENES.files().filter_map(|file| file.path().file_stem()?.to_str());
                let fault = Fault::placeless(format!("there is no scene `{name}`"))
                    .help(advice(name, known.collect::<Vec<_>>()));
                Err(SceneErrors::new(name, "", vec![fault]))
            }
        }
    }

    /// The text of a table beside the case.
    ///
    /// # Errors
    /// Why it cannot be read.
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
    use super::*;

    #[test]
    fn shipped_cases_have_no_faults() {
        assert!(!shipped().is_empty());
        for name in shipped() {
            if let Err(faults) = Case::load(&name) {
                panic!("{name}: {:#?}", faults.faults());
            }
        }
    }

    #[test]
    fn faults_of_a_case_are_all_named() {
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
        for words in [
            "called `a`",
            "no scene `nowhere`",
            "no run `b`",
            "no probe `acros`",
            "as many spacings",
            "`sin`",
        ] {
            assert!(titles.iter().any(|title| title.contains(words)), "nothing about {words} in {titles:#?}");
        }
        assert_eq!(titles.len(), 8, "{titles:#?}");
    }

    #[test]
    fn faults_of_ensembles_features_and_pictures_are_named() {
        let text = r#"Case(
            title: "", source: "", setting: "",
            runs: [
                (name: "a", scene: "poiseuille", again: (set: "constants.nothing", to: ["1"])),
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
            "run `a.2` does not read",
            "no probe `nowhere*`",
            "no other members",
            "no unit vector",
            "asked of many profiles",
            "share of a width",
            "no coefficients of a body `cylinder`",
            "held against another run",
            "drawings are called `p`",
            "`sped` is not a field",
            "does not rise",
            "width of a picture",
        ] {
            assert!(titles.iter().any(|title| title.contains(words)), "nothing about {words} in {titles:#?}");
        }
        assert_eq!(titles.len(), 12, "{titles:#?}");
    }
}
