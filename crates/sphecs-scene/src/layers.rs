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
//! In 2D the curves are found by marching squares, Lorensen & Cline (1987), on a grid of Δ/4 and
//! moved to the layer by a step along the gradient; for 3D see [`sheets`]. Where layers of two
//! surfaces meet in a thin wall, the nearer ones to their surface stay.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::iter::{IntoParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::fill::{Place, wall_thickness};
use super::model::Scene;
use super::movers::Wall;
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
    let keeps = |place: &Place| !is_of_wall(place) || !is_layered(place.position);
    let kept: Vec<bool> = places.par_iter().map(keeps).collect();
    let replaced = places.iter().zip(&kept).filter(|(_, kept)| !**kept).map(|(place, _)| place.position);
    let replaced: Vec<DVec3> = replaced.collect();
    let mut kept = kept.into_iter();
    places.retain(|_| kept.next().unwrap_or(true));
    let mut taken = TakenPlaces::new(APART * scene.spacing);
    places.iter().filter(|place| is_of_wall(place)).for_each(|place| taken.add(place.position));
    let deepest = wall_thickness(scene) - 1e-9 * scene.spacing;
    let depths = (0..).map(|layer| (f64::from(layer) + 0.5) * scene.spacing);
    let depths: Vec<f64> = depths.take_while(|depth| *depth < deepest).collect();
    let sheets: Vec<Vec<DVec3>> = if scene.dimensions == 2 {
        let grid = DistanceGrid::new(scene, wall);
        depths.iter().flat_map(|depth| curves(scene, wall, &grid, *depth)).collect()
    } else {
        sheets::spread(scene, wall, &replaced, &depths)
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

/// Returns the curves of the surface of a wall at the start in 2D, m; a closed curve ends at its
/// first point.
pub fn surface_curves(scene: &Scene, wall: Wall) -> Vec<Vec<DVec3>> {
    let curves = DistanceGrid::new(scene, wall).curves(0.0).into_iter();
    let moved =
        |curve: Vec<DVec3>| curve.into_iter().map(|point| moved_to(scene, wall, point, 0.0)).collect();
    curves.map(moved).collect()
}

/// Returns the particles of the curves of a layer, m.
fn curves(scene: &Scene, wall: Wall, grid: &DistanceGrid, depth: f64) -> Vec<Vec<DVec3>> {
    let on_it = |curve: &Vec<DVec3>| {
        spread(curve, scene.spacing).into_iter().map(|point| moved_to(scene, wall, point, depth)).collect()
    };
    grid.curves(depth).iter().map(on_it).collect()
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

/// Returns points at equal distances of about `spacing` along a curve, m.
fn spread(curve: &[DVec3], spacing: f64) -> Vec<DVec3> {
    let lengths = curve.windows(2).map(|pair| pair[0].distance(pair[1]));
    let total: f64 = lengths.clone().sum();
    let count = (total / spacing).round().max(1.0);
    let step = total / count;
    let mut points = Vec::new();
    let (mut passed, mut next) = (0.0, 0.5 * step);
    for (pair, length) in curve.windows(2).zip(lengths) {
        while next <= passed + length && points.len() < count as usize {
            points.push(pair[0].lerp(pair[1], (next - passed) / length.max(f64::MIN_POSITIVE)));
            next += step;
        }
        passed += length;
    }
    points
}

/// Signed distances on the nodes of a grid around the walls, m.
struct DistanceGrid {
    low: DVec3,
    cell: f64,
    counts: [usize; 2],
    distances: Vec<f64>,
}

/// An edge of the grid: its first node and its direction, 0 along x and 1 along y.
type Edge = ([usize; 2], usize);

impl DistanceGrid {
    fn new(scene: &Scene, wall: Wall) -> Self {
        let cell = scene.spacing / CELLS;
        let margin = DVec3::splat(wall_thickness(scene) + scene.spacing);
        let (low, high) = wall.bounds(scene);
        let (low, high) = ((low - margin).with_z(0.0), (high + margin).with_z(0.0));
        let counts = [0, 1].map(|axis| ((high[axis] - low[axis]) / cell).ceil() as usize + 1);
        let node = |index: usize| {
            low + cell * DVec3::new((index % counts[0]) as f64, (index / counts[0]) as f64, 0.0)
        };
        let nodes = (0..counts[0] * counts[1]).into_par_iter();
        let distances = nodes.map(|index| wall.distance(scene, node(index))).collect();
        Self { low, cell, counts, distances }
    }

    fn distance(&self, node: [usize; 2]) -> f64 {
        self.distances[node[0] + node[1] * self.counts[0]]
    }

    /// Returns the point of an edge at which the distance is `level`.
    fn crossing(&self, (node, axis): Edge, level: f64) -> DVec3 {
        let mut end = node;
        end[axis] += 1;
        let (from, to) = (self.distance(node) - level, self.distance(end) - level);
        let mut place = DVec3::new(node[0] as f64, node[1] as f64, 0.0);
        place[axis] += from / (from - to);
        self.low + self.cell * place
    }

    /// Returns the curves on which the distance is `level`, m; a closed curve ends at its first
    /// point.
    fn curves(&self, level: f64) -> Vec<Vec<DVec3>> {
        let mut links: BTreeMap<Edge, Vec<Edge>> = BTreeMap::new();
        for y in 0..self.counts[1] - 1 {
            for x in 0..self.counts[0] - 1 {
                for (from, to) in self.segments([x, y], level).into_iter().flatten() {
                    links.entry(from).or_default().push(to);
                    links.entry(to).or_default().push(from);
                }
            }
        }
        let mut curves = Vec::new();
        // Open curves begin at an edge with one link; what remains is closed.
        while let Some(start) = links
            .iter()
            .find(|(_, to)| to.len() == 1)
            .or_else(|| links.iter().find(|(_, to)| !to.is_empty()))
            .map(|(edge, _)| *edge)
        {
            let mut curve = vec![self.crossing(start, level)];
            let mut at = start;
            while let Some(next) = links.get_mut(&at).and_then(Vec::pop) {
                if let Some(back) = links.get_mut(&next) {
                    back.retain(|edge| *edge != at);
                }
                curve.push(self.crossing(next, level));
                at = next;
            }
            links.retain(|_, to| !to.is_empty());
            curves.push(curve);
        }
        curves
    }

    /// Returns the segments of a curve in a cell, between its edges.
    fn segments(&self, [x, y]: [usize; 2], level: f64) -> [Option<(Edge, Edge)>; 2] {
        let corners = [[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]];
        let inside = corners.map(|node| self.distance(node) < level);
        let edges = [([x, y], 0), ([x + 1, y], 1), ([x, y + 1], 0), ([x, y], 1)];
        let crossed: Vec<Edge> =
            (0..4).filter(|side| inside[*side] != inside[(side + 1) % 4]).map(|side| edges[side]).collect();
        match crossed[..] {
            [a, b] => [Some((a, b)), None],
            [a, b, c, d] => {
                let middle = corners.iter().map(|node| self.distance(*node)).sum::<f64>() / 4.0;
                // The middle joins the pair of corners on its own side.
                if (middle < level) == inside[0] {
                    [Some((a, b)), Some((c, d))]
                } else {
                    [Some((d, a)), Some((b, c))]
                }
            }
            _ => [None, None],
        }
    }
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
