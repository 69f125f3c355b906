//! Quantities at the points of the walls at one time.
//!
//! ```text
//! y⁺ = u_τ Δ/2ν,   u_τ = √(|τ|/ρ0),   Δ/2: distance of the first particles from the wall
//! ```

use std::sync::Arc;

use glam::DVec3;

use super::{AXES, WallQuantity, WallSites};
use sphecs_core::pass::surface_flow::{SurfaceFlow, SurfacePoint};
use sphecs_scene::model::Scene;
use sphecs_scene::wall_points::WallPoint;

/// Samples the flow at points of the walls.
pub type SampleSurface<'a> = dyn FnMut(&[SurfacePoint]) -> Vec<Option<SurfaceFlow>> + 'a;

/// Quantities at the walls at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WallSnapshot {
    /// Time, s.
    pub time: f64,
    /// Steps done.
    pub step: u64,
    /// The points at the start.
    pub points: Arc<Vec<WallPoint>>,
    /// Columns over the points in the order of their names in the file; NaN without fluid.
    pub columns: Vec<Vec<f32>>,
}

/// Returns the quantities that are written at each time.
pub(crate) fn quantities(dimensions: usize, moves: bool) -> Vec<WallQuantity> {
    let axes = &AXES[..dimensions];
    let mut all = vec![WallQuantity::new("pressure", "Pa", "pressure above that of the reference density")];
    all.extend(axes.iter().map(|axis| {
        let long_name = format!("shear stress of the fluid on the wall along {axis}");
        WallQuantity::new(format!("wall_shear_stress_{axis}"), "Pa", long_name)
    }));
    let long_name = "distance of the first particles from the wall, half a spacing, in viscous lengths";
    all.push(WallQuantity::new("y_plus", "1", long_name));
    if moves {
        all.extend(axes.iter().map(|axis| WallQuantity::new(*axis, "m", format!("{axis} coordinate"))));
        all.extend(axes.iter().map(|axis| {
            let long_name = format!("unit normal of the wall along {axis}, into the fluid");
            WallQuantity::new(format!("normal_{axis}"), "1", long_name)
        }));
    }
    all
}

impl WallSites {
    /// Samples the quantities at a time, s.
    pub fn snapshot(
        &self,
        scene: &Scene,
        (time, step): (f64, u64),
        sample: &mut SampleSurface<'_>,
    ) -> WallSnapshot {
        let placed = self.placed(scene, &scene.wall_poses(time), time);
        let found = sample(&placed);
        let axes = 0..self.dimensions;
        let count = quantities(self.dimensions, self.moves).len();
        let mut columns: Vec<Vec<f32>> = vec![Vec::with_capacity(placed.len()); count];
        for (point, flow) in placed.iter().zip(found) {
            let mut next = columns.iter_mut();
            let mut put = |value: f64| {
                if let Some(column) = next.next() {
                    column.push(value as f32);
                }
            };
            let absent = SurfaceFlow { pressure: f64::NAN, shear: DVec3::NAN };
            let flow = flow.unwrap_or(absent);
            put(flow.pressure);
            axes.clone().for_each(|axis| put(flow.shear[axis]));
            put(self.y_plus(flow.shear));
            if self.moves {
                axes.clone().for_each(|axis| put(point.position[axis]));
                axes.clone().for_each(|axis| put(point.normal[axis]));
            }
        }
        WallSnapshot { time, step, points: Arc::clone(&self.points), columns }
    }
}
