//! Means, variances and Reynolds stresses on grids, accumulated during a run.
//!
//! ```text
//! w_k = t_k − t_(k−1), both limited to the interval of the mean,   W += w_k
//! δ = f − ⟨f⟩,   ⟨f⟩ += w_k/W δ,   C_fg += w_k δ_f (g − ⟨g⟩),   ⟨f'g'⟩ = C_fg/W
//! ```
//!
//! West (1979): weighted sums about the present mean, which lose no digits where the fluctuations
//! are small. A sample stands for the time since the one before it. Times at which a node has no
//! fluid do not count, so that its means are those of the time with fluid.

use super::quantities::{mean_count, mean_values, means, pairs};
use super::{FieldNodes, SampleRows, is_filled, row_slices};
use sphecs_core::math::column::{ColumnMismatch, Columns};
use sphecs_core::pass::grid_rows::{NodeFields, NodeRow, RowSink};

/// Sums for the means on all grids.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FieldAverages {
    dimensions: usize,
    /// True if the passive scalar has a mean.
    tagged: bool,
    /// Time covered, s.
    duration: f64,
    /// Columns over the nodes of each grid, in the order of [`means`](super::quantities::means):
    /// means, C_fg, W, and Σ w_k α of the fluid fraction.
    grids: Vec<Vec<Vec<f64>>>,
}

/// Means on all grids.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FieldMeans {
    /// Interval that they cover, s.
    pub covered: (f64, f64),
    /// Columns over the nodes of each grid; NaN where there was no fluid.
    pub grids: Vec<Vec<Vec<f64>>>,
}

impl FieldAverages {
    /// Returns sums without samples.
    pub fn new(nodes: &FieldNodes) -> Self {
        let columns = means(nodes.dimensions, nodes.tagged).len();
        let grids = nodes.grids.iter().map(|grid| vec![vec![0.0; grid.len()]; columns]).collect();
        Self { dimensions: nodes.dimensions, tagged: nodes.tagged, duration: 0.0, grids }
    }

    /// Returns the time covered, s.
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// Adds the present fields, which stand for a duration in s.
    pub fn add(&mut self, nodes: &FieldNodes, duration: f64, sample: &mut SampleRows<'_>) {
        self.duration += duration;
        let pairs = pairs(self.dimensions, self.tagged);
        let mut rows = nodes.rows.iter();
        let mut sinks: Vec<AverageRow<'_>> = Vec::with_capacity(nodes.rows.len());
        for (columns, grid) in self.grids.iter_mut().zip(&nodes.grids) {
            let slices = row_slices(columns, grid.axes[0].count, grid.rows());
            let (dimensions, tagged, pairs) = (self.dimensions, self.tagged, pairs.as_slice());
            let sink = |(columns, row)| AverageRow { columns, row, duration, dimensions, tagged, pairs };
            sinks.extend(slices.into_iter().zip(rows.by_ref()).map(sink));
        }
        let mut sinks: Vec<&mut dyn RowSink> =
            sinks.iter_mut().map(|sink| sink as &mut dyn RowSink).collect();
        sample(&nodes.rows, &mut sinks);
    }

    /// Returns the means, which cover the interval `covered`, s.
    pub fn means(&self, covered: (f64, f64)) -> FieldMeans {
        let mut grids = self.grids.clone();
        let first = mean_count(self.dimensions, self.tagged);
        for columns in &mut grids {
            let Some((fraction, columns)) = columns.split_last_mut() else { continue };
            let Some((weights, columns)) = columns.split_last_mut() else { continue };
            let (columns, covariances) = columns.split_at_mut(first);
            for (node, &weight) in weights.iter().enumerate() {
                if weight <= 0.0 {
                    columns.iter_mut().for_each(|column| column[node] = f64::NAN);
                }
                // Without any fluid it is 0/0, NaN.
                covariances.iter_mut().for_each(|column| column[node] /= weight);
            }
            fraction.iter_mut().for_each(|sum| *sum /= self.duration);
        }
        FieldMeans { covered, grids }
    }

    /// Saves the sums as columns of a checkpoint.
    pub fn save(&self, to: &mut Columns) {
        to.put(name("duration", 0, 0), vec![self.duration]);
        for (grid, columns) in self.grids.iter().enumerate() {
            for (column, values) in columns.iter().enumerate() {
                to.put(name("sum", grid, column), values.clone());
            }
        }
    }

    /// Restores the sums that [`Self::save`] has saved.
    ///
    /// # Errors
    /// [`ColumnMismatch`] when a column is missing or has another length.
    pub fn restore(nodes: &FieldNodes, from: &mut Columns) -> Result<Self, ColumnMismatch> {
        let mut restored = Self::new(nodes);
        restored.duration = from.take_exactly(&name("duration", 0, 0), 1)?[0];
        for (grid, columns) in restored.grids.iter_mut().enumerate() {
            for (column, values) in columns.iter_mut().enumerate() {
                *values = from.take_exactly(&name("sum", grid, column), values.len())?;
            }
        }
        Ok(restored)
    }
}

/// Returns the name of a column of a checkpoint.
fn name(what: &str, grid: usize, column: usize) -> String {
    format!("fields.{what}.{grid}.{column}")
}

/// Part of the sums that belongs to a row.
struct AverageRow<'a> {
    columns: Vec<&'a mut [f64]>,
    row: &'a NodeRow,
    duration: f64,
    dimensions: usize,
    tagged: bool,
    pairs: &'a [(usize, usize)],
}

