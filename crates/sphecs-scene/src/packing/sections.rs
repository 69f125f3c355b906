//! Columns of particles in the zones of openings: a section that is filled evenly up to its walls.
//!
//! A section of area A has A/Δ^(D−1) columns, rounded, along the normal of the opening. In 2D they
//! are equidistant. In 3D the plane is filled as the domain is: cells with the area of the section,
//! layers of wall particles around them, and a relaxation in the plane.

use std::ops::Range;

use glam::DVec3;

use super::cell_shares::Cells;
use super::relaxation::{concentrations, relax};
use super::{DISTURBED, KEPT_FROM_WALLS};
use crate::distance_grid::{DistanceGrid, spread};
use crate::fill::{TOLERANCE, beyond, confined_distance, wall_thickness};
use crate::lattice::Lattice;
use crate::model::{Patch, Scene};
use crate::near_points::Region;
use sphecs_core::discretisation::Discretisation;
use sphecs_core::math::lattice::LatticeSums;

/// Cells of the grid for the walls' layers per spacing.
const CELLS: f64 = 4.0;

/// Parts of a spacing in which the section of a channel in 2D is searched for its walls.
const STEPS: f64 = 64.0;

/// Columns of the zone of an opening.
pub(super) struct Columns {
    /// Place of each column in the plane of the opening, m.
    pub(super) feet: Vec<DVec3>,
    /// Distances of its particles beyond the plane, m, in rising order.
    pub(super) rows: Vec<f64>,
    /// Distance beyond the plane at which the volume of the zone begins, m.
    pub(super) start: f64,
}

impl Columns {
    /// Returns the columns of the opening with a number, inlets first.
    pub(super) fn of(scene: &Scene, lattice: &Lattice, number: usize, patch: &Patch, is_inlet: bool) -> Self {
        let outwards = if is_inlet { -patch.towards } else { patch.towards };
        let section = Section { scene, number, patch, outwards, middle: 0.5 * patch.depth };
        let frame = Frame::of(lattice, patch, scene.spacing);
        let (rows, pitch) = frame.rows(patch, is_inlet, scene.spacing);
        let start = rows.first().map_or(0.0, |first| first - 0.5 * pitch);
        let feet =
            if scene.dimensions == 2 { section.feet_on_a_line() } else { section.feet_in_a_plane(&frame) };
        Self { feet, rows, start }
    }
}

/// Section of an opening.
struct Section<'a> {
    scene: &'a Scene,
    number: usize,
    patch: &'a Patch,
    outwards: DVec3,
    /// Distance beyond the plane at which the walls are searched, m.
    middle: f64,
}

