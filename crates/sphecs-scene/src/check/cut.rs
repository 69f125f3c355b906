//! Cut of the domain by the plane of an opening: its connected parts, and which of them are open.

use glam::DVec3;

use super::patches::Site;
use sphecs_core::boundary::patch::Extent;

/// Width of a cell, in spacings, in 2D and 3D: particles do not resolve what is smaller.
const CELL: [f64; 2] = [1.0 / 32.0, 0.25];

/// Largest number of cells along a direction, in 2D and 3D, which bounds time and memory.
const MOST_CELLS: [f64; 2] = [1e6, 2000.0];

/// Number of points at which a part is tested for the domain beyond the plane.
const TESTS: usize = 64;

/// Cut of the domain by a plane, as cells.
pub struct Cut<'a> {
    site: &'a Site<'a>,
    plane: CutPlane,
    cell: f64,
    /// Offsets of the middle of the first cell from the point of the plane, m.
    first: [f64; 2],
    counts: [usize; 2],
    /// Number of the part of each cell, 0 for cells outside the domain.
    labels: Vec<u16>,
    /// Parts, number 1 first.
    pub parts: Vec<CutPart>,
}

/// Plane of an opening, just inside the domain.
#[derive(Clone, Copy, Debug)]
pub struct CutPlane {
    /// A point of the plane, m.
    pub at: DVec3,
    /// Unit normal into the domain.
    pub inwards: DVec3,
    /// Unit vectors that span it; the second is zero in 2D.
    pub across: [DVec3; 2],
    /// Distance of the sampled points from it, into the domain, m.
    pub aside: f64,
}

impl CutPlane {
    /// Returns the sampled point at offsets along both directions, m.
    pub fn point(&self, offset: [f64; 2]) -> DVec3 {
        self.at + self.aside * self.inwards + offset[0] * self.across[0] + offset[1] * self.across[1]
    }
}

/// Connected part of a cut.
#[derive(Clone, Debug, PartialEq)]
pub struct CutPart {
    /// A point in its middle or, if that is outside, near its edge, m.
    pub at: DVec3,
    /// Area, m² (length in m in 2D), to about a cell along the edge.
    pub area: f64,
    /// True if the domain ends at the plane over the whole part.
    pub is_end: bool,
    /// True if it is open.
    pub is_open: bool,
    /// Lower and upper corner of its bounding rectangle, as offsets from the point of the plane, m.
    pub bounds: [[f64; 2]; 2],
}

impl<'a> Cut<'a> {
    /// Returns the cut by a plane, whose point is in the part to open.
    pub fn new(plane: CutPlane, extent: Extent, site: &'a Site<'a>) -> Self {
        let axes = site.dimensions - 1;
        let (low, high) = bounds(&plane, site);
        let longest = (0..axes).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
        let cell = (CELL[axes - 1] * site.spacing).max(longest / MOST_CELLS[axes - 1]);
        let counts: [usize; 2] = std::array::from_fn(|axis| {
            if axis < axes { ((high[axis] - low[axis]) / cell).ceil() as usize + 2 } else { 1 }
        });
        // The point of the plane is in the middle of a cell.
        let first: [f64; 2] =
            std::array::from_fn(|axis| if axis < axes { (low[axis] / cell).floor() * cell } else { 0.0 });
        let mut cut = Self { site, plane, cell, first, counts, labels: Vec::new(), parts: Vec::new() };
        cut.labels = cut.inside();
        cut.find_parts();
        cut.open(extent);
        cut
    }

    fn offset(&self, cell: usize) -> [f64; 2] {
        let index = [cell % self.counts[0], cell / self.counts[0]];
        std::array::from_fn(|axis| self.first[axis] + index[axis] as f64 * self.cell)
    }

    /// Returns the cell of an offset, m; None outside the cut.
    fn cell_at(&self, offset: [f64; 2]) -> Option<usize> {
        let mut index = [0; 2];
        for axis in 0..2 {
            let place = ((offset[axis] - self.first[axis]) / self.cell).round();
            if place < 0.0 || place >= self.counts[axis] as f64 {
                return None;
            }
            index[axis] = place as usize;
        }
        Some(index[0] + self.counts[0] * index[1])
    }

    /// Returns `u16::MAX` for each cell in the domain, else 0.
    fn inside(&self) -> Vec<u16> {
        let mut labels = vec![0; self.counts[0] * self.counts[1]];
        for row in labels.chunks_mut(self.counts[0]).enumerate() {
            let (j, labels) = row;
            let mut i = 0;
            while i < labels.len() {
                let point = self.plane.point(self.offset(i + self.counts[0] * j));
                let distance = self.site.domain.signed_distance(point);
                // The sign is the same up to this distance.
                let next = labels.len().min(i + ((distance.abs() / self.cell) as usize).max(1));
                if distance <= 0.0 {
                    labels[i..next].fill(u16::MAX);
                }
                i = next;
            }
        }
        labels
    }

