//! Loop of a run: steps, scheduled output, progress and the reasons to stop.

mod writing;

use std::time::Instant;

use crate::console::Console;
use crate::error::RunError;
use crate::gridded::GriddedFields;
use crate::output_schedule::WallClock;
use crate::progress::{Progress, ProgressDisplay, SpeedEstimate, fraction};
use crate::rank_messages::RankMessages;
use crate::ranks::Followers;
use crate::run_state::{self, RunState};
use crate::signals::{Signal, Signals};
use crate::wall_output::WallQuantities;
use crate::{Ending, RunOptions, report, waiting};
use sphecs_core::format::{duration, grouped, significant};
use sphecs_core::math::lanes::InstructionSet;
use sphecs_core::particles::zone::Zone;
use sphecs_engine::plugins::Plugin;
use sphecs_engine::saved_state::encode_record;
use sphecs_engine::simulation::{Simulation, SimulationBuilder, Stop};
use sphecs_output::error::OutputError;
use sphecs_output::folder::RunFolder;
use sphecs_output::frame::Frame;
use sphecs_output::header::{Header, InitialParticles};
use sphecs_output::pack::Packed;
use sphecs_output::probes::ProbeSet;
use sphecs_output::summary::{LedgerCounts, StageTime, Status, Summary, this_build};
use sphecs_scene::model::Scene;

/// A run in progress.
pub struct RunLoop {
    simulation: Simulation,
    folder: RunFolder,
    probes: ProbeSet,
    fields: GriddedFields,
    walls: WallQuantities,
    signals: Signals,
    console: Console,
    display: ProgressDisplay,
    until: f64,
    max_steps: u64,
    state: RunState,
    wall_clock: WallClock,
    /// Step of the last checkpoint submitted; None before the first.
    last_checkpoint: Option<u64>,
    speed: SpeedEstimate,
    /// Frame of the header, until it is written.
    first_frame: Option<Frame>,
    /// Number of the simulation's notes already printed.
    notes_printed: usize,
    started: Instant,
    /// Steps before this process.
    first_step: u64,
    /// Other ranks, which end when the simulation is dropped.
    _followers: Followers,
}

/// Reason to leave the loop.
enum Halt {
    Done,
    Signal(Signal),
    OutOfTime,
    Flow(Stop),
}

impl RunLoop {
    /// Builds the simulation, makes the folder and prints the start summary.
    ///
    /// # Errors
    /// [`RunError::Output`] when the folder cannot be made, [`RunError::Threads`] when another rank
    /// cannot be started.
    pub fn start(
        scene: Scene,
        plugins: Vec<Box<dyn Plugin + Send>>,
        options: &RunOptions,
        signals: Signals,
    ) -> Result<Self, RunError> {
        let has_plugins = !plugins.is_empty();
        if has_plugins && options.ranks.count() > 1 {
            let what = "plugins act on one rank alone: run the scene with one rank".to_owned();
            return Err(OutputError::Request(what).into());
        }
        let builder = options.ranks.begin(Simulation::builder(scene));
        let builder = plugins.into_iter().fold(builder, SimulationBuilder::plugin);
        let mut simulation = waiting::during("placing the particles", || builder.build())?;
        // Several ranks find the first densities together, and the first of them needs less memory
        // without a frame.
        let first_frame = (options.ranks.count() < 2).then(|| Frame::of(&mut simulation));
        let particles = match &first_frame {
            Some(first) => InitialParticles::of_frame(first),
            None => InitialParticles::of(&mut simulation),
        };
        let scene = simulation.scene();
        let mut header = Header::new(scene, &particles);
        (header.until, header.max_steps) = (options.until, options.max_steps);
        header.has_plugins = has_plugins;
        let probes = ProbeSet::new(scene);
        let until = options.until.unwrap_or(scene.time.end);
        let folder = RunFolder::create(&options.folder, options.force, &header, &probes)?;
        options.console.print(&report::start_summary(scene, simulation.ledger(), until, options));
        let state = RunState::new(scene);
        let sampled = (GriddedFields::new(scene), WallQuantities::new(scene));
        let run = Self::new(simulation, (folder, sampled), state, None, options, signals)?;
        Ok(Self { first_frame, ..run })
    }

    /// Continues a run whose folder is cut back to a checkpoint, from which simulation and state
    /// come; the header of the folder has the end of the run.
    ///
    /// # Errors
    /// [`RunError::Threads`] when another rank cannot be started.
    pub(super) fn resume(
        simulation: Simulation,
        (folder, sampled): (RunFolder, (GriddedFields, WallQuantities)),
        state: RunState,
        options: &RunOptions,
        signals: Signals,
    ) -> Result<Self, RunError> {
        let state = state.resumed(simulation.scene(), simulation.clock().time);
        let last = (simulation.clock().step > 0).then_some(simulation.clock().step);
        Self::new(simulation, (folder, sampled), state, last, options, signals)
    }