impl Section<'_> {
    /// Returns the signed distance of a place in the plane behind the walls of the zone, m.
    fn distance(&self, foot: DVec3) -> f64 {
        confined_distance(self.scene, foot + self.outwards * self.middle)
    }

    /// Returns true if a place in the plane, if it is fluid, belongs to the opening.
    fn holds(&self, foot: DVec3) -> bool {
        let tolerance = 0.5 * self.scene.spacing;
        self.scene.layout.zones[self.number].contains(foot + self.outwards * self.middle, tolerance)
    }

    /// Returns equidistant columns of each part of a section in 2D.
    fn feet_on_a_line(&self) -> Vec<DVec3> {
        let (spacing, [across, _]) = (self.scene.spacing, self.patch.across);
        let half = self.patch.half_extent[0] + spacing;
        let at = |along: f64| self.patch.at + across * along;
        let is_open = |along: f64| self.holds(at(along)) && self.distance(at(along)) <= 0.0;
        let edge = |mut open: f64, mut closed: f64| {
            for _ in 0..40 {
                let middle = 0.5 * (open + closed);
                *(if is_open(middle) { &mut open } else { &mut closed }) = middle;
            }
            open
        };
        let count = (2.0 * half / spacing * STEPS).ceil();
        let step = 2.0 * half / count;
        let (mut feet, mut from) = (Vec::new(), None);
        for index in 0..=count as usize {
            let along = index as f64 * step - half;
            match (from, is_open(along)) {
                (None, true) => from = Some(edge(along, along - step)),
                (Some(low), false) => {
                    let length = edge(along - step, along) - low;
                    let count = (length / spacing).round();
                    let place = |number: usize| at(low + length * (number as f64 + 0.5) / count);
                    feet.extend((0..count as usize).map(place));
                    from = None;
                }
                _ => {}
            }
        }
        feet
    }

    /// Returns columns that fill a section in 3D.
    fn feet_in_a_plane(&self, frame: &Frame) -> Vec<DVec3> {
        let scene = self.scene;
        let spacing = scene.spacing;
        let [columns, lines] = frame.ranges(self.patch, spacing);
        let cell = |[i, j, _]: [usize; 3]| frame.centre(columns.start + i as i64, lines.start + j as i64);
        let placed = |at: DVec3| frame.place(self.patch, at);
        let distance = |at: DVec3| self.distance(placed(at));
        let cells = Cells {
            dimensions: 2,
            counts: [(columns.end - columns.start) as usize, (lines.end - lines.start) as usize, 1],
            edges: [DVec3::X * frame.pitch[0], DVec3::Y * frame.pitch[1], DVec3::ZERO],
            centre: &cell,
            distance: &distance,
            is_in_front: &|at| self.holds(placed(at)),
        };
        let mut feet = cells.selected();
        let region = self.region(frame, [columns, lines]);
        let (low, high) = (region.low, region.high);
        let grid = DistanceGrid::new(low, high, spacing / CELLS, distance);
        let depths = (0..).map(|layer| (f64::from(layer) + 0.5) * spacing);
        let layers =
            depths.take_while(|depth| *depth < wall_thickness(scene)).flat_map(|depth| grid.curves(depth));
        let walls: Vec<DVec3> = layers.flat_map(|curve| spread(&curve, spacing)).collect();
        let lengths = scene.discretisation;
        let lengths = Discretisation::new(lengths.kernel, 2, spacing, lengths.smoothing_ratio, 1.0);
        let lattice = LatticeSums::new(lengths.kernel, lengths.smoothing_ratio, 2).density;
        let all: Vec<DVec3> = feet.iter().chain(&walls).copied().collect();
        if concentrations::<2>(&feet, &all, &region, &lengths)
            .iter()
            .any(|share| (share / lattice - 1.0).abs() > DISTURBED)
        {
            let held = |to: DVec3, bound: f64| held_by(to, bound, spacing, 2, &distance);
            relax::<2>(&mut feet, &walls, &region, &lengths, held);
        }
        feet.into_iter().map(placed).collect()
    }

    /// Returns the part of the plane around the section, with its periodic directions.
    fn region(&self, frame: &Frame, ranges: [Range<i64>; 2]) -> Region {
        let margin = wall_thickness(self.scene) + self.scene.spacing;
        let mut region = Region { low: DVec3::ZERO, high: DVec3::ZERO, periodic: [false; 3] };
        for (side, range) in ranges.iter().enumerate() {
            let axis = (0..3).find(|axis| frame.axes[side].abs().dot(DVec3::AXES[*axis]) > 1.0 - 1e-9);
            let edges =
                [range.start, range.end].map(|cell| frame.first[side] + cell as f64 * frame.pitch[side]);
            let period = axis.and_then(|axis| self.scene.periodic[axis]).map(|(low, high)| high - low);
            region.periodic[side] = period.is_some();
            (region.low[side], region.high[side]) = match period {
                Some(period) => {
                    let middle = self.patch.at.dot(frame.axes[side]);
                    (middle - 0.5 * period, middle + 0.5 * period)
                }
                None => (edges[0] - margin, edges[1] + margin),
            };
        }
        region
    }
}

/// Axes of the cells in the plane of an opening, and the rows along its normal.
struct Frame {
    axes: [DVec3; 2],
    /// Coordinate of an edge of the cells along each axis, m.
    first: [f64; 2],
    pitch: [f64; 2],
    /// Coordinate of a row along the normal and the distance of rows, m; None where the lattice has
    /// no rows along it.
    along: Option<(DVec3, f64, f64)>,
}

