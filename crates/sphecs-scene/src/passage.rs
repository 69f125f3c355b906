//! Narrowest passage: shortest distance between walls that face each other.
//!
//! From the surface in front of wall particles a line goes along the normal through the fluid to
//! the opposite surface. It counts as the width of a passage if the surface there faces the line.

use std::f64::consts::FRAC_1_SQRT_2;
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering::Relaxed;

use glam::DVec3;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::fill::{beyond, confined_distance};
use super::geometry::measure::traced_exit;
use super::model::{ParticleSeed, Patch, Scene};
use super::wall_particles::surface_at;
use sphecs_core::particles::zone::Zone;

/// Largest number of lines; more walls than that are sampled evenly.
const MOST_LINES: usize = 20_000;

/// Least cosine between a line and the normal of the surface that it ends at. Lines from the
/// corners of a rectangle end below it, at 45°.
const LEAST_FACING: f64 = FRAC_1_SQRT_2 + 0.05;

/// Step along a line in spacings: walls that are thinner hold no particles.
const STEP: f64 = 0.5;

/// Two points of the surface that face each other, and nothing but fluid between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passage {
    /// Ends of the line across, m.
    pub ends: [DVec3; 2],
}

impl Passage {
    /// Returns the width, m.
    pub fn width(&self) -> f64 {
        self.ends[0].distance(self.ends[1])
    }

    /// Returns the point midway between the walls, m.
    pub fn middle(&self) -> DVec3 {
        self.ends[0].midpoint(self.ends[1])
    }
}

/// Returns the narrowest passage between the walls of a scene; None if no walls face each other.
pub fn narrowest_passage(scene: &Scene, seeds: &[ParticleSeed]) -> Option<Passage> {
    let at_surface = |seed: &&ParticleSeed| seed.zone == Zone::Wall && seed.wall_distance < scene.spacing;
    let first_layer: Vec<&ParticleSeed> = seeds.iter().filter(at_surface).collect();
    let stride = first_layer.len().div_ceil(MOST_LINES).max(1);
    // Widths of a channel are equal up to rounding: the one in the middle of its walls is taken.
    let tolerance = 1e-6 * scene.spacing;
    // Lines need not be followed beyond the least width that any of them has found so far.
    let shortest = AtomicU64::new(f64::INFINITY.to_bits());
    let passage = |seed: &ParticleSeed| {
        let found = across(scene, seed, f64::from_bits(shortest.load(Relaxed)) + tolerance)?;
        // The bits of positive numbers have the order of the numbers.
        shortest.fetch_min(found.width().to_bits(), Relaxed);
        Some(found)
    };
    let mut passages: Vec<Passage> = (0..first_layer.len().div_ceil(stride))
        .into_par_iter()
        .filter_map(|index| passage(first_layer[index * stride]))
        .collect();
    let least = passages.iter().map(Passage::width).fold(f64::INFINITY, f64::min);
    passages.retain(|passage| passage.width() <= least + tolerance);
    (!passages.is_empty()).then(|| passages[passages.len() / 2])
}

/// Returns the line from the surface in front of a wall particle to the opposite surface; None if
/// it is longer than `longest`, m, or nothing faces the particle.
fn across(scene: &Scene, seed: &ParticleSeed, longest: f64) -> Option<Passage> {
    let (start, direction) = (seed.position + seed.wall_distance * seed.wall_normal, seed.wall_normal);
    let length = exit(scene, start, direction, longest)?;
    let end = start + length * direction;
    let (_, normal, _) = surface_at(scene, end);
    let faces = normal.dot(direction) < -LEAST_FACING;
    let inlets = scene.inlets.iter().any(|inlet| ends_in(&inlet.patch, true, end, direction, scene.spacing));
    let outlets =
        scene.outlets.iter().any(|outlet| ends_in(&outlet.patch, false, end, direction, scene.spacing));
    (faces && !inlets && !outlets).then_some(Passage { ends: [start, end] })
}

/// Returns true if a line ends at the far end of the zone of an opening, where there is no wall.
fn ends_in(patch: &Patch, is_inlet: bool, end: DVec3, direction: DVec3, spacing: f64) -> bool {
    beyond(patch, is_inlet, end) > -spacing
        && patch.covers(end, spacing)
        && direction.dot(patch.towards).abs() > LEAST_FACING
}

/// Returns the length of fluid along a line from the surface, m; None if there is none, or no end.
fn exit(scene: &Scene, from: DVec3, direction: DVec3, longest: f64) -> Option<f64> {
    let (low, high) = scene.container.bounds();
    let across: f64 = (high - low).to_array().into_iter().filter(|length| length.is_finite()).sum();
    let distance = |length: f64| confined_distance(scene, from + length * direction);
    let step = STEP * scene.spacing;
    if direction == DVec3::ZERO || distance(step) > 0.0 {
        return None;
    }
    // Periodic images are beyond the shape itself.
    let is_periodic = scene.periodic.iter().any(Option::is_some);
    let clearance = |length: f64| match is_periodic {
        true => distance(length).abs(),
        false => scene.layout.confines.clearance(from + length * direction),
    };
    traced_exit(distance, clearance, step, across.min(longest))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeds;

    fn passage(text: &str) -> Option<Passage> {
        let scene = Scene::from_text("passage", text).load().expect("a scene");
        narrowest_passage(&scene, &seeds(&scene))
    }

    fn channel(domain: &str, more: &str) -> String {
        format!(
            r#"Scene(
    title: "Passage", dimensions: 2, spacing: 0.05, smoke: 0.05,
    fluid: (density: 1000.0, viscosity: 1e-3, sound_speed: 10.0),
    scheme: Wcsph(), domain: {domain}, {more}
    reference: (velocity: 1.0, length: 1.0),
    time: (end: 1.0), output: (every: 0.5),
)"#
        )
    }

    const OPEN: &str = r#"
    inlets: [(at: (0.0, 0.5), towards: (1.0, 0.0), velocity: Normal(1.0))],
    outlets: [(at: (4.0, 0.5), towards: (1.0, 0.0), condition: WaveEquation())],"#;

    #[test]
    fn width_of_a_channel_is_found_in_its_middle() {
        let found = passage(&channel("Box(min: (0.0, 0.0), max: (4.0, 1.0))", OPEN)).expect("a passage");
        assert!((found.width() - 1.0).abs() < 1e-9, "{found:?}");
        assert!((found.middle().y - 0.5).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn gap_between_a_cylinder_and_the_wall_is_narrower_than_the_channel() {
        let domain =
            "Difference([Box(min: (0.0, 0.0), max: (4.0, 1.0)), Circle(center: (2.0, 0.6), radius: 0.2)])";
        let found = passage(&channel(domain, OPEN)).expect("a passage");
        // Wall particles of the cylinder lie at angles that need not include the shortest line.
        assert!((0.2..0.21).contains(&found.width()), "{found:?}");
        assert!((found.middle().x - 2.0).abs() < 0.1 && found.middle().y > 0.8, "{found:?}");
    }

    #[test]
    fn periodic_box_has_no_passage() {
        let domain = "Box(min: (0.0, 0.0), max: (1.0, 1.0))";
        let text = channel(domain, r#"periodic: ["x", "y"], walls: None,"#);
        assert_eq!(passage(&text), None);
    }
}