    fn new(
        mut simulation: Simulation,
        (folder, (fields, walls)): (RunFolder, (GriddedFields, WallQuantities)),
        state: RunState,
        last_checkpoint: Option<u64>,
        options: &RunOptions,
        signals: Signals,
    ) -> Result<Self, RunError> {
        let followers = options.ranks.start(&mut simulation)?;
        let first_step = simulation.clock().step;
        let (scene, header) = (simulation.scene(), folder.header());
        let (until, started) = (header.until.unwrap_or(scene.time.end), Instant::now());
        let max_steps = header.max_steps.unwrap_or(u64::MAX);
        let every = options.checkpoint_every.unwrap_or(scene.output.checkpoint_every);
        let progress = Progress {
            elapsed: 0.0,
            fraction: fraction(&simulation.clock(), until, max_steps),
            particle_steps: state.particle_steps,
        };
        Ok(Self {
            wall_clock: WallClock::new(started, every, options.max_wall_time),
            probes: ProbeSet::new(scene),
            first_frame: None,
            notes_printed: simulation.notes().len(),
            simulation,
            folder,
            fields,
            walls,
            signals,
            console: options.console,
            display: ProgressDisplay::new(options.console),
            until,
            max_steps,
            state,
            last_checkpoint,
            speed: SpeedEstimate::from(progress),
            started,
            first_step,
            _followers: followers,
        })
    }

    /// Advances the run to its end, or until it is stopped.
    ///
    /// # Errors
    /// [`RunError`]; the folder is closed in any case.
    pub fn run(mut self) -> Result<Ending, RunError> {
        let halt = self.steps();
        self.display.clear();
        match halt {
            Ok(Halt::Done) => self.close(Status::Completed).map(|()| Ending::Completed),
            Ok(Halt::Signal(signal)) => {
                let interrupted = signal == Signal::Interrupt;
                let status = if interrupted { Status::Interrupted } else { Status::Terminated };
                self.close(status).map(|()| Ending::Stopped(signal))
            }
            Ok(Halt::OutOfTime) => self.close(Status::OutOfTime).map(|()| Ending::OutOfTime),
            Ok(Halt::Flow(stop)) => Err(self.close_after_failure(stop)),
            Err(error) => {
                // The first error is reported: closing may fail for the same reason.
                let summary = self.summary(Status::Failed, Some(error.to_string()));
                let _second = self.folder.finish(summary);
                Err(error.into())
            }
        }
    }

    fn steps(&mut self) -> Result<Halt, OutputError> {
        loop {
            self.write_due_output()?;
            let now = Instant::now();
            let halt = self.halt(now);
            let is_requested = self.signals.take_checkpoint_request();
            // It precedes the last row and frame, which an uninterrupted run would not write.
            if halt.is_some() || self.wall_clock.is_checkpoint_due(now) || is_requested {
                self.write_checkpoint(now)?;
            }
            if let Some(halt) = halt {
                self.write_last_output()?;
                return Ok(halt);
            }
            if let Err(stop) = self.simulation.step() {
                if matches!(stop, Stop::ReservoirEmpty { .. } | Stop::Drained { .. }) {
                    self.write_last_output()?;
                }
                return Ok(Halt::Flow(stop));
            }
            self.print_notes();
            self.write_forces()?;
            self.update_progress();
        }
    }

    /// Prints the notes that the last step added.
    fn print_notes(&mut self) {
        for note in &self.simulation.notes()[self.notes_printed..] {
            self.display.print(&format!("note: {note}"));
            self.notes_printed += 1;
        }
    }

    fn halt(&self, now: Instant) -> Option<Halt> {
        let clock = self.simulation.clock();
        if clock.time >= self.until || clock.step >= self.max_steps {
            return Some(Halt::Done);
        }
        let signal = self.signals.received().map(Halt::Signal);
        signal.or_else(|| self.wall_clock.is_time_up(now).then_some(Halt::OutOfTime))
    }

    /// Submits the state to the writer thread, unless this step already has a checkpoint.
    fn write_checkpoint(&mut self, now: Instant) -> Result<(), OutputError> {
        self.wall_clock.checkpoint_written(now);
        let clock = self.simulation.clock();
        if self.last_checkpoint == Some(clock.step) {
            return Ok(());
        }
        self.last_checkpoint = Some(clock.step);
        let mut columns = self.simulation.state();
        let state = RunState {
            wall_time: self.wall_time(),
            stages: self.stages().into_iter().map(|(_, seconds)| seconds).collect(),
            ..self.state.clone()
        };
        self.fields.save(&mut columns);
        self.walls.save(&mut columns);
        columns.put(run_state::COLUMN, encode_record(&state));
        self.folder.checkpoint(&clock, columns)?;
        self.state.output_time += now.elapsed().as_secs_f64();
        if self.console == Console::Verbose {
            let (time, step) = (significant(clock.time), grouped(clock.step));
            self.display.print(&format!("checkpoint  t = {time} s step {step}"));
        }
        Ok(())
    }

