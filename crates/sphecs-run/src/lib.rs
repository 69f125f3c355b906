//! Run loop: advances a scene to its end and writes the results into a folder.
//!
//! - [`run_loop`]: steps, output, checkpoints and the reasons to stop
//! - [`resume`]: continuation of a run from its last checkpoint
//! - [`output_schedule`]: times of frames, rows and checkpoints, and the wall-time limit
//! - [`gridded`], [`wall_output`]: gridded fields and quantities at the walls, with their means
//! - [`sample_schedule`]: the times of both
//! - [`run_state`]: state of the loop that a checkpoint saves
//! - [`report`]: summaries at the start and at the end, and the report on a flow that stopped
//! - [`progress`]: speed, time left and their display; [`waiting`]: a spinner before the first step
//! - [`check`]: figures and cost of a run before it starts
//! - [`first_steps`]: cost of a run by its first steps
//! - `doubtful`: notes on choices that are seldom meant
//! - [`close_pairs`], [`closed_pressure`]: notes on what a run shows
//! - [`disk_check`]: free disk space before the start
//! - [`ranks`]: ranks of a run, in one process or in several
//! - [`memory`]: memory of the machine
//! - [`environment`]: environment variables
//! - [`concurrent`], [`sweep`]: several runs at once, and one for each combination of values
//! - [`console`], [`signals`], [`threads`], [`error`]: terminal, signals, threads and errors of the
//!   process

pub mod check;
pub mod close_pairs;
pub mod closed_pressure;
pub mod concurrent;
pub mod console;
pub mod disk_check;
mod doubtful;
pub mod environment;
pub mod error;
pub mod first_steps;
pub mod gridded;
pub mod memory;
pub mod output_schedule;
pub mod progress;
mod progress_bar;
pub mod rank_messages;
mod rank_shares;
pub mod ranks;
pub mod report;
pub mod resume;
pub mod run_loop;
pub mod run_state;
pub mod sample_schedule;
pub mod signals;
pub mod sweep;
pub mod threads;
pub mod waiting;
pub mod wall_output;

use std::path::{Component, Path, PathBuf};

use console::Console;
use error::RunError;
use ranks::RankSource;
use run_loop::RunLoop;
use signals::{Signal, Signals};
use threads::on_threads;

use sphecs_engine::plugins::Plugin;
use sphecs_output::error::OutputError;
use sphecs_output::start::check_free;
use sphecs_scene::model::Scene;

/// Options of a run that are not part of its scene.
#[derive(Clone, Debug)]
pub struct RunOptions {
    /// Folder for the results.
    pub folder: PathBuf,
    /// Replace an earlier run in the folder.
    pub force: bool,
    /// Number of threads of each rank; None: one for each core, shared among the ranks.
    pub threads: Option<usize>,
    /// Ranks that share the pair passes.
    pub ranks: RankSource,
    /// End, s; overrides the scene.
    pub until: Option<f64>,
    /// Largest number of steps.
    pub max_steps: Option<u64>,
    /// Wall time between checkpoints, s; overrides the scene.
    pub checkpoint_every: Option<f64>,
    /// Wall time after which the run stops, s.
    pub max_wall_time: Option<f64>,
    /// Start although the free disk space is too small for all results.
    pub allow_oversize: bool,
    /// Amount of text on standard output.
    pub console: Console,
}

/// End of a run that no error stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// The end in time or steps was reached.
    Completed,
    /// A signal stopped the run; its files are complete, and `sphecs resume` continues it.
    Stopped(Signal),
    /// The wall-time limit was reached; `sphecs resume` continues the run.
    OutOfTime,
}

/// Runs a scene and writes its results into a folder.
///
/// # Errors
/// [`RunError`]: before the first step nothing is written; later the files written stay readable.
pub fn run(scene: Scene, options: &RunOptions) -> Result<Ending, RunError> {
    let signals = Signals::listen().map_err(RunError::Signals)?;
    on_threads(options.ranks.threads(options.threads), || run_on_current_pool(scene, options, signals))?
}

/// Runs a scene as [`run`] does, on the thread pool of the caller and until these signals stop it.
///
/// # Errors
/// As [`run`].
pub fn run_on_current_pool(scene: Scene, options: &RunOptions, signals: Signals) -> Result<Ending, RunError> {
    run_with_plugins(scene, Vec::new(), options, signals)
}

