//! Faults of a case: repeated and unknown names, formulas that cannot be parsed, scenes with
//! faults.

use std::collections::{HashMap, HashSet};

use super::case::Case;
use super::measures::measurement::error_of;
use super::measures::{FORCES, MONITOR, fields, reference};
use super::picture;
use super::schema::{
    CurveFile, FeatureFile, FieldFile, PictureFile, ReferenceFile, RunFile, ValueFile, WhenFile,
};
use sphecs_scene::expression::Constants;
use sphecs_scene::faults::{Fault, advice};
use sphecs_scene::notation::typed::Spanned;
use sphecs_scene::schema::{Formula, FormulaText, Text};

/// Tolerance of the length of a direction, which must be 1.
const UNIT: f64 = 1e-3;

/// Returns all faults of a case that was parsed.
pub(crate) fn faults(case: &Case) -> Vec<Fault> {
    let file = &case.file;
    let mut check = Check { case, probes: HashMap::new(), bodies: HashMap::new(), faults: Vec::new() };
    check.unique("run", file.runs.iter().map(|run| &run.name));
    check.unique("figure", file.figures.iter().map(|figure| &figure.name));
    let drawings = file.plots.iter().map(|plot| &plot.name);
    check.unique("drawing", drawings.chain(file.pictures.iter().map(|picture| &picture.name)));
    file.runs.iter().for_each(|run| check.scenes(run));
    let mut known: Vec<String> = Vec::new();
    for figure in &file.figures {
        check.value(&figure.value, &known);
        known.extend([figure.name.value.clone(), error_of(&figure.name.value)]);
        if let Some(reason) = Constants::refuses(&figure.name.value) {
            let name = &figure.name;
            check.fault(name, format!("`{}` cannot be the name of a figure: {reason}", name.value));
        }
    }
    file.plots.iter().flat_map(|plot| &plot.curves).for_each(|curve| check.curve(curve));
    file.pictures.iter().for_each(|picture| check.picture(picture));
    check.faults
}

