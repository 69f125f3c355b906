//! Time, step and step size.

use bevy_ecs::resource::Resource;
use serde::{Deserialize, Serialize};

/// Time, step and step size.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Clock {
    /// Time, s.
    pub time: f64,
    /// Number of steps done.
    pub step: u64,
    /// Size of the last step, s.
    pub time_step: f64,
}
