//! Wall particles in layers along a surface of any shape.
//!
//! ```text
//! layer k: {x : φ(x) = (k + ½) Δ},  n_k = L_k/Δ rounded,   k = 0, 1, … within reach of the fluid
//! ```
//!
//! φ is the signed distance behind the surface, L_k the length of a curve of the layer. Its n_k
//! particles have equal distances along it. On the lattice the particles behind a wall oblique to
//! it are stairs, along which the pressure of the wall has hills and valleys: they brake a flow
//! past a free-slip wall as roughness does. The layers have none.
//!
//! In 2D the curves are found on a [grid](super::distance_grid) of Δ/4 and moved to the layer by a
//! step along the gradient; for 3D see [`sheets`]. Where layers of two
//! surfaces meet in a thin wall, the nearer ones to their surface stay.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::iter::{IntoParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::distance_grid::{DistanceGrid, spread};
use super::fill::{Place, wall_thickness};
use super::model::{Fill, Scene};
use super::movers::Wall;
use super::periodic_curves::within_periods;
use super::sheets;
use super::wall_particles::surface;
use sphecs_core::particles::zone::Zone;

/// Cells of the grid per spacing.
const CELLS: f64 = 4.0;

/// Smallest distance of particles of different curves, in spacings.
const APART: f64 = 0.7;

/// Replaces the lattice's particles of a wall behind the layered parts of a scene by layers;
/// `is_wall` says whether a point is wall.
pub fn replace(scene: &Scene, wall: Wall, places: &mut Vec<Place>, is_wall: impl Fn(DVec3) -> bool + Sync) {
    let is_layered = |point: DVec3| scene.layout.layered.contains(&surface(scene, wall, point).part);
    let is_of_wall = |place: &Place| place.zone == Zone::Wall && place.patch == wall.number();
    let is_kept = |point: DVec3| !is_layered(point) || is_fitted(scene, wall, point);
    let keeps = |place: &Place| !is_of_wall(place) || is_kept(place.position);
    let kept: Vec<bool> = places.par_iter().map(keeps).collect();
    let mut kept = kept.into_iter();
    places.retain(|_| kept.next().unwrap_or(true));
    let mut taken = TakenPlaces::new(APART * scene.spacing);
    places.iter().filter(|place| is_of_wall(place)).for_each(|place| taken.add(place.position));
    let deepest = wall_thickness(scene) - 1e-9 * scene.spacing;
    let depths = (0..).map(|layer| (f64::from(layer) + 0.5) * scene.spacing);
    let depths: Vec<f64> = depths.take_while(|depth| *depth < deepest).collect();
    let sheets: Vec<Vec<DVec3>> = match &scene.layout.fill {
        Fill::Lattice(lattice) | Fill::Packed(lattice) if scene.dimensions == 3 => {
            let is_here = |centre: DVec3| is_layered(centre) && !is_fitted(scene, wall, centre);
            sheets::spread(scene, lattice, wall, &depths, is_here)
        }
        _ => {
            let grid = distance_grid(scene, wall);
            depths.iter().flat_map(|depth| curves(scene, wall, &grid, *depth)).collect()
        }
    };
    // Sheets come from the surface inwards; the particles of one are not too near to each other.
    for sheet in sheets {
        let is_place = |point: &DVec3| taken.is_free(*point) && is_wall(*point) && is_layered(*point);
        let points: Vec<DVec3> = sheet.into_par_iter().filter(is_place).collect();
        for position in points {
            taken.add(position);
            places.push(Place { position, zone: Zone::Wall, patch: wall.number() });
        }
    }
}

/// Largest distance of a fitted particle from the middle of a layer, in spacings.
const OFF_THE_MIDDLE: f64 = 0.02;

/// Length along which a plane wall is plane, in spacings.
const FLAT: f64 = 2.0;

/// Returns true for a wall particle of a packed lattice that lies in the middle of layers: those
/// along plane walls stay in line with the fluid.
fn is_fitted(scene: &Scene, wall: Wall, point: DVec3) -> bool {
    let Fill::Packed(lattice) = &scene.layout.fill else { return false };
    let surface = surface(scene, wall, point);
    let way = lattice.rotation.transpose() * (surface.normal * surface.distance) / lattice.spacing;
    let layer = |along: f64| (along.abs() - 0.5) - (along.abs() - 0.5).round().max(0.0);
    // Along a curved wall a particle in the middle of a layer is an accident.
    let is_flat = |axis: usize| {
        let step = lattice.rotation.col(axis) * (FLAT * scene.spacing);
        [step, -step].into_iter().any(|step| {
            (wall.distance(scene, point + step) - surface.distance).abs() < OFF_THE_MIDDLE * scene.spacing
        })
    };
    (0..scene.dimensions).all(|axis| match way[axis].abs() < OFF_THE_MIDDLE {
        true => is_flat(axis),
        false => layer(way[axis]).abs() < OFF_THE_MIDDLE,
    })
}

