//! Gaps that close as walls move: fluid between a mover and another wall that fewer particles than
//! resolve it have to leave.
//!
//! ```text
//! g(t) = −d_wall(x(t)) − b      b depth of a particle of the mover behind its surface
//! ```
//!
//! d_wall is the signed distance of the particle from the casing or from another mover, negative in
//! front of it. A particle counts if its gap is wide at the start and below three spacings later. A
//! gap that is narrow all the time is the narrowest passage, not one that closes.

use glam::DVec3;
use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};

use super::fill::periodic_distance;
use super::model::{ParticleSeed, Scene};
use super::movers::{Wall, WallPoses};
use sphecs_core::particles::zone::Zone;

/// Number of intervals of the run at whose ends gaps are measured.
const INTERVALS: usize = 64;

/// Width of a gap that is too narrow, in spacings.
pub const NARROW: f64 = 3.0;

/// Largest number of particles of a mover that are followed; more are sampled evenly.
const MOST_PARTICLES: usize = 2_000;

/// A gap between a mover and another wall that closes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosingGap {
    /// Index of the mover.
    pub mover: usize,
    /// The other wall.
    pub wall: Wall,
    /// Least width, m; 0 where both touch.
    pub width: f64,
    /// Time of it, s.
    pub time: f64,
    /// Place at the surface of the mover, m.
    pub place: DVec3,
}

/// Returns the narrowest of the closing gaps between each pair of walls until a time, s.
pub fn closing_gaps(scene: &Scene, seeds: &[ParticleSeed], until: f64) -> Vec<ClosingGap> {
    let times: Vec<f64> =
        (0..=INTERVALS).map(|interval| until * interval as f64 / INTERVALS as f64).collect();
    if scene.movers.is_empty() || !until.is_finite() {
        return Vec::new();
    }
    let poses: Vec<WallPoses> = times.iter().map(|time| scene.wall_poses(*time)).collect();
    let walls = || (0..scene.movers.len()).map(Wall::Mover).chain([Wall::Casing]);
    let mut found = Vec::new();
    for first in 0..scene.movers.len() {
        let particles = surface_particles(scene, seeds, first);
        for wall in walls() {
            // Of two movers each pair once.
            if matches!(wall, Wall::Mover(second) if second <= first) {
                continue;
            }
            let of_particle = |(place, depth): &(DVec3, f64)| {
                narrowest(scene, (first, wall), (*place, *depth), &poses).map(|(at, width, place)| {
                    ClosingGap { mover: first, wall, width, time: times[at], place }
                })
            };
            let narrowest = (0..particles.len())
                .into_par_iter()
                .with_min_len(8)
                .filter_map(|index| of_particle(&particles[index]))
                .min_by(|a, b| a.width.total_cmp(&b.width).then(a.time.total_cmp(&b.time)));
            found.extend(narrowest);
        }
    }
    found
}

/// Returns the reference places of the particles at the surface of a mover with their depth, m.
fn surface_particles(scene: &Scene, seeds: &[ParticleSeed], mover: usize) -> Vec<(DVec3, f64)> {
    let own = &scene.movers[mover];
    let mut found: Vec<(DVec3, f64)> = seeds
        .iter()
        .filter(|seed| seed.zone == Zone::Wall && Wall::numbered(seed.patch) == Wall::Mover(mover))
        .map(|seed| own.start.reference(seed.position))
        .map(|place| (place, -own.shape.signed_distance(place)))
        .filter(|(_, depth)| (0.0..scene.spacing).contains(depth))
        .collect();
    let stride = found.len().div_ceil(MOST_PARTICLES).max(1);
    found = found.into_iter().step_by(stride).collect();
    found
}

/// Returns index of the time, width and place of the narrowest gap in front of a particle, if it
/// was wide and becomes narrow.
fn narrowest(
    scene: &Scene,
    (mover, wall): (usize, Wall),
    (place, depth): (DVec3, f64),
    poses: &[WallPoses],
) -> Option<(usize, f64, DVec3)> {
    let limit = NARROW * scene.spacing;
    let gap = |poses: &WallPoses| {
        let at = poses.movers[mover].place(place);
        let distance = match wall {
            Wall::Casing => distance_from_casing(scene, poses, at),
            Wall::Mover(other) => {
                let (pose, other) = (&poses.movers[other], &scene.movers[other]);
                let near = scene.nearest_image(at, pose.place(other.centre));
                other.shape.signed_distance(pose.reference(near))
            }
        };
        (distance - depth, at)
    };
    if gap(&poses[0]).0 < limit {
        return None;
    }
    let widths = poses.iter().enumerate().map(|(index, poses)| (index, gap(poses)));
    let (index, (width, at)) = widths.min_by(|a, b| a.1.0.total_cmp(&b.1.0))?;
    (width < limit).then_some((index, width.max(0.0), at))
}