/// Runs a scene as [`run_on_current_pool`] does, with plugins of the caller.
///
/// The header of the run says so: `sphecs resume`, which lacks the plugins, refuses to continue it.
///
/// # Errors
/// As [`run`].
pub fn run_with_plugins(
    scene: Scene,
    plugins: Vec<Box<dyn Plugin + Send>>,
    options: &RunOptions,
    signals: Signals,
) -> Result<Ending, RunError> {
    // The folder is checked before the domain is filled, and again when the folder is made.
    check_free(&options.folder, options.force)?;
    if !options.allow_oversize {
        disk_check::check(&scene, options)?;
    }
    RunLoop::start(scene, plugins, options, signals)?.run()
}

/// Returns the folder `runs/NAME` of a scene without a folder of its own.
///
/// # Errors
/// [`OutputError::Request`] for names such as `..` (of a scene `...ron`) that lead out of `runs/`.
pub fn default_folder(name: &str) -> Result<PathBuf, OutputError> {
    let folder = Path::new("runs").join(name);
    let below =
        folder.components().eq([Component::Normal("runs".as_ref()), Component::Normal(name.as_ref())]);
    let refused = || format!("`{name}`: cannot be the name of a folder in `runs/`: give a folder by `--out`");
    if below { Ok(folder) } else { Err(OutputError::Request(refused())) }
}

#[cfg(test)]
mod tests {
    use super::resume::{ResumeOptions, resume_on_current_pool};
    use super::*;
    use sphecs_engine::plugins::PluginContext;
    use sphecs_engine::simulation::{Stop, StopRequest};
    use sphecs_engine::systems::force_fields::FluidState;
    use sphecs_engine::systems::forces::AddedForces;
    use sphecs_output::results::Results;
    use sphecs_output::summary::{Status, Summary};

    /// Pushes the fluid along x until a time, s, at which it asks to stop.
    struct PushUntil(f64);

    impl Plugin for PushUntil {
        fn build(&self, context: &mut PluginContext<'_>) {
            let stop = context.world.get_resource_or_init::<StopRequest>().clone();
            let end = self.0;
            let push = move |fluid: &FluidState<'_>, force: &mut [glam::DVec3]| {
                if fluid.time > end {
                    stop.set("far enough");
                }
                force.iter_mut().for_each(|force| force.x += 0.5);
            };
            context.world.get_resource_or_init::<AddedForces>().add_field(push);
        }
    }

    fn options(folder: PathBuf) -> RunOptions {
        RunOptions {
            folder,
            force: false,
            threads: None,
            ranks: RankSource::default(),
            until: None,
            max_steps: None,
            checkpoint_every: None,
            max_wall_time: None,
            allow_oversize: false,
            console: Console::Quiet,
        }
    }

    #[test]
    fn plugins_act_in_a_run_which_is_not_resumed_without_them() {
        let parent = tempfile::tempdir().expect("a folder");
        let options = options(parent.path().join("run"));
        let text = r#"Scene(
            title: "Box", dimensions: 2, spacing: 0.05, periodic: ["x", "y"],
            fluid: (density: 1000.0, viscosity: 1e-3, sound_speed: 2.0),
            domain: Box(min: (0.0, 0.0), max: (0.5, 0.4)),
            reference: (velocity: 0.1, length: 0.4),
            time: (end: 1.0), output: (every: 0.05),
        )"#;
        let scene = Scene::from_text("box", text).load().expect("a scene");
        let plugins: Vec<Box<dyn Plugin + Send>> = vec![Box::new(PushUntil(0.12))];
        let ended = run_with_plugins(scene, plugins, &options, Signals::without_handlers());
        let Err(RunError::Flow { stop: Stop::Requested { time, reason, .. }, .. }) = ended else {
            panic!("{ended:?}");
        };
        assert!(time > 0.12 && time < 0.15 && reason == "far enough", "{time}: {reason}");
        assert_eq!(Summary::read(&options.folder).expect("a summary").status, Status::Failed);
        let results = Results::open(&options.folder).expect("a run");
        assert_eq!(results.times().len(), 3);
        let last = results.frame(2).expect("a frame");
        let u = f64::from(last.velocity[0][0]);
        assert!((u - 0.5 * last.time).abs() < 1e-6, "{u} m/s at {} s", last.time);

        let resumed = ResumeOptions { run: options, sets: Vec::new(), allow_other_isa: false };
        let refused = resume_on_current_pool(&resumed, Signals::without_handlers()).expect_err("refused");
        assert!(refused.to_string().contains("plugins of the program"), "{refused}");
    }

    #[test]
    fn no_scene_name_leads_out_of_the_runs_folder() {
        assert_eq!(default_folder("flow.v2").expect("a folder"), Path::new("runs/flow.v2"));
        for name in ["..", ".", "", "/etc", "a/b", "../b", "a/.."] {
            assert!(default_folder(name).is_err(), "`{name}` was accepted");
        }
    }
}
