//! The five zones of Alvarado-Rodríguez et al. (2017), Fig. 1, as a particle's column in the
//! arrays.

use serde::{Deserialize, Serialize};

/// Where a particle belongs. The number is what `particles.nc` stores in `zone`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[repr(u8)]
pub enum Zone {
    /// Moves by the equations of motion.
    #[default]
    Fluid = 0,
    /// A fixed image particle behind a wall.
    Wall = 1,
    /// Upstream of an inlet plane, velocity prescribed.
    Inflow = 2,
    /// Downstream of an outlet plane, moved by the outlet's condition.
    Outflow = 3,
    /// Stored, outside the flow: has no neighbours and no velocity.
    Reservoir = 4,
}

impl Zone {
    /// All zones in the order of their numbers.
    pub const ALL: [Zone; 5] = [Zone::Fluid, Zone::Wall, Zone::Inflow, Zone::Outflow, Zone::Reservoir];

    /// Whether particles of the zone belong to the flow: fluid, inflow and outflow.
    #[inline(always)]
    pub fn flows(self) -> bool {
        matches!(self, Zone::Fluid | Zone::Inflow | Zone::Outflow)
    }

    /// Returns the zone of a number; None beyond the last.
    pub fn from_number(number: u8) -> Option<Self> {
        Self::ALL.get(usize::from(number)).copied()
    }

    /// Lower-case name, as in CF `flag_meanings`.
    pub fn name(self) -> &'static str {
        match self {
            Zone::Fluid => "fluid",
            Zone::Wall => "wall",
            Zone::Inflow => "inflow",
            Zone::Outflow => "outflow",
            Zone::Reservoir => "reservoir",
        }
    }
}
