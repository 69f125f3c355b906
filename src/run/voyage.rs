//! The loop of a run: step, write what is due, say how far it has come, stop when it is time.

use std::time::Instant;

use super::console::Console;
use super::display::Display;
use super::due::Due;
use super::error::RunError;
use super::pace::{Pace, Progress};
use super::signals::{Signal, Signals};
use super::words::{duration, figure, grouped};
use super::{Ending, RunOptions, opening, report};
use crate::math::lanes::InstructionSet;
use crate::output::error::OutputError;
use crate::output::folder::RunFolder;
use crate::output::frame::Frame;
use crate::output::header::Header;
use crate::output::pack::Packed;
use crate::output::probes::ProbeSet;
use crate::output::summary::{LedgerCounts, StageTime, Status, Summary};
use crate::particles::zone::Zone;
use crate::scene::model::Scene;
use crate::simulation::{Simulation, Stop};
use crate::systems::monitor::MonitorRow;

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
    frames: Due,
    rows: Due,
    /// Step of the last frame; None before the first.
    last_frame: Option<u64>,
    frame_count: u64,
    last_row: MonitorRow,
    /// Step of the last row; None before the first.
    last_row_step: Option<u64>,
    pace: Pace,
    particle_steps: f64,
    started: Instant,
    /// Wall time spent on handing frames and rows over, s.
    output_time: f64,
}

/// Why the loop was left.
enum Halt {
    Done,
    Signal(Signal),
    Flow(Stop),
}

impl Voyage {
    /// Builds the world, makes the folder and says what the run is.
    ///
    /// # Errors
    /// [`RunError::Output`] when the folder cannot be made.
    pub fn begin(scene: Scene, options: &RunOptions, signals: Signals) -> Result<Self, RunError> {
        let mut simulation = Simulation::from_scene(scene);
        let first = Frame::from_world(simulation.world_mut());
        let scene = simulation.scene();
        let header = Header::new(scene, &first);
        let probes = ProbeSet::new(scene);
        let (until, output) = (options.until.unwrap_or(scene.time.end), &scene.output);
        let (frames, rows) = (Due::every(output.every), Due::every(output.monitor_every));
        let folder = RunFolder::create(&options.folder, options.force, &header, &probes)?;
        options.console.say(&opening::text(scene, simulation.ledger(), until, options));
        Ok(Self {
            simulation,
            folder,
            probes,
            signals,
            console: options.console,
            display: Display::new(options.console),
            until,
            most_steps: options.steps.unwrap_or(u64::MAX),
            frames,
            rows,
            last_frame: None,
            frame_count: 0,
            last_row: MonitorRow::default(),
            last_row_step: None,
            pace: Pace::default(),
            particle_steps: 0.0,
            started: Instant::now(),
            output_time: 0.0,
        })
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
            let clock = self.simulation.clock();
            let halt = if clock.time >= self.until || clock.step >= self.most_steps {
                Some(Halt::Done)
            } else {
                self.signals.received().map(Halt::Signal)
            };
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
            self.take_pace();
        }
    }

    fn write_what_is_due(&mut self) -> Result<(), OutputError> {
        let started = Instant::now();
        let time = self.simulation.clock().time;
        if self.rows.take(time) {
            self.write_row()?;
        }
        if self.frames.take(time) {
            self.write_frame()?;
        }
        self.output_time += started.elapsed().as_secs_f64();
        Ok(())
    }

    fn write_last(&mut self) -> Result<(), OutputError> {
        let step = Some(self.simulation.clock().step);
        // A row may have been due at this step without a frame: twice in the table, it would be two times of one step.
        if self.last_row_step != step {
            self.write_row()?;
        }
        if self.last_frame != step {
            self.write_frame()?;
        }
        Ok(())
    }

    fn write_row(&mut self) -> Result<(), OutputError> {
        self.last_row = self.simulation.monitor_row();
        self.last_row_step = Some(self.last_row.step);
        self.folder.monitor(&self.last_row)?;
        if !self.probes.is_empty() {
            let samples = self.simulation.sample(&self.probes.points());
            self.folder.probe(&self.probes.reduce(self.last_row.time, &samples))?;
        }
        Ok(())
    }

    fn write_frame(&mut self) -> Result<(), OutputError> {
        self.folder.submit(Frame::from_world(self.simulation.world_mut()))?;
        let clock = self.simulation.clock();
        if self.console == Console::Verbose {
            let row = &self.last_row;
            self.display.say(&format!(
                "frame {:>4}  t = {:<10} step {:<9} largest speed {} m/s, |Δρ|/ρ0 {}, {} through walls, {} close pairs",
                self.frame_count,
                format!("{} s", figure(clock.time)),
                grouped(clock.step),
                figure(row.largest_speed),
                figure(row.largest_density_deviation),
                row.through_walls,
                row.close_pairs,
            ));
        }
        self.last_frame = Some(clock.step);
        self.frame_count += 1;
        Ok(())
    }

    fn take_pace(&mut self) {
        let clock = self.simulation.clock();
        let ledger = self.simulation.ledger();
        self.particle_steps += (ledger.total() - ledger.count(Zone::Reservoir)) as f64;
        let fraction = (clock.time / self.until).max(clock.step as f64 / self.most_steps as f64).min(1.0);
        self.pace.record(Progress {
            elapsed: self.started.elapsed().as_secs_f64(),
            fraction,
            particle_steps: self.particle_steps,
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
        let (wall_time, particle_steps, console) = (summary.wall_time, self.particle_steps, self.console);
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
        Ok(())
    }

    /// Closes the folder of a flow that cannot go on.
    fn wreck(self, stop: Stop) -> RunError {
        let (status, cure) = match &stop {
            Stop::BlowUp { cure, .. } => (Status::BlownUp, (*cure).to_owned()),
            Stop::Drained { .. } => {
                (Status::Failed, "lengthen its `depth`, lower `time.end`, or let it be `Fed`".to_owned())
            }
            Stop::ReservoirEmpty { .. } => (
                Status::Failed,
                "raise `reservoir.initial`, or let it grow with `when_empty: Grow`".to_owned(),
            ),
        };
        let summary = self.summary(status, Some(stop.to_string()));
        let path = self.folder.path().display().to_string();
        let clock_of_frame = self.frame_count;
        match self.folder.finish(summary) {
            Ok(_) => {
                let kept = format!(
                    "\n{clock_of_frame} frames up to there are in `{path}`: `sphecs render {path} --all` draws how it came"
                );
                RunError::Flow { stop, cure, kept }
            }
            Err(error) => {
                RunError::Flow { stop, cure, kept: format!("\nthe results could not be closed: {error}") }
            }
        }
    }

    fn summary(&self, status: Status, message: Option<String>) -> Summary {
        let clock = self.simulation.clock();
        let mut stages: Vec<StageTime> = self
            .simulation
            .stage_times()
            .into_iter()
            .map(|(stage, seconds)| StageTime { stage: stage.to_owned(), seconds })
            .collect();
        stages.push(StageTime { stage: "output".to_owned(), seconds: self.output_time });
        Summary {
            status,
            message,
            wall_time: self.started.elapsed().as_secs_f64(),
            steps: clock.step,
            time: clock.time,
            frames: self.frame_count,
            threads: rayon::current_num_threads(),
            lanes: InstructionSet::best().name().to_owned(),
            ledger: LedgerCounts::from(self.simulation.ledger()),
            stages,
            run: self.folder.header().clone(),
        }
    }
}
