//! Continuation of a run from its last checkpoint, bitwise identical to an uninterrupted run.
//!
//! The folder is not changed until a complete checkpoint of this scene and instruction set is found
//! whose output exists. Then the output is cut back to it. A run that was killed before its first
//! checkpoint starts again.

use std::path::PathBuf;

use super::error::RunError;
use super::gridded::GriddedFields;
use super::memory;
use super::run_loop::RunLoop;
use super::run_state::{self, RunState};
use super::signals::Signals;
use super::threads::on_threads;
use super::wall_output::WallQuantities;
use super::{Ending, RunOptions, report};
use sphecs_core::format::{grouped, significant};
use sphecs_core::math::lanes::InstructionSet;
use sphecs_engine::saved_state::decode_record;
use sphecs_engine::simulation::Simulation;
use sphecs_output::checkpoint::store::{Rejected, Store};
use sphecs_output::checkpoint::{Checkpoint, Facts};
use sphecs_output::cut_back::has_output;
use sphecs_output::error::OutputError;
use sphecs_output::folder::RunFolder;
use sphecs_output::header::Header;
use sphecs_output::lock::Lock;
use sphecs_output::pack::pack_locked;
use sphecs_output::probes::ProbeSet;
use sphecs_output::results::read_header;
use sphecs_output::summary::{Status, Summary};
use sphecs_scene::model::Scene;

/// Scene values that a resumed run may change: the end and the output intervals, which do not
/// change the flow.
pub const CHANGEABLE: [&str; 4] =
    ["time.end", "output.every", "output.monitor_every", "output.checkpoint_every"];

/// Options of a resumed run.
#[derive(Clone, Debug)]
pub struct ResumeOptions {
    /// Options as of any run. An end given by `until` or `max_steps` replaces that of the run.
    pub run: RunOptions,
    /// Changes to the scene: path and value.
    pub sets: Vec<(String, String)>,
    /// Resume on another instruction set, although the results will then differ bitwise.
    pub allow_other_isa: bool,
}

/// Resumes a run.
///
/// # Errors
/// [`RunError`]; before the first step the folder is unchanged, unless cutting back its output
/// failed.
pub fn resume(options: &ResumeOptions) -> Result<Ending, RunError> {
    let signals = Signals::listen().map_err(RunError::Signals)?;
    on_threads(options.run.ranks.threads(options.run.threads), || resume_on_current_pool(options, signals))?
}

/// Resumes a run as [`resume`] does, on the thread pool of the caller and until these signals stop
/// it.
///
/// # Errors
/// As [`resume`].
pub fn resume_on_current_pool(options: &ResumeOptions, signals: Signals) -> Result<Ending, RunError> {
    match prepare(options, signals)? {
        Some(run_loop) => run_loop.run(),
        None => Ok(Ending::Completed),
    }
}

/// Returns the run ready for its next step; None when it is complete.
fn prepare(options: &ResumeOptions, signals: Signals) -> Result<Option<RunLoop>, RunError> {
    let path = options.run.folder.as_path();
    let mut header = read_header(path)?;
    if header.has_plugins {
        return Err(request(format!(
            "`{}`: has forces or plugins of the program that started it, without which the flow would be another: \
             run the scene from its start in that program",
            path.display()
        )));
    }
    let lock = Lock::acquire_without_links(path)?;
    let status = Summary::read(path)?.status;
    let (scene, changes) = changed_scene(options, &header)?;
    let (last, facts, simulation, (state, sampled)) = match latest(options, &header)? {
        Some((last, checkpoint)) => {
            let (facts, simulation, state) = restored(scene, checkpoint, &options.run)?;
            (Some(last), facts, simulation, state)
        }
        None => {
            let state = (RunState::new(&scene), (GriddedFields::new(&scene), WallQuantities::new(&scene)));
            (None, Facts::default(), options.run.ranks.begin(Simulation::builder(scene)).build()?, state)
        }
    };
    let (scene, clock) = (simulation.scene(), simulation.clock());
    let new_end = options.run.until.is_some() || options.run.max_steps.is_some();
    if new_end || options.sets.iter().any(|(path, _)| path == "time.end") {
        (header.until, header.max_steps) = (options.run.until, options.run.max_steps);
    }
    header.change(scene, changes);
    let until = header.until.unwrap_or(scene.time.end);
    let at_end = clock.time >= until || header.max_steps.is_some_and(|limit| clock.step >= limit);
    if at_end && status == Status::Completed {
        // The process may have been killed while it packed the run.
        pack_locked(path, &header)?;
        options.run.console.print(&format!(
            "`{}`: is complete, t = {} s after {} steps; to continue it, give a later end by `--until` or `--set time.end=…`",
            path.display(),
            significant(clock.time),
            grouped(clock.step),
        ));
        return Ok(None);
    }
    let console = options.run.console;
    console.print(&report::start_summary(scene, simulation.ledger(), until, &options.run));
    console.print(&match facts.step {
        0 => "no checkpoint was written: the run starts again\n".to_owned(),
        step => format!("resumes at t = {} s, step {}\n", significant(facts.time), grouped(step)),
    });
    Store::of(path).cut_back(last.as_deref())?;
    let folder = RunFolder::resume(path, &header, &ProbeSet::new(scene), &facts, lock)?;
    RunLoop::resume(simulation, (folder, sampled), state, &options.run, signals).map(Some)
}

