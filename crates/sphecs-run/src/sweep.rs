//! Sweep over values of a scene: one run for each combination of values, in one folder.
//!
//! ```text
//! runs/my_sweep/sweep.csv                    a line for each run: its folder and its values
//! runs/my_sweep/spacing-0.002_viscosity-1e-5/
//! ```
//!
//! The name of a run follows from its values alone, so that a sweep may get more values later. Runs
//! that are complete are used again, stopped ones are resumed.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use miette::Diagnostic;

use super::Ending;
use super::concurrent::{make_run, on_all_threads};
use super::console::Console;
use super::error::RunError;
use super::signals::Signal;
use sphecs_output::disk;
use sphecs_output::error::OutputError;
use sphecs_scene::faults::SceneErrors;
use sphecs_scene::model::Scene;

/// Name of the index in the folder of a sweep.
pub const INDEX: &str = "sweep.csv";

/// Largest number of runs of a sweep.
const MOST_RUNS: usize = 10_000;

/// Values of one path of the scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SweepAxis {
    /// Path, as `fluid.viscosity`.
    pub path: String,
    /// Values, as text of the scene file.
    pub values: Vec<String>,
}

/// Scene and the values of its runs.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// Scene file.
    pub scene: PathBuf,
    /// True for the scene's coarse smoke spacing.
    pub smoke: bool,
    /// Changes that all runs have.
    pub sets: Vec<(String, String)>,
    /// Values that are combined; the last axis changes fastest.
    pub axes: Vec<SweepAxis>,
    /// Folder of the runs.
    pub folder: PathBuf,
    /// Number of threads; None: one for each core.
    pub threads: Option<usize>,
    /// Index of the only run to make; None: all.
    pub only: Option<usize>,
    /// False to make complete runs again.
    pub reuse: bool,
    /// Memory limit of a run, B; None for no limit.
    pub memory: Option<f64>,
    /// Amount of text on standard output.
    pub console: Console,
}

/// Run of a sweep.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SweepRun {
    /// Name of its folder.
    pub name: String,
    /// Value of each axis.
    pub values: Vec<String>,
}

/// Numbers of runs that have ended.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SweepEnd {
    /// Runs that are complete.
    pub completed: usize,
    /// Names of the runs whose flow diverged.
    pub diverged: Vec<String>,
    /// Signal that stopped the sweep.
    pub signal: Option<Signal>,
}

/// Run whose scene has faults.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FaultyRun {
    /// Name.
    pub name: String,
    /// Number of other runs with faults, in words.
    pub others: String,
}

/// Sweep that was stopped by an error.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub enum SweepError {
    /// The scene of a run has faults.
    #[error("run `{}`{}", run.name, run.others)]
    Scene {
        /// The run.
        run: Box<FaultyRun>,
        /// The faults.
        #[source]
        #[diagnostic_source]
        errors: SceneErrors,
    },
    /// A run could not be made.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Run(#[from] RunError),
    /// The sweep cannot be made as it is, or its index cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

impl Sweep {
    /// Returns the runs in the order of their indices.
    ///
    /// # Errors
    /// [`SweepError::Output`] for too many runs, for a path that is given twice, and for two runs
    /// with the same name.
    pub fn runs(&self) -> Result<Vec<SweepRun>, SweepError> {
        let count = self.axes.iter().try_fold(1_usize, |count, axis| count.checked_mul(axis.values.len()));
        let count = count.filter(|&count| (1..=MOST_RUNS).contains(&count));
        let count = count.ok_or_else(|| refused(format!("a sweep has from 1 to {MOST_RUNS} runs")))?;
        for (index, axis) in self.axes.iter().enumerate() {
            if self.axes[..index].iter().any(|other| other.path == axis.path) {
                return Err(refused(format!(
                    "`--grid {}` is given twice: give all values at once",
                    axis.path
                )));
            }
        }
        let runs: Vec<SweepRun> = (0..count).map(|index| self.run(index)).collect();
        for (index, run) in runs.iter().enumerate() {
            if let Some(other) = runs[..index].iter().find(|other| other.name == run.name) {
                let values = |run: &SweepRun| run.values.join(", ");
                return Err(refused(format!(
                    "the values ({}) and ({}) would have the same folder, `{}`: leave out one of them",
                    values(other),
                    values(run),
                    run.name
                )));
            }
        }
        Ok(runs)
    }

