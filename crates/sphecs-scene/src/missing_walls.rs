//! Solids between neighbouring places of the fluid that are too thin to have wall particles, so
//! that the flow passes through them.
//!
//! Lines along the axes go from each fluid particle near a surface to the place a spacing away. A
//! solid on such a line, with fluid at both ends and no wall particle within a spacing, is missing.
//! The last is the case within a spacing of a sharp edge too, where it does not matter.

use std::collections::HashSet;

use glam::{DVec3, IVec3};
use rayon::iter::ParallelIterator;
use rayon::slice::ParallelSlice;

use super::fill::confined_distance;
use super::model::{ParticleSeed, Scene};
use super::movers::{Mover, Wall};
use super::thin_walls::ThinWall;
use sphecs_core::particles::zone::Zone;

/// Particles that a thread takes at a time.
const CHUNK: usize = 4096;

/// Smallest step along a line, in spacings.
const LEAST_STEP: f64 = 0.01;

/// Returns the thickest solid without particles that lines along the axes cross; None without one.
pub fn missing_wall(scene: &Scene, seeds: &[ParticleSeed]) -> Option<ThinWall> {
    let walls = WallCells::new(scene, seeds);
    let fluid: Vec<DVec3> =
        seeds.iter().filter(|seed| seed.zone == Zone::Fluid).map(|seed| seed.position).collect();
    fluid
        .par_chunks(CHUNK)
        .filter_map(|chunk| thickest(near_surface(scene, chunk).filter_map(|point| at(scene, &walls, point))))
        .reduce_with(thicker)
}

/// Returns a note for each mover without particles.
pub fn movers_without_particles(scene: &Scene, seeds: &[ParticleSeed]) -> Vec<String> {
    let walls = seeds.iter().filter(|seed| seed.zone == Zone::Wall);
    let filled: HashSet<Wall> = walls.map(|seed| Wall::of_part(scene, seed.patch)).collect();
    let empty = scene.movers.iter().enumerate().filter(|(index, _)| !filled.contains(&Wall::Mover(*index)));
    let note = |(_, mover): (usize, &Mover)| {
        format!(
            "the mover `{}` has no particles, so that the flow passes through it: make it a spacing thick, or take a smaller \
             `spacing`",
            mover.name
        )
    };
    empty.map(note).collect()
}

fn thickest(walls: impl Iterator<Item = ThinWall>) -> Option<ThinWall> {
    walls.reduce(thicker)
}

fn thicker(one: ThinWall, other: ThinWall) -> ThinWall {
    if other.thickness() > one.thickness() { other } else { one }
}

/// Returns the points within a spacing of a surface. Points that cannot be are skipped by the
/// distance of one before.
fn near_surface<'a>(scene: &'a Scene, points: &'a [DVec3]) -> impl Iterator<Item = DVec3> + 'a {
    let mut last = (DVec3::ZERO, 0.0);
    points.iter().copied().filter(move |&point| {
        if point.distance(last.0) + scene.spacing < last.1 {
            return false;
        }
        last = (point, -confined_distance(scene, point));
        last.1 < scene.spacing
    })
}

/// Returns the thickest missing solid on the lines from a fluid particle.
fn at(scene: &Scene, walls: &WallCells, point: DVec3) -> Option<ThinWall> {
    let axes = DVec3::AXES.into_iter().take(scene.dimensions);
    let crossed = axes.filter_map(|axis| crossed(scene, point, axis));
    thickest(crossed.filter(|wall| !walls.any_near(wall.middle())))
}

/// Returns the solid on the line of a spacing along an axis, which ends in fluid.
fn crossed(scene: &Scene, start: DVec3, axis: DVec3) -> Option<ThinWall> {
    let length = scene.spacing;
    let depth = |along: f64| confined_distance(scene, start + along * axis);
    let (first, last) = (-depth(0.0), -depth(length));
    if first <= 0.0 || last <= 0.0 || first + last >= length {
        return None;
    }
    let step = LEAST_STEP * length;
    let mut along = first.max(step);
    while along < length - last && depth(along) <= 0.0 {
        along += (-depth(along)).max(step);
    }
    let begin = along;
    while along < length - last && depth(along) > 0.0 {
        along += depth(along).max(step);
    }
    let solid = along.min(length - last);
    (solid > begin).then(|| ThinWall { ends: [start + begin * axis, start + solid * axis] })
}

