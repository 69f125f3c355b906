//! Surface of a wall part as points with areas, for surface integrals.
//!
//! ```text
//! ∮ g dS = ∫ g(nearest point) δ(φ) dV,   δ(φ) = (1 + cos(π φ/Δ))/2Δ for |φ| < Δ
//! ```
//!
//! The signed distance φ is sampled four times per spacing Δ along each axis. The samples in a cell
//! of size Δ are merged into one point. As the band is symmetric about the surface, the area is of
//! second order in Δ/R.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use glam::DVec3;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use super::model::Scene;
use super::movers::Wall;
use super::wall_particles::surface_of;

/// A piece of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutlinePoint {
    /// Position, m.
    pub point: DVec3,
    /// Unit normal, into the fluid.
    pub normal: DVec3,
    /// Its area, m² (m in 2D).
    pub area: f64,
}

/// Returns the surface of a wall part at the start in pieces of about a spacing; their order is
/// reproducible. Of a mover it is the part inside the casing.
pub fn outline(scene: &Scene, part: u16) -> Vec<OutlinePoint> {
    let spacing = scene.spacing;
    let wall = Wall::of_part(scene, part);
    let is_covered = |point: DVec3| wall != Wall::Casing && Wall::Casing.distance(scene, point) > 0.0;
    let (low, high) = band(scene, wall, part);
    let axes: [Vec<f64>; 3] = std::array::from_fn(|axis| {
        if axis < scene.dimensions { samples(low[axis], high[axis], spacing) } else { vec![0.0] }
    });
    let mut volume = 1.0;
    for axis in 0..scene.dimensions {
        volume *= (high[axis] - low[axis]) / axes[axis].len() as f64;
    }
    // Distance of two samples of a line along z.
    let step = (high.z - low.z) / axes[2].len() as f64;
    let step = if scene.dimensions == 3 { step } else { spacing };
    let mut pieces: BTreeMap<[i64; 3], (f64, DVec3, DVec3)> = BTreeMap::new();
    let on_line = |x: f64, y: f64| {
        let mut found = Vec::new();
        let mut at = 0;
        while let Some(&z) = axes[2].get(at) {
            let sample = DVec3::new(x, y, z);
            let distance = wall.distance(scene, sample);
            // Nearer than by its way the distance does not fall.
            at += 1 + ((distance.abs() - spacing) / step).max(0.0) as usize;
            if distance.abs() >= spacing {
                continue;
            }
            let (point, normal, of) = surface_of(scene, wall, sample);
            if of == part && !is_covered(point) {
                let area = volume * (1.0 + (PI * distance / spacing).cos()) / (2.0 * spacing);
                found.push((area, point, normal));
            }
        }
        found
    };
    for &x in &axes[0] {
        // In the order of the lines: bitwise identical for any number of threads.
        let lines: Vec<_> = axes[1].par_iter().map(|&y| on_line(x, y)).collect();
        for (area, point, normal) in lines.into_iter().flatten() {
            let cell = ((point - low) / spacing).floor().as_i64vec3().to_array();
            let piece = pieces.entry(cell).or_default();
            *piece = (piece.0 + area, piece.1 + area * point, piece.2 + area * normal);
        }
    }
    let merged = |(area, point, normal): (f64, DVec3, DVec3)| OutlinePoint {
        point: point / area,
        normal: normal.normalize_or_zero(),
        area,
    };
    pieces.into_values().filter(|piece| piece.0 > 0.0).map(merged).collect()
}

/// Returns the corners of a box around the surface of a part, a period wide in periodic directions,
/// m.
fn band(scene: &Scene, wall: Wall, part: u16) -> (DVec3, DVec3) {
    let region = usize::from(part).checked_sub(1).and_then(|index| scene.layout.wall_regions.get(index));
    let (mut low, mut high) = wall.bounds(scene);
    if let Some((lower, upper)) = region.map(|region| region.bounds()) {
        (low, high) = (low.max(lower), high.min(upper));
    }
    let (mut low, mut high) = (low - scene.spacing, high + scene.spacing);
    for (axis, period) in scene.periodic.iter().enumerate() {
        if let Some((from, to)) = *period {
            (low[axis], high[axis]) = (from, to);
        }
    }
    (low, high)
}

/// Returns the centres of equal parts of an interval, at least four per spacing, m.
fn samples(low: f64, high: f64, spacing: f64) -> Vec<f64> {
    let count = (4.0 * (high - low) / spacing).ceil().max(1.0) as usize;
    (0..count).map(|at| low + (high - low) * (at as f64 + 0.5) / count as f64).collect()
}

#[cfg(test)]
mod tests {
    use crate::model::Scene;
    use std::f64::consts::PI;

    use glam::DVec3;

    use super::outline;

    /// Cylinder (2D) and sphere (3D) in a box, ten spacings in radius: the areas are exact, normals
    /// point outwards and sum to zero.
    #[test]
    fn outline_of_a_body_has_its_area_and_is_closed() {
        for (dimensions, ball, area) in [
            (2, "Circle(center: (0.1, 0.2)", 2.0 * PI * 0.25),
            (3, "Sphere(center: (0.1, 0.2, 0.0)", 4.0 * PI * 0.0625),
        ] {
            let corner = |at: f64| vec![format!("{at:?}"); dimensions].join(", ");
            let text = format!(
                r#"Scene(
                    title: "Drum", dimensions: {dimensions}, spacing: 0.025, smoke: 0.05,
                    fluid: (density: 1000.0, viscosity: 0.1, sound_speed: 10.0),
                    domain: Difference([Box(min: ({}), max: ({})), {ball}, radius: 0.25)]),
                    walls: (parts: [(name: "drum", region: {ball}, radius: 0.35))]),
                    reference: (velocity: 1.0, length: 1.0), time: (end: 1.0), output: (every: 1.0),
                )"#,
                corner(-0.7),
                corner(0.7)
            );
            let scene = Scene::from_text("drum", &text).load().unwrap_or_else(|faults| panic!("{faults:?}"));
            let middle = DVec3::new(0.1, 0.2, 0.0);
            let pieces = outline(&scene, 1);
            let found: f64 = pieces.iter().map(|piece| piece.area).sum();
            assert!((found / area - 1.0).abs() < 2e-3, "{found} of {area} m in {dimensions}D");
            let closed: DVec3 = pieces.iter().map(|piece| piece.normal * piece.area).sum();
            assert!(closed.length() < 2e-3 * area, "{closed}");
            for piece in &pieces {
                let out = (piece.point - middle) / 0.25;
                assert!((out - piece.normal).length() < 0.05, "{piece:?}");
            }
        }
    }
}
