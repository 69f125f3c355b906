//! `sphecs resume`: a run gone on with from its last checkpoint, to the same bits as if it had never been broken off.
//!
//! Nothing in the folder is touched before a checkpoint is found that is whole, of this scene and this instruction set, and whose
//! output is there. Then the output is cut back to it. A run that was killed before its first checkpoint begins anew.

use std::path::PathBuf;

use super::error::RunError;
use super::log::{self, Log};
use super::memory;
use super::signals::Signals;
use super::threads::on_threads;
use super::voyage::Voyage;
use super::words::{figure, grouped};
use super::{Ending, RunOptions, opening};
use sphecs_core::math::lanes::InstructionSet;
use sphecs_engine::saved_state::decode_record;
use sphecs_engine::simulation::Simulation;
use sphecs_output::checkpoint::store::{Refused, Store};
use sphecs_output::checkpoint::{Checkpoint, Facts, cut};
use sphecs_output::error::OutputError;
use sphecs_output::folder::RunFolder;
use sphecs_output::header::Header;
use sphecs_output::lock::Lock;
use sphecs_output::pack::pack_locked;
use sphecs_output::probes::ProbeSet;
use sphecs_output::results::read_header;
use sphecs_output::summary::{Status, Summary};
use sphecs_scene::model::Scene;

/// Paths of a scene that a resumed run may change: they say how long it goes and what is written when, not what flows.
pub const CHANGEABLE: [&str; 4] =
    ["time.end", "output.every", "output.monitor_every", "output.checkpoint_every"];

/// What the user asks of a run that is gone on with.
#[derive(Clone, Debug)]
pub struct ResumeOptions {
    /// The folder, and the rest as of any run. An end by `until` or `steps` replaces that of the run.
    pub run: RunOptions,
    /// Changes of the scene: path and value.
    pub sets: Vec<(String, String)>,
    /// Go on although another instruction set gives other bits.
    pub allow_other_isa: bool,
}

/// Goes on with a run.
///
/// # Errors
/// [`RunError`]; before the first step the folder is as it was, unless its output could not be cut back.
pub fn resume(options: &ResumeOptions) -> Result<Ending, RunError> {
    let signals = Signals::listen().map_err(RunError::Signals)?;
    on_threads(options.run.threads, || resume_here(options, signals))?
}

/// The same on the pool of the thread that calls, whatever threads the options ask for, until these signals stop it.
///
/// # Errors
/// As those of [`resume`].
pub fn resume_here(options: &ResumeOptions, signals: Signals) -> Result<Ending, RunError> {
    match board(options, signals)? {
        Some(voyage) => voyage.sail(),
        None => Ok(Ending::Completed),
    }
}

/// The run ready for its next step; None when it is at its end.
fn board(options: &ResumeOptions, signals: Signals) -> Result<Option<Voyage>, RunError> {
    let path = options.run.folder.as_path();
    let mut header = read_header(path)?;
    let lock = Lock::take_plain(path)?;
    let status = Summary::read(path)?.status;
    let (scene, changes) = changed_scene(options, &header)?;
    let (last, facts, simulation, log) = match latest(options, &header)? {
        Some((last, checkpoint)) => {
            let (facts, simulation, log) = restored(scene, checkpoint)?;
            (Some(last), facts, simulation, log)
        }
        None => {
            let log = Log::new(scene.output.every, scene.output.monitor_every);
            (None, Facts::default(), Simulation::builder(scene).build()?, log)
        }
    };
    let (scene, clock) = (simulation.scene(), simulation.clock());
    let new_end = options.run.until.is_some() || options.run.steps.is_some();
    if new_end || options.sets.iter().any(|(path, _)| path == "time.end") {
        (header.until, header.most_steps) = (options.run.until, options.run.steps);
    }
    header.change(scene, changes);
    let until = header.until.unwrap_or(scene.time.end);
    let at_end = clock.time >= until || header.most_steps.is_some_and(|most| clock.step >= most);
    if at_end && status == Status::Completed {
        // It may have been killed while it was packed.
        pack_locked(path, &header)?;
        options.run.console.say(&format!(
            "`{}` is at its end, t = {} s after {} steps: give a later one by `--until` or `--set time.end=…`",
            path.display(),
            figure(clock.time),
            grouped(clock.step),
        ));
        return Ok(None);
    }
    let console = options.run.console;
    console.say(&opening::text(scene, simulation.ledger(), until, &options.run));
    console.say(&match facts.step {
        0 => "no checkpoint yet: the run begins anew\n".to_owned(),
        step => format!("goes on at t = {} s, step {}\n", figure(facts.time), grouped(step)),
    });
    Store::of(path).cut_back(last.as_deref())?;
    let folder = RunFolder::go_on(path, &header, &ProbeSet::new(scene), &facts, lock)?;
    Ok(Some(Voyage::go_on(simulation, folder, log, &options.run, signals)))
}

