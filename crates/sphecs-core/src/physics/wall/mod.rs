//! Wall models: the door lists the rooms and holds the closed choices.
//!
//! To add a model: a room here; a variant of [`WallModel`] with an arm in each of its functions; in the pair loops, what it
//! does to a velocity or pressure that these functions cannot say; a row of the table in docs/walls.md, measured.

pub mod dummy;
pub mod ghost;
pub mod image;
pub mod law;
pub mod transposed;

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
    /// Dummy particles, Adami et al. (2012): velocity and pressure continue the kernel mean of the fluid's.
    Dummy,
    /// Ghost particles of Simcenter STAR-CCM+: for each fluid particle its own velocity turned about that of the wall, and
    /// its own pressure with the weight between both.
    Ghost,
}

impl Default for WallModel {
    fn default() -> Self {
        WallModel::Image { velocity_cap: None, pressure: WallPressure::Extrapolated }
    }
}

impl WallModel {
    /// Where the pressure of a wall particle comes from.
    pub fn pressure(self) -> WallPressure {
        match self {
            WallModel::Image { pressure, .. } => pressure,
            WallModel::Dummy => WallPressure::Extrapolated,
            WallModel::Ghost => WallPressure::Mirrored,
        }
    }

    /// Largest factor by which the difference v_a − v_wall is continued into the wall.
    pub fn largest_factor(self) -> f64 {
        match self {
            WallModel::Image { velocity_cap, .. } => velocity_cap.unwrap_or(f64::INFINITY),
            WallModel::Dummy => 1.0,
            WallModel::Ghost => ghost::FACTOR,
        }
    }

    /// 1/d_a of the factor 1 + d_b/d_a, 1/m, of a fluid particle at a distance (m) from the wall.
    #[inline(always)]
    pub fn inverse_distance(self, distance: f64, spacing: f64) -> f64 {
        match self {
            WallModel::Image { .. } => image::inverse_distance(distance, spacing),
            // A wall particle has the velocity that is seen.
            WallModel::Dummy => 0.0,
            WallModel::Ghost => ghost::INVERSE_DISTANCE,
        }
    }

    /// d_b of the factor 1 + d_b/d_a, m, of a wall particle this far behind the surface.
    #[inline(always)]
    pub fn image_distance(self, distance: f64) -> f64 {
        match self {
            WallModel::Image { .. } | WallModel::Dummy => distance,
            WallModel::Ghost => ghost::DISTANCE,
        }
    }
}

/// Pressure of a wall particle.
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
    /// The wall takes the stress of the law of the wall, Spalding (1961), from the flow a spacing away; pairs with it exert none. For
    /// boundary layers that the spacing does not resolve.
    WallFunction,
}

impl Slip {
    /// Whether the pairs of fluid and wall exert no viscous force.
    pub fn is_free_in_pairs(self) -> bool {
        self != Slip::NoSlip
    }
}
