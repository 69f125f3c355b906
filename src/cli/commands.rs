//! Commands: one function each, from arguments to an exit code.

use std::io::{IsTerminal, Write};
use std::num::NonZeroUsize;
use std::path::Path;

use super::arguments::{CheckArguments, InfoArguments, PackArguments, SceneArguments};
use super::check_arguments::{BenchArguments, ValidateArguments};
use super::failure::{DONE, Failure, MISSED, OUT_OF_TIME};
use super::run_arguments::{LimitArguments, ResumeArguments, RunArguments, VerbosityArguments};
use sphecs_bench::BenchOptions;
use sphecs_bench::cases::BenchCase;
use sphecs_output::disk;
use sphecs_output::error::OutputError;
use sphecs_output::picture::{self, RenderOptions};
use sphecs_output::results::Results;
use sphecs_output::{info as run_info, pack as packing};
use sphecs_run::check::{self as scene_check, CheckOptions};
use sphecs_run::console::Console;
use sphecs_run::error::RunError;
use sphecs_run::memory;
use sphecs_run::ranks::RankSource;
use sphecs_run::resume::{self, ResumeOptions};
use sphecs_run::threads::on_threads;
use sphecs_run::waiting;
use sphecs_run::{Ending, RunOptions, default_folder, report};
use sphecs_scene::model::Scene;
use sphecs_validate::schema::Tier;
use sphecs_validate::{Conclusion, ValidateError, ValidateOptions, case};

/// Runs a scene.
///
/// # Errors
/// [`Failure`] with its exit code.
pub fn run(arguments: &RunArguments) -> Result<u8, Failure> {
    let Some(ranks) = ranks(&arguments.limits)? else { return Ok(DONE) };
    // Each rank of this process has all particles.
    let memory = memory::available().map(|bytes| bytes / ranks.in_this_process() as f64);
    let memory = memory.filter(|_| !arguments.allow_oversize);
    let scene = load_within(&arguments.input, memory)?;
    let options = RunOptions {
        folder: match &arguments.out {
            Some(folder) => folder.clone(),
            None => default_folder(&scene.name)?,
        },
        force: arguments.force,
        threads: arguments.limits.threads.map(usize::from),
        ranks,
        until: arguments.limits.until,
        max_steps: arguments.limits.steps,
        checkpoint_every: arguments.limits.checkpoint_every,
        max_wall_time: arguments.limits.max_walltime,
        allow_oversize: arguments.allow_oversize,
        console: console(&arguments.verbosity),
    };
    Ok(code_of(sphecs_run::run(scene, &options)?))
}

/// Resumes a run.
///
/// # Errors
/// [`Failure`] with its exit code.
pub fn resume(arguments: &ResumeArguments) -> Result<u8, Failure> {
    let Some(ranks) = ranks(&arguments.limits)? else { return Ok(DONE) };
    let options = ResumeOptions {
        run: RunOptions {
            folder: arguments.run.clone(),
            force: false,
            threads: arguments.limits.threads.map(usize::from),
            ranks,
            until: arguments.limits.until,
            max_steps: arguments.limits.steps,
            checkpoint_every: arguments.limits.checkpoint_every,
            max_wall_time: arguments.limits.max_walltime,
            // The run was allowed to start, and part of it is already written.
            allow_oversize: true,
            console: console(&arguments.verbosity),
        },
        sets: arguments.sets.clone(),
        allow_other_isa: arguments.allow_other_isa,
    };
    Ok(code_of(resume::resume(&options)?))
}

/// Returns the ranks of a run; None in a process that has followed another one to its end.
fn ranks(limits: &LimitArguments) -> Result<Option<RankSource>, Failure> {
    let given = limits.ranks.map(NonZeroUsize::get);
    Ok(RankSource::of_process(given, limits.threads.map(NonZeroUsize::get))?)
}

fn console(verbosity: &VerbosityArguments) -> Console {
    match (verbosity.quiet, verbosity.verbose) {
        (true, _) => Console::Quiet,
        (false, true) => Console::Verbose,
        (false, false) => Console::Normal,
    }
}

fn code_of(ending: Ending) -> u8 {
    match ending {
        Ending::Completed => DONE,
        Ending::Stopped(signal) => signal.exit_code(),
        Ending::OutOfTime => OUT_OF_TIME,
    }
}