/// The scene of the run with all changes, and those changes.
fn changed_scene(
    options: &ResumeOptions,
    header: &Header,
) -> Result<(Scene, Vec<(String, String)>), RunError> {
    let folder = options.run.folder.display();
    if !header.is_scene_unchanged() {
        return Err(request(format!(
            "`{folder}/scene.ron`: has been changed since the run began, so that the run would be of two flows: put it back, or run \
             the changed scene into another folder"
        )));
    }
    if let Some((path, _)) = options.sets.iter().find(|(path, _)| !CHANGEABLE.contains(&path.as_str())) {
        return Err(request(format!(
            "--set {path}: cannot be changed in a run that goes on, only `{}` can: run the changed scene anew",
            CHANGEABLE.join("`, `")
        )));
    }
    let changes = [header.changes.clone(), options.sets.clone()].concat();
    let scene = Scene::from_text(&header.scene, &header.text)
        .tables(header.tables.clone())
        .sets(&changes)
        .memory(memory::available())
        .load()?;
    Ok((scene, changes))
}

/// The latest checkpoint that can be gone on from, with its path; None when the run has none yet.
fn latest(options: &ResumeOptions, header: &Header) -> Result<Option<(PathBuf, Checkpoint)>, RunError> {
    let run = options.run.folder.as_path();
    let store = Store::of(run);
    let fingerprint = header.fingerprint();
    let fits = |checkpoint: &Checkpoint| match &checkpoint.facts {
        facts if facts.scene_sha256 != fingerprint => Err("is of another scene".to_owned()),
        facts => cut::has_output(run, facts),
    };
    let (found, refused) = store.latest(fits)?;
    let named = |Refused { path, why }: &Refused| format!("`{}`: {why}", path.display());
    let Some((path, checkpoint)) = found else {
        if refused.is_empty() {
            return Ok(None);
        }
        let refused: Vec<String> = refused.iter().map(named).collect();
        return Err(request(format!(
            "no checkpoint can be gone on from, run the scene anew:\n{}",
            refused.join("\n")
        )));
    };
    let lanes = InstructionSet::best().name();
    if checkpoint.facts.lanes != lanes {
        let differ = format!(
            "`{}`: was written on {} lanes, this process has {lanes}: the bits will differ",
            path.display(),
            checkpoint.facts.lanes
        );
        if !options.allow_other_isa {
            // On a line of its own: in the middle of one it might be broken at a hyphen.
            return Err(request(format!("{differ};\n`--allow-other-isa` goes on nevertheless")));
        }
        options.run.console.warn(&format!("note: {differ}"));
    }
    if checkpoint.facts.version != env!("CARGO_PKG_VERSION") {
        options.run.console.warn(&format!(
            "note: `{}`: was written by sphecs {}, this is {}: the bits may differ",
            path.display(),
            checkpoint.facts.version,
            env!("CARGO_PKG_VERSION")
        ));
    }
    for refused in &refused {
        let step = grouped(checkpoint.facts.step);
        options.run.console.warn(&format!("note: {}; the one of step {step} is taken", named(refused)));
    }
    Ok(Some((path, checkpoint)))
}

fn restored(scene: Scene, checkpoint: Checkpoint) -> Result<(Facts, Simulation, Log), RunError> {
    let Checkpoint { facts, mut state } = checkpoint;
    let misfit =
        |what: String| request(format!("the checkpoint of step {} does not fit: {what}", facts.step));
    let log = state.take::<u8>(log::NAME).map_err(|error| misfit(error.to_string()))?;
    let log = decode_record(&log).map_err(misfit)?;
    let simulation = Simulation::builder(scene).state(state).build();
    let simulation = simulation.map_err(|error| misfit(error.to_string()))?;
    Ok((facts, simulation, log))
}

fn request(what: String) -> RunError {
    RunError::Output(OutputError::Request(what))
}
