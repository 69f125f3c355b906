//! Thin walls: solid between two parts of the fluid that is thinner than the kernel reaches.
//!
//! ```text
//! t < κh − Δ    fluid feels fluid through the wall
//! t < 2κh − Δ   a wall particle has fluid of both sides in its support, and mixes their pressures
//! ```
//!
//! κh is the support, Δ the spacing. From the surface in front of each wall particle a line goes
//! along the normal into the solid. It counts if it ends at a surface that faces away from it.

use std::f64::consts::FRAC_1_SQRT_2;

use glam::DVec3;
use rayon::iter::{IntoParallelIterator, IntoParallelRefMutIterator, ParallelIterator};

use super::fill::{behind_far_end, confined_distance};
use super::model::{ParticleSeed, Scene};
use super::wall_particles::surface_at;
use sphecs_core::particles::zone::Zone;
use sphecs_core::physics::wall::Slip;

/// Largest number of lines; more walls than that are sampled evenly.
const MOST_LINES: usize = 20_000;

/// Least cosine between a line and the normal of the surface at its end, into the fluid there.
const LEAST_FACING: f64 = -FRAC_1_SQRT_2;

/// Smallest step along a line, in spacings.
const LEAST_STEP: f64 = 0.02;

/// A wall with fluid on both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThinWall {
    /// Ends of the line through the wall, m.
    pub ends: [DVec3; 2],
}

impl ThinWall {
    /// Returns the thickness, m.
    pub fn thickness(&self) -> f64 {
        self.ends[0].distance(self.ends[1])
    }

    /// Returns the point in the middle of the wall, m.
    pub fn middle(&self) -> DVec3 {
        self.ends[0].midpoint(self.ends[1])
    }
}

/// Returns the thickness below which fluid feels fluid through a wall, m.
pub fn leaking_thickness(scene: &Scene) -> f64 {
    scene.scheme.support(scene.spacing) - scene.spacing
}

/// Returns the thickness below which wall particles mix the pressures of both sides, m.
pub fn mixing_thickness(scene: &Scene) -> f64 {
    2.0 * scene.scheme.support(scene.spacing) - scene.spacing
}

/// Returns the thinnest wall of a scene below the [mixing thickness](mixing_thickness); None
/// without one.
pub fn thinnest_wall(scene: &Scene, seeds: &[ParticleSeed]) -> Option<ThinWall> {
    // One-sided walls do neither.
    let at_surface = |seed: &&ParticleSeed| {
        seed.zone == Zone::Wall && seed.wall_distance < scene.spacing && seed.wall_thickness == 0.0
    };
    let first_layer: Vec<&ParticleSeed> = seeds.iter().filter(at_surface).collect();
    let stride = first_layer.len().div_ceil(MOST_LINES).max(1);
    (0..first_layer.len().div_ceil(stride))
        .into_par_iter()
        .filter_map(|index| through(scene, first_layer[index * stride]))
        .min_by(|a, b| a.thickness().total_cmp(&b.thickness()))
}

/// Finds the thickness of the solid at the particles of no-slip walls where it is below the [mixing
/// thickness](mixing_thickness). A particle in the middle, where the surface has no direction, gets
/// that of the line through the wall.
pub fn find_thicknesses(scene: &Scene, seeds: &mut [ParticleSeed]) {
    let sticks = |seed: &&mut ParticleSeed| {
        seed.zone == Zone::Wall && scene.walls.parts[usize::from(seed.patch)].slip == Slip::NoSlip
    };
    seeds.par_iter_mut().filter(sticks).for_each(|seed| {
        if let Some(wall) = through(scene, seed) {
            seed.wall_thickness = wall.thickness();
            if seed.wall_normal == DVec3::ZERO {
                seed.wall_normal = (wall.ends[0] - wall.ends[1]).normalize_or_zero();
            }
        }
    });
}

/// Returns the line through the wall from the surface in front of one of its particles.
fn through(scene: &Scene, seed: &ParticleSeed) -> Option<ThinWall> {
    if seed.wall_normal == DVec3::ZERO {
        return across_centre(scene, seed.position);
    }
    let (start, into) = (seed.position + seed.wall_distance * seed.wall_normal, -seed.wall_normal);
    let end = start + exit(scene, start, into)? * into;
    let (surface, normal, _) = surface_at(scene, end);
    let faces_away = normal.dot(into) > -LEAST_FACING && surface.distance(end) < scene.spacing;
    faces_away.then_some(ThinWall { ends: [start, end] })
}

