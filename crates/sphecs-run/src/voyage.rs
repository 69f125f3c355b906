//! The loop of a run: step, write what is due, say how far it has come, stop when it is time.

use std::time::Instant;

use super::console::Console;
use super::display::Display;
use super::error::RunError;
use super::log::{self, Log};
use super::occasions::Occasions;
use super::pace::{Pace, Progress, fraction};
use super::signals::{Signal, Signals};
use super::words::{duration, figure, grouped};
use super::{Ending, RunOptions, opening, report, wreck};
use sphecs_core::math::lanes::InstructionSet;
use sphecs_core::particles::zone::Zone;
use sphecs_engine::saved_state::encode_record;
use sphecs_engine::simulation::{Simulation, Stop};
use sphecs_output::error::OutputError;
use sphecs_output::folder::RunFolder;
use sphecs_output::frame::Frame;
use sphecs_output::header::Header;
use sphecs_output::pack::Packed;
use sphecs_output::probes::ProbeSet;
use sphecs_output::summary::{LedgerCounts, StageTime, Status, Summary, this_build};
use sphecs_scene::model::{ForcesEvery, Scene};

/// A run under way.
pub struct Voyage {
    simulation: Simulation,
    folder: RunFolder,
    probes: ProbeSet,
    signals: Signals,
    console: Console,
    display: Display,
    until: f64,
    most_steps: u64,
    log: Log,
    occasions: Occasions,
    /// Step of the last checkpoint handed over; None before the first.
    last_checkpoint: Option<u64>,
    pace: Pace,
    /// How many of the simulation's notes were said.
    notes_said: usize,
    started: Instant,
}

/// Why the loop was left.
enum Halt {
    Done,
    Signal(Signal),
    OutOfTime,
    Flow(Stop),
}

impl Voyage {
    /// Builds the world, makes the folder and says what the run is.
    ///
    /// # Errors
    /// [`RunError::Output`] when the folder cannot be made.
    pub fn begin(scene: Scene, options: &RunOptions, signals: Signals) -> Result<Self, RunError> {
        let mut simulation = Simulation::builder(scene).build()?;
        let first = Frame::from_world(simulation.world_mut());
        let scene = simulation.scene();
        let mut header = Header::new(scene, &first);
        (header.until, header.most_steps) = (options.until, options.steps);
        let probes = ProbeSet::new(scene);
        let until = options.until.unwrap_or(scene.time.end);
        let folder = RunFolder::create(&options.folder, options.force, &header, &probes)?;
        options.console.say(&opening::text(scene, simulation.ledger(), until, options));
        let log = Log::new(scene.output.every, scene.output.monitor_every);
        Ok(Self::new(simulation, folder, log, None, options, signals))
    }

    /// Goes on with a run: the folder is cut back, the simulation and the log are those of a checkpoint. What ends the run is in the
    /// folder's header.
    pub(super) fn go_on(
        simulation: Simulation,
        folder: RunFolder,
        log: Log,
        options: &RunOptions,
        signals: Signals,
    ) -> Self {
        let scene = simulation.scene();
        let time = simulation.clock().time;
        let log = Log {
            frames: log.frames.going_on(scene.output.every, time),
            rows: log.rows.going_on(scene.output.monitor_every, time),
            ..log
        };
        let last = (simulation.clock().step > 0).then_some(simulation.clock().step);
        Self::new(simulation, folder, log, last, options, signals)
    }

    fn new(
        simulation: Simulation,
        folder: RunFolder,
        log: Log,
        last_checkpoint: Option<u64>,
        options: &RunOptions,
        signals: Signals,
    ) -> Self {
        let (scene, header) = (simulation.scene(), folder.header());
        let until = header.until.unwrap_or(scene.time.end);
        let most_steps = header.most_steps.unwrap_or(u64::MAX);
        let every = options.checkpoint_every.unwrap_or(scene.output.checkpoint_every);
        let started = Instant::now();
        let begun = Progress {
            elapsed: 0.0,
            fraction: fraction(&simulation.clock(), until, most_steps),
            particle_steps: log.particle_steps,
        };
        Self {
            occasions: Occasions::new(started, every, options.most_wall_time),
            probes: ProbeSet::new(scene),
            notes_said: simulation.notes().len(),
            simulation,
            folder,
            signals,
            console: options.console,
            display: Display::new(options.console),
            until,
            most_steps,
            log,
            last_checkpoint,
            pace: Pace::from(begun),
            started,
        }
    }

