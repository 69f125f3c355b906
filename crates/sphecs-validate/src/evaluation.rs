//! Evaluation of the cases: figures, pages, plots and `report.json`, each case as soon as its runs
//! have ended.

use std::collections::BTreeMap;
use std::path::Path;

use super::case::Case;
use super::case_page;
use super::case_report::{self, CaseResult, FigureResult};
use super::measures::measurement::{Measurement, error_of, names};
use super::measures::{Context, RunResults, evaluate, runs_of};
use super::runner::{CaseRun, FinishedRun};
use super::schema::{CurveFile, ReferenceFile, RunFile, Tier, ValueFile};
use super::verdict::Verdict;
use super::{Conclusion, ValidateError, ValidateOptions, picture, plot};
use sphecs_core::format::duration;
use sphecs_output::disk::write_whole;
use sphecs_output::error::OutputError;

/// Name of the report for programs.
const REPORT: &str = "report.json";

/// Evaluates the cases in their order.
pub(crate) struct Evaluator<'a> {
    cases: &'a [Case],
    runs: &'a [CaseRun<'a>],
    options: &'a ValidateOptions,
    /// Finished runs by index, until their case is evaluated.
    finished: Vec<Option<FinishedRun>>,
    /// Index of the next case.
    next: usize,
    results: Vec<(&'a Case, CaseResult)>,
}

impl<'a> Evaluator<'a> {
    /// Returns the evaluator before the first run has ended.
    pub(crate) fn new(cases: &'a [Case], runs: &'a [CaseRun<'a>], options: &'a ValidateOptions) -> Self {
        let finished = runs.iter().map(|_| None).collect();
        Self { cases, runs, options, finished, next: 0, results: Vec::new() }
    }

    /// Adds a finished run and evaluates the cases that it completes.
    ///
    /// # Errors
    /// [`ValidateError`] when a file cannot be written.
    pub(crate) fn add(&mut self, index: usize, finished: FinishedRun) -> Result<(), ValidateError> {
        let case = &self.cases[self.runs[index].case_index].name;
        let took = finished.line.failure.clone().unwrap_or_else(|| duration(finished.line.wall_time));
        let name = format!("{case}/{}", finished.line.name);
        self.options.console.print(&format!("ran {name:<32} {took}"));
        self.finished[index] = Some(finished);
        self.evaluate_complete_cases()
    }

    /// Evaluates the next cases up to the first with unfinished runs.
    ///
    /// # Errors
    /// [`ValidateError`] when a file cannot be written.
    pub(crate) fn evaluate_complete_cases(&mut self) -> Result<(), ValidateError> {
        while let Some(case) = self.cases.get(self.next) {
            let of_case = |index: &usize| self.runs[*index].case_index == self.next;
            let of_case: Vec<usize> = (0..self.runs.len()).filter(of_case).collect();
            if of_case.iter().any(|&index| self.finished[index].is_none()) {
                break;
            }
            self.next += 1;
            if of_case.is_empty() {
                self.options.console.print(&format!("{}: no runs in this tier\n", case.name));
                continue;
            }
            let result = self.evaluate_case(case, &of_case);
            let page = case_page::page(case, &result, &command(self.options, case));
            write(&self.options.folder.join(format!("{}.md", case.name)), &page)?;
            self.results.push((case, result));
            write(&self.options.folder.join(REPORT), &case_report::json(&self.results))?;
        }
        Ok(())
    }

    /// Measures a case from its runs.
    fn evaluate_case(&mut self, case: &Case, runs: &[usize]) -> CaseResult {
        self.options.console.print(&format!("\n{}: {}", case.name, case.file.title));
        let mut result = CaseResult::default();
        let mut results: BTreeMap<String, Vec<RunResults>> = BTreeMap::new();
        for &index in runs {
            let Some(finished) = self.finished[index].take() else { continue };
            if let Some(found) = finished.results {
                results.entry(self.runs[index].run.name.value.clone()).or_default().push(found);
            }
            result.runs.push(finished.line);
        }
        let mut wanted: Vec<&RunFile> = runs.iter().map(|&index| self.runs[index].run).collect();
        wanted.dedup_by_key(|run| run.name.value.as_str());
        measure(case, &wanted, &results, &mut result, self.options);
        draw(case, &results, &mut result, self.options);
        self.options.console.print("");
        result
    }

    /// Prints and returns the conclusion from all cases.
    pub(crate) fn conclusion(&self) -> Conclusion {
        let missed: Vec<&str> = self
            .results
            .iter()
            .filter(|(_, result)| result.is_missed())
            .map(|(case, _)| case.name.as_str())
            .collect();
        let folder = self.options.folder.display();
        let of_case = |case: &Case| case.file.figures.iter().filter(|figure| figure.must.is_some()).count();
        let measured = |(case, result): &(&Case, CaseResult)| of_case(case) - result.not_measured.len();
        let (all, measured): (usize, usize) =
            (self.cases.iter().map(of_case).sum(), self.results.iter().map(measured).sum());
        let not_measured = match all - measured {
            0 => String::new(),
            count => format!(
                " ({measured} of {all} figures, {count} not measured: their runs are not in this tier or may diverge and did)"
            ),
        };
        self.options.console.print(&if missed.is_empty() {
            format!("all required bands are met{not_measured}; pages and plots are in {folder}")
        } else {
            format!(
                "required bands missed: {}{not_measured}; pages and plots are in {folder}",
                missed.join(", ")
            )
        });
        if missed.is_empty() { Conclusion::Met } else { Conclusion::Missed }
    }
}

/// Returns the command that reproduces the page of a case.
fn command(options: &ValidateOptions, case: &Case) -> String {
    let tier = match options.tier {
        Tier::Quick => " --quick",
        Tier::Usual => "",
        Tier::Full => " --full",
    };
    let name = options.cases.iter().find(|name| name.ends_with(&format!("{}.ron", case.name)));
    format!("sphecs validate{tier} --case {}", name.unwrap_or(&case.name))
}

fn write(path: &Path, text: &str) -> Result<(), OutputError> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(OutputError::io(folder, "make the folder"))?;
    }
    write_whole(path, text.as_bytes())
}

