//! Plane of a picture: the plane of a 2D flow, or a slice of a 3D flow.

use crate::error::OutputError;
use crate::frame::Frame;
use crate::header::Header;
use sphecs_core::format::significant;

/// Plane normal to an axis of a 3D flow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slice {
    /// Axis normal to the plane: 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// Position on that axis, m; None: the middle of the domain.
    pub at: Option<f64>,
}

/// Plane that is drawn and its coordinates.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct View {
    /// Axes to the right, upwards and normal to the plane.
    pub(crate) axes: [usize; 3],
    /// Position of the plane on the third axis, m.
    pub(crate) at: f64,
    /// Lower left corner, m.
    pub(crate) low: [f64; 2],
    /// Upper right corner, m.
    pub(crate) high: [f64; 2],
    /// Particle spacing Δ, m.
    pub(crate) spacing: f64,
    /// Smoothing length h, m.
    pub(crate) smoothing_length: f64,
    /// 2 or 3.
    pub(crate) dimensions: usize,
    /// True if all particles are drawn, not only those at the plane.
    pub(crate) is_whole: bool,
}

impl View {
    /// Returns the view of a run.
    ///
    /// # Errors
    /// [`OutputError::Request`] when the slice is outside the domain or the run has no extent.
    pub(crate) fn new(header: &Header, slice: Option<Slice>) -> Result<Self, OutputError> {
        let [low, high] = header.bounds;
        if slice.is_some() && header.dimensions == 2 {
            return Err(OutputError::Request(
                "slice: the flow is in 2D and has one plane only: leave `--slice` out".to_owned(),
            ));
        }
        let axes = match slice.map(|slice| slice.axis) {
            Some(0) => [1, 2, 0],
            Some(1) => [0, 2, 1],
            _ => [0, 1, 2],
        };
        let across = axes[2];
        let middle = 0.5 * (low[across] + high[across]);
        let given = slice.and_then(|slice| slice.at);
        let at = if header.dimensions == 2 { 0.0 } else { given.unwrap_or(middle) };
        if !(low[across]..=high[across]).contains(&at) {
            return Err(OutputError::Request(format!(
                "slice at {} = {} m: must lie in the domain, from {} to {} m",
                ["x", "y", "z"][across],
                significant(at),
                significant(low[across]),
                significant(high[across])
            )));
        }
        // A particle is in the middle of its volume.
        let pad = 0.5 * header.spacing;
        let view = Self {
            axes,
            at,
            low: [low[axes[0]] - pad, low[axes[1]] - pad],
            high: [high[axes[0]] + pad, high[axes[1]] + pad],
            spacing: header.spacing,
            smoothing_length: header.smoothing_length,
            dimensions: header.dimensions,
            is_whole: false,
        };
        if header.spacing > 0.0 && view.extent().iter().all(|length| length.is_finite() && *length > 0.0) {
            Ok(view)
        } else {
            Err(OutputError::Request("the run has no particles to draw".to_owned()))
        }
    }

    /// Returns the view of a part of the plane, given by its edges left, right, below and above, m.
    ///
    /// # Errors
    /// [`OutputError::Request`] when the part is outside the view.
    pub(crate) fn part(self, [left, right, below, above]: [f64; 4]) -> Result<Self, OutputError> {
        let (low, high) = ([left, below], [right, above]);
        for axis in 0..2 {
            if low[axis] >= self.high[axis] || high[axis] <= self.low[axis] {
                return Err(OutputError::Request(format!(
                    "box from {name} = {} to {} m: must meet the flow, which is from {name} = {} to {} m",
                    significant(low[axis]),
                    significant(high[axis]),
                    significant(self.low[axis]),
                    significant(self.high[axis]),
                    name = self.axis_name(axis),
                )));
            }
        }
        Ok(Self { low, high, ..self })
    }

    /// Returns the distance from the plane up to which particles are drawn, m.
    pub(crate) fn depth(&self) -> f64 {
        if self.is_whole { f64::INFINITY } else { 1.75 * self.spacing }
    }

    /// Returns true if a place is in the picture or within a distance, m, of its edges.
    pub(crate) fn is_near(&self, place: [f64; 3], distance: f64) -> bool {
        (0..2).all(|k| (self.low[k] - distance..=self.high[k] + distance).contains(&place[k]))
    }

    /// Returns true if a place is in the picture.
    pub(crate) fn shows(&self, place: [f64; 3]) -> bool {
        self.is_near(place, 0.0)
    }

    /// Returns width and height, m.
    pub(crate) fn extent(&self) -> [f64; 2] {
        [self.high[0] - self.low[0], self.high[1] - self.low[1]]
    }