/// Returns the scene of the run with all changes, and the changes.
fn changed_scene(
    options: &ResumeOptions,
    header: &Header,
) -> Result<(Scene, Vec<(String, String)>), RunError> {
    let folder = options.run.folder.display();
    if !header.is_scene_unchanged() {
        return Err(request(format!(
            "`{folder}/scene.ron`: was changed after the run started, must be the scene of the run: restore it, \
             or run the changed scene into another folder"
        )));
    }
    if let Some((path, _)) = options.sets.iter().find(|(path, _)| !CHANGEABLE.contains(&path.as_str())) {
        return Err(request(format!(
            "--set {path}: cannot be changed when a run is resumed, only `{}` can: run the changed scene from its start",
            CHANGEABLE.join("`, `")
        )));
    }
    let changes = [header.changes.clone(), options.sets.clone()].concat();
    let scene = Scene::from_text(&header.scene, &header.text)
        .tables(header.tables.clone())
        .meshes(header.meshes.clone())
        .sets(&changes)
        .memory(memory::available())
        .load()?;
    Ok((scene, changes))
}

/// Returns the latest checkpoint that the run can resume from, with its path; None when there is
/// none yet.
fn latest(options: &ResumeOptions, header: &Header) -> Result<Option<(PathBuf, Checkpoint)>, RunError> {
    let run = options.run.folder.as_path();
    let store = Store::of(run);
    let fingerprint = header.fingerprint();
    let is_usable = |checkpoint: &Checkpoint| match &checkpoint.facts {
        facts if facts.scene_sha256 != fingerprint => Err("belongs to another scene".to_owned()),
        facts => has_output(run, header, facts),
    };
    let (found, rejected) = store.latest(is_usable)?;
    let named = |Rejected { path, reason }: &Rejected| format!("`{}`: {reason}", path.display());
    let Some((path, checkpoint)) = found else {
        if rejected.is_empty() {
            return Ok(None);
        }
        let rejected: Vec<String> = rejected.iter().map(named).collect();
        return Err(request(format!(
            "no checkpoint can be resumed from, run the scene from its start:\n{}",
            rejected.join("\n")
        )));
    };
    let lanes = InstructionSet::best().name();
    if checkpoint.facts.lanes != lanes {
        let differ = format!(
            "`{}`: was written on {} lanes, this process has {lanes}: the results will differ bitwise",
            path.display(),
            checkpoint.facts.lanes
        );
        if !options.allow_other_isa {
            // The option has its own line; in a longer line it might be broken at a hyphen.
            return Err(request(format!("{differ};\nto resume anyway, give `--allow-other-isa`")));
        }
        options.run.console.warn(&format!("note: {differ}"));
    }
    if checkpoint.facts.version != env!("CARGO_PKG_VERSION") {
        options.run.console.warn(&format!(
            "note: `{}`: was written by sphecs {}, this is {}: the results may differ bitwise",
            path.display(),
            checkpoint.facts.version,
            env!("CARGO_PKG_VERSION")
        ));
    }
    for rejected in &rejected {
        let step = grouped(checkpoint.facts.step);
        options
            .run
            .console
            .warn(&format!("note: {}; resuming from the checkpoint of step {step}", named(rejected)));
    }
    Ok(Some((path, checkpoint)))
}

/// Rebuilds the simulation and the state of the run loop from a checkpoint.
fn restored(
    scene: Scene,
    checkpoint: Checkpoint,
    options: &RunOptions,
) -> Result<(Facts, Simulation, (RunState, (GriddedFields, WallQuantities))), RunError> {
    let Checkpoint { facts, mut state } = checkpoint;
    let mismatch = |what: String| {
        request(format!("the checkpoint of step {} does not match the scene: {what}", facts.step))
    };
    let run_state = state.take::<u8>(run_state::COLUMN).map_err(|error| mismatch(error.to_string()))?;
    let run_state = decode_record(&run_state).map_err(mismatch)?;
    let fields = GriddedFields::restore(&scene, &mut state).map_err(|error| mismatch(error.to_string()))?;
    let walls = WallQuantities::restore(&scene, &mut state).map_err(|error| mismatch(error.to_string()))?;
    let simulation = options.ranks.begin(Simulation::builder(scene)).state(state).build();
    let simulation = simulation.map_err(|error| mismatch(error.to_string()))?;
    Ok((facts, simulation, (run_state, (fields, walls))))
}

fn request(what: String) -> RunError {
    RunError::Output(OutputError::Request(what))
}