/// Measures the figures of the runs of this tier in their order.
fn measure(
    case: &Case,
    wanted: &[&RunFile],
    runs: &BTreeMap<String, Vec<RunResults>>,
    result: &mut CaseResult,
    options: &ValidateOptions,
) {
    let mut known = case.constants.clone();
    let mut measurements = BTreeMap::new();
    let mut omitted: Vec<&str> = Vec::new();
    let is_present = |run: &&&RunFile| !run.may_fail || runs.contains_key(&run.name.value);
    let present: Vec<&RunFile> = wanted.iter().filter(is_present).copied().collect();
    options.console.print(&case_report::console_head());
    for (index, figure) in case.file.figures.iter().enumerate() {
        let name = &figure.name.value;
        if is_omitted(&figure.value, &present, options.tier, &omitted, &measurements) {
            omitted.push(name);
            if figure.must.is_some() {
                result.not_measured.push(index);
            }
            continue;
        }
        let value =
            evaluate(&figure.value, Context { case, runs, known: &known, measurements: &measurements });
        if let Ok(measurement) = &value {
            known.define(name, measurement.value);
            if let Some(error) = measurement.error {
                known.define(&error_of(name), error);
            }
            measurements.insert(name.clone(), measurement.clone());
        }
        let found = value.as_ref().ok().map(|measurement| measurement.value);
        let verdict = Verdict::on(found, figure.must.as_ref(), figure.goal.as_ref());
        let measured = FigureResult { index, value, verdict };
        options.console.print(&case_report::console_line(figure, &measured));
        result.figures.push(measured);
    }
}

/// Returns true if a figure depends on omitted figures, or on runs or members that this tier or a
/// permitted failure omits.
fn is_omitted(
    value: &ValueFile,
    present: &[&RunFile],
    tier: Tier,
    omitted: &[&str],
    measurements: &BTreeMap<String, Measurement>,
) -> bool {
    let run_of = |name: &str| present.iter().find(|run| run.name.value == name);
    match value {
        ValueFile::Order { figures, .. } => figures.iter().any(|name| omitted.contains(&name.value.as_str())),
        ValueFile::Formula(text) => names(&text.value).any(|word| {
            let figure = word.strip_suffix("_error").unwrap_or(word);
            let without_error = |measurement: &Measurement| figure != word && measurement.error.is_none();
            omitted.contains(&word)
                || figure != word && omitted.contains(&figure)
                || measurements.get(figure).is_some_and(without_error)
        }),
        value => {
            let runs = runs_of(value);
            let needs_members = matches!(value, ValueFile::Profile { reference: ReferenceFile::Members, .. });
            !runs.iter().all(|name| run_of(name).is_some())
                || needs_members
                    && runs.iter().filter_map(|name| run_of(name)).any(|run| run.members(tier).len() < 2)
        }
    }
}

/// Draws the plots and pictures whose runs have results; those that fail are reported on the
/// console.
fn draw(
    case: &Case,
    runs: &BTreeMap<String, Vec<RunResults>>,
    result: &mut CaseResult,
    options: &ValidateOptions,
) {
    let context = Context { case, runs, known: &case.constants, measurements: &BTreeMap::new() };
    let has_results = |curve: &CurveFile| runs.contains_key(&curve.run().value);
    for plot in case.file.plots.iter().filter(|plot| plot.curves.iter().any(has_results)) {
        let name = format!("{}_{}.svg", case.name, plot.name.value);
        match plot::draw(plot, context, &options.folder.join(&name)) {
            Ok(()) => result.plots.push((name, plot.title.clone())),
            Err(reason) => options.console.print(&format!("  no plot {name}: {reason}")),
        }
    }
    for file in case.file.pictures.iter().filter(|file| runs.contains_key(&file.run.value)) {
        let run = options.folder.join(&case.name).join(&file.run.value);
        let stem = format!("{}_{}", case.name, file.name.value);
        for (name, drawn) in picture::draw(file, &run, &options.folder, &stem) {
            match drawn {
                Ok(title) => result.plots.push((name, title)),
                Err(reason) => options.console.print(&format!("  no picture {name}: {reason}")),
            }
        }
    }
}