/// Prints figures and cost of the run of a scene, and draws the scene on request.
///
/// # Errors
/// [`Failure::Scene`] with every fault of the scene; [`Failure::Output`] for the picture.
pub fn check(arguments: &CheckArguments) -> Result<u8, Failure> {
    let scene = load(&arguments.input)?;
    let threads = arguments.threads.map(usize::from);
    let seeds = || on_threads(threads, || sphecs_scene::seeds(&scene));
    let seeds = waiting::during("placing the particles", seeds).map_err(RunError::Threads)?;
    if let Some(path) = &arguments.picture {
        make_parent(path)?;
        let options = RenderOptions { slice: arguments.slice, ..RenderOptions::default() };
        picture::render_plan(&scene, &seeds, &options, &disk::target(path))?;
    }
    let options =
        CheckOptions { until: arguments.until, timed: !arguments.no_timing, ranks: arguments.ranks.get() };
    let report = || on_threads(threads, || scene_check::check(&scene, seeds, &options));
    let report = waiting::during("measuring the scene", report).map_err(RunError::Threads)?;
    Console::Normal.print(&report.text);
    if let Some(path) = &arguments.picture {
        Console::Normal.print(&format!("\nthe picture is {}", path.display()));
    }
    Ok(if arguments.strict && !report.notes.is_empty() { MISSED } else { DONE })
}

/// Prints a description of a run folder.
///
/// # Errors
/// [`Failure::Output`].
pub fn info(arguments: &InfoArguments) -> Result<u8, Failure> {
    let results = Results::open(&arguments.run)?;
    Console::Normal.print(run_info::describe(&results)?.trim_end());
    Ok(DONE)
}

/// Packs the journal of a run.
///
/// # Errors
/// [`Failure::Output`].
pub fn pack(arguments: &PackArguments) -> Result<u8, Failure> {
    let packed = packing::pack(&arguments.run)?;
    if packed.frames == 0 {
        Console::Normal.print("the run is packed already: its journal has no frames");
    } else {
        Console::Normal.print(&report::results(&arguments.run, &packed));
    }
    Ok(DONE)
}

/// Measures how fast the engine is on this machine.
///
/// # Errors
/// [`Failure::Bench`].
pub fn bench(arguments: &BenchArguments) -> Result<u8, Failure> {
    let is_requested = |case: BenchCase| {
        arguments.cases.contains(&case)
            || if case.is_large() { arguments.large } else { arguments.cases.is_empty() }
    };
    let mut threads: Vec<usize> = arguments.threads.iter().map(|threads| threads.get()).collect();
    threads.sort_unstable();
    threads.dedup();
    let options = BenchOptions {
        cases: BenchCase::ALL.into_iter().map(|(_, case)| case).filter(|&case| is_requested(case)).collect(),
        threads: if threads.is_empty() { sphecs_bench::default_threads() } else { threads },
        ranks: arguments.ranks.iter().map(|ranks| ranks.get()).collect(),
        console: Console::Normal,
    };
    sphecs_bench::run(&options)?;
    Ok(DONE)
}

/// Runs validation cases and compares them with their references.
///
/// # Errors
/// [`Failure::Validate`].
pub fn validate(arguments: &ValidateArguments) -> Result<u8, Failure> {
    if arguments.list {
        for (name, title) in case::titles().map_err(ValidateError::from)? {
            Console::Normal.print(&format!("{name:<16}  {title}"));
        }
        return Ok(DONE);
    }
    let options = ValidateOptions {
        cases: if arguments.cases.is_empty() { case::shipped() } else { arguments.cases.clone() },
        tier: match (arguments.quick, arguments.full) {
            (true, _) => Tier::Quick,
            (_, true) => Tier::Full,
            _ => Tier::Usual,
        },
        folder: arguments.out.clone(),
        reuse: arguments.reuse,
        threads: arguments.threads.map(NonZeroUsize::get),
        console: Console::Normal,
    };
    Ok(match sphecs_validate::validate(&options)? {
        Conclusion::Met => DONE,
        Conclusion::Missed => MISSED,
        Conclusion::Stopped(signal) => signal.exit_code(),
    })
}

fn load(input: &SceneArguments) -> Result<Scene, Failure> {
    load_within(input, memory::available())
}

fn load_within(input: &SceneArguments, memory: Option<f64>) -> Result<Scene, Failure> {
    let loader = Scene::from_file(&input.scene).sets(&input.sets).memory(memory);
    let loader = if input.smoke { loader.smoke() } else { loader };
    Ok(waiting::during("reading the scene", || loader.load())?)
}

/// Makes the folder of a file.
pub(super) fn make_parent(path: &Path) -> Result<(), OutputError> {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => std::fs::create_dir_all(parent)
            .map_err(|cause| OutputError::Io { path: parent.to_owned(), doing: "make the folder", cause }),
        _ => Ok(()),
    }
}

/// Returns a counter that overwrites one line of a terminal while a series is written.
pub(super) fn counter(what: &str) -> impl FnMut(usize, usize) + '_ {
    let on_terminal = std::io::stderr().is_terminal();
    move |done, all| {
        if on_terminal {
            let end = if done == all { "\n" } else { "" };
            let _reader_gone = write!(std::io::stderr(), "\r{done} of {all} {what}{end}");
        }
    }
}