    /// Goes to the end, or as far as it comes.
    ///
    /// # Errors
    /// [`RunError`]; the folder is closed whatever happens.
    pub fn sail(mut self) -> Result<Ending, RunError> {
        let halt = self.steps();
        self.display.clear();
        match halt {
            Ok(Halt::Done) => self.close(Status::Completed, None).map(|()| Ending::Completed),
            Ok(Halt::Signal(signal)) => {
                let status = match signal {
                    Signal::Interrupt => Status::Interrupted,
                    Signal::Terminate => Status::Terminated,
                };
                self.close(status, None).map(|()| Ending::Stopped(signal))
            }
            Ok(Halt::OutOfTime) => self.close(Status::OutOfTime, None).map(|()| Ending::OutOfTime),
            Ok(Halt::Flow(stop)) => Err(self.wreck(stop)),
            Err(error) => {
                // The first error is the one to report: closing may well fail for the same reason, a full disk.
                let summary = self.summary(Status::Failed, Some(error.to_string()));
                let _second = self.folder.finish(summary);
                Err(error.into())
            }
        }
    }

    fn steps(&mut self) -> Result<Halt, OutputError> {
        loop {
            self.write_what_is_due()?;
            let now = Instant::now();
            let halt = self.halt(now);
            // Before the last row and frame, which a run that goes on past here does not have.
            if halt.is_some() || self.occasions.is_checkpoint_due(now) || self.signals.take_checkpoint() {
                self.write_checkpoint(now)?;
            }
            if let Some(halt) = halt {
                self.write_last()?;
                return Ok(halt);
            }
            if let Err(stop) = self.simulation.step() {
                if matches!(stop, Stop::ReservoirEmpty { .. } | Stop::Drained { .. }) {
                    self.write_last()?;
                }
                return Ok(Halt::Flow(stop));
            }
            self.say_notes();
            self.write_forces()?;
            self.take_pace();
        }
    }

    /// Says what was found of the outlets in the step.
    fn say_notes(&mut self) {
        for note in &self.simulation.notes()[self.notes_said..] {
            self.display.say(&format!("note: {note}"));
            self.notes_said += 1;
        }
    }

    fn halt(&self, now: Instant) -> Option<Halt> {
        let clock = self.simulation.clock();
        if clock.time >= self.until || clock.step >= self.most_steps {
            return Some(Halt::Done);
        }
        let signal = self.signals.received().map(Halt::Signal);
        signal.or_else(|| self.occasions.is_time_up(now).then_some(Halt::OutOfTime))
    }

    /// Hands the state to the thread that writes, unless this step has its checkpoint.
    fn write_checkpoint(&mut self, now: Instant) -> Result<(), OutputError> {
        self.occasions.checkpoint_taken(now);
        let clock = self.simulation.clock();
        if self.last_checkpoint == Some(clock.step) {
            return Ok(());
        }
        self.last_checkpoint = Some(clock.step);
        let mut state = self.simulation.state();
        let log = Log {
            wall_time: self.wall_time(),
            stages: self.stages().into_iter().map(|(_, seconds)| seconds).collect(),
            ..self.log.clone()
        };
        state.put(log::NAME, encode_record(&log));
        self.folder.checkpoint(&clock, state)?;
        self.log.output_time += now.elapsed().as_secs_f64();
        if self.console == Console::Verbose {
            self.display.say(&format!(
                "checkpoint  t = {} s step {}",
                figure(clock.time),
                grouped(clock.step)
            ));
        }
        Ok(())
    }

    /// Wall time of the run, earlier processes included, s.
    fn wall_time(&self) -> f64 {
        self.log.wall_time + self.started.elapsed().as_secs_f64()
    }

    /// Wall time by stage, earlier processes included.
    fn stages(&self) -> Vec<(&'static str, f64)> {
        let stages = self.simulation.stage_times().into_iter().enumerate();
        stages.map(|(index, (name, seconds))| (name, self.log.stage(index, seconds))).collect()
    }

    fn write_what_is_due(&mut self) -> Result<(), OutputError> {
        let started = Instant::now();
        let time = self.simulation.clock().time;
        if self.log.rows.take(time) {
            self.write_row()?;
        }
        if self.log.frames.take(time) {
            self.write_frame()?;
        }
        self.log.output_time += started.elapsed().as_secs_f64();
        Ok(())
    }

    /// The forces that the last step was made with. A row of the monitor at its beginning has them beside it.
    fn write_forces(&mut self) -> Result<(), OutputError> {
        let row = self.simulation.body_forces();
        let every_step = self.simulation.scene().output.forces == ForcesEvery::Step;
        if every_step || self.log.last_row_step == Some(row.step) {
            self.folder.forces(row)?;
        }
        Ok(())
    }

    fn write_last(&mut self) -> Result<(), OutputError> {
        let step = Some(self.simulation.clock().step);
        // A row may have been due at this step without a frame: twice in the table, it would be two times of one step.
        if self.log.last_row_step != step {
            self.write_row()?;
        }
        if self.log.last_frame != step {
            self.write_frame()?;
        }
        Ok(())
    }

    fn write_row(&mut self) -> Result<(), OutputError> {
        self.log.last_row = self.simulation.monitor_row();
        self.log.last_row_step = Some(self.log.last_row.step);
        self.folder.monitor(&self.log.last_row)?;
        if !self.probes.is_empty() {
            let samples = self.simulation.sample_seeing(&self.probes.points());
            let flows = self.simulation.mass_flows(&self.probes.sections());
            self.folder.probe(&self.probes.reduce(self.log.last_row.time, &samples, &flows))?;
        }
        Ok(())
    }

