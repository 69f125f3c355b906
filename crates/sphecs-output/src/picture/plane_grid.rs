//! Velocity and the drawn field on a regular grid of the picture, for lines, arrows and means.
//!
//! The nodes are sampled as those of `sphecs export --grid` are: a linear field is exact with any
//! particle disorder. Nodes are half a particle spacing apart in 2D, one spacing in 3D, or more if
//! there would be over a million of them.

use super::field::Field;
use super::view::View;
use crate::error::OutputError;
use crate::fields::{FieldNodes, resampling};
use crate::frame::Frame;
use crate::header::Header;
use crate::results::Results;
use sphecs_scene::field_grid::{FieldGrid, GridAxis};
use sphecs_scene::model::Scene;

/// Largest number of nodes.
const MOST_NODES: f64 = 1e6;

/// Part of the time with fluid from which on a node has a mean.
const LEAST_SHARE: f64 = 0.5;

/// Fields at the nodes of a plane; NaN without fluid.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PlaneGrid {
    /// First node, m.
    pub(super) low: [f64; 2],
    /// Distance of the nodes to the right and upwards, m.
    pub(super) step: [f64; 2],
    /// Number of nodes to the right and upwards.
    pub(super) count: [usize; 2],
    /// Velocity to the right and upwards, m/s, by node, row by row from below.
    pub(super) velocity: [Vec<f64>; 2],
    /// The drawn field.
    pub(super) values: Vec<f64>,
}

impl PlaneGrid {
    /// Returns the position of a node, m.
    pub(super) fn node(&self, column: usize, row: usize) -> [f64; 2] {
        [self.low[0] + column as f64 * self.step[0], self.low[1] + row as f64 * self.step[1]]
    }

    /// Returns the four nodes around a point with their shares; None outside the grid.
    fn corners(&self, point: [f64; 2]) -> Option<[(usize, f64); 4]> {
        let share = |k: usize| (point[k] - self.low[k]) / self.step[k];
        let (x, y) = (share(0), share(1));
        let cell = |share: f64, count: usize| -> Option<(usize, f64)> {
            let last = count.checked_sub(2)?;
            if !(0.0..=(count - 1) as f64).contains(&share) {
                return None;
            }
            let index = (share as usize).min(last);
            Some((index, share - index as f64))
        };
        let ((i, x), (j, y)) = (cell(x, self.count[0])?, cell(y, self.count[1])?);
        let first = j * self.count[0] + i;
        let above = first + self.count[0];
        Some([
            (first, (1.0 - x) * (1.0 - y)),
            (first + 1, x * (1.0 - y)),
            (above, (1.0 - x) * y),
            (above + 1, x * y),
        ])
    }

    /// Returns the velocity at a point by bilinear interpolation; None beside the fluid.
    pub(super) fn velocity_at(&self, point: [f64; 2]) -> Option<[f64; 2]> {
        let corners = self.corners(point)?;
        let [u, v] = [0, 1].map(|component| {
            corners.iter().map(|&(node, share)| share * self.velocity[component][node]).sum::<f64>()
        });
        (u.is_finite() && v.is_finite()).then_some([u, v])
    }

    /// Returns the drawn field at a point from those nodes around it that have fluid; NaN without
    /// any.
    pub(super) fn value_at(&self, point: [f64; 2]) -> f64 {
        let Some(corners) = self.corners(point) else { return f64::NAN };
        let (mut sum, mut weight) = (0.0, 0.0);
        for (node, share) in corners {
            if self.values[node].is_finite() {
                sum += share * self.values[node];
                weight += share;
            }
        }
        sum / weight
    }

    /// Returns the largest speed in the plane, m/s.
    pub(super) fn largest_speed(&self) -> f64 {
        self.fastest().1
    }

    /// Returns the place of the largest speed, m, and that speed, m/s.
    pub(super) fn fastest(&self) -> ([f64; 2], f64) {
        let [u, v] = &self.velocity;
        let speeds = u.iter().zip(v).map(|(u, v)| u.hypot(*v)).enumerate();
        let (node, speed) = speeds.fold((0, 0.0), |best, next| if next.1 > best.1 { next } else { best });
        (self.node(node % self.count[0], node / self.count[0]), speed)
    }
}

/// Sampler of the frames of a run on one grid.
pub(super) struct PlaneSampler {
    scene: Scene,
    nodes: FieldNodes,
    grid: FieldGrid,
    /// Axes to the right and upwards.
    axes: [usize; 2],
    field: Field,
}