    /// Numbers the connected cells and measures their parts.
    fn find_parts(&mut self) {
        let mut queue = Vec::new();
        for start in 0..self.labels.len() {
            if self.labels[start] != u16::MAX || self.parts.len() + 2 > usize::from(u16::MAX) {
                continue;
            }
            let number = self.parts.len() as u16 + 1;
            let mut cells = Vec::new();
            queue.push(start);
            self.labels[start] = number;
            while let Some(cell) = queue.pop() {
                cells.push(cell);
                for near in self.around(cell).into_iter().flatten() {
                    if self.labels[near] == u16::MAX {
                        self.labels[near] = number;
                        queue.push(near);
                    }
                }
            }
            let part = self.part(&cells);
            self.parts.push(part);
        }
    }

    fn around(&self, cell: usize) -> [Option<usize>; 4] {
        let [columns, rows] = self.counts;
        let (i, j) = (cell % columns, cell / columns);
        [
            (i > 0).then(|| cell - 1),
            (i + 1 < columns).then(|| cell + 1),
            (j > 0).then(|| cell - columns),
            (j + 1 < rows).then(|| cell + columns),
        ]
    }

    fn part(&self, cells: &[usize]) -> CutPart {
        let mut bounds = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        let mut sum = [0.0; 2];
        for offset in cells.iter().map(|&cell| self.offset(cell)) {
            for axis in 0..2 {
                bounds[0][axis] = bounds[0][axis].min(offset[axis]);
                bounds[1][axis] = bounds[1][axis].max(offset[axis]);
                sum[axis] += offset[axis] / cells.len() as f64;
            }
        }
        let distance = |cell: &usize| {
            let offset = self.offset(*cell);
            (offset[0] - sum[0]).hypot(offset[1] - sum[1])
        };
        let middle = cells.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let at = middle.map_or(self.plane.at, |&cell| self.plane.point(self.offset(cell)));
        let beyond = -2.0 * self.plane.aside * self.plane.inwards;
        let tests = cells.iter().step_by((cells.len() / TESTS).max(1));
        let is_end = tests
            .map(|&cell| self.plane.point(self.offset(cell)))
            .all(|point| !self.site.domain.contains(point + beyond, 0.0));
        let area = cells.len() as f64 * self.cell.powi(self.site.dimensions as i32 - 1);
        CutPart { at: at - self.plane.aside * self.plane.inwards, area, is_end, is_open: false, bounds }
    }

    /// Opens the part of the plane's point and, on request, all others at which the domain ends.
    fn open(&mut self, extent: Extent) {
        let own = self.number_at([0.0; 2]);
        for (index, part) in self.parts.iter_mut().enumerate() {
            part.is_open = index + 1 == own || (extent == Extent::Whole && part.is_end);
        }
    }

    /// Returns the number of the part at an offset, m, or next to it; 0 without any.
    fn number_at(&self, offset: [f64; 2]) -> usize {
        const NEAR: [(f64, f64); 9] = [
            (0.0, 0.0),
            (1.0, 0.0),
            (-1.0, 0.0),
            (0.0, 1.0),
            (0.0, -1.0),
            (1.0, 1.0),
            (-1.0, 1.0),
            (1.0, -1.0),
            (-1.0, -1.0),
        ];
        let label = |(along, aside): (f64, f64)| {
            let near = [offset[0] + along * self.cell, offset[1] + aside * self.cell];
            self.cell_at(near).map_or(0, |cell| usize::from(self.labels[cell]))
        };
        NEAR.into_iter().map(label).find(|label| *label > 0).unwrap_or(0)
    }

    /// Returns true if an offset, m, is in the domain and in an open part.
    pub fn is_open(&self, offset: [f64; 2]) -> bool {
        let number = self.number_at(offset);
        number > 0
            && self.parts[number - 1].is_open
            && self.site.domain.contains(self.plane.point(offset), 0.0)
    }

    /// Returns lower and upper corner of the bounding rectangle of the open parts, to a cell, m.
    pub fn open_bounds(&self) -> [[f64; 2]; 2] {
        let open = self.parts.iter().filter(|part| part.is_open);
        open.fold([[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]], |[low, high], part| {
            let [from, to] = part.bounds;
            [
                std::array::from_fn(|axis| low[axis].min(from[axis])),
                std::array::from_fn(|axis| high[axis].max(to[axis])),
            ]
        })
    }

    /// Returns the width of a cell, m.
    pub fn cell(&self) -> f64 {
        self.cell
    }
}

/// Returns the least and largest offsets of the domain's bounding box along the plane, m.
fn bounds(plane: &CutPlane, site: &Site<'_>) -> ([f64; 2], [f64; 2]) {
    let (min, max) = site.domain.bounds();
    let (mut low, mut high) = ([0.0_f64; 2], [0.0_f64; 2]);
    for corner in 0..8 {
        let pick = |axis: usize| if corner >> axis & 1 == 0 { min[axis] } else { max[axis] };
        let corner = DVec3::new(pick(0), pick(1), if site.dimensions == 2 { 0.0 } else { pick(2) });
        for axis in 0..site.dimensions - 1 {
            let offset = (corner - plane.at).dot(plane.across[axis]);
            low[axis] = low[axis].min(offset);
            high[axis] = high[axis].max(offset);
        }
    }
    (low, high)
}
