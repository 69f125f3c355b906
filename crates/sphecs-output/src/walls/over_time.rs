//! Means at the points of the walls, accumulated during a run.
//!
//! ```text
//! w_k = t_k − t_(k−1), both limited to the interval of the mean,   W += w_k
//! ⟨f⟩ += w_k/W (f − ⟨f⟩),   OSI = ½ (1 − |⟨τ⟩|/⟨|τ|⟩)
//! ```
//!
//! The oscillatory shear index is that of He & Ku (1996): 0 where the shear stress keeps its
//! direction, ½ where it has none in the mean. The sums are those of West (1979). The stress on a
//! wall that moves is summed in the directions of its place at the start.

use std::sync::Arc;

use glam::DVec3;

use super::at_time::SampleSurface;
use super::{AXES, WallQuantity, WallSites};
use sphecs_core::math::column::{ColumnMismatch, Columns};
use sphecs_scene::model::Scene;
use sphecs_scene::wall_points::WallPoint;

/// Sums for the means at the walls.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WallSums {
    /// Time covered, s.
    duration: f64,
    /// Columns over the points: W, ⟨p⟩, Σ of its variance, ⟨|τ|⟩, ⟨y⁺⟩, ⟨τ⟩.
    columns: Vec<Vec<f64>>,
}

/// Means at the walls.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WallMeans {
    /// Interval that they cover, s.
    pub covered: (f64, f64),
    /// The points at the start.
    pub points: Arc<Vec<WallPoint>>,
    /// Columns over the points in the order of their names in the file; NaN where there was no
    /// fluid.
    pub columns: Vec<Vec<f64>>,
}

/// Indices of the columns of the sums.
const WEIGHT: usize = 0;
const PRESSURE: usize = 1;
const VARIANCE: usize = 2;
const MAGNITUDE: usize = 3;
const Y_PLUS: usize = 4;
const SHEAR: usize = 5;

/// Returns the means that are written.
pub(crate) fn means(dimensions: usize) -> Vec<WallQuantity> {
    let mean = |name: &str, unit, long_name: &str, method| WallQuantity {
        method,
        ..WallQuantity::new(name, unit, long_name)
    };
    let mut all = vec![
        mean("pressure_mean", "Pa", "mean pressure above that of the reference density", "mean"),
        mean("pressure_variance", "Pa2", "variance of the pressure", "variance"),
        mean("wall_shear_stress_mean", "Pa", "mean magnitude of the shear stress on the wall", "mean"),
        mean("y_plus_mean", "1", "mean distance of the first particles in viscous lengths", "mean"),
    ];
    all.extend(AXES[..dimensions].iter().map(|axis| {
        let long_name = format!("mean shear stress of the fluid on the wall along {axis}");
        mean(&format!("wall_shear_stress_{axis}_mean"), "Pa", &long_name, "mean")
    }));
    all.push(mean("oscillatory_shear_index", "1", "oscillatory shear index", "mean"));
    all.push(mean("fluid_time", "s", "time with fluid at the wall", "sum"));
    all
}

impl WallSums {
    /// Returns sums without samples.
    pub fn new(sites: &WallSites) -> Self {
        Self { duration: 0.0, columns: vec![vec![0.0; sites.points.len()]; SHEAR + sites.dimensions] }
    }

    /// Returns the time covered, s.
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// Adds the flow at a time, s, which stands for a duration, s.
    pub fn add(
        &mut self,
        sites: &WallSites,
        scene: &Scene,
        (time, duration): (f64, f64),
        sample: &mut SampleSurface<'_>,
    ) {
        self.duration += duration;
        let poses = scene.wall_poses(time);
        let found = sample(&sites.placed(scene, &poses, time));
        for (index, (point, flow)) in sites.points.iter().zip(found).enumerate() {
            let Some(flow) = flow else { continue };
            let y_plus = sites.y_plus(flow.shear);
            self.columns[WEIGHT][index] += duration;
            let part = duration / self.columns[WEIGHT][index];
            let mut towards = |column: usize, value: f64| {
                let mean = &mut self.columns[column][index];
                let before = value - *mean;
                *mean += part * before;
                before * (value - *mean)
            };
            let square = towards(PRESSURE, flow.pressure);
            towards(MAGNITUDE, flow.shear.length());
            towards(Y_PLUS, y_plus);
            let shear = scene.wall_direction_at_start(point.part, &poses, flow.shear);
            for axis in 0..sites.dimensions {
                towards(SHEAR + axis, shear[axis]);
            }
            self.columns[VARIANCE][index] += duration * square;
        }
    }

