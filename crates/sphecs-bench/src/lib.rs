//! The figures of the engine on the machine at hand: what `sphecs bench` measures and `cargo bench` shares.
//!
//! Rooms: `cases` (what is timed), `measure` (steps, sets of systems and pairs), `operations` (floating-point operations
//! of a pair), `stirring` (boxes as a flow leaves them), `peak` (the most multiply-adds of a core), `scalar` (a straightforward code as the baseline), `memory` (growth of the process), `table` (how it is said).
//!
//! To add a case: a variant of [`Case`] with its name, plan and scene, and its place in `Case::ALL`. What its pair loops
//! compute must be counted in `operations`.

pub mod cases;
pub mod measure;
pub mod memory;
pub mod operations;
pub mod peak;
pub mod scalar;
pub mod stirring;
pub mod table;

use std::num::NonZeroUsize;
use std::time::Instant;

use miette::Diagnostic;
use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

use cases::Case;
use peak::Peaks;
use stirring::{Tile, TileError};

use sphecs_engine::simulation::Stop;
use sphecs_run::console::Console;
use sphecs_scene::faults::SceneErrors;

/// What the user asks of a bench.
#[derive(Clone, Debug)]
pub struct BenchOptions {
    /// The cases, in the order in which they are timed.
    pub cases: Vec<Case>,
    /// Numbers of threads, rising, each timed by itself; the flows are warmed up on the most.
    pub threads: Vec<usize>,
    /// Where the figures go.
    pub console: Console,
}

/// Why a bench ended without its figures.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub enum BenchError {
    /// The scene of a case has faults: too little memory, as a rule.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneErrors),
    /// The flow of a case blew up.
    #[error("{case}: {stop}")]
    #[diagnostic(help("the cases are tame on any machine: please report it with the lines above"))]
    Flow {
        /// Name of the case.
        case: &'static str,
        /// What happened.
        stop: Stop,
    },
    /// The threads could not be started.
    #[error("cannot start the threads: {0}")]
    #[diagnostic(help("give a smaller number by `--threads`"))]
    Threads(#[from] ThreadPoolBuildError),
}

/// One thread, and as many as the machine has cores.
pub fn usual_threads() -> Vec<usize> {
    let cores = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    if cores == 1 { vec![1] } else { vec![1, cores] }
}

/// Times the cases and says their figures, each as soon as it is known.
///
/// # Errors
/// [`BenchError`]; what was said before holds.
pub fn run(options: &BenchOptions) -> Result<(), BenchError> {
    let started = Instant::now();
    let build = |&threads: &usize| ThreadPoolBuilder::new().num_threads(threads).build();
    let pools: Vec<ThreadPool> = options.threads.iter().map(build).collect::<Result<_, _>>()?;
    let peaks = Peaks::measure();
    let at_rest = memory::at_rest();
    options.console.say(&table::opening(&peaks));
    let mut measured = Vec::new();
    for &case in &options.cases {
        let scene = case.scene()?;
        let precision = scene.precision;
        let flow_error = |stop| BenchError::Flow { case: case.name(), stop };
        let tile = match case.stirred().map(Tile::of).transpose() {
            Ok(tile) => tile,
            Err(TileError::Scene(faults)) => return Err(faults.into()),
            Err(TileError::Flow(stop)) => return Err(flow_error(stop)),
        };
        let figures =
            measure::measure(scene, tile.as_ref(), case.plan(), &pools, at_rest).map_err(flow_error)?;
        options.console.say(&table::rows(case.name(), &figures, peaks.of(precision)));
        measured.push((case.name(), figures));
    }
    options.console.say(&table::close(&measured, started.elapsed().as_secs_f64()));
    Ok(())
}
