//! Wall models: the door lists the rooms and holds the closed choices.

pub mod image;

use serde::{Deserialize, Serialize};

/// How a wall enters the sums of a fluid particle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum WallModel {
    /// Image particles, Morris et al. (1997).
    Image {
        /// Largest factor 1 + d_w/d_a of the image velocity; Morris et al. take 1.5. None: no cap.
        #[serde(default)]
        velocity_cap: Option<f64>,
        /// Where the pressure of a wall particle comes from.
        #[serde(default)]
        pressure: WallPressure,
    },
}

impl Default for WallModel {
    fn default() -> Self {
        WallModel::Image { velocity_cap: None, pressure: WallPressure::Extrapolated }
    }
}

/// Pressure of an image particle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum WallPressure {
    /// Adami et al. (2012): kernel mean of the fluid's pressure with its hydrostatic part.
    #[default]
    Extrapolated,
    /// Per pair: p_a + ρ_a (g − a_wall)·(x_w − x_a).
    Mirrored,
}

/// Whether the fluid sticks to a wall.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Slip {
    /// The fluid has the wall's velocity at its surface.
    #[default]
    NoSlip,
    /// The wall takes no tangential stress.
    FreeSlip,
}