/// Returns the distance in front of the casing, m; infinite where the nearest face is the seam of a
/// period, beyond which the fluid continues.
fn distance_from_casing(scene: &Scene, poses: &WallPoses, at: DVec3) -> f64 {
    let confines = &scene.layout.casing.confines;
    let (low, high) = confines.bounds();
    let of_casing = poses.casing.as_ref().map_or(at, |pose| pose.reference(at));
    let image = scene.nearest_image(of_casing, low.midpoint(high));
    let distance = -confines.signed_distance(image);
    if scene.periodic.iter().any(Option::is_some) {
        let outwards = confines.gradient(image, 1e-4 * scene.spacing, scene.dimensions);
        let beyond = image + outwards * (distance + 0.5 * scene.spacing);
        if periodic_distance(confines, &scene.periodic, beyond) < 0.0 {
            return f64::INFINITY;
        }
    }
    distance
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeds;

    const OUTLET: &str = "outlets: [(name: \"end\", at: (4.0, 1.0), towards: (1.0, 0.0))],";

    fn gaps(movers: &str) -> Vec<ClosingGap> {
        gaps_between(OUTLET, movers)
    }

    fn gaps_between(ends: &str, movers: &str) -> Vec<ClosingGap> {
        let text = format!(
            r#"Scene(
    title: "Gaps", dimensions: 2, spacing: 0.05,
    fluid: (density: 1000.0, viscosity: 1e-3, sound_speed: 20.0),
    domain: Box(min: (0.0, 0.0), max: (4.0, 2.0)),
    {ends}
    movers: [{movers}],
    reference: (velocity: 1.0), time: (end: 1.0), output: (every: 0.5),
)"#
        );
        let scene = Scene::from_text("gaps", text).load().expect("a scene");
        closing_gaps(&scene, &seeds(&scene), 1.0)
    }

    fn disc(name: &str, x: f64, motion: &str) -> String {
        format!(
            "(name: \"{name}\", shape: Circle(center: ({x}, 1.0), radius: 0.4), motion: \
             Translation(displacement: ({motion})))"
        )
    }

    #[test]
    fn gap_to_a_wall_that_becomes_narrow_is_found() {
        // The disc sinks to 0.1 m above the bottom at 0.5 s and rises again.
        let found = gaps(&disc("body", 2.0, "0.0, \"-0.5*sin(pi*t)\""));
        let [gap] = found.as_slice() else { panic!("{found:?}") };
        assert_eq!((gap.mover, gap.wall), (0, Wall::Casing));
        assert!((gap.width - 0.1).abs() < 0.02, "{gap:?}");
        assert!((gap.time - 0.5).abs() < 1e-9 && (gap.place.x - 2.0).abs() < 0.1, "{gap:?}");
    }

    #[test]
    fn gap_between_movers_is_found_once() {
        let movers =
            [disc("left", 1.0, "\"0.45*t\", 0.0"), disc("right", 2.3, "0.0, \"0.0001*t\"")].join(", ");
        let found = gaps(&movers);
        let [gap] = found.as_slice() else { panic!("{found:?}") };
        assert_eq!((gap.mover, gap.wall, gap.time), (0, Wall::Mover(1), 1.0));
        assert!((gap.width - 0.05).abs() < 0.02, "{gap:?}");
    }

    #[test]
    fn seam_of_a_period_is_no_wall() {
        let towed = disc("body", 2.0, "\"7.0*t\", 0.0");
        assert_eq!(gaps_between("periodic: [\"x\"],", &towed), []);
        // The bottom is one, also of the second period.
        let sinks = disc("body", 2.0, "\"7.0*t\", \"-0.5*sin(pi*t)\"");
        let found = gaps_between("periodic: [\"x\"],", &sinks);
        let [gap] = found.as_slice() else { panic!("{found:?}") };
        assert!((gap.width - 0.1).abs() < 0.02 && (gap.time - 0.5).abs() < 1e-9, "{gap:?}");
    }

    #[test]
    fn wide_gaps_and_those_narrow_from_the_start_are_none() {
        assert_eq!(gaps(&disc("body", 2.0, "0.0, \"-0.3*sin(pi*t)\"")), []);
        // A piston along the side walls.
        let piston = "(name: \"piston\", shape: Box(min: (-0.5, 0.0), max: (0.5, 2.0)), motion: \
                      Translation(displacement: (\"0.3*t\", 0.0)))";
        assert_eq!(gaps(piston), []);
    }
}
