//! Speed of the engine on the present machine, for `sphecs bench` and `cargo bench`.
//!
//! - [`cases`]: flows that are timed
//! - [`measure`]: time of steps, sets of systems and pairs
//! - [`operations`]: floating-point operations of a pair
//! - [`tile`]: particle disorder of an advected flow
//! - [`peak`]: multiply-add rate of a core
//! - [`scalar`]: straightforward code as the baseline
//! - [`memory`]: growth of the process
//! - [`timing_table`]: results as text
//!
//! To add a case: a variant of [`BenchCase`] with its name, plan and scene, and an entry in
//! `BenchCase::ALL`. The operations of its pair loops must be counted in `operations`.

pub mod cases;
pub mod measure;
pub mod memory;
pub mod operations;
pub mod peak;
pub mod scalar;
pub mod tile;
pub mod timing_table;

use std::num::NonZeroUsize;
use std::time::Instant;

use miette::Diagnostic;
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

use cases::BenchCase;
use measure::MeasureError;
use peak::Peaks;
use tile::{Tile, TileError};

use sphecs_engine::simulation::Stop;
use sphecs_run::console::Console;
use sphecs_scene::faults::SceneErrors;

/// Options of a bench.
#[derive(Clone, Debug)]
pub struct BenchOptions {
    /// Cases in the order of their timing.
    pub cases: Vec<BenchCase>,
    /// Numbers of threads, ascending, each timed by itself; flows are warmed up on the largest.
    pub threads: Vec<usize>,
    /// Numbers of ranks that are timed besides one, each with each number of threads.
    pub ranks: Vec<usize>,
    /// Amount of text on standard output.
    pub console: Console,
}

/// Error that stops a bench.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub enum BenchError {
    /// The scene of a case has faults, usually too little memory.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneErrors),
    /// The flow of a case diverged.
    #[error("{case}: {stop}")]
    #[diagnostic(help("the cases are stable on any machine: please report this with the lines above"))]
    Flow {
        /// Name of the case.
        case: &'static str,
        /// Reason.
        stop: Stop,
    },
    /// The threads could not be started.
    #[error("cannot start the threads: {0}")]
    #[diagnostic(help("give a smaller number by `--threads`"))]
    Threads(#[from] ThreadPoolBuildError),
}

/// Returns one thread and one for each core.
pub fn default_threads() -> Vec<usize> {
    let cores = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    if cores == 1 { vec![1] } else { vec![1, cores] }
}

/// Times the cases and prints the results of each as soon as they are known.
///
/// # Errors
/// [`BenchError`]; results printed before stay valid.
pub fn run(options: &BenchOptions) -> Result<(), BenchError> {
    let started = Instant::now();
    let build = |&threads: &usize| ThreadPoolBuilder::new().num_threads(threads).build();
    let pools: Vec<ThreadPool> = options.threads.iter().map(build).collect::<Result<_, _>>()?;
    let peaks = Peaks::measure();
    let at_rest = memory::at_rest();
    options.console.print(&timing_table::head(&peaks));
    let mut measured = Vec::new();
    for &case in &options.cases {
        let scene = case.scene()?;
        let precision = scene.precision;
        let flow_error = |stop| BenchError::Flow { case: case.name(), stop };
        let tile = match case.periodic_box().map(Tile::of).transpose() {
            Ok(tile) => tile,
            Err(TileError::Scene(faults)) => return Err(faults.into()),
            Err(TileError::Flow(stop)) => return Err(flow_error(stop)),
        };
        let groups = (&pools[..], &options.ranks[..]);
        let figures = match measure::measure(scene, tile.as_ref(), case.plan(), groups, at_rest) {
            Ok(figures) => figures,
            Err(MeasureError::Flow(stop)) => return Err(flow_error(stop)),
            Err(MeasureError::Threads(refused)) => return Err(refused.into()),
        };
        options.console.print(&timing_table::rows(case.name(), &figures, peaks.of(precision)));
        measured.push((case.name(), figures));
    }
    options.console.print(&timing_table::summary(&measured, started.elapsed().as_secs_f64()));
    Ok(())
}
