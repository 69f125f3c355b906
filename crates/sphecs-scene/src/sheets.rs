//! Layers of wall particles along a surface in 3D: evenly spread by repulsion.
//!
//! ```text
//! N_k = V_k/Δ³,   V_k: volume of the shell k Δ ≤ φ < (k + 1) Δ
//! x_i += β Δ P Σ_j (1 − r_ij/R)² x_ij/r_ij,   R = 1.7 Δ
//! ```
//!
//! The N_k particles start in cells of the lattice, by the shares of the cells in the shell. The
//! sum runs over the neighbours in the same layer; φ is the signed distance behind the surface and
//! P the projection onto the layer, φ = (k + ½) Δ.

use glam::DVec3;
use rayon::iter::{IntoParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::fill::lattice_ranges;
use super::lattice::Lattice;
use super::layers::moved_to;
use super::model::Scene;
use super::movers::Wall;
use super::near_points::{NearPoints, Region};

/// Radius of the repulsion R, in spacings.
const RADIUS: f64 = 1.7;

/// Step of the repulsion β, in spacings.
const STEP: f64 = 0.12;

/// Number of steps.
const STEPS: usize = 40;

/// Steps after which particles are moved back to their layer; in between they move along it.
const STEPS_ALONG: usize = 5;

/// Largest distance of a particle from its layer, in spacings: at sharp edges of a wall a layer
/// ends.
const OFF_THE_LAYER: f64 = 0.05;

/// Parts of a cell along each axis in which its share of a shell is counted.
const PARTS: usize = 4;

/// Returns the particles of the layers at some depths, m, behind the surface of a wall; `is_here`
/// says of the centre of a cell whether its volume is to be filled.
pub fn spread(
    scene: &Scene,
    lattice: &Lattice,
    wall: Wall,
    depths: &[f64],
    is_here: impl Fn(DVec3) -> bool + Sync,
) -> Vec<Vec<DVec3>> {
    let layers = starts(scene, lattice, wall, depths.len(), is_here);
    let of_layer = |(points, depth): (Vec<DVec3>, &f64)| {
        let points = points.par_iter().map(|point| moved_to(scene, wall, *point, *depth)).collect();
        let is_on_it =
            |point: &DVec3| (wall.distance(scene, *point) - depth).abs() < OFF_THE_LAYER * scene.spacing;
        relaxed(scene, wall, points, *depth).into_par_iter().filter(is_on_it).collect()
    };
    layers.into_iter().zip(depths).map(of_layer).collect()
}

/// Returns a cell and those around it.
pub fn around([x, y, z]: [i64; 3]) -> impl Iterator<Item = [i64; 3]> {
    (0..27).map(move |at| [x + at % 3 - 1, y + at / 3 % 3 - 1, z + at / 9 - 1])
}

/// Returns centres of cells for the particles of each layer: one whenever the volume of the shell
/// in the cells passed so far exceeds that of its particles by half of one.
fn starts(
    scene: &Scene,
    lattice: &Lattice,
    wall: Wall,
    layers: usize,
    is_here: impl Fn(DVec3) -> bool + Sync,
) -> Vec<Vec<DVec3>> {
    let deepest = layers as f64 * scene.spacing;
    let (low, high) = wall.bounds(scene);
    let shape = super::geometry::Shape::Box { min: low, max: high };
    let ranges = lattice_ranges(scene, lattice, &shape, deepest);
    let line = |index: usize| {
        let lines = (ranges[1].end - ranges[1].start).max(1) as usize;
        [ranges[0].start + (index / lines) as i64, ranges[1].start + (index % lines) as i64]
    };
    let count =
        ((ranges[0].end - ranges[0].start).max(0) * (ranges[1].end - ranges[1].start).max(0)) as usize;
    // Shares of the cells of a line that the shells cut.
    let shares_of = |index: usize| {
        let [i, j] = line(index);
        let mut shares = Vec::new();
        let mut k = ranges[2].start;
        while k < ranges[2].end {
            let centre = lattice.point([i, j, k], 3);
            let depth = wall.distance(scene, centre);
            let off = (-scene.spacing - depth).max(depth - deepest - scene.spacing);
            if off > 0.0 {
                k += ((off / lattice.spacing.z) as i64).max(1);
                continue;
            }
            if is_here(centre) {
                let normal = wall.gradient(scene, centre);
                shares.extend(
                    shells(scene, lattice, depth, normal, layers)
                        .map(|(layer, share)| (centre, layer, share)),
                );
            }
            k += 1;
        }
        shares
    };
    let shares: Vec<Vec<(DVec3, usize, f64)>> = (0..count).into_par_iter().map(shares_of).collect();
    let mut carried = vec![0.0; layers];
    let mut starts = vec![Vec::new(); layers];
    for (centre, layer, share) in shares.into_iter().flatten() {
        carried[layer] += share;
        if carried[layer] >= 0.5 {
            carried[layer] -= 1.0;
            starts[layer].push(centre);
        }
    }
    starts
}

/// Returns the shells that a cell has volume in, each with its share of the cell, from the depth of
/// its centre, m, and the normal there.
fn shells(
    scene: &Scene,
    lattice: &Lattice,
    depth: f64,
    normal: DVec3,
    layers: usize,
) -> impl Iterator<Item = (usize, f64)> {
    let across = lattice.rotation.transpose() * normal * lattice.spacing;
    let part = |index: usize| (index as f64 + 0.5) / PARTS as f64 - 0.5;
    let mut counts = vec![0_u32; layers];
    for index in 0..PARTS.pow(3) {
        let at = DVec3::new(part(index % PARTS), part(index / PARTS % PARTS), part(index / PARTS / PARTS));
        let layer = ((depth + across.dot(at)) / scene.spacing).floor();
        if layer >= 0.0
            && let Some(count) = counts.get_mut(layer as usize)
        {
            *count += 1;
        }
    }
    let share = |count: u32| f64::from(count) / PARTS.pow(3) as f64;
    counts
        .into_iter()
        .enumerate()
        .filter(|(_, count)| *count > 0)
        .map(move |(layer, count)| (layer, share(count)))
}

/// Returns the particles of a layer after they have repelled each other.
fn relaxed(scene: &Scene, wall: Wall, mut points: Vec<DVec3>, depth: f64) -> Vec<DVec3> {
    let radius = RADIUS * scene.spacing;
    let (low, high) = wall.bounds(scene);
    let margin = DVec3::splat(depth + 2.0 * radius);
    let (low, high) = (low - margin, high + margin);
    // Particles of a mover are wrapped when it is placed.
    let region = match wall {
        Wall::Casing => Region::of(scene, low, high),
        Wall::Mover(_) => Region { low, high, periodic: [false; 3] },
    };
    let mut near = NearPoints::<3>::new(&region, radius);
    part(&mut points, scene.spacing);
    let mut normals = Vec::new();
    for step in 0..STEPS {
        if step % STEPS_ALONG == 0 {
            points = points.into_par_iter().map(|point| moved_to(scene, wall, point, depth)).collect();
            normals = points.par_iter().map(|point| wall.gradient(scene, *point)).collect();
        }
        near.sort(points.iter().copied());
        let moved = |(point, normal): (&DVec3, &DVec3)| {
            let mut push = DVec3::ZERO;
            near.for_each_near(*point, |way, distance| {
                if distance > 0.0 {
                    push += DVec3::from(way) * ((1.0 - distance / radius).powi(2) / distance);
                }
            });
            let push = push - *normal * push.dot(*normal);
            region.wrapped(*point + (STEP * scene.spacing * push).clamp_length_max(0.2 * scene.spacing))
        };
        points = (&points, &normals).into_par_iter().map(moved).collect();
    }
    points.into_par_iter().map(|point| region.wrapped(moved_to(scene, wall, point, depth))).collect()
}

/// Moves points apart that lie at one place, where they would not repel each other: cells on one
/// normal of the surface start there.
fn part(points: &mut [DVec3], spacing: f64) {
    let mut order: Vec<usize> = (0..points.len()).collect();
    let key = |at: usize| (points[at] / (1e-6 * spacing)).round().as_i64vec3().to_array();
    order.sort_by_key(|&at| (key(at), at));
    let keys: Vec<[i64; 3]> = order.iter().map(|&at| key(at)).collect();
    let mut before = 0_u32;
    for place in 1..order.len() {
        before = if keys[place] == keys[place - 1] { before + 1 } else { 0 };
        points[order[place]] += DVec3::new(0.013, 0.019, 0.029) * (f64::from(before) * spacing);
    }
}

#[cfg(test)]
mod tests {
    use crate::model::Scene;
    use crate::spawn::seeds;
    use sphecs_core::particles::zone::Zone;

    /// A tube that repeats: no particle lies beyond a seam, and none is near to an image.
    #[test]
    fn sheets_of_a_periodic_tube_end_at_its_seams() {
        let text = "Scene(title: \"t\", dimensions: 3, spacing: 0.1, smoke: 0.2,
            fluid: (density: 1000.0, viscosity: 1.0e-3, sound_speed: 15.0), periodic: [\"x\"],
            domain: Cylinder(from: (0.0, 0.0, 0.0), to: (2.0, 0.0, 0.0), radius: 0.65),
            walls: (slip: FreeSlip, fill: Layers),
            initial: (velocity: (0.1, 0.0, 0.0)), time: (end: 1.0), output: (every: 1.0))";
        let scene = Scene::from_text("walls", text).load().unwrap_or_else(|faults| panic!("{faults:?}"));
        let walls: Vec<_> = seeds(&scene).into_iter().filter(|seed| seed.zone == Zone::Wall).collect();
        let shell = std::f64::consts::PI * (1.04_f64.powi(2) - 0.65_f64.powi(2)) * 2.0 / 1e-3;
        let share = walls.len() as f64 / shell;
        assert!((share - 1.0).abs() < 0.06, "{} particles, {shell} volumes", walls.len());
        for (index, wall) in walls.iter().enumerate() {
            assert!((0.0..2.0).contains(&wall.position.x), "{}", wall.position);
            let distance = |other: &crate::model::ParticleSeed| {
                let mut way = wall.position - other.position;
                way.x -= 2.0 * (way.x / 2.0).round();
                way.length()
            };
            let nearest = walls[..index].iter().map(distance).fold(f64::INFINITY, f64::min) / scene.spacing;
            assert!(nearest > 0.6, "{nearest} spacings at {}", wall.position);
        }
    }

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