impl PlaneSampler {
    /// Returns the sampler of a view, which needs values of the field or the velocity only.
    ///
    /// # Errors
    /// [`OutputError::Request`] when this version cannot read the scene of the run, or the field
    /// has no values between particles.
    pub(super) fn new(
        header: &Header,
        view: &View,
        field: Field,
        needs_values: bool,
    ) -> Result<Self, OutputError> {
        if needs_values && field == Field::Zone {
            return Err(OutputError::Request(
                "field `zone`: has no lines of equal value and no mean, since zones are not numbers"
                    .to_owned(),
            ));
        }
        let scene = resampling::scene_of_run(header)?;
        if needs_values && field == Field::Tag && !scene.has_tags() {
            return Err(OutputError::Request(
                "field `tag`: is the same for all particles, since `initial: (tag: …)` of the scene is a number"
                    .to_owned(),
            ));
        }
        let grid = grid_of(view);
        let nodes = FieldNodes::over(&scene, vec![grid.clone()]);
        Ok(Self { scene, nodes, grid, axes: [view.axes[0], view.axes[1]], field })
    }

    /// Returns the fields of a frame.
    pub(super) fn sample(&mut self, frame: &Frame) -> PlaneGrid {
        let snapshot = resampling::snapshot(&self.scene, &mut self.nodes, frame);
        let columns = snapshot.grids.into_iter().next().map(|grid| grid.columns).unwrap_or_default();
        let column =
            |index: usize| -> Vec<f64> { columns[index].iter().map(|&value| f64::from(value)).collect() };
        let dimensions = self.scene.dimensions;
        let norm = |first: usize, count: usize| {
            let square = |node: usize| -> f64 {
                columns[first..first + count].iter().map(|column| f64::from(column[node]).powi(2)).sum()
            };
            (0..self.grid.len()).map(|node| square(node).sqrt()).collect()
        };
        // The order of the columns is that of `fields::quantities`.
        let values = match self.field {
            Field::Speed => norm(0, dimensions),
            Field::U => column(0),
            Field::V => column(1),
            Field::W => column(2),
            Field::Pressure => column(dimensions),
            Field::Density => column(dimensions + 1),
            Field::Vorticity if dimensions == 2 => column(dimensions + 2),
            Field::Vorticity => norm(dimensions + 2, 3),
            Field::Tag if self.scene.has_tags() => column(columns.len() - 2),
            Field::Zone | Field::Tag => vec![f64::NAN; self.grid.len()],
        };
        let [right, up] = &self.grid.axes[..] else { unreachable!("a plane has two axes") };
        PlaneGrid {
            low: [right.first, up.first],
            step: [right.spacing, up.spacing],
            count: [right.count, up.count],
            velocity: self.axes.map(column),
            values,
        }
    }

    /// Returns the time mean of the frames in an interval, s, its part with frames, and the last
    /// frame in it. A frame stands for the time since the one before it.
    ///
    /// # Errors
    /// [`OutputError`] when no frame is in the interval or one cannot be read.
    pub(super) fn mean(
        &mut self,
        results: &Results,
        (from, to): (f64, f64),
    ) -> Result<(PlaneGrid, (f64, f64), Frame), OutputError> {
        let times = results.times();
        let mut sum: Option<PlaneGrid> = None;
        let mut durations = vec![0.0; self.grid.len()];
        let (mut sampled, mut last) = (from, None);
        for (index, &time) in times.iter().enumerate().filter(|(_, time)| **time > from) {
            let weight = time.min(to) - sampled;
            if weight <= 0.0 {
                break;
            }
            let frame = results.frame(index)?;
            let found = self.sample(&frame);
            add(&mut sum, &mut durations, found, weight);
            sampled = time.min(to);
            last = Some(frame);
        }
        let (Some(mut mean), Some(last)) = (sum, last) else {
            return Err(results.no_frames_between(from, to));
        };
        for (node, &duration) in durations.iter().enumerate() {
            let scale = if duration >= LEAST_SHARE * (sampled - from) { 1.0 / duration } else { f64::NAN };
            mean.values[node] *= scale;
            mean.velocity.iter_mut().for_each(|column| column[node] *= scale);
        }
        Ok((mean, (from, sampled), last))
    }
}

