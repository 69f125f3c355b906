//! Output of a run that is due after a step: rows, samples, gridded fields, frames and forces.

use std::time::Instant;

use super::RunLoop;
use crate::console::Console;
use sphecs_core::format::{grouped, significant};
use sphecs_output::error::OutputError;
use sphecs_output::frame::Frame;
use sphecs_scene::model::ForcesEvery;

impl RunLoop {
    pub(super) fn write_due_output(&mut self) -> Result<(), OutputError> {
        let started = Instant::now();
        let time = self.simulation.clock().time;
        if self.state.rows.advance(time) {
            self.write_row()?;
        }
        let due = self.state.probes_due(time);
        self.write_samples(&due)?;
        self.fields.write(&mut self.simulation, (&mut self.folder, &mut self.state), false)?;
        self.walls.write(&mut self.simulation, (&mut self.folder, &mut self.state), false)?;
        if self.state.frames.advance(time) {
            self.write_frame()?;
        }
        self.state.output_time += started.elapsed().as_secs_f64();
        Ok(())
    }

    /// Writes the forces of the last step if they are due in every step or with the monitor row at
    /// its beginning.
    pub(super) fn write_forces(&mut self) -> Result<(), OutputError> {
        let row = self.simulation.body_forces();
        let every_step = self.simulation.scene().output.forces == ForcesEvery::Step;
        if every_step || self.state.last_row_step == Some(row.step) {
            self.folder.forces(row)?;
        }
        Ok(())
    }

    pub(super) fn write_last_output(&mut self) -> Result<(), OutputError> {
        let step = self.simulation.clock().step;
        // A row may be written at this step without a frame; a second one would repeat its time.
        if self.state.last_row_step != Some(step) {
            self.write_row()?;
        }
        self.write_samples(&self.state.probes_without(step))?;
        self.fields.write(&mut self.simulation, (&mut self.folder, &mut self.state), true)?;
        self.walls.write(&mut self.simulation, (&mut self.folder, &mut self.state), true)?;
        if self.state.last_frame != Some(step) {
            self.write_frame()?;
        }
        Ok(())
    }

    fn write_row(&mut self) -> Result<(), OutputError> {
        self.state.last_row = self.simulation.monitor_row();
        self.state.last_row_step = Some(self.state.last_row.step);
        self.folder.monitor(&self.state.last_row)?;
        for note in self.state.record_row(self.simulation.scene()) {
            self.display.print(&format!("note: {note}"));
        }
        Ok(())
    }

    /// Samples the probes that are due.
    fn write_samples(&mut self, due: &[bool]) -> Result<(), OutputError> {
        if !due.contains(&true) {
            return Ok(());
        }
        let clock = self.simulation.clock();
        let samples = self.simulation.sample_seeing(&self.probes.points(due));
        let pressures = self.simulation.sample_pressure(&self.probes.section_points(due));
        let flows = self.simulation.mass_flows(&self.probes.sections(due));
        self.folder.probe(&self.probes.reduce(due, clock.time, &samples, &pressures, &flows))?;
        self.state.record_samples(due, clock.step);
        Ok(())
    }

    fn write_frame(&mut self) -> Result<(), OutputError> {
        let clock = self.simulation.clock();
        let first = self.first_frame.take().filter(|first| first.step == clock.step);
        self.folder.submit(first.unwrap_or_else(|| Frame::of(&mut self.simulation)))?;
        if self.console == Console::Verbose {
            let row = &self.state.last_row;
            self.display.print(&format!(
                "frame {:>4}  t = {:<10} step {:<9} largest speed {} m/s, |Δρ|/ρ0 {}, {} through walls, {} close pairs",
                self.state.frame_count,
                format!("{} s", significant(clock.time)),
                grouped(clock.step),
                significant(row.largest_speed),
                significant(row.largest_density_deviation),
                row.through_walls,
                row.close_pairs,
            ));
        }
        self.state.last_frame = Some(clock.step);
        self.state.frame_count += 1;
        Ok(())
    }
}