    /// Returns the name of an axis of the picture.
    pub(crate) fn axis_name(&self, direction: usize) -> &'static str {
        ["x", "y", "z"][self.axes[direction]]
    }

    /// Returns the position of a slot: right, up, and distance from the plane, m. NaN without a
    /// position.
    pub(crate) fn place(&self, frame: &Frame, slot: usize) -> [f64; 3] {
        let [right, up, across] = self.axes.map(|axis| frame.position[axis][slot]);
        [right, up, across - self.at]
    }
}

/// Points of a plane sorted into square cells.
#[derive(Debug)]
pub(crate) struct Cells {
    low: [f64; 2],
    size: f64,
    count: [usize; 2],
    starts: Vec<u32>,
    /// Indices of points, by cell.
    order: Vec<u32>,
}

impl Cells {
    /// Sorts points into cells of a size, m. Points outside the view go into the cells at its edge.
    pub(crate) fn new(view: &View, size: f64, points: &[[f64; 3]]) -> Self {
        let extent = view.extent();
        let count = [0, 1].map(|k| ((extent[k] / size).ceil() as usize).clamp(1, 20_000));
        let mut cells =
            Self { low: view.low, size, count, starts: vec![0; count[0] * count[1] + 1], order: Vec::new() };
        let cell_of: Vec<usize> = points.iter().map(|point| cells.cell(point[0], point[1])).collect();
        for &cell in &cell_of {
            cells.starts[cell + 1] += 1;
        }
        for cell in 1..cells.starts.len() {
            cells.starts[cell] += cells.starts[cell - 1];
        }
        let mut next = cells.starts.clone();
        cells.order = vec![0; points.len()];
        for (index, &cell) in cell_of.iter().enumerate() {
            cells.order[next[cell] as usize] = index as u32;
            next[cell] += 1;
        }
        cells
    }

    fn column(&self, axis: usize, x: f64) -> usize {
        (((x - self.low[axis]) / self.size).max(0.0) as usize).min(self.count[axis] - 1)
    }

    fn cell(&self, x: f64, y: f64) -> usize {
        self.column(1, y) * self.count[0] + self.column(0, x)
    }

    /// Returns the points of the nine cells around a position, among them all within the size of a
    /// cell.
    pub(crate) fn near(&self, x: f64, y: f64) -> impl Iterator<Item = usize> + '_ {
        let (i, j) = (self.column(0, x), self.column(1, y));
        let across = i.saturating_sub(1)..=(i + 1).min(self.count[0] - 1);
        (j.saturating_sub(1)..=(j + 1).min(self.count[1] - 1)).flat_map(move |row| {
            let first = self.starts[row * self.count[0] + across.start()] as usize;
            let last = self.starts[row * self.count[0] + across.end() + 1] as usize;
            self.order[first..last].iter().map(|&index| index as usize)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header() -> Header {
        Header { dimensions: 3, spacing: 0.1, bounds: [[0.0; 3], [4.0, 2.0, 1.0]], ..Header::default() }
    }

    #[test]
    fn slice_shows_the_other_two_axes() {
        let view = View::new(&header(), Some(Slice { axis: 1, at: None })).expect("a view");
        assert_eq!((view.axis_name(0), view.axis_name(1), view.at), ("x", "z", 1.0));
        let slice = Some(Slice { axis: 2, at: Some(1.5) });
        assert!(View::new(&header(), slice).is_err());
        let flat = Header { dimensions: 2, ..header() };
        assert!(View::new(&flat, slice).expect_err("refused").to_string().contains("2D"));
    }

    #[test]
    fn part_must_meet_the_flow() {
        let view = View::new(&header(), None).expect("a view");
        let part = view.clone().part([1.0, 2.0, -1.0, 1.0]).expect("a part");
        assert_eq!((part.low, part.high), ([1.0, -1.0], [2.0, 1.0]));
        assert!(part.shows([1.5, 0.0, 9.0]) && !part.shows([0.5, 0.0, 0.0]));
        let refused = view.part([0.0, 1.0, 3.0, 4.0]).expect_err("refused").to_string();
        assert!(refused.contains("y = -0.05 to 2.05 m"), "{refused}");
    }

    #[test]
    fn cells_find_all_points_within_their_size() {
        let view = View::new(&header(), None).expect("a view");
        let points: Vec<[f64; 3]> =
            (0..400).map(|k| [f64::from(k * 37 % 400) * 0.01, f64::from(k * 53 % 200) * 0.01, 0.0]).collect();
        let cells = Cells::new(&view, 0.25, &points);
        for &[x, y, _] in &points {
            let within = |k: &usize| (points[*k][0] - x).hypot(points[*k][1] - y) < 0.25;
            let found = cells.near(x, y).filter(within).count();
            assert_eq!(found, (0..points.len()).filter(within).count());
        }
    }
}