impl RowSink for AverageRow<'_> {
    fn take(&mut self, fields: &[NodeFields]) {
        let first = mean_count(self.dimensions, self.tagged);
        let covariances = first..first + self.pairs.len();
        let (weight, fraction) = (covariances.end, covariances.end + 1);
        for (node, field) in fields.iter().enumerate().filter(|&(node, _)| self.row.wanted[node]) {
            self.columns[fraction][node] += self.duration * field.fraction;
            if !is_filled(field) {
                continue;
            }
            self.columns[weight][node] += self.duration;
            let part = self.duration / self.columns[weight][node];
            let mut values = mean_values(field, self.dimensions, self.tagged);
            let mut before = values;
            for column in 0..first {
                let mean = &mut self.columns[column][node];
                // A vorticity without meaning leaves the mean unchanged.
                if !values[column].is_finite() {
                    values[column] = *mean;
                }
                before[column] = values[column] - *mean;
                *mean += part * before[column];
                values[column] -= *mean;
            }
            for (column, &(i, j)) in covariances.clone().zip(self.pairs) {
                self.columns[column][node] += self.duration * before[i] * values[j];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use sphecs_scene::field_grid::{FieldGrid, GridAxis};

    fn nodes() -> FieldNodes {
        let axis = |name: &str, count, direction| GridAxis {
            name: name.to_owned(),
            first: 0.0,
            spacing: 1.0,
            count,
            direction,
        };
        let grid = FieldGrid {
            name: String::new(),
            axes: vec![axis("x", 3, DVec3::X), axis("y", 2, DVec3::Y)],
            origin: DVec3::ZERO,
        };
        let row =
            |row| NodeRow { start: grid.row_start(row), step: DVec3::X, wanted: vec![true, true, row == 0] };
        let rows = vec![row(0), row(1)];
        FieldNodes { dimensions: 2, tagged: true, grids: vec![grid], rows, ..FieldNodes::default() }
    }

    /// Samples u = `u` + x, v = u², p = 10⁶ + u; the second node of each row is dry if `is_dry`.
    fn add(averages: &mut FieldAverages, duration: f64, u: f64, is_dry: bool) {
        averages.add(&nodes(), duration, &mut |rows, sinks| {
            for (row, sink) in rows.iter().zip(sinks) {
                let node = |node: usize| NodeFields {
                    velocity: [u + node as f64 + row.start.y, u * u, 0.0],
                    vorticity: [0.0, 0.0, -u],
                    pressure: 1e6 + u,
                    density: 1000.0 + u,
                    tag: 2.0 * u,
                    fraction: if is_dry && node == 1 { 0.2 } else { 1.0 },
                };
                sink.take(&(0..3).map(node).collect::<Vec<_>>());
            }
        });
    }

    #[test]
    fn means_and_stresses_are_those_of_the_weighted_samples() {
        let mut averages = FieldAverages::new(&nodes());
        let samples = [(0.5, 1.0), (1.5, -2.0), (2.0, 0.25)];
        for (duration, u) in samples {
            add(&mut averages, duration, u, false);
        }
        let means = averages.means((0.0, 4.0));
        let mean = |f: &dyn Fn(f64) -> f64| samples.iter().map(|&(w, u)| w * f(u)).sum::<f64>() / 4.0;
        let (u, v) = (mean(&|u| u), mean(&|u| u * u));
        let near =
            |found: f64, expected: f64| assert!((found - expected).abs() < 1e-9, "{found}, {expected}");
        let columns = &means.grids[0];
        near(columns[0][4], u + 2.0);
        near(columns[1][0], v);
        near(columns[2][0], 1e6 + u);
        near(columns[3][0], -u);
        near(columns[4][0], 1000.0 + u);
        near(columns[5][0], 2.0 * u);
        near(columns[6][0], mean(&|x| (x - u) * (x - u)));
        near(columns[7][4], mean(&|x| (x - u) * (x * x - v)));
        near(columns[9][0], columns[6][0]);
        near(columns[10][0], 4.0 * columns[6][0]);
        assert_eq!((columns[11][0], columns[12][0]), (4.0, 1.0));
        assert!(columns[0][5].is_nan() && columns[11][5] == 0.0, "the node is in a wall");
    }

    #[test]
    fn times_without_fluid_do_not_count() {
        let mut averages = FieldAverages::new(&nodes());
        add(&mut averages, 1.0, 3.0, false);
        add(&mut averages, 3.0, 5.0, true);
        let columns = averages.means((0.0, 4.0)).grids.remove(0);
        assert_eq!((columns[0][0], columns[0][1]), (4.5, 4.0));
        assert_eq!((columns[11][0], columns[11][1]), (4.0, 1.0));
        assert!((columns[12][1] - 0.4).abs() < 1e-15);
    }

    #[test]
    fn restored_sums_continue_bitwise_identically() {
        let mut whole = FieldAverages::new(&nodes());
        add(&mut whole, 0.3, 1.7, true);
        let mut saved = Columns::default();
        whole.save(&mut saved);
        let mut other = FieldAverages::restore(&nodes(), &mut saved).expect("restored");
        add(&mut whole, 0.1, 0.7, false);
        add(&mut other, 0.1, 0.7, false);
        assert_eq!(whole, other);
        assert!(FieldAverages::restore(&nodes(), &mut saved).is_err(), "the columns were taken");
    }
}