struct Check<'a> {
    case: &'a Case,
    /// Names of the probes in the scene of each run without faults.
    probes: HashMap<&'a str, Vec<String>>,
    /// Names of the bodies with coefficients in the scene of each run without faults.
    bodies: HashMap<&'a str, Vec<String>>,
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
                self.fault(
                    name,
                    format!("two {what}s of the case are named `{}`, names must differ", name.value),
                );
            }
            // Folders and files have this name, so it must not lead out of the run folder.
            let plain = |c: char| c.is_alphanumeric() || " _-+".contains(c);
            if name.value.is_empty() || !name.value.chars().all(plain) {
                let may = "must have only letters, digits, spaces, `_`, `-` and `+`";
                self.fault(name, format!("the name `{}` of a {what} {may}", name.value));
            }
        }
    }

    /// Checks the scenes of a run and of its members.
    fn scenes(&mut self, run: &'a RunFile) {
        for (member, set) in run.members(super::Tier::Full).iter().enumerate() {
            let faults = match self.case.member_scene(run, set) {
                Ok(scene) => {
                    let bodies = scene.bodies.iter().filter(|body| body.reference.is_some());
                    let bodies = bodies.map(|body| body.name.clone());
                    self.bodies.entry(&run.name.value).or_insert_with(|| bodies.collect());
                    let names = scene.output.probes.into_iter().map(|probe| probe.name);
                    self.probes.entry(&run.name.value).or_insert_with(|| names.collect());
                    continue;
                }
                Err(faults) => faults,
            };
            let first = faults.faults().first().map_or(String::new(), ToString::to_string);
            let at = run.again.as_ref().filter(|_| member > 0).map_or(&run.scene, |again| &again.set);
            let name = run.member_name(member);
            self.fault(at, format!("the scene of run `{name}` has faults: {first}"));
            return;
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
        if self.run(run).is_none() {
            return;
        }
        let Some(names) = self.probes.get(run.value.as_str()) else { return };
        if !names.iter().any(|name| fields::matches(&probe.value, name)) {
            let title = format!("run `{}` has no probe `{}`", run.value, probe.value);
            let help = advice(&probe.value, names.iter().map(String::as_str));
            self.faults.push(Fault::new(title, probe.span, "here").help(help));
        }
    }

    fn table_of(&mut self, run: &Text, table: &Text) {
        if table.value != MONITOR && table.value != FORCES {
            self.probe(run, table);
        } else {
            let _is_reported = self.run(run);
        }
    }

    fn body(&mut self, run: &Text, body: &Text) {
        if self.run(run).is_none() {
            return;
        }
        let Some(names) = self.bodies.get(run.value.as_str()) else { return };
        if !names.contains(&body.value) {
            let title = format!("run `{}` has no coefficients of a body `{}`", run.value, body.value);
            let help = advice(&body.value, names.iter().map(String::as_str));
            self.faults.push(Fault::new(title, body.span, "here").help(help));
        }
    }

    fn field(&mut self, field: &FieldFile) {
        let FieldFile::Along(direction) = field else { return };
        let square: f64 = direction.value.iter().map(|component| component.value.powi(2)).sum();
        if !(2..=3).contains(&direction.value.len()) || (square.sqrt() - 1.0).abs() > UNIT {
            let label =
                format!("has length `{:.4}`, must have two or three components and length 1", square.sqrt());
            self.faults.push(Fault::new("a direction is not a unit vector", direction.span, label));
        }
    }

    fn reference(&mut self, reference: &ReferenceFile) {
        match reference {
            ReferenceFile::Formula(formula) => self.formula(formula),
            ReferenceFile::Run(run) => {
                let _is_reported = self.run(run);
            }
            ReferenceFile::Table { file, .. } => {
                if let Err(reason) = self.case.table(&file.value) {
                    self.fault(file, reason);
                }
            }
            _ => {}
        }
    }

    fn formula(&mut self, formula: &Formula) {
        if let FormulaText::Text(text) = &formula.value
            && let Err(fault) = self.case.constants.field(text)
        {
            self.faults.push(fault.into_fault(formula.span, None));
        }
    }

    /// Checks that a run compared with its other members has some.
    fn members(&mut self, run: &Text) {
        let alone = |file: &RunFile| file.members(super::Tier::Full).len() < 2;
        if self.case.file.runs.iter().any(|file| file.name.value == run.value && alone(file)) {
            let title = format!("run `{}` has no other members", run.value);
            self.faults.push(Fault::new(title, run.span, "here").help("add members by `again`"));
        }
    }

    fn feature(&mut self, when: &Spanned<WhenFile>, take: &FeatureFile) {
        let of_many = matches!(take, FeatureFile::Largest | FeatureFile::Smallest);
        if matches!(when.value, WhenFile::Every(..)) && !of_many {
            let label = "must be `At` or `Mean`, which give one profile";
            self.faults.push(Fault::new("a position or a width needs one profile", when.span, label));
        }
        if let FeatureFile::Width(share) = take
            && !(0.0..1.0).contains(&share.value)
        {
            let label = format!("is `{}`, must be at least 0 and below 1", share.value);
            self.faults.push(Fault::new("the fraction of a width is out of bounds", share.span, label));
        }
    }

    fn value(&mut self, value: &ValueFile, known: &[String]) {
        match value {
            ValueFile::Profile { run, probe, field, reference, .. } => {
                self.probe(run, probe);
                self.field(field);
                self.reference(reference);
                if matches!(reference, ReferenceFile::Members) {
                    self.members(run);
                }
            }
            ValueFile::Feature { run, probe, field, when, take, .. } => {
                self.probe(run, probe);
                self.field(field);
                self.feature(when, take);
            }
            ValueFile::Series { run, table, .. } => self.table_of(run, table),
            ValueFile::Signal { run, table, reference, .. } => {
                self.table_of(run, table);
                self.formula(reference);
            }
            ValueFile::TorqueThrough { run, probes, .. } => self.probe(run, probes),
            ValueFile::Body { run, body, .. } => self.body(run, body),
            ValueFile::Departure { run, table, from, .. } => {
                self.table_of(run, table);
                self.table_of(from, table);
            }
            ValueFile::Growth { run, probe, field, .. } => {
                self.probe(run, probe);
                self.field(field);
            }
            ValueFile::Reflection { run, probe, .. } => self.probe(run, probe),
            ValueFile::Order { figures, spacings } => {
                for figure in figures.iter().filter(|figure| !known.contains(&figure.value)) {
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

    fn curve(&mut self, curve: &CurveFile) {
        match curve {
            CurveFile::Profile { run, probe, field, reference, .. } => {
                self.probe(run, probe);
                self.field(field);
                reference.iter().for_each(|reference| self.reference(reference));
            }
            CurveFile::Series { run, table, reference, .. } => {
                self.table_of(run, table);
                let Some(reference) = reference else { return };
                self.reference(reference);
                let has_place = !matches!(table.value.as_str(), MONITOR | FORCES);
                let is_formula = matches!(**reference, ReferenceFile::Formula(_));
                if !(has_place || is_formula) || reference::run_of(reference).is_some() {
                    let title = "the reference of this series cannot be drawn";
                    let help =
                        "a series can have a formula, that of a probe also a table or an exact solution";
                    self.faults.push(Fault::new(title, table.span, "has no place").help(help));
                }
            }
            CurveFile::Distance { run, probe, field, reference, label, .. } => {
                self.probe(run, probe);
                self.field(field);
                self.reference(reference);
                if matches!(**reference, ReferenceFile::Run(_) | ReferenceFile::Members) {
                    let title = format!("the curve `{label}` over time is compared with another run");
                    let help = "two runs have no samples at equal times: give a formula, a table or an exact solution";
                    self.faults.push(Fault::new(title, run.span, "of this one").help(help));
                }
            }
        }
    }

    fn picture(&mut self, picture: &PictureFile) {
        let _is_reported = self.run(&picture.run);
        if let Err(reason) = picture::options(picture) {
            self.fault(&picture.field, reason);
        }
        if let Some((low, high)) = picture.range
            && low.value >= high.value
        {
            let label = format!("is `{}`, must be less than `{}`", low.value, high.value);
            self.faults.push(Fault::new("the range of a picture is not ascending", low.span, label));
        }
        if let Some(width) = picture.width.filter(|width| !(200..=4000).contains(&width.value)) {
            let label = format!("is `{}`, must be from 200 to 4000", width.value);
            self.faults.push(Fault::new("the width of a picture is out of bounds", width.span, label));
        }
    }
}