/// Depth at which the curves of a surface are sought, in spacings.
const BESIDE_SEAMS: f64 = 1e-6;

/// Returns the curves of the surface of a wall at the start in 2D, m; a closed curve ends at its
/// first point.
pub fn surface_curves(scene: &Scene, wall: Wall) -> Vec<Vec<DVec3>> {
    // The seam of a period has the distance 0, too, but is no surface.
    let curves = distance_grid(scene, wall).curves(BESIDE_SEAMS * scene.spacing).into_iter();
    let moved =
        |curve: Vec<DVec3>| curve.into_iter().map(|point| moved_to(scene, wall, point, 0.0)).collect();
    curves.map(moved).collect()
}

/// Returns the distance behind a wall on a grid around it, in 2D.
fn distance_grid(scene: &Scene, wall: Wall) -> DistanceGrid {
    let margin = DVec3::splat(wall_thickness(scene) + scene.spacing);
    let (low, high) = wall.bounds(scene);
    let (low, high) = ((low - margin).with_z(0.0), (high + margin).with_z(0.0));
    DistanceGrid::new(low, high, scene.spacing / CELLS, |point| wall.distance(scene, point))
}

/// Returns the particles of the curves of a layer, m.
fn curves(scene: &Scene, wall: Wall, grid: &DistanceGrid, depth: f64) -> Vec<Vec<DVec3>> {
    let on_it = |curve: &Vec<DVec3>| {
        spread(curve, scene.spacing).into_iter().map(|point| moved_to(scene, wall, point, depth)).collect()
    };
    // Those of a mover are wrapped when it is placed.
    let periods = if wall == Wall::Casing { scene.periodic } else { [None; 3] };
    let curves = grid.curves(depth).into_iter().flat_map(|curve| within_periods(curve, &periods));
    curves.map(|curve| on_it(&curve)).collect()
}

/// Places of wall particles, by cells of the distance that others must keep.
struct TakenPlaces {
    distance: f64,
    cells: BTreeMap<[i64; 3], Vec<DVec3>>,
}

impl TakenPlaces {
    fn new(distance: f64) -> Self {
        Self { distance, cells: BTreeMap::new() }
    }

    fn cell(&self, point: DVec3) -> [i64; 3] {
        (point / self.distance).floor().as_i64vec3().to_array()
    }

    fn add(&mut self, point: DVec3) {
        self.cells.entry(self.cell(point)).or_default().push(point);
    }

    /// Returns true if no place is nearer than the distance.
    fn is_free(&self, point: DVec3) -> bool {
        sheets::around(self.cell(point))
            .filter_map(|cell| self.cells.get(&cell))
            .flatten()
            .all(|other| other.distance(point) > self.distance)
    }
}

