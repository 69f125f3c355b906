//! Cases: shipped with the program or read from a file, checked before anything runs.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use include_dir::{Dir, include_dir};

use super::schema::{CaseFile, CurveFile, ReferenceFile, RunFile, ValueFile};
use crate::scene::expression::Constants;
use crate::scene::faults::{Fault, SceneFaults, advice};
use crate::scene::model::Scene;
use crate::scene::notation::{reader, typed};
use crate::scene::schema::{FormulaText, Text};
use crate::scene::{self, constants};

/// The cases with their tables, part of the program.
static CASES: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/assets/validation");
/// The scenes that they run.
static SCENES: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/scenes");

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
    pub fn load(name: &str) -> Result<Self, SceneFaults> {
        let refused = |fault: Fault| SceneFaults::new(name, "", vec![fault]);
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

    fn read(name: &str, text: &str, folder: Option<PathBuf>) -> Result<Self, SceneFaults> {
        let reader::Reading { root, mut faults, lost } = reader::read(text);
        let shown = format!("{name}.ron");
        if lost {
            return Err(SceneFaults::new(&shown, text, faults));
        }
        let constants = constants::read(&root, &mut faults);
        let (file, typed_faults) = typed::read::<CaseFile>(&root, &constants);
        faults.extend(typed_faults);
        let Some(file) = file.filter(|_| faults.is_empty()) else {
            return Err(SceneFaults::new(&shown, text, faults));
        };
        let case = Self { name: name.to_owned(), file, constants, folder };
        let faults = case.check();
        if faults.is_empty() { Ok(case) } else { Err(SceneFaults::new(&shown, text, faults)) }
    }

    /// The scene of a run, with its values put in.
    ///
    /// # Errors
    /// All faults of the scene.
    pub fn scene(&self, run: &RunFile) -> Result<Scene, SceneFaults> {
        let sets: Vec<(String, String)> =
            run.set.iter().map(|(path, value)| (path.value.clone(), value.value.clone())).collect();
        let name = &run.scene.value;
        if let Some(folder) = self.folder.as_ref().filter(|_| name.ends_with(".ron")) {
            return scene::load(&folder.join(name), &sets);
        }
        let file = SCENES.get_file(format!("{name}.ron"));
        match file.and_then(|file| file.contents_utf8()) {
            Some(text) => scene::load_str(name, text, &sets),
            None => {
                let known = SCENES.files().filter_map(|file| file.path().file_stem()?.to_str());
                let fault = Fault::placeless(format!("there is no scene `{name}`"))
                    .help(advice(name, known.collect::<Vec<_>>()));
                Err(SceneFaults::new(name, "", vec![fault]))
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

    /// Names that are given twice or not at all, formulas that do not read, scenes with faults.
    fn check(&self) -> Vec<Fault> {
        let mut check = Check { case: self, faults: Vec::new() };
        check.unique("run", self.file.runs.iter().map(|run| &run.name));
        check.unique("figure", self.file.figures.iter().map(|figure| &figure.name));
        check.unique("plot", self.file.plots.iter().map(|plot| &plot.name));
        for run in &self.file.runs {
            if let Err(faults) = self.scene(run) {
                let first = faults.faults().first().map_or(String::new(), ToString::to_string);
                check.fault(
                    &run.scene,
                    format!("the scene of run `{}` does not read: {first}", run.name.value),
                );
            }
        }
        let mut known: Vec<&str> = Vec::new();
        for figure in &self.file.figures {
            check.value(&figure.value, &known);
            known.push(&figure.name.value);
            if let Some(reason) = Constants::refuses(&figure.name.value) {
                check.fault(
                    &figure.name,
                    format!("`{}` cannot be the name of a figure: {reason}", figure.name.value),
                );
            }
        }
        for curve in self.file.plots.iter().flat_map(|plot| &plot.curves) {
            match curve {
                CurveFile::Profile { run, probe, reference, .. } => {
                    check.probe(run, probe);
                    reference.iter().for_each(|reference| check.reference(reference));
                }
                CurveFile::Series { run, table, .. } => check.table_of(run, table),
            }
        }
        check.faults
    }
}

struct Check<'a> {
    case: &'a Case,
    faults: Vec<Fault>,
}

impl<'a> Check<'a> {
    fn fault(&mut self, at: &Text, title: String) {
        self.faults.push(Fault::new(title, at.span, "here"));
    }

    fn unique(&mut self, what: &str, names: impl Iterator<Item = &'a Text>) {
        let mut seen = HashSet::new();
        for name in names {
            if !seen.insert(&name.value) {
                self.fault(name, format!("two of the case's {what}s are called `{}`", name.value));
            }
            // Folders and files are named by it: it must not lead out of theirs.
            let plain = |c: char| c.is_alphanumeric() || " _-+".contains(c);
            if name.value.is_empty() || !name.value.chars().all(plain) {
                let may = "may have letters, digits, spaces, `_`, `-` and `+`";
                self.fault(name, format!("the name `{}` of a {what} {may}", name.value));
            }
        }
    }

    fn run(&mut self, name: &Text) -> Option<&'a RunFile> {
        let runs = &self.case.file.runs;
        let found = runs.iter().find(|run| run.name.value == name.value);
        if found.is_none() {
            let help = advice(&name.value, runs.iter().map(|run| run.name.value.as_str()));
            let title = format!("there is no run `{}`", name.value);
            self.faults.push(Fault::new(title, name.span, "here").help(help));
        }
        found
    }

    fn probe(&mut self, run: &Text, probe: &Text) {
        let Some(Ok(scene)) = self.run(run).map(|run| self.case.scene(run)) else { return };
        let names: Vec<&str> = scene.output.probes.iter().map(|probe| probe.name.as_str()).collect();
        if !names.contains(&probe.value.as_str()) {
            let title = format!("run `{}` has no probe `{}`", run.value, probe.value);
            let help = advice(&probe.value, names);
            self.faults.push(Fault::new(title, probe.span, "here").help(help));
        }
    }

    fn table_of(&mut self, run: &Text, table: &Text) {
        if table.value != super::value::MONITOR {
            self.probe(run, table);
        } else {
            let _faults_are_noted = self.run(run);
        }
    }

    fn reference(&mut self, reference: &ReferenceFile) {
        match reference {
            ReferenceFile::Formula(formula) => {
                if let FormulaText::Text(text) = &formula.value
                    && let Err(fault) = self.case.constants.field(text)
                {
                    self.faults.push(fault.into_fault(formula.span, None));
                }
            }
            ReferenceFile::Run(run) => {
                let _faults_are_noted = self.run(run);
            }
            ReferenceFile::Table { file, .. } => {
                if let Err(reason) = self.case.table(&file.value) {
                    self.fault(file, reason);
                }
            }
            _ => {}
        }
    }

    fn value(&mut self, value: &ValueFile, known: &[&str]) {
        match value {
            ValueFile::Profile { run, probe, reference, .. } => {
                self.probe(run, probe);
                self.reference(reference);
            }
            ValueFile::Series { run, table, .. } => self.table_of(run, table),
            ValueFile::Growth { run, probe, .. } | ValueFile::Reflection { run, probe, .. } => {
                self.probe(run, probe);
            }
            ValueFile::Order { figures, spacings } => {
                for figure in figures.iter().filter(|figure| !known.contains(&figure.value.as_str())) {
                    self.fault(figure, format!("there is no figure `{}` before this one", figure.value));
                }
                if let Some(first) = figures.first().filter(|_| figures.len() != spacings.len()) {
                    self.fault(first, "an order needs as many spacings as figures".to_owned());
                }
            }
            ValueFile::Formula(text) => {
                let mut constants = self.case.constants.clone();
                known.iter().for_each(|name| constants.define(name, 1.0));
                if let Err(fault) = constants.number(&text.value) {
                    self.faults.push(fault.into_fault(text.span, None));
                }
            }
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
}
