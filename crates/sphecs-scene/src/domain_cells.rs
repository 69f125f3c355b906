//! Cells of about a particle's size over the bounding box of the domain.

use glam::DVec3;

use super::model::Scene;

/// Largest number of cells: a solution on them takes less than a second.
const MOST_CELLS: f64 = 3e5;

/// Samples along each axis of what is open of a cell or of a face that a wall may cut.
const SAMPLES: usize = 4;

/// Grid of cells over the bounding box of the domain.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Cells {
    low: DVec3,
    /// Size of a cell, m.
    pub(crate) size: f64,
    counts: [usize; 3],
}

impl Cells {
    /// Returns cells over the domain of a scene.
    pub(crate) fn over(scene: &Scene) -> Self {
        let (low, high) = scene.layout.casing.domain.bounds();
        let extent = (high - low).max(DVec3::ZERO);
        let dimensions = scene.dimensions;
        let lengths: f64 = (0..dimensions).map(|axis| extent[axis] / scene.spacing).product();
        let coarser = (lengths / MOST_CELLS).powf(1.0 / dimensions as f64).max(1.0);
        let size = scene.spacing * coarser;
        let counts = std::array::from_fn(|axis| {
            if axis < dimensions { ((extent[axis] / size - 1e-6).ceil() as usize).max(1) } else { 1 }
        });
        // The cells of an axis that does not divide into whole ones overlap both ends alike.
        let half = DVec3::from(std::array::from_fn(|axis| 0.5 * size * counts[axis] as f64));
        let middle = 0.5 * (low + high);
        let low = middle - half;
        Self { low: DVec3::new(low.x, low.y, if dimensions == 3 { low.z } else { 0.0 }), size, counts }
    }

    /// Returns the number of cells.
    pub(crate) fn len(&self) -> usize {
        self.counts.iter().product()
    }

    fn place(&self, index: usize) -> [usize; 3] {
        let [nx, ny, _] = self.counts;
        [index % nx, index / nx % ny, index / (nx * ny)]
    }

    fn index(&self, place: [usize; 3]) -> usize {
        (place[2] * self.counts[1] + place[1]) * self.counts[0] + place[0]
    }

    /// Returns the centre of a cell, m.
    pub(crate) fn centre(&self, index: usize, dimensions: usize) -> DVec3 {
        let place = self.place(index);
        let mut centre = DVec3::ZERO;
        for axis in 0..dimensions {
            centre[axis] = self.low[axis] + (place[axis] as f64 + 0.5) * self.size;
        }
        centre
    }

    /// Returns the cell at a point (m), or the nearest one.
    pub(crate) fn nearest(&self, point: DVec3) -> usize {
        let place = std::array::from_fn(|axis| {
            let at = ((point[axis] - self.low[axis]) / self.size).max(0.0) as usize;
            at.min(self.counts[axis] - 1)
        });
        self.index(place)
    }

    /// Returns samples about a point, m: of a cell, or of its section across an axis.
    pub(crate) fn samples(
        &self,
        centre: DVec3,
        across: Option<usize>,
        dimensions: usize,
    ) -> impl Iterator<Item = DVec3> + use<> {
        let size = self.size;
        let count = |axis: usize| if axis < dimensions && across != Some(axis) { SAMPLES } else { 1 };
        let counts: [usize; 3] = std::array::from_fn(count);
        (0..counts.iter().product()).map(move |sample: usize| {
            let place =
                [sample % counts[0], sample / counts[0] % counts[1], sample / (counts[0] * counts[1])];
            let offset = |axis: usize| ((place[axis] as f64 + 0.5) / counts[axis] as f64 - 0.5) * size;
            centre + DVec3::from(std::array::from_fn(offset))
        })
    }

    /// Returns the neighbour of a cell along an axis; None at the end of the grid.
    pub(crate) fn neighbour(
        &self,
        index: usize,
        axis: usize,
        forward: bool,
        is_periodic: bool,
    ) -> Option<usize> {
        let mut place = self.place(index);
        let last = self.counts[axis] - 1;
        place[axis] = match (forward, place[axis]) {
            (true, at) if at == last => is_periodic.then_some(0)?,
            (true, at) => at + 1,
            (false, 0) => is_periodic.then_some(last)?,
            (false, at) => at - 1,
        };
        Some(self.index(place))
    }
}

/// Returns the part of samples that are open.
pub(crate) fn open_part(samples: impl Iterator<Item = DVec3>, is_open: impl Fn(DVec3) -> bool) -> f64 {
    let (mut open, mut count) = (0, 0);
    for point in samples {
        open += u32::from(is_open(point));
        count += 1;
    }
    f64::from(open) / f64::from(count.max(1))
}
