//! Cost of a run by the first steps of its scene, without output.
//!
//! The size of a step is estimated from the sound speed and the viscosity before a run. Forces at
//! the start and the friction of particles close to a wall may limit it further. Steps that are
//! taken show that.

use std::time::Instant;

use sphecs_core::format::{duration, significant};
use sphecs_engine::simulation::{Simulation, Stop};
use sphecs_scene::model::Scene;
use sphecs_scene::summary::steps_to;

/// Wall time for the timed steps, s.
const TIMED_SECONDS: f64 = 1.0;

/// Steps before the timed ones: they allocate the buffers.
const WARM_UP: u32 = 2;

/// Least and largest number of timed steps.
const TIMED_STEPS: [u32; 2] = [3, 200];

/// Part of the estimated step size below which the first steps are noted as short.
const SHORT: f64 = 0.5;

/// Timed first steps of a flow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstSteps {
    /// Wall time of a step, s.
    wall_time: f64,
    /// Number of timed steps.
    count: u32,
    /// Mean size of the timed steps, s.
    size: f64,
}

impl FirstSteps {
    /// Returns the run time of an estimated number of steps to `until`, s.
    ///
    /// Where the first steps are short it is an interval up to the time with steps of their size.
    pub fn run_time_text(&self, steps: f64, until: f64) -> String {
        let threads = rayon::current_num_threads();
        let longest = if self.are_short(until / steps) {
            format!(" to {}", duration(until / self.size * self.wall_time))
        } else {
            String::new()
        };
        format!(
            "about {}{longest} on {threads} thread{}, without output: {} ms a step, measured over {}",
            duration(steps * self.wall_time),
            if threads == 1 { "" } else { "s" },
            significant(1e3 * self.wall_time),
            self.count
        )
    }

    /// Returns a note if the steps are much shorter than those by which a run to `until` (s) is
    /// estimated.
    pub fn short_step_note(&self, scene: &Scene, until: f64) -> Option<String> {
        let estimated = until / steps_to(scene, until);
        self.are_short(estimated).then(|| {
            format!(
                "the first steps are {} s long, {} of the estimate: forces at the start, or friction of \
                 particles close to a wall, limit them. If that lasts, the run takes {} steps; a slower start, \
                 or `Wcsph` for a very viscous flow, lengthens them",
                significant(self.size),
                significant(self.size / estimated),
                significant((until / self.size).ceil())
            )
        })
    }

    fn are_short(&self, estimated: f64) -> bool {
        self.size < SHORT * estimated
    }
}

/// Takes the first steps of a flow; returns the text on the run time to `until`, s, and a note if
/// the steps are short or the flow stops.
pub fn time_first_steps(
    simulation: Simulation,
    scene: &Scene,
    until: f64,
) -> (Option<String>, Option<String>) {
    match take_first_steps(simulation) {
        Ok(first) => {
            let text = first.run_time_text(steps_to(scene, until), until);
            (Some(text), first.short_step_note(scene, until))
        }
        Err(stop) => (None, Some(format!("the flow stops within its first steps: {stop}"))),
    }
}

/// Takes the first steps of a flow.
///
/// # Errors
/// [`Stop`] when the flow stops in these steps.
fn take_first_steps(mut simulation: Simulation) -> Result<FirstSteps, Stop> {
    for _ in 0..WARM_UP {
        simulation.step()?;
    }
    let (started, from) = (Instant::now(), simulation.clock().time);
    let mut count = 0;
    while count < TIMED_STEPS[0] || count < TIMED_STEPS[1] && started.elapsed().as_secs_f64() < TIMED_SECONDS
    {
        simulation.step()?;
        count += 1;
    }
    let wall_time = started.elapsed().as_secs_f64() / f64::from(count);
    let size = (simulation.clock().time - from) / f64::from(count);
    Ok(FirstSteps { wall_time, count, size })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_first_steps_lengthen_the_run_time() {
        let first = FirstSteps { wall_time: 0.01, count: 5, size: 1e-4 };
        // 1000 steps of 1e-3 s, 10 000 of 1e-4 s.
        let text = first.run_time_text(1000.0, 1.0);
        assert!(text.contains(&format!("{} to {}", duration(10.0), duration(100.0))), "{text}");
        let long = FirstSteps { size: 0.9e-3, ..first };
        assert!(!long.run_time_text(1000.0, 1.0).contains(" to "), "{}", long.run_time_text(1000.0, 1.0));
    }
}