/// Moves a point near a layer onto it.
pub fn moved_to(scene: &Scene, wall: Wall, point: DVec3, depth: f64) -> DVec3 {
    let normal = wall.gradient(scene, point);
    point - normal * (wall.distance(scene, point) - depth)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::spawn::seeds;

    fn walls(fields: &str) -> (Scene, Vec<crate::model::ParticleSeed>) {
        let text = format!(
            "Scene(title: \"t\", dimensions: 2, spacing: 0.05, smoke: 0.1,
                fluid: (density: 1000.0, viscosity: 1.0e-3, sound_speed: 15.0),
                initial: (velocity: (0.1, 0.0)), time: (end: 1.0), output: (every: 1.0), {fields})"
        );
        let scene = Scene::from_text("walls", &text).load().unwrap_or_else(|faults| panic!("{faults:?}"));
        let walls = seeds(&scene).into_iter().filter(|seed| seed.zone == Zone::Wall).collect();
        (scene, walls)
    }

    /// Checks that all particles lie in the middle of a layer and none is too near to another.
    fn check(scene: &Scene, walls: &[crate::model::ParticleSeed]) {
        for (index, wall) in walls.iter().enumerate() {
            let layer = wall.wall_distance / scene.spacing - 0.5;
            assert!((layer - layer.round()).abs() < 1e-3, "{layer} spacings at {}", wall.position);
            let nearest = walls[..index].iter().map(|other| other.position.distance(wall.position));
            let nearest = nearest.fold(f64::INFINITY, f64::min) / scene.spacing;
            assert!(nearest > 0.69, "{nearest} spacings at {}", wall.position);
        }
    }

    /// The fluid reaches to the surface, not a quarter of a spacing less as before stairs.
    #[test]
    fn fluid_before_layers_has_its_mass() {
        let (scene, _) =
            walls("domain: Circle(center: (0.01, 0.02), radius: 0.8), walls: (slip: FreeSlip, fill: Layers)");
        let fluid = seeds(&scene).iter().filter(|seed| seed.zone == Zone::Fluid).count() as f64;
        let share = fluid * 0.0025 / (std::f64::consts::PI * 0.64);
        assert!((share - 1.0).abs() < 0.01, "{share} of the area");
    }

    #[test]
    fn layers_around_a_drum_have_the_lengths_of_their_circles() {
        let (scene, walls) =
            walls("domain: Circle(center: (0.01, 0.02), radius: 0.6), walls: (slip: FreeSlip, fill: Layers)");
        check(&scene, &walls);
        let expected: f64 =
            [0.625, 0.675, 0.725].map(|radius: f64| (TAU * radius / 0.05).round()).iter().sum();
        assert_eq!(walls.len() as f64, expected);
    }

    /// A wedge has four corners; along its sides the particles are a spacing apart.
    #[test]
    fn layers_of_a_wedge_follow_both_sides() {
        let (scene, walls) = walls(
            "domain: Polygon(points: [(0.0, -0.3), (1.5, -0.5), (1.5, 0.5), (0.0, 0.3)]), walls: (fill: Layers)",
        );
        check(&scene, &walls);
        let side = (2.0 / 15.0_f64).atan().sin_cos();
        let normal = DVec3::new(side.0, side.1, 0.0);
        let along = DVec3::new(side.1, -side.0, 0.0);
        let mut first: Vec<f64> = walls
            .iter()
            .filter(|wall| wall.wall_distance < scene.spacing && wall.wall_normal.distance(normal) < 1e-6)
            .map(|wall| wall.position.dot(along))
            .collect();
        first.sort_by(f64::total_cmp);
        assert!((first.len() as f64 - 1.5 / side.1 / 0.05).abs() < 1.5, "{} particles", first.len());
        for pair in first.windows(2) {
            assert!(((pair[1] - pair[0]) / 0.05 - 1.0).abs() < 0.02, "{} m apart", pair[1] - pair[0]);
        }
    }

    /// A channel with a disc across its seam: the layers end there, at half a spacing.
    #[test]
    fn layers_of_a_periodic_channel_end_at_its_seams() {
        let (scene, walls) = walls(
            "domain: Difference([Box(min: (0.0, -0.5), max: (2.0, 0.5)), Circle(center: (0.0, 0.0), radius: 0.25),
                Circle(center: (2.0, 0.0), radius: 0.25)]),
            periodic: [\"x\"], walls: (fill: Layers)",
        );
        check(&scene, &walls);
        assert!(walls.iter().all(|wall| (0.0..2.0).contains(&wall.position.x)));
        // Three layers of 40 along each side.
        let sides = walls.iter().filter(|wall| wall.position.y.abs() > 0.5).count();
        assert_eq!(sides, 2 * 3 * 40);
        // The solid disc, less what is too deep for the fluid to feel.
        let disc = (walls.len() - sides) as f64 * 0.0025;
        let area = std::f64::consts::PI * (0.25_f64.powi(2) - 0.1_f64.powi(2));
        assert!((disc / area - 1.0).abs() < 0.1, "{disc} m² of {area} m²");
        for wall in walls.iter().filter(|wall| wall.position.x < 0.05 && wall.position.y.abs() > 0.5) {
            assert!((wall.position.x - 0.025).abs() < 1e-9, "{}", wall.position);
        }
    }

    /// Only the part has layers; a thin plate holds those of both its sides without close pairs.
    #[test]
    fn parts_and_thin_plates_have_layers_of_their_own() {
        let (scene, walls) = walls(
            "domain: Difference([Box(min: (-1.0, -1.0), max: (1.0, 1.0)),
                Rotated(angle: 20.0, shape: Box(min: (-0.5, -0.08), max: (0.5, 0.08)))]),
            walls: (parts: [(name: \"plate\", region: Circle(center: (0.0, 0.0), radius: 0.7), fill: Layers)])",
        );
        let (plate, rest): (Vec<_>, Vec<_>) = walls.into_iter().partition(|wall| wall.patch == 1);
        check(&scene, &plate);
        assert!(
            rest.iter().all(|wall| wall.wall_normal.x == 0.0
                || wall.wall_normal.y == 0.0
                || wall.wall_distance > 0.03)
        );
        // 1.0 m by 0.16 m at 0.0025 m² a particle.
        assert!((plate.len() as f64 / 64.0 - 1.0).abs() < 0.2, "{} particles", plate.len());
    }
}
