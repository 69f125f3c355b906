//! Pressure and shear stress at points of the walls, `walls.nc`, and their means over time.
//!
//! - [`at_time`]: the quantities at one time
//! - [`over_time`]: means and the oscillatory shear index, accumulated during a run
//! - `files`: the file of all times, made from the journal
//!
//! The fits at the points are in [`surface_flow`](sphecs_core::pass::surface_flow). A point without
//! fluid nearby has no values.

pub mod at_time;
pub(crate) mod files;
pub mod over_time;

use std::sync::Arc;

use glam::DVec3;

use sphecs_core::pass::surface_flow::{Friction, SurfacePoint};
use sphecs_core::physics::wall::Slip;
use sphecs_scene::model::Scene;
use sphecs_scene::movers::WallPoses;
use sphecs_scene::wall_points::{PlacedPoint, WallPoint};

/// A quantity at the points of the walls.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct WallQuantity {
    /// Name of its variable.
    pub(crate) name: String,
    /// Unit in UDUNITS notation.
    pub(crate) unit: &'static str,
    /// Long name.
    pub(crate) long_name: String,
    /// Method of the means in CF notation; empty for values at a time.
    pub(crate) method: &'static str,
}

impl WallQuantity {
    fn new(name: impl Into<String>, unit: &'static str, long_name: impl Into<String>) -> Self {
        Self { name: name.into(), unit, long_name: long_name.into(), method: "" }
    }
}

/// Names of the axes.
const AXES: [&str; 3] = ["x", "y", "z"];

/// Points of the walls of a scene; none without quantities at the walls.
#[derive(Clone, Debug, Default)]
pub struct WallSites {
    dimensions: usize,
    /// The points at the start.
    points: Arc<Vec<WallPoint>>,
    /// Friction at each point.
    friction: Vec<Friction>,
    /// True if a wall with points changes its place.
    moves: bool,
    /// Distance of the first particles from the wall over ν, s/m.
    scale: f64,
    /// Reference density, kg/m³.
    density: f64,
}

impl WallSites {
    /// Returns the points of a scene.
    pub fn new(scene: &Scene) -> Self {
        let points = scene.wall_points();
        let friction = |point: &WallPoint| match scene.friction_of(point.part) {
            Slip::FreeSlip => Friction::FreeSlip,
            Slip::NoSlip => Friction::NoSlip,
            Slip::WallFunction => Friction::WallFunction,
        };
        Self {
            dimensions: scene.dimensions,
            friction: points.iter().map(friction).collect(),
            points: Arc::new(points),
            moves: scene.has_moving_wall_points(),
            scale: 0.5 * scene.spacing / scene.fluid.viscosity,
            density: scene.fluid.density,
        }
    }

    /// Returns the points with their velocities at a time, s.
    fn placed(&self, scene: &Scene, poses: &WallPoses, time: f64) -> Vec<SurfacePoint> {
        let placed = |(point, &friction): (&WallPoint, &Friction)| {
            let placed = scene.placed_wall_point(point, poses, time);
            let PlacedPoint { position, normal, velocity, gradient } = placed;
            SurfacePoint { position, normal, velocity, gradient, friction }
        };
        self.points.iter().zip(&self.friction).map(placed).collect()
    }

    /// Returns y⁺ of the first particles for a shear stress, Pa; NaN for an inviscid fluid.
    fn y_plus(&self, shear: DVec3) -> f64 {
        if self.scale.is_finite() { (shear.length() / self.density).sqrt() * self.scale } else { f64::NAN }
    }
}
