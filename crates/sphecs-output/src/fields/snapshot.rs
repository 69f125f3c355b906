//! Fields on the grids of a scene at one time.

use super::quantities::{for_each_value, quantities};
use super::{FieldNodes, SampleRows, is_filled, row_slices};
use sphecs_core::pass::grid_rows::{NodeFields, NodeRow, RowSink};

/// Fields on all grids at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FieldSnapshot {
    /// Time, s.
    pub time: f64,
    /// Steps done.
    pub step: u64,
    /// Grids in the order of the scene.
    pub grids: Vec<GridValues>,
}

/// Fields on one grid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GridValues {
    /// Columns over the nodes in the order of their names in the file; NaN without fluid.
    pub columns: Vec<Vec<f32>>,
    /// 1 for the nodes inside walls or outside the domain.
    pub solid: Vec<u8>,
}

impl FieldNodes {
    /// Samples the fields on all grids.
    pub fn snapshot(&self, time: f64, step: u64, sample: &mut SampleRows<'_>) -> FieldSnapshot {
        let count = quantities(self.dimensions, self.tagged).len();
        let mut rows = self.rows.iter();
        let empty = |length: usize| GridValues {
            columns: vec![vec![f32::NAN; length]; count],
            solid: Vec::with_capacity(length),
        };
        let mut grids: Vec<GridValues> = self.grids.iter().map(|grid| empty(grid.len())).collect();
        for (values, grid) in grids.iter_mut().zip(&self.grids) {
            let wanted = rows.by_ref().take(grid.rows()).flat_map(|row| &row.wanted);
            values.solid.extend(wanted.map(|&wanted| u8::from(!wanted)));
        }
        let mut rows = self.rows.iter();
        let mut sinks: Vec<SnapshotRow<'_>> = Vec::with_capacity(self.rows.len());
        for (values, grid) in grids.iter_mut().zip(&self.grids) {
            let slices = row_slices(&mut values.columns, grid.axes[0].count, grid.rows());
            let (dimensions, tagged) = (self.dimensions, self.tagged);
            let sink = |(columns, row)| SnapshotRow { columns, row, dimensions, tagged };
            sinks.extend(slices.into_iter().zip(rows.by_ref()).map(sink));
        }
        let mut sinks: Vec<&mut dyn RowSink> =
            sinks.iter_mut().map(|sink| sink as &mut dyn RowSink).collect();
        sample(&self.rows, &mut sinks);
        FieldSnapshot { time, step, grids }
    }
}

/// Part of the columns that belongs to a row.
struct SnapshotRow<'a> {
    columns: Vec<&'a mut [f32]>,
    row: &'a NodeRow,
    dimensions: usize,
    tagged: bool,
}

impl RowSink for SnapshotRow<'_> {
    fn take(&mut self, fields: &[NodeFields]) {
        let Some((fraction, columns)) = self.columns.split_last_mut() else { return };
        for (node, field) in fields.iter().enumerate().filter(|&(node, _)| self.row.wanted[node]) {
            fraction[node] = field.fraction as f32;
            if is_filled(field) {
                for_each_value(field, self.dimensions, self.tagged, |(column, value)| {
                    columns[column][node] = value as f32;
                });
            }
        }
    }
}
