//! Flow from the inlets before a run: path length, volume, and the section with the largest mean
//! speed.
//!
//! The distance from the inlets is measured through the fluid, over a grid with cells of a particle
//! spacing. All fluid at one distance is taken for a section, so that
//!
//! ```text
//! A(s) = V(s, s + Δs)/Δs,   U(s, t) = Σ Q_in(t)/A(s)
//! ```
//!
//! with the volume V of the fluid between two distances and the volume flows Q_in of the inlets
//! (mass balance of an incompressible flow). Around a body A is the sum of the gaps, and in a bend
//! or a bifurcation the sections follow the flow. Where streams of different inlets meet, U is an
//! estimate.

use glam::DVec3;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::fill::beyond;
use super::model::{Inlet, ParticleSeed, Scene};
use super::sampled_times::sampled_times;
use sphecs_core::particles::zone::Zone;

/// Length Δs of a section along the flow, spacings.
const SECTION_LENGTH: f64 = 4.0;

/// Largest number of grid cells, of 5 B each.
const MOST_CELLS: f64 = 4e8;

/// Number of points along each side of an opening at which its velocity is evaluated.
const POINTS: usize = 40;

/// Flow along the path from the inlets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlowPath {
    /// Largest distance from the inlets through the fluid, m.
    pub length: f64,
    /// Volume of the fluid (area in 2D), m³ (m²).
    pub volume: f64,
    /// Largest volume flow of all inlets together, m³/s (m²/s in 2D).
    pub volume_flow: f64,
    /// Time of the largest volume flow, s.
    pub time: f64,
    /// Area of the narrowest section, m² (m in 2D).
    pub area: f64,
    /// Middle of the fluid in the narrowest section, m.
    pub at: DVec3,
}

impl FlowPath {
    /// Returns the largest mean speed over a section, m/s.
    pub fn mean_speed(&self) -> f64 {
        self.volume_flow / self.area
    }

    /// Returns the mean time of the fluid from inlet to outlet at the largest flow, s.
    pub fn passage_time(&self) -> f64 {
        self.volume / self.volume_flow
    }
}

/// Returns the flow from the inlets of a scene; None without inlets that feed it, or if the grid
/// would be too large.
pub fn flow_path(scene: &Scene, seeds: &[ParticleSeed]) -> Option<FlowPath> {
    let (volume_flow, time) = largest_flow(scene)?;
    let fluid: Vec<DVec3> =
        seeds.iter().filter(|seed| seed.zone == Zone::Fluid).map(|seed| seed.position).collect();
    let distances = distances_from_inlets(scene, &fluid)?;
    let length = distances.iter().copied().filter(|distance| distance.is_finite()).fold(0.0, f32::max);
    let cell_volume = scene.discretisation.cell_volume();
    let (area, at) = narrowest_section(scene, &fluid, &distances, length)?;
    let length = f64::from(length);
    Some(FlowPath { length, volume: fluid.len() as f64 * cell_volume, volume_flow, time, area, at })
}

/// Returns area and middle of the narrowest section upstream of the nearest outlet.
fn narrowest_section(scene: &Scene, fluid: &[DVec3], distances: &[f32], length: f32) -> Option<(f64, DVec3)> {
    let section_length = SECTION_LENGTH * scene.spacing;
    let section = |distance: f32| (f64::from(distance) / section_length) as usize;
    let at_outlet = |point: DVec3| {
        scene.outlets.iter().any(|outlet| {
            outlet.patch.covers(point, 0.0) && beyond(&outlet.patch, false, point) > -1.5 * scene.spacing
        })
    };
    let nearest_outlet = fluid
        .iter()
        .zip(distances)
        .filter(|(point, _)| at_outlet(**point))
        .map(|(_, distance)| *distance)
        .fold(length, f32::min);
    // The last section is incomplete.
    let count = section(nearest_outlet).max(1);
    let mut sections = vec![(0_usize, DVec3::ZERO); count];
    for (point, distance) in fluid.iter().zip(distances) {
        // Of fluid that no inlet reaches the index is beyond the last one.
        if let Some((particles, sum)) = sections.get_mut(section(*distance)) {
            *particles += 1;
            *sum += *point;
        }
    }
    let (particles, sum) =
        sections.into_iter().filter(|(particles, _)| *particles > 0).min_by_key(|s| s.0)?;
    let area = particles as f64 * scene.discretisation.cell_volume() / section_length;
    Some((area, sum / particles as f64))
}

