//! Reasons for which a simulation cannot continue.

/// Reason for which a simulation cannot continue.
#[derive(Clone, Debug, thiserror::Error)]
pub enum Stop {
    /// The flow diverged.
    #[error("the flow diverged at step {step}, t = {time:.6} s: {found}")]
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
    #[error("{inlet} is drained at step {step}, t = {time:.6} s")]
    Drained {
        /// Number of steps done.
        step: u64,
        /// Time, s.
        time: f64,
        /// Name of the inlet.
        inlet: String,
    },
    /// The reservoir is empty, and the scene demands a stop.
    #[error("the reservoir is empty at step {step}, t = {time:.6} s")]
    ReservoirEmpty {
        /// Number of steps done.
        step: u64,
        /// Time, s.
        time: f64,
    },
}
