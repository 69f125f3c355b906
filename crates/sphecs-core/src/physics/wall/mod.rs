//! Wall models.
//!
//! - [`dummy`]: velocity and pressure from the kernel mean of the fluid
//! - [`ghost`]: velocity and pressure from each fluid particle
//! - [`image`]: velocity continued linearly through the surface
//! - [`law`]: law of the wall for boundary layers thinner than the spacing
//! - [`transposed`]: shear of a moving surface by the transposed velocity gradient
//!
//! To add a model: a file with a type that implements [`WallMethod`], a variant of [`WallModel`]
//! and an arm of its dispatch below, and the source in docs/REFERENCES.md.

pub mod dummy;
pub mod ghost;
pub mod image;
pub mod law;
pub mod transposed;

use serde::{Deserialize, Serialize};

use dummy::Dummy;
use ghost::Ghost;
use image::Image;

/// Model of a wall in the sums of a fluid particle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub enum WallModel {
    /// Image particles, Morris et al. (1997). Take it wherever a boundary layer matters.
    Image {
        /// Largest factor 1 + d_w/d_a of the image velocity, dimensionless, default no cap; Morris
        /// et al. take 1.5.
        #[serde(default)]
        velocity_cap: Option<f64>,
        /// Source of the pressure of a wall particle.
        #[serde(default)]
        pressure: WallPressure,
    },
    /// Dummy particles, Adami et al. (2012): velocity and pressure continue the kernel mean of the
    /// fluid. Take it for sharp corners and few particles across.
    Dummy,
    /// Ghost particles of Simcenter STAR-CCM+: for each fluid particle its own velocity reversed
    /// relative to the wall, and its own pressure with the weight of the fluid between both. Take
    /// it to compare with codes that have it.
    Ghost,
}

/// A wall model: velocity and pressure of wall particles as the pair sums see them.
pub trait WallMethod {
    /// Returns the source of the pressure of a wall particle.
    fn pressure(&self) -> WallPressure;

    /// Returns the largest factor by which the difference v_a − v_wall is continued into the wall.
    fn largest_factor(&self) -> f64;

    /// Returns 1/d_a of the factor 1 + d_b/d_a, 1/m, of a fluid particle at a distance (m) from the
    /// wall.
    fn inverse_distance(&self, distance: f64, spacing: f64) -> f64;

    /// Returns d_b of the factor 1 + d_b/d_a, m, of a wall particle this far (m) behind the
    /// surface.
    fn image_distance(&self, distance: f64) -> f64;

    /// Returns true if viscous sums see a velocity from the kernel mean of the fluid in wall
    /// particles.
    fn sees_kernel_mean(&self) -> bool {
        false
    }

    /// Returns true if the divergence sees the reversed velocity of each fluid particle in wall
    /// particles.
    fn mirrors_velocity(&self) -> bool {
        false
    }

    /// Returns true if wall particles have a velocity and pressure of their own for each fluid
    /// particle, so that the fluid behind a thin wall can take their place.
    fn can_be_one_sided(&self) -> bool {
        false
    }

    /// Returns what is wrong with the parameters, if anything is.
    fn fault(&self) -> Option<&'static str> {
        None
    }
}

/// Evaluates an expression with the method of a model: the only match on the models.
macro_rules! with_model {
    ($model:expr, $method:ident => $result:expr) => {
        match $model {
            WallModel::Image { velocity_cap, pressure } => {
                let $method = Image { velocity_cap, pressure };
                $result
            }
            WallModel::Dummy => {
                let $method = Dummy;
                $result
            }
            WallModel::Ghost => {
                let $method = Ghost;
                $result
            }
        }
    };
}

impl Default for WallModel {
    fn default() -> Self {
        WallModel::Image { velocity_cap: None, pressure: WallPressure::Extrapolated }
    }
}

impl WallModel {
    /// Returns the source of the pressure of a wall particle.
    pub fn pressure(self) -> WallPressure {
        with_model!(self, method => method.pressure())
    }

    /// Returns the largest factor by which the difference v_a − v_wall is continued into the wall.
    pub fn largest_factor(self) -> f64 {
        with_model!(self, method => method.largest_factor())
    }

    /// Returns 1/d_a of the factor 1 + d_b/d_a, 1/m, of a fluid particle at a distance (m) from the
    /// wall.
    #[inline(always)]
    pub fn inverse_distance(self, distance: f64, spacing: f64) -> f64 {
        with_model!(self, method => method.inverse_distance(distance, spacing))
    }

    /// Returns d_b of the factor 1 + d_b/d_a, m, of a wall particle this far (m) behind the
    /// surface.
    #[inline(always)]
    pub fn image_distance(self, distance: f64) -> f64 {
        with_model!(self, method => method.image_distance(distance))
    }

    /// Returns true if viscous sums see a velocity from the kernel mean of the fluid in wall
    /// particles.
    pub fn sees_kernel_mean(self) -> bool {
        with_model!(self, method => method.sees_kernel_mean())
    }

    /// Returns true if the divergence sees the reversed velocity of each fluid particle in wall
    /// particles.
    pub fn mirrors_velocity(self) -> bool {
        with_model!(self, method => method.mirrors_velocity())
    }

    /// Returns true if wall particles have a velocity and pressure of their own for each fluid
    /// particle, so that the fluid behind a thin wall can take their place.
    pub fn can_be_one_sided(self) -> bool {
        with_model!(self, method => method.can_be_one_sided())
    }

    /// Returns what is wrong with the parameters, if anything is.
    pub fn fault(self) -> Option<&'static str> {
        with_model!(self, method => method.fault())
    }
}

/// Source of the pressure of a wall particle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum WallPressure {
    /// Adami et al. (2012): kernel mean of the pressure of the fluid, with its hydrostatic part.
    /// Take it unless results are compared with those of the mirrored pressure.
    #[default]
    Extrapolated,
    /// The pressure of each fluid particle with its hydrostatic part, p_a + ρ_a g·(x_w − x_a). Take
    /// it to compare with programs that use it.
    Mirrored,
}

/// Slip condition of a wall.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Slip {
    /// The fluid has the velocity of the wall at its surface. Take it for resolved boundary layers.
    #[default]
    NoSlip,
    /// The wall takes no tangential stress. Take it for symmetry planes and distant side walls.
    FreeSlip,
    /// The wall takes the stress of the law of the wall, Spalding (1961), from the flow a spacing
    /// away; pairs with it exert none. Take it for boundary layers that the spacing does not
    /// resolve.
    WallFunction,
}

impl Slip {
    /// Returns true if the pairs of fluid and wall exert no viscous force.
    pub fn is_free_in_pairs(self) -> bool {
        self != Slip::NoSlip
    }
}