/// Returns the largest volume flow of all inlets together, m³/s (m²/s in 2D), and its time, s.
fn largest_flow(scene: &Scene) -> Option<(f64, f64)> {
    let points: Vec<Vec<DVec3>> =
        scene.inlets.iter().map(|inlet| inlet.section_points(scene, POINTS)).collect();
    let flow = |time: f64| -> f64 {
        scene
            .inlets
            .iter()
            .zip(&points)
            .map(|(inlet, points)| inlet.volume_flow(scene.fluid.viscosity, points, time))
            .sum()
    };
    let end = if scene.inlets.iter().any(Inlet::is_unsteady) { scene.time.end } else { 0.0 };
    // A steady flow needs one time, and many points of a large section take long.
    let times: Vec<f64> = if end > 0.0 { sampled_times(end).collect() } else { vec![0.0] };
    let flows: Vec<(f64, f64)> = times.into_par_iter().map(|time| (flow(time), time)).collect();
    flows
        .into_iter()
        .filter(|(flow, _)| *flow > 0.0)
        // Of equal flows the first.
        .reduce(|largest, next| if next.0 > largest.0 * (1.0 + 1e-9) { next } else { largest })
}

/// Grid of cells of one spacing around the fluid.
struct Cells {
    low: DVec3,
    spacing: f64,
    counts: [usize; 3],
}

impl Cells {
    /// Returns the grid around points; None without any, or if it would be too large.
    fn around(points: &[DVec3], spacing: f64) -> Option<Self> {
        let low = points.iter().copied().reduce(DVec3::min)? - DVec3::splat(0.5 * spacing);
        let extent = points.iter().copied().reduce(DVec3::max)? - low;
        let counts = extent.to_array().map(|length| (length / spacing) as usize + 1);
        let cells: f64 = counts.iter().map(|count| *count as f64).product();
        (cells <= MOST_CELLS).then_some(Self { low, spacing, counts })
    }

    fn len(&self) -> usize {
        self.counts.iter().product()
    }

    fn index(&self, point: DVec3) -> usize {
        let place = ((point - self.low) / self.spacing).to_array();
        let [i, j, k] = [0, 1, 2].map(|axis| (place[axis] as usize).min(self.counts[axis] - 1));
        (k * self.counts[1] + j) * self.counts[0] + i
    }

    /// Visits the cells around a cell, diagonal ones included, with the length of the way, m.
    fn for_each_neighbour(&self, cell: usize, mut visit: impl FnMut(usize, f32)) {
        let [nx, ny, _] = self.counts;
        let place = [cell % nx, cell / nx % ny, cell / (nx * ny)];
        // The length for a difference along no axis, one, two and three of them.
        let lengths = [0.0_f32, 1.0, 2.0, 3.0].map(|axes| axes.sqrt() * self.spacing as f32);
        let [columns, rows, layers] =
            [0, 1, 2].map(|axis| place[axis].saturating_sub(1)..(place[axis] + 2).min(self.counts[axis]));
        for k in layers {
            for j in rows.clone() {
                let differing = usize::from(j != place[1]) + usize::from(k != place[2]);
                for i in columns.clone() {
                    visit((k * ny + j) * nx + i, lengths[differing + usize::from(i != place[0])]);
                }
            }
        }
    }
}

/// Cells whose distance is known but whose neighbours' is not, in bins of distances.
///
/// A bin is as wide as the shortest way between two cells. So no cell of a bin shortens the way to
/// another one of it, and their order does not matter: no heap has to keep it.
struct Queue {
    width: f32,
    bins: Vec<Vec<u32>>,
}

impl Queue {
    fn bin(&self, distance: f32) -> usize {
        (distance / self.width) as usize
    }

    fn push(&mut self, distance: f32, cell: usize) {
        let bin = self.bin(distance);
        if bin >= self.bins.len() {
            self.bins.resize_with(bin + 1, Vec::new);
        }
        // There are fewer than `MOST_CELLS`.
        self.bins[bin].push(cell as u32);
    }
}

