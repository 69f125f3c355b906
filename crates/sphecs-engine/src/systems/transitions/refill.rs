//! Injections at the far end of a zone that wait for a free position.
//!
//! Particles of a zone that came from the fluid are disordered, so that the position behind one
//! that entered the fluid may be taken. If the injection were omitted, the zone would thin out, and
//! with it the fluid: the outflow zone by 9 % in 6 s of a channel of 1 cm that a pressure drives,
//! and by 20 % in six periods of a channel whose inflow turns back, both under `EdacTvf`. It is
//! made up for as soon as its position is free, unless the zone has filled up meanwhile because
//! the flow turned.

use bevy_ecs::resource::Resource;
use serde::{Deserialize, Serialize};

use super::injection::Injection;

/// Injections that wait, and the particles that each outflow zone had at the start.
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct WaitingInjections {
    /// Particles of each outflow zone at the start.
    pub capacity: Vec<u64>,
    /// Injections, the oldest first.
    pub waiting: Vec<Injection>,
}