    fn write_frame(&mut self) -> Result<(), OutputError> {
        self.folder.submit(Frame::from_world(self.simulation.world_mut()))?;
        let clock = self.simulation.clock();
        if self.console == Console::Verbose {
            let row = &self.log.last_row;
            self.display.say(&format!(
                "frame {:>4}  t = {:<10} step {:<9} largest speed {} m/s, |Δρ|/ρ0 {}, {} through walls, {} close pairs",
                self.log.frame_count,
                format!("{} s", figure(clock.time)),
                grouped(clock.step),
                figure(row.largest_speed),
                figure(row.largest_density_deviation),
                row.through_walls,
                row.close_pairs,
            ));
        }
        self.log.last_frame = Some(clock.step);
        self.log.frame_count += 1;
        Ok(())
    }

    fn take_pace(&mut self) {
        let clock = self.simulation.clock();
        let ledger = self.simulation.ledger();
        self.log.particle_steps += (ledger.total() - ledger.count(Zone::Reservoir)) as f64;
        let fraction = fraction(&clock, self.until, self.most_steps);
        self.pace.record(Progress {
            elapsed: self.started.elapsed().as_secs_f64(),
            fraction,
            particle_steps: self.log.particle_steps,
        });
        let (pace, until) = (&self.pace, self.until);
        self.display.update(fraction, || {
            format!(
                "t = {} of {} s, step {}, Δt {} s, {} particle-steps/s, {} left",
                figure(clock.time),
                figure(until),
                grouped(clock.step),
                figure(clock.time_step),
                figure(pace.particle_steps_per_second()),
                pace.seconds_left().map_or("?".to_owned(), duration),
            )
        });
    }

    /// Packs the results and says what came of the run.
    fn close(self, status: Status, message: Option<String>) -> Result<(), RunError> {
        let summary = self.summary(status, message);
        let stages: Vec<(String, f64)> =
            summary.stages.iter().map(|stage| (stage.stage.clone(), stage.seconds)).collect();
        let (clock, ledger) = (self.simulation.clock(), self.simulation.ledger().clone());
        let (wall_time, particle_steps, console) = (summary.wall_time, self.log.particle_steps, self.console);
        let header = self.folder.header().clone();
        let path = self.folder.path().to_owned();
        let packed: Packed = self.folder.finish(summary)?;
        let stages: Vec<(&str, f64)> =
            stages.iter().map(|(name, seconds)| (name.as_str(), *seconds)).collect();
        console.say(&format!(
            "{}: {}, {} particle-steps/s\n\n{}\n\n{}\n\n{}",
            status.word(),
            report::reached(&clock, wall_time),
            figure(particle_steps / wall_time.max(f64::MIN_POSITIVE)),
            report::stages(&stages, wall_time),
            report::ledger(&ledger, &header.inlets, &header.outlets),
            report::results(&path, &packed),
        ));
        if status != Status::Completed {
            console.say(&format!("\ngo on by `sphecs resume {}`", path.display()));
        }
        Ok(())
    }

    /// Closes the folder of a flow that cannot go on.
    fn wreck(self, stop: Stop) -> RunError {
        let (status, cure) = wreck::cure(&stop);
        let summary = self.summary(status, Some(stop.to_string()));
        let (path, header) = (self.folder.path().to_owned(), self.folder.header().clone());
        let (clock, frames) = (self.simulation.clock(), self.log.frame_count);
        let kept = match self.folder.finish(summary) {
            Ok(_) => {
                let scene = self.simulation.scene();
                let of = |fault| wreck::particulars(&path, &header, scene, &clock, fault);
                let particulars = self.simulation.diverged_particle().map(of);
                particulars.unwrap_or_default() + &wreck::kept(&path, frames, self.last_checkpoint)
            }
            Err(error) => wreck::not_closed(&error),
        };
        RunError::Flow { stop, cure, kept }
    }

    fn summary(&self, status: Status, message: Option<String>) -> Summary {
        let clock = self.simulation.clock();
        let of_stage = |(stage, seconds): (&str, f64)| StageTime { stage: stage.to_owned(), seconds };
        let mut stages: Vec<StageTime> = self.stages().into_iter().map(of_stage).collect();
        stages.push(StageTime { stage: "output".to_owned(), seconds: self.log.output_time });
        Summary {
            status,
            message,
            wall_time: self.wall_time(),
            steps: clock.step,
            time: clock.time,
            frames: self.log.frame_count,
            threads: rayon::current_num_threads(),
            lanes: InstructionSet::best().name().to_owned(),
            ledger: LedgerCounts::from(self.simulation.ledger()),
            stages,
            notes: self.simulation.notes().to_vec(),
            build: this_build().to_owned(),
            run: self.folder.header().clone(),
        }
    }
}