    /// Returns the run of an index.
    fn run(&self, mut index: usize) -> SweepRun {
        let mut values = Vec::new();
        for axis in self.axes.iter().rev() {
            values.push(axis.values[index % axis.values.len()].clone());
            index /= axis.values.len();
        }
        values.reverse();
        let part = |(axis, value): (&SweepAxis, &String)| format!("{}-{}", self.label(axis), in_name(value));
        let name = self.axes.iter().zip(&values).map(part).collect::<Vec<_>>().join("_");
        SweepRun { name, values }
    }

    /// Returns the last part of a path, or all of it if another axis has the same.
    fn label(&self, axis: &SweepAxis) -> String {
        let last = |path: &str| path.rsplit('.').next().unwrap_or_default().to_owned();
        let is_taken =
            self.axes.iter().any(|other| other.path != axis.path && last(&other.path) == last(&axis.path));
        if is_taken { axis.path.clone() } else { last(&axis.path) }
    }

    /// Returns the changes of the scene of a run.
    fn sets(&self, run: &SweepRun) -> Vec<(String, String)> {
        let of_axes =
            self.axes.iter().zip(&run.values).map(|(axis, value)| (axis.path.clone(), value.clone()));
        self.sets.iter().cloned().chain(of_axes).collect()
    }

    fn load(&self, run: &SweepRun) -> Result<Scene, SceneErrors> {
        let loader = Scene::from_file(&self.scene).sets(self.sets(run)).memory(self.memory);
        if self.smoke { loader.smoke().load() } else { loader.load() }
    }

    /// Makes the runs, several at once, and writes the index before the first.
    ///
    /// # Errors
    /// [`SweepError`]; with faults in any scene nothing is written.
    pub fn make(&self) -> Result<SweepEnd, SweepError> {
        let all = self.runs()?;
        let runs = match self.only {
            None => all.as_slice(),
            Some(index) => all.get(index..=index).ok_or_else(|| {
                refused(format!("`--only {index}`: the runs have the indices 0 to {}", all.len() - 1))
            })?,
        };
        self.check(runs)?;
        self.write_index(&all)?;
        let ended = std::sync::Mutex::new(SweepEnd::default());
        let record = |change: &dyn Fn(&mut SweepEnd)| {
            change(&mut ended.lock().unwrap_or_else(std::sync::PoisonError::into_inner));
        };
        let signal = on_all_threads(runs.len(), self.threads, |index, signals| {
            let (run, started) = (&runs[index], Instant::now());
            let scene = self.load(run).map_err(|errors| faulty(run, 0, errors))?;
            let folder = self.folder.join(&run.name);
            let took = || format!("{:.1} s", started.elapsed().as_secs_f64());
            match make_run(scene, &folder, self.reuse, signals) {
                Ok(Ending::Stopped(_)) => {}
                Ok(Ending::Completed | Ending::OutOfTime) => {
                    self.console.print(&format!("completed {:<40} {}", run.name, took()));
                    record(&|end| end.completed += 1);
                }
                Err(RunError::Flow { stop, .. }) => {
                    self.console.print(&format!("diverged  {:<40} {}: {stop}", run.name, took()));
                    record(&|end| end.diverged.push(run.name.clone()));
                }
                Err(error) => return Err(SweepError::from(error)),
            }
            Ok(())
        })?;
        let mut end = ended.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
        end.diverged.sort();
        Ok(SweepEnd { signal, ..end })
    }

    /// Checks the scenes of all runs before the first.
    fn check(&self, runs: &[SweepRun]) -> Result<(), SweepError> {
        let mut faults = runs.iter().filter_map(|run| self.load(run).err().map(|errors| (run, errors)));
        match faults.next() {
            Some((run, errors)) => Err(faulty(run, faults.count(), errors)),
            None => Ok(()),
        }
    }

    /// Writes a line for each run: its folder and its values.
    fn write_index(&self, runs: &[SweepRun]) -> Result<(), SweepError> {
        let mut text = "run".to_owned();
        for axis in &self.axes {
            let _infallible = write!(text, ",{}", quoted(&axis.path));
        }
        text.push('\n');
        for run in runs {
            text.push_str(&quoted(&run.name));
            for value in &run.values {
                let _infallible = write!(text, ",{}", quoted(value));
            }
            text.push('\n');
        }
        std::fs::create_dir_all(&self.folder).map_err(OutputError::io(&self.folder, "make the folder"))?;
        Ok(disk::write_whole(&self.folder.join(INDEX), text.as_bytes())?)
    }
}

fn refused(what: String) -> SweepError {
    OutputError::Request(what).into()
}