    /// Returns the means, which cover the interval `covered`, s.
    pub fn means(&self, sites: &WallSites, covered: (f64, f64)) -> WallMeans {
        let mut columns = vec![Vec::with_capacity(sites.points.len()); means(sites.dimensions).len()];
        for index in 0..sites.points.len() {
            let weight = self.columns[WEIGHT][index];
            let of = |column: usize| if weight > 0.0 { self.columns[column][index] } else { f64::NAN };
            let mut shear = DVec3::ZERO;
            (0..sites.dimensions).for_each(|axis| shear[axis] = of(SHEAR + axis));
            let mut values = vec![of(PRESSURE), of(VARIANCE) / weight, of(MAGNITUDE), of(Y_PLUS)];
            values.extend((0..sites.dimensions).map(|axis| shear[axis]));
            values.push(shear_index(shear, of(MAGNITUDE)));
            values.push(weight);
            columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
        }
        WallMeans { covered, points: Arc::clone(&sites.points), columns }
    }

    /// Saves the sums as columns of a checkpoint.
    pub fn save(&self, to: &mut Columns) {
        to.put("walls.duration", vec![self.duration]);
        for (index, column) in self.columns.iter().enumerate() {
            to.put(format!("walls.sum.{index}"), column.clone());
        }
    }

    /// Restores the sums that [`Self::save`] has saved.
    ///
    /// # Errors
    /// [`ColumnMismatch`] when a column is missing or has another length.
    pub fn restore(sites: &WallSites, from: &mut Columns) -> Result<Self, ColumnMismatch> {
        let mut restored = Self::new(sites);
        restored.duration = from.take_exactly("walls.duration", 1)?[0];
        for (index, column) in restored.columns.iter_mut().enumerate() {
            *column = from.take_exactly(&format!("walls.sum.{index}"), column.len())?;
        }
        Ok(restored)
    }
}

/// Returns the oscillatory shear index of a mean stress and of its mean magnitude, Pa; 0 without
/// stress.
fn shear_index(mean: DVec3, magnitude: f64) -> f64 {
    if magnitude == 0.0 { 0.0 } else { 0.5 * (1.0 - mean.length() / magnitude).max(0.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sphecs_core::pass::surface_flow::SurfaceFlow;

    fn scene() -> Scene {
        let text = r#"Scene(
            title: "Box", dimensions: 2, spacing: 0.1, smoke: 0.1,
            fluid: (density: 1000.0, viscosity: 1.0e-3, sound_speed: 10.0),
            domain: Box(min: (0.0, 0.0), max: (1.0, 1.0)),
            time: (end: 4.0), reference: (velocity: 1.0), output: (every: 1.0, walls: (mean: (0.0, 4.0))),
        )"#;
        Scene::from_text("box", text).load().unwrap_or_else(|faults| panic!("{faults:?}"))
    }

    fn column(means: &WallMeans, name: &str) -> Vec<f64> {
        let index = super::means(2).iter().position(|quantity| quantity.name == name);
        means.columns[index.expect("a mean")].clone()
    }

    /// A stress of 3 Pa for 3 s and of −1 Pa for 1 s: mean 2 Pa, magnitude 2.5 Pa, index 0.1. The
    /// first point has fluid in the first part only.
    #[test]
    fn means_and_shear_index_are_weighted_by_time() {
        let scene = scene();
        let sites = WallSites::new(&scene);
        let mut sums = WallSums::new(&sites);
        for (time, duration, shear) in [(3.0, 3.0, 3.0), (4.0, 1.0, -1.0)] {
            sums.add(&sites, &scene, (time, duration), &mut |points| {
                let flow = SurfaceFlow { pressure: 5.0 * shear, shear: DVec3::X * shear };
                (0..points.len()).map(|point| (point > 0 || shear > 0.0).then_some(flow)).collect()
            });
        }
        let means = sums.means(&sites, (0.0, 4.0));
        let near = |name: &str, expected: [f64; 2]| {
            let found = column(&means, name);
            assert!(
                (found[0] - expected[0]).abs() < 1e-12 && (found[1] - expected[1]).abs() < 1e-12,
                "{name} {found:?}"
            );
        };
        near("wall_shear_stress_x_mean", [3.0, 2.0]);
        near("wall_shear_stress_mean", [3.0, 2.5]);
        near("oscillatory_shear_index", [0.0, 0.1]);
        near("pressure_mean", [15.0, 10.0]);
        near("pressure_variance", [0.0, 75.0]);
        near("fluid_time", [3.0, 4.0]);
        // Δ/2ν √(τ/ρ) = 50 s/m · √(3e-3) m/s, and √(1e-3) for the second part.
        let second = 50.0 * (0.75 * 3e-3_f64.sqrt() + 0.25 * 1e-3_f64.sqrt());
        near("y_plus_mean", [50.0 * 3e-3_f64.sqrt(), second]);
    }

    #[test]
    fn restored_sums_are_those_saved() {
        let scene = scene();
        let sites = WallSites::new(&scene);
        let mut sums = WallSums::new(&sites);
        sums.add(&sites, &scene, (0.5, 0.5), &mut |points| {
            vec![Some(SurfaceFlow { pressure: 0.3, shear: DVec3::Y }); points.len()]
        });
        let mut saved = Columns::default();
        sums.save(&mut saved);
        assert_eq!(WallSums::restore(&sites, &mut saved).expect("restored"), sums);
        assert!(WallSums::restore(&sites, &mut saved).is_err(), "the columns were taken");
    }
}