/// Adds the fields of a frame, weighted by its duration in s, at the nodes with fluid.
fn add(sum: &mut Option<PlaneGrid>, durations: &mut [f64], mut found: PlaneGrid, weight: f64) {
    for (node, duration) in durations.iter_mut().enumerate() {
        let has_fluid = found.values[node].is_finite();
        let scale = if has_fluid { weight } else { 0.0 };
        *duration += scale;
        for column in found.velocity.iter_mut().chain([&mut found.values]) {
            column[node] = if has_fluid { scale * column[node] } else { 0.0 };
        }
    }
    match sum {
        None => *sum = Some(found),
        Some(sum) => {
            let of_sum = sum.velocity.iter_mut().chain([&mut sum.values]);
            for (column, more) in of_sum.zip(found.velocity.iter().chain([&found.values])) {
                column.iter_mut().zip(more).for_each(|(value, more)| *value += more);
            }
        }
    }
}

/// Returns the grid that fills a view, with nodes on its edges.
fn grid_of(view: &View) -> FieldGrid {
    let extent = view.extent();
    let wanted = if view.dimensions == 2 { 0.5 * view.spacing } else { view.spacing };
    let spacing = wanted.max((extent[0] * extent[1] / MOST_NODES).sqrt());
    let axis = |k: usize| {
        let count = (extent[k] / spacing).ceil().max(1.0) as usize + 1;
        GridAxis {
            name: view.axis_name(k).to_owned(),
            first: view.low[k],
            spacing: extent[k] / (count - 1) as f64,
            count,
            direction: glam::DVec3::AXES[view.axes[k]],
        }
    };
    let origin = view.at * glam::DVec3::AXES[view.axes[2]];
    FieldGrid { name: "picture".to_owned(), axes: vec![axis(0), axis(1)], origin }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// Returns a grid over the square from −1 to 1 with a velocity and a field of the place.
    pub(in crate::picture) fn grid(count: usize, of: impl Fn([f64; 2]) -> ([f64; 2], f64)) -> PlaneGrid {
        let step = 2.0 / (count - 1) as f64;
        let mut grid = PlaneGrid {
            low: [-1.0; 2],
            step: [step; 2],
            count: [count; 2],
            velocity: [Vec::new(), Vec::new()],
            values: Vec::new(),
        };
        for node in 0..count * count {
            let (velocity, value) = of(grid.node(node % count, node / count));
            grid.velocity.iter_mut().zip(velocity).for_each(|(column, value)| column.push(value));
            grid.values.push(value);
        }
        grid
    }

    #[test]
    fn linear_fields_are_interpolated_exactly() {
        let grid = grid(11, |[x, y]| ([2.0 * x - y, x + 1.0], 3.0 * x + y));
        for point in [[0.13, -0.71], [-1.0, 1.0], [1.0, 0.0]] {
            let [u, v] = grid.velocity_at(point).expect("inside");
            let value = grid.value_at(point);
            let [x, y] = point;
            assert!((u - (2.0 * x - y)).abs() < 1e-12 && (v - (x + 1.0)).abs() < 1e-12);
            assert!((value - (3.0 * x + y)).abs() < 1e-12);
        }
        assert_eq!(grid.velocity_at([1.01, 0.0]), None);
        assert!(grid.value_at([0.0, -1.01]).is_nan());
    }

    #[test]
    fn beside_a_wall_the_nodes_with_fluid_count() {
        let grid = grid(3, |[x, _]| if x < -0.5 { ([f64::NAN; 2], f64::NAN) } else { ([1.0, 0.0], 7.0) });
        assert_eq!(grid.velocity_at([-0.5, 0.0]), None);
        assert_eq!(grid.value_at([-0.25, 0.3]), 7.0);
    }

    #[test]
    fn mean_counts_the_time_with_fluid() {
        let frame = |value: f64| {
            grid(2, |[x, _]| if x < 0.0 { ([f64::NAN; 2], f64::NAN) } else { ([value; 2], value) })
        };
        let (mut sum, mut durations) = (None, vec![0.0; 4]);
        add(&mut sum, &mut durations, frame(1.0), 3.0);
        add(&mut sum, &mut durations, frame(5.0), 1.0);
        let sum = sum.expect("two frames");
        assert_eq!((durations[0], durations[1]), (0.0, 4.0));
        assert_eq!((sum.values[0], sum.values[1] / 4.0), (0.0, 2.0));
    }
}
