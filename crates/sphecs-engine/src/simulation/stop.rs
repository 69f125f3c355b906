//! Reasons for which a simulation cannot continue.

use sphecs_core::format::with_digits;

/// Reason for which a simulation cannot continue.
#[derive(Clone, Debug, thiserror::Error)]
pub enum Stop {
    /// The flow diverged.
    #[error("the flow diverged at step {step}, t = {} s: {found}", with_digits(*time, 6))]
    Diverged {
        /// Number of steps done.
        step: u64,
        /// Time, s.
        time: f64,
        /// Impossible value, with the number, zone and position of the particle.
        found: String,
        /// Advice to the user.
        advice: &'static str,
    },
    /// An inlet that is filled once has no particles left.
    #[error("{inlet} is drained at step {step}, t = {} s", with_digits(*time, 6))]
    Drained {
        /// Number of steps done.
        step: u64,
        /// Time, s.
        time: f64,
        /// Name of the inlet.
        inlet: String,
    },
    /// The reservoir is empty, and the scene demands a stop.
    #[error("the reservoir is empty at step {step}, t = {} s", with_digits(*time, 6))]
    ReservoirEmpty {
        /// Number of steps done.
        step: u64,
        /// Time, s.
        time: f64,
    },
}