/// Cells of a spacing that have wall particles.
struct WallCells {
    size: f64,
    cells: HashSet<IVec3>,
    points: Vec<DVec3>,
}

impl WallCells {
    fn new(scene: &Scene, seeds: &[ParticleSeed]) -> Self {
        let walls = seeds.iter().filter(|seed| seed.zone == Zone::Wall);
        let points: Vec<DVec3> = walls.map(|seed| seed.position).collect();
        let size = scene.spacing;
        let cells = points.iter().map(|&point| Self::cell(size, point)).collect();
        Self { size, cells, points }
    }

    fn cell(size: f64, point: DVec3) -> IVec3 {
        (point / size).floor().as_ivec3()
    }

    /// Returns true if there is a wall particle within a spacing of a point.
    fn any_near(&self, point: DVec3) -> bool {
        let cell = Self::cell(self.size, point);
        let offsets = || -1..=1;
        let has_cell = offsets().any(|x| {
            offsets().any(|y| offsets().any(|z| self.cells.contains(&(cell + IVec3::new(x, y, z)))))
        });
        // Few points get here.
        has_cell && self.points.iter().any(|wall| wall.distance(point) < self.size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeds;

    fn missing(domain: &str) -> Option<ThinWall> {
        let text = format!(
            r#"Scene(
    title: "Thin", dimensions: 2, spacing: 0.05,
    fluid: (density: 1000.0, viscosity: 1e-3, sound_speed: 10.0),
    domain: Difference([Box(min: (0.0, 0.0), max: (2.0, 1.0)), {domain}]),
    reference: (velocity: 1.0, length: 1.0), time: (end: 1.0), output: (every: 0.5),
)"#
        );
        let scene = Scene::from_text("thin", &text).load().unwrap_or_else(|faults| panic!("{faults:?}"));
        missing_wall(&scene, &seeds(&scene))
    }

    #[test]
    fn plate_between_two_rows_is_missing() {
        let found =
            missing("Box(min: (0.5, 0.495), max: (1.5, 0.505))").expect("no particle has its place there");
        assert!((found.thickness() - 0.01).abs() < 1e-3, "{found:?}");
        assert!((found.middle().y - 0.5).abs() < 1e-3, "{found:?}");
        let oblique = "Polygon(points: [(0.5, 0.3), (1.5, 0.7), (1.5, 0.705), (0.5, 0.305)])";
        // Along x the plate is 0.005/0.4 m thick.
        let found = missing(oblique).expect("no particle has its place there");
        assert!((found.thickness() - 0.0125).abs() < 1e-3, "{found:?}");
        let middle = found.middle();
        assert!((middle.y - 0.3 - 0.4 * (middle.x - 0.5)).abs() < 0.01, "{found:?}");
    }

    #[test]
    fn mover_between_the_places_of_particles_has_none() {
        let notes = |radius: f64| {
            let text = format!(
                r#"Scene(
    title: "Small", dimensions: 2, spacing: 0.05,
    fluid: (density: 1000.0, viscosity: 1e-3, sound_speed: 10.0),
    domain: Box(min: (0.0, 0.0), max: (1.0, 1.0)),
    movers: [(
        name: "dot", shape: Circle(center: (0.5, 0.5), radius: {radius}),
        motion: Rotation(about: (0.5, 0.5), rate: 1.0),
    )],
    reference: (velocity: 1.0, length: 1.0), time: (end: 1.0), output: (every: 0.5),
)"#
            );
            let scene = Scene::from_text("small", &text).load().unwrap_or_else(|faults| panic!("{faults:?}"));
            movers_without_particles(&scene, &seeds(&scene))
        };
        let found = notes(0.01);
        assert!(found.len() == 1 && found[0].contains("`dot` has no particles"), "{found:?}");
        assert!(notes(0.1).is_empty());
    }

    #[test]
    fn plates_with_particles_and_tips_are_not_missing() {
        assert_eq!(missing("Box(min: (0.5, 0.5), max: (1.5, 0.55))"), None);
        assert_eq!(missing("Circle(center: (1.0, 0.5), radius: 0.2)"), None);
        let wedge = "Polygon(points: [(0.5, 0.1), (0.9, 0.5), (0.5, 0.9)])";
        assert_eq!(missing(wedge), None, "the last spacing of a tip does not matter");
    }
}