/// Returns the distance of each point of the fluid from the inlets through the fluid, m; infinite
/// where no inlet is reached. None if the grid would be too large.
///
/// Shortest paths from cell to neighbouring cell, diagonals included (Dijkstra). Along the axes and
/// the diagonals they are exact, between them up to 8 % too long in 2D and 14 % in 3D.
fn distances_from_inlets(scene: &Scene, fluid: &[DVec3]) -> Option<Vec<f32>> {
    let cells = Cells::around(fluid, scene.spacing)?;
    // NaN where there is no fluid: no comparison with it is true.
    let mut distances = vec![f32::NAN; cells.len()];
    let indices: Vec<usize> = fluid.iter().map(|point| cells.index(*point)).collect();
    for &cell in &indices {
        distances[cell] = f32::INFINITY;
    }
    let mut queue = Queue { width: scene.spacing as f32, bins: Vec::new() };
    for (point, &cell) in fluid.iter().zip(&indices) {
        let along = scene
            .inlets
            .iter()
            .filter(|inlet| inlet.patch.covers(*point, 0.0))
            .map(|inlet| inlet.patch.along(*point))
            .filter(|along| (0.0..1.5 * scene.spacing).contains(along))
            .fold(f64::INFINITY, f64::min) as f32;
        if along < distances[cell] {
            distances[cell] = along;
            queue.push(along, cell);
        }
    }
    spread(&cells, &mut queue, &mut distances);
    Some(indices.into_iter().map(|cell| distances[cell]).collect())
}

/// Replaces the distances of all cells by the shortest through their neighbours.
fn spread(cells: &Cells, queue: &mut Queue, distances: &mut [f32]) {
    let mut bin = 0;
    while bin < queue.bins.len() {
        let current = std::mem::take(&mut queue.bins[bin]);
        for &cell in &current {
            let distance = distances[cell as usize];
            if queue.bin(distance) != bin {
                // A shorter way was found after the cell was put here.
                continue;
            }
            cells.for_each_neighbour(cell as usize, |neighbour, length| {
                let through = distance + length;
                if through < distances[neighbour] {
                    distances[neighbour] = through;
                    queue.push(through, neighbour);
                }
            });
        }
        // By rounding a neighbour may be in the same bin.
        if queue.bins[bin].is_empty() {
            bin += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::seeds;

    fn path_of(domain: &str, inlet: &str, outlet: &str) -> FlowPath {
        let text = format!(
            r#"Scene(
    title: "Path", dimensions: 2, spacing: 0.05, smoke: 0.05,
    fluid: (density: 1000.0, viscosity: 1e-3, sound_speed: 20.0),
    scheme: Wcsph(), domain: {domain},
    inlets: [(at: {inlet}, towards: (1.0, 0.0), velocity: Normal("1.0 + 0.5*sin(pi*t)"))],
    outlets: [(at: {outlet}, condition: WaveEquation())],
    reference: (velocity: 1.0, length: 1.0),
    time: (end: 1.0), output: (every: 0.5),
)"#
        );
        let scene = Scene::from_text("path", text).load().expect("a scene");
        flow_path(&scene, &seeds(&scene)).expect("a path")
    }

    #[test]
    fn constriction_is_the_narrowest_section() {
        let domain =
            "Difference([Box(min: (0.0, 0.0), max: (6.0, 1.0)), Box(min: (2.0, 0.4), max: (3.0, 2.0))])";
        let path = path_of(domain, "(0.0, 0.5)", "(6.0, 0.5), towards: (1.0, 0.0)");
        assert!((path.area - 0.4).abs() < 1e-9, "{path:?}");
        assert!((2.0..3.0).contains(&path.at.x) && (path.at.y - 0.2).abs() < 0.05, "{path:?}");
        // The inflow is largest at half a second, 1.5 m/s over a width of 1 m.
        assert!((path.volume_flow - 1.5).abs() < 1e-9 && (path.time - 0.5).abs() < 1e-9, "{path:?}");
        assert!((path.mean_speed() - 3.75).abs() < 1e-6 && (path.volume - 5.4).abs() < 1e-6, "{path:?}");
        assert!(path.length > 5.9, "{path:?}");
    }

    #[test]
    fn gaps_beside_a_body_are_one_section() {
        let domain =
            "Difference([Box(min: (0.0, 0.0), max: (6.0, 2.0)), Box(min: (2.0, 0.8), max: (3.0, 1.4))])";
        let path = path_of(domain, "(0.0, 1.0)", "(6.0, 1.0), towards: (1.0, 0.0)");
        assert!((path.area - 1.4).abs() < 0.02, "{path:?}");
    }

    #[test]
    fn section_of_a_bend_is_not_counted_in_both_legs() {
        // Two legs of 1 m, 0.5 m apart, joined at the right: the outlet is above the inlet.
        let domain =
            "Difference([Box(min: (0.0, 0.0), max: (5.0, 2.5)), Box(min: (-1.0, 1.0), max: (4.0, 1.5))])";
        let path = path_of(domain, "(0.0, 0.5)", "(0.0, 2.0), towards: (-1.0, 0.0)");
        assert!((0.9..1.05).contains(&path.area), "{path:?}");
        // Around the inner corner.
        assert!((8.5..9.2).contains(&path.length), "{path:?}");
    }
}
