//! Reasons for which a simulation cannot continue.

use std::sync::{Arc, OnceLock};

use bevy_ecs::resource::Resource;

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
    /// A plugin asked to stop.
    #[error("stopped at step {step}, t = {} s: {reason}", with_digits(*time, 6))]
    Requested {
        /// Number of steps done.
        step: u64,
        /// Time, s.
        time: f64,
        /// Reason that the plugin gave.
        reason: String,
    },
}

/// Request of a plugin to stop.
///
/// A plugin inserts it, keeps a clone, and sets it where it cannot go further, also from a function
/// that the engine calls. The step in which it is set returns [`Stop::Requested`].
#[derive(Resource, Clone, Debug, Default)]
pub struct StopRequest(Arc<OnceLock<String>>);

impl StopRequest {
    /// Asks to stop; the first reason counts.
    pub fn set(&self, reason: impl Into<String>) {
        // A later reason is a consequence of the first.
        let _kept = self.0.set(reason.into());
    }

    /// Returns the reason, if a plugin has asked.
    pub fn reason(&self) -> Option<&str> {
        self.0.get().map(String::as_str)
    }
}
