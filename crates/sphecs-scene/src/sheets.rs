//! Layers of wall particles along a surface in 3D: evenly spread by repulsion.
//!
//! ```text
//! x_i(0): wall particles of the lattice, φ = k Δ … (k + 1) Δ, moved to φ = (k + ½) Δ
//! x_i += β Δ P Σ_j (1 − r_ij/R)² x_ij/r_ij,   R = 1.7 Δ,  P: projection onto the layer
//! ```
//!
//! A layer so has as many particles as its shell has volumes Δ³. The sum runs over the neighbours
//! in the same layer; φ is the signed distance behind the surface.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use super::layers::moved_to;
use super::model::Scene;
use super::movers::Wall;

/// Radius of the repulsion R, in spacings.
const RADIUS: f64 = 1.7;

/// Step of the repulsion β, in spacings.
const STEP: f64 = 0.12;

/// Number of steps.
const STEPS: usize = 40;

/// Largest distance of a particle from its layer, in spacings: at sharp edges of a wall a layer
/// ends.
const OFF_THE_LAYER: f64 = 0.05;

/// Returns the particles of the layers at some depths, m, from the lattice's wall particles behind
/// a surface.
pub fn spread(scene: &Scene, wall: Wall, walls: &[DVec3], depths: &[f64]) -> Vec<Vec<DVec3>> {
    let mut layers: Vec<Vec<DVec3>> = vec![Vec::new(); depths.len()];
    for point in walls {
        let layer = (wall.distance(scene, *point) / scene.spacing).floor();
        if layer >= 0.0
            && let Some(layer) = layers.get_mut(layer as usize)
        {
            layer.push(*point);
        }
    }
    let of_layer = |(points, depth): (Vec<DVec3>, &f64)| {
        let points = points.par_iter().map(|point| moved_to(scene, wall, *point, *depth)).collect();
        let is_on_it =
            |point: &DVec3| (wall.distance(scene, *point) - depth).abs() < OFF_THE_LAYER * scene.spacing;
        relaxed(scene, wall, points, *depth).into_iter().filter(is_on_it).collect()
    };
    layers.into_iter().zip(depths).map(of_layer).collect()
}

/// Returns a cell and those around it.
pub fn around([x, y, z]: [i64; 3]) -> impl Iterator<Item = [i64; 3]> {
    (0..27).map(move |at| [x + at % 3 - 1, y + at / 3 % 3 - 1, z + at / 9 - 1])
}

/// Returns the particles of a layer after they have repelled each other.
fn relaxed(scene: &Scene, wall: Wall, mut points: Vec<DVec3>, depth: f64) -> Vec<DVec3> {
    let radius = RADIUS * scene.spacing;
    for _ in 0..STEPS {
        let mut cells: BTreeMap<[i64; 3], Vec<DVec3>> = BTreeMap::new();
        let cell = |point: DVec3| (point / radius).floor().as_i64vec3().to_array();
        points.iter().for_each(|point| cells.entry(cell(*point)).or_default().push(*point));
        points = points
            .par_iter()
            .map(|&point| {
                let mut push = DVec3::ZERO;
                for other in around(cell(point)).filter_map(|near| cells.get(&near)).flatten() {
                    let way = point - *other;
                    let distance = way.length();
                    if distance > 0.0 && distance < radius {
                        push += way * ((1.0 - distance / radius).powi(2) / distance);
                    }
                }
                let step = (STEP * scene.spacing * push).clamp_length_max(0.2 * scene.spacing);
                moved_to(scene, wall, point + step, depth)
            })
            .collect();
    }
    points
}

#[cfg(test)]
mod tests {
    use crate::model::Scene;
    use crate::spawn::seeds;
    use sphecs_core::particles::zone::Zone;

    /// A sphere and a tilted box: particles lie in the middle of the layers, as many as the shells
    /// have volumes, and no two are nearer than on other walls.
    #[test]
    fn sheets_have_the_volume_of_their_shells() {
        let pi = std::f64::consts::PI;
        // The walls are 3.9 spacings thick.
        let reach: f64 = 0.39;
        let shells = |radius: f64| 4.0 / 3.0 * pi * ((radius + reach).powi(3) - radius.powi(3)) / 1e-3;
        for (domain, expected) in [
            ("Sphere(center: (0.01, 0.02, 0.03), radius: 0.6)", shells(0.6)),
            (
                "Rotated(angle: 25.0, axis: (1.0, 1.0, 0.3), shape: Box(min: (-0.5, -0.5, -0.5), max: (0.5, 0.5, 0.5)))",
                (6.0 * reach + 3.0 * pi * reach.powi(2)) / 1e-3 + shells(0.0),
            ),
        ] {
            let text = format!(
                "Scene(title: \"t\", dimensions: 3, spacing: 0.1, smoke: 0.2,
                    fluid: (density: 1000.0, viscosity: 1.0e-3, sound_speed: 15.0), fill: Lattice(angle: 0.0),
                    domain: {domain}, walls: (slip: FreeSlip, fill: Layers),
                    initial: (velocity: (0.1, 0.0, 0.0)), time: (end: 1.0), output: (every: 1.0))"
            );
            let scene = Scene::from_text("walls", &text).load().unwrap_or_else(|faults| panic!("{faults:?}"));
            let walls: Vec<_> = seeds(&scene).into_iter().filter(|seed| seed.zone == Zone::Wall).collect();
            let share = walls.len() as f64 / expected;
            assert!((share - 1.0).abs() < 0.06, "{domain}: {} particles, {expected} volumes", walls.len());
            for (index, wall) in walls.iter().enumerate() {
                let layer = wall.wall_distance / scene.spacing - 0.5;
                assert!((layer - layer.round()).abs() < 0.06, "{layer} spacings at {}", wall.position);
                let nearest = walls[..index].iter().map(|other| other.position.distance(wall.position));
                let nearest = nearest.fold(f64::INFINITY, f64::min) / scene.spacing;
                assert!(nearest > 0.6, "{nearest} spacings at {}", wall.position);
            }
        }
    }
}
