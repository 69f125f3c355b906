//! Particle counts: total = initial + grown + created − deleted, in integers, at every step.

use bevy_ecs::resource::Resource;
use serde::{Deserialize, Serialize};

use sphecs_core::particles::zone::Zone;

/// Particle counts since the start.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ledger {
    /// Particles at the start, reservoir included.
    pub initial: u64,
    /// Particles added because the reservoir was empty.
    pub grown: u64,
    /// Particles created without a reservoir.
    pub created: u64,
    /// Particles deleted.
    pub deleted: u64,
    /// Present count by zone, in the order of [`Zone::ALL`].
    pub by_zone: [u64; 5],
    /// Inflow → Fluid crossings through each inlet, then each emitter.
    pub entered: Vec<u64>,
    /// Fluid → Inflow crossings through each inlet (backflow), then 0 for each emitter.
    pub entered_back: Vec<u64>,
    /// Fluid → Outflow crossings through each outlet.
    pub left: Vec<u64>,
    /// Outflow → Fluid crossings through each outlet (backflow).
    pub left_back: Vec<u64>,
}

impl Ledger {
    /// Returns the present number of particles in a zone.
    pub fn count(&self, zone: Zone) -> u64 {
        self.by_zone[zone as usize]
    }

    /// Returns the number of particles in all zones.
    pub fn total(&self) -> u64 {
        self.by_zone.iter().sum()
    }

    /// Returns true if total = initial + grown + created − deleted.
    pub fn balances(&self) -> bool {
        self.total() + self.deleted == self.initial + self.grown + self.created
    }
}

/// Number of particles of each inflow zone in a steady flow: that at the start.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct InflowCapacity(pub Vec<u64>);