fn faulty(run: &SweepRun, others: usize, errors: SceneErrors) -> SweepError {
    let others = match others {
        0 => String::new(),
        1 => ", and one more run has faults".to_owned(),
        more => format!(", and {more} more runs have faults"),
    };
    SweepError::Scene { run: Box::new(FaultyRun { name: run.name.clone(), others }), errors }
}

/// Returns a field of a CSV file.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}

/// Longest value in the name of a run, characters.
const LONGEST: usize = 40;

/// Returns a value with the characters that a name of a folder may have without quotes in a shell.
fn in_name(value: &str) -> String {
    let kept = value.chars().filter(|letter| letter.is_ascii_alphanumeric() || "+-.".contains(*letter));
    let name: String = kept.take(LONGEST).collect();
    if name.is_empty() { "value".to_owned() } else { name }
}

/// Returns path and values of `path=value,value`; commas inside brackets and quotes are part of a
/// value.
///
/// # Errors
/// The form that is expected.
pub fn axis(text: &str) -> Result<SweepAxis, String> {
    let form = || "must be `path=value,value`, as `spacing=2e-3,1e-3`".to_owned();
    let (path, list) = text.split_once('=').ok_or_else(form)?;
    let (mut depth, mut in_quotes, mut values) = (0_i32, false, vec![String::new()]);
    for letter in list.chars() {
        match letter {
            '"' => in_quotes = !in_quotes,
            '(' | '[' | '{' if !in_quotes => depth += 1,
            ')' | ']' | '}' if !in_quotes => depth -= 1,
            ',' if !in_quotes && depth == 0 => {
                values.push(String::new());
                continue;
            }
            _ => {}
        }
        if let Some(value) = values.last_mut() {
            value.push(letter);
        }
    }
    let values: Vec<String> = values.iter().map(|value| value.trim().to_owned()).collect();
    if path.trim().is_empty() || values.iter().any(String::is_empty) {
        return Err(form());
    }
    Ok(SweepAxis { path: path.trim().to_owned(), values })
}

/// Returns true for a folder that has the index of a sweep.
pub fn is_sweep(folder: &Path) -> bool {
    folder.join(INDEX).is_file()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sweep(axes: &[&str]) -> Sweep {
        Sweep {
            scene: PathBuf::from("flow.ron"),
            smoke: false,
            sets: Vec::new(),
            axes: axes.iter().map(|text| axis(text).expect("an axis")).collect(),
            folder: PathBuf::from("runs"),
            threads: None,
            only: None,
            reuse: true,
            memory: None,
            console: Console::Quiet,
        }
    }

    #[test]
    fn values_are_split_outside_brackets_and_quotes() {
        let found =
            axis("outlets.0.condition=WaveEquation(pressure: Reference(0.0)), Hybrid()").expect("an axis");
        assert_eq!(found.values, ["WaveEquation(pressure: Reference(0.0))", "Hybrid()"]);
        assert_eq!(axis(r#"title="a, b",c"#).expect("an axis").values, ["\"a, b\"", "c"]);
        for text in ["spacing", "=1", "spacing=", "spacing=1,,2"] {
            assert!(axis(text).expect_err(text).contains("path=value"), "{text}");
        }
    }

    #[test]
    fn runs_are_all_combinations_with_names_of_their_values() {
        let runs = sweep(&["spacing=2e-3,1e-3", "fluid.viscosity=1e-5,1e-6"]).runs().expect("runs");
        let names: Vec<&str> = runs.iter().map(|run| run.name.as_str()).collect();
        assert_eq!(
            names,
            [
                "spacing-2e-3_viscosity-1e-5",
                "spacing-2e-3_viscosity-1e-6",
                "spacing-1e-3_viscosity-1e-5",
                "spacing-1e-3_viscosity-1e-6"
            ]
        );
        let both = sweep(&["inlets.0.depth=0.1", "outlets.0.depth=0.2"]).runs().expect("runs");
        assert_eq!(both[0].name, "inlets.0.depth-0.1_outlets.0.depth-0.2");
    }

    #[test]
    fn ambiguous_and_oversized_sweeps_are_refused() {
        let refused = |axes: &[&str]| sweep(axes).runs().expect_err("refused").to_string();
        assert!(refused(&["a=1", "a=2"]).contains("given twice"));
        assert!(refused(&["v=\"x\",x"]).contains("same folder, `v-x`"));
        let many = format!("a={}", vec!["1"; 101].join(","));
        assert!(refused(&[&many, &many.replace('a', "b")]).contains("10000 runs"));
    }
}