impl Frame {
    fn of(lattice: &Lattice, patch: &Patch, spacing: f64) -> Self {
        let axis = (0..3).find(|axis| lattice.rotation.col(*axis).dot(patch.towards).abs() > 1.0 - 1e-9);
        match axis {
            Some(axis) => {
                let [a, b] = [(axis + 1) % 3, (axis + 2) % 3];
                Self {
                    axes: [lattice.rotation.col(a), lattice.rotation.col(b)],
                    first: [lattice.origin[a], lattice.origin[b]],
                    pitch: [lattice.spacing[a], lattice.spacing[b]],
                    along: Some((
                        lattice.rotation.col(axis),
                        lattice.origin[axis] + 0.5 * lattice.spacing[axis],
                        lattice.spacing[axis],
                    )),
                }
            }
            None => Self {
                axes: patch.across,
                first: [0, 1].map(|side| patch.at.dot(patch.across[side]) - patch.half_extent[side]),
                pitch: [spacing; 2],
                along: None,
            },
        }
    }

    /// Returns the distances of the rows of a zone beyond the plane, m, and their pitch.
    fn rows(&self, patch: &Patch, is_inlet: bool, spacing: f64) -> (Vec<f64>, f64) {
        let tolerance = TOLERANCE * spacing;
        if let Some((axis, first, pitch)) = self.along {
            // The row next to the plane, found from its own place.
            let nearest = ((patch.at.dot(axis) - first) / pitch).round() as i64;
            let reach = (patch.depth / pitch).ceil() as i64 + 2;
            let place = |row: i64| patch.at + axis * (first + row as f64 * pitch - patch.at.dot(axis));
            let rows = (nearest - reach..=nearest + reach).map(|row| beyond(patch, is_inlet, place(row)));
            let mut rows: Vec<f64> =
                rows.filter(|beyond| *beyond > tolerance && *beyond <= patch.depth + tolerance).collect();
            rows.sort_by(f64::total_cmp);
            return (rows, pitch);
        }
        let count = (patch.depth / spacing).round().max(1.0);
        let pitch = patch.depth / count;
        ((0..count as usize).map(|row| (row as f64 + 0.5) * pitch).collect(), pitch)
    }

    /// Returns the ranges of the cells that cover a section.
    fn ranges(&self, patch: &Patch, spacing: f64) -> [Range<i64>; 2] {
        [0, 1].map(|side| {
            let middle = patch.at.dot(self.axes[side]);
            let half: f64 = (0..2)
                .map(|edge| (patch.across[edge].dot(self.axes[side])).abs() * patch.half_extent[edge])
                .sum();
            let index = |at: f64| (at - self.first[side]) / self.pitch[side];
            (index(middle - half - spacing)).floor() as i64..(index(middle + half + spacing)).ceil() as i64
        })
    }

    fn centre(&self, i: i64, j: i64) -> DVec3 {
        let at = |side: usize, cell: i64| self.first[side] + (cell as f64 + 0.5) * self.pitch[side];
        DVec3::new(at(0, i), at(1, j), 0.0)
    }

    /// Returns the place in the plane of an opening with these coordinates along the axes, m.
    fn place(&self, patch: &Patch, at: DVec3) -> DVec3 {
        let [a, b] = self.axes;
        patch.at + a * (at.x - patch.at.dot(a)) + b * (at.y - patch.at.dot(b))
    }
}

/// Returns a particle that came too near to a wall to its place before it, and the bound of its
/// distance behind the walls, m, from the bound without it.
pub(super) fn held_by(
    to: DVec3,
    bound: f64,
    spacing: f64,
    dimensions: usize,
    distance: &(dyn Fn(DVec3) -> f64 + Sync),
) -> (DVec3, f64) {
    let most = -KEPT_FROM_WALLS * spacing;
    if bound < most {
        return (to, bound);
    }
    let behind = distance(to);
    if behind <= most {
        return (to, behind);
    }
    let step = 1e-4 * spacing;
    let mut normal = DVec3::ZERO;
    for axis in 0..dimensions {
        normal[axis] = distance(to + step * DVec3::AXES[axis]) - distance(to - step * DVec3::AXES[axis]);
    }
    (to - normal.normalize_or_zero() * (behind - most), most)
}