    /// Returns the wall time of the run, earlier processes included, s.
    fn wall_time(&self) -> f64 {
        self.state.wall_time + self.started.elapsed().as_secs_f64()
    }

    /// Returns the wall time by stage, earlier processes included, s.
    fn stages(&self) -> Vec<(&'static str, f64)> {
        let stages = self.simulation.stage_times().into_iter().enumerate();
        stages.map(|(index, (name, seconds))| (name, self.state.stage(index, seconds))).collect()
    }

    fn update_progress(&mut self) {
        let clock = self.simulation.clock();
        let ledger = self.simulation.ledger();
        self.state.particle_steps += (ledger.total() - ledger.count(Zone::Reservoir)) as f64;
        let fraction = fraction(&clock, self.until, self.max_steps);
        self.speed.record(Progress {
            elapsed: self.started.elapsed().as_secs_f64(),
            fraction,
            particle_steps: self.state.particle_steps,
        });
        let (speed, until) = (&self.speed, self.until);
        self.display.update(fraction, || {
            format!(
                "t = {} of {} s, step {}, Δt {} s, {} particle-steps/s, {} left",
                significant(clock.time),
                significant(until),
                grouped(clock.step),
                significant(clock.time_step),
                significant(speed.particle_steps_per_second()),
                speed.seconds_left().map_or("?".to_owned(), duration),
            )
        });
    }

    /// Packs the results and prints the end summary.
    fn close(self, status: Status) -> Result<(), RunError> {
        let summary = self.summary(status, None);
        let wall_time = summary.wall_time;
        let stages = summary.stages.clone();
        let stages: Vec<(&str, f64)> =
            stages.iter().map(|stage| (stage.stage.as_str(), stage.seconds)).collect();
        let end = report::EndState {
            status,
            clock: self.simulation.clock(),
            wall_time,
            particle_steps: self.state.particle_steps,
            stages: &stages,
            ledger: &self.simulation.ledger().clone(),
            messages: self.messages(),
        };
        let (header, path) = (self.folder.header().clone(), self.folder.path().to_owned());
        let packed: Packed = self.folder.finish(summary)?;
        self.console.print(&report::end_summary(&end, &header, &path, &packed));
        Ok(())
    }

    /// Returns the messages between the ranks; None for one rank alone.
    fn messages(&self) -> Option<RankMessages> {
        let traffic = self.simulation.traffic();
        let steps = self.simulation.clock().step - self.first_step;
        let wall_time = self.started.elapsed().as_secs_f64();
        (!traffic.is_empty()).then_some(RankMessages { traffic, steps, wall_time })
    }

    /// Closes the folder of a flow that cannot be advanced further.
    fn close_after_failure(self, stop: Stop) -> RunError {
        let (status, cure) = report::status_and_cure(&stop);
        let summary = self.summary(status, Some(stop.to_string()));
        let (path, header) = (self.folder.path().to_owned(), self.folder.header().clone());
        let (clock, frames, scene) =
            (self.simulation.clock(), self.state.frame_count, self.simulation.scene());
        let report = match self.folder.finish(summary) {
            Ok(_) => {
                let report = |diverged| report::failure_report(&path, &header, scene, &clock, diverged);
                let on_particle = self.simulation.diverged_particle().map(report).unwrap_or_default();
                on_particle + &report::results_kept(&path, frames, self.last_checkpoint)
            }
            Err(error) => report::results_not_closed(&error),
        };
        RunError::Flow { stop, cure, report }
    }

    fn summary(&self, status: Status, message: Option<String>) -> Summary {
        let clock = self.simulation.clock();
        let stage_time = |(stage, seconds): (&str, f64)| StageTime { stage: stage.to_owned(), seconds };
        let mut stages: Vec<StageTime> = self.stages().into_iter().map(stage_time).collect();
        stages.push(StageTime { stage: "output".to_owned(), seconds: self.state.output_time });
        Summary {
            status,
            message,
            wall_time: self.wall_time(),
            steps: clock.step,
            time: clock.time,
            frames: self.state.frame_count,
            threads: rayon::current_num_threads(),
            ranks: self.simulation.ranks(),
            lanes: InstructionSet::best().name().to_owned(),
            ledger: LedgerCounts::from(self.simulation.ledger()),
            stages,
            notes: [self.simulation.notes(), &self.state.notes].concat(),
            build: this_build().to_owned(),
            run: self.folder.header().clone(),
        }
    }
}