/// Returns the shortest line along an axis through a particle in the middle of a wall, where the
/// surface has no direction.
fn across_centre(scene: &Scene, centre: DVec3) -> Option<ThinWall> {
    let line = |axis: DVec3| {
        let ends = [exit(scene, centre, -axis)? * -axis, exit(scene, centre, axis)? * axis];
        Some(ThinWall { ends: ends.map(|end| centre + end) })
    };
    let lines = DVec3::AXES.into_iter().take(scene.dimensions).filter_map(line);
    let thin = lines.filter(|wall| wall.thickness() < mixing_thickness(scene));
    thin.min_by(|a, b| a.thickness().total_cmp(&b.thickness()))
}

/// Returns the length of the solid along a line from its surface or inside, m; None if it is not
/// thin or ends behind an opening.
fn exit(scene: &Scene, start: DVec3, into: DVec3) -> Option<f64> {
    let longest = mixing_thickness(scene);
    let least = LEAST_STEP * scene.spacing;
    // The distance to the fluid is at least the signed distance.
    let mut length = 2.0 * least;
    while length < longest {
        let distance = confined_distance(scene, start + length * into);
        if distance <= 0.0 {
            return (!behind_far_end(scene, start + length * into)).then_some(length);
        }
        length += distance.max(least);
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeds;

    fn thinnest(domain: &str) -> Option<ThinWall> {
        let text = format!(
            r#"Scene(
    title: "Thin", dimensions: 2, spacing: 0.05,
    fluid: (density: 1000.0, viscosity: 1e-3, sound_speed: 10.0),
    domain: {domain},
    reference: (velocity: 1.0, length: 1.0), time: (end: 1.0), output: (every: 0.5),
)"#
        );
        let scene = Scene::from_text("thin", &text).load().unwrap_or_else(|faults| panic!("{faults:?}"));
        thinnest_wall(&scene, &seeds(&scene))
    }

    fn with_plate(thickness: f64) -> Option<ThinWall> {
        let top = 0.5 + thickness;
        thinnest(&format!(
            "Difference([Box(min: (0.0, 0.0), max: (2.0, 1.0)), Box(min: (0.5, 0.5), max: (1.5, {top:?}))])"
        ))
    }

    /// The support is 3 Δ = 0.15 m, so walls below 0.25 m mix pressures.
    #[test]
    fn plate_has_its_thickness() {
        for thickness in [0.05, 0.1, 0.2] {
            let found = with_plate(thickness).expect("a thin wall");
            assert!((found.thickness() - thickness).abs() < 2e-3, "{found:?} is not {thickness} m");
            assert!((0.5..0.75).contains(&found.middle().y), "{found:?}");
        }
        assert_eq!(with_plate(0.3), None);
    }

    #[test]
    fn particles_of_one_sided_walls_have_the_thickness_of_the_solid() {
        let text = r#"Scene(
    title: "Thin", dimensions: 2, spacing: 0.05,
    fluid: (density: 1000.0, viscosity: 1e-3, sound_speed: 10.0),
    domain: Difference([Box(min: (0.0, 0.0), max: (2.0, 1.0)), Box(min: (0.5, 0.5), max: (1.5, 0.6)),
        Box(min: (0.5, 0.2), max: (1.5, 0.25))]),
    walls: (one_sided: true, parts: [(name: "slippery", region: Box(min: (0.4, 0.15), max: (1.6, 0.3)), slip: FreeSlip)]),
    reference: (velocity: 1.0, length: 1.0), time: (end: 1.0), output: (every: 0.5),
)"#;
        let scene = Scene::from_text("thin", text).load().unwrap_or_else(|faults| panic!("{faults:?}"));
        let seeds = seeds(&scene);
        for seed in seeds.iter().filter(|seed| seed.zone == Zone::Wall) {
            let inside = (0.5..0.6).contains(&seed.position.y) && (0.6..1.4).contains(&seed.position.x);
            let expected = if inside { 0.1 } else { 0.0 };
            if inside || !(0.45..1.55).contains(&seed.position.x) {
                assert!((seed.wall_thickness - expected).abs() < 2e-3, "{seed:?}");
            }
            let is_slippery = (0.2..0.25).contains(&seed.position.y) && (0.5..1.5).contains(&seed.position.x);
            assert!(!is_slippery || seed.wall_thickness == 0.0, "{seed:?}");
        }
        let left = thinnest_wall(&scene, &seeds).expect("the slippery one");
        assert!((left.thickness() - 0.05).abs() < 2e-3, "{left:?}");
    }

    #[test]
    fn outer_walls_and_thick_bodies_are_not_thin() {
        assert_eq!(thinnest("Box(min: (0.0, 0.0), max: (2.0, 1.0))"), None);
        let disc =
            "Difference([Box(min: (0.0, 0.0), max: (2.0, 1.0)), Circle(center: (1.0, 0.5), radius: 0.2)])";
        assert_eq!(thinnest(disc), None);
    }
}
