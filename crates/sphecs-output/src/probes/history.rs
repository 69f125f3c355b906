//! Time series of the probes of a run in memory, for comparisons.

use std::path::Path;

use super::series::{read, read_places, time_mean};
use crate::error::OutputError;
use crate::header::{Header, ProbeHeader, ProbeShape};

/// Time series of one probe.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProbeHistory {
    /// Name in the scene.
    pub name: String,
    /// Points, m; of a section the point given by the scene.
    pub places: Vec<[f64; 3]>,
    /// Times of the samples, s.
    pub times: Vec<f64>,
    /// Name and values of each quantity: all points at the first time, then at the next.
    pub columns: Vec<(&'static str, Vec<f64>)>,
}

impl ProbeHistory {
    /// Returns the histories of all probes of a run.
    ///
    /// # Errors
    /// [`OutputError`] with the path and the cause.
    pub fn read_all(folder: &Path, header: &Header) -> Result<Vec<Self>, OutputError> {
        if header.probes.is_empty() {
            return Ok(Vec::new());
        }
        let places = read_places(folder, header)?;
        let history = |(probe, places): (&ProbeHeader, Vec<[f64; 3]>)| {
            let series = read(folder, header, probe, places)?;
            let columns = series.columns.into_iter().map(|(quantity, values)| (quantity.name, values));
            let mut columns: Vec<_> = columns.collect();
            // The files of a plane flow leave out w.
            if header.dimensions == 2 && probe.kind != ProbeShape::Section {
                columns.insert(2, ("w", vec![0.0; columns[0].1.len()]));
            }
            Ok(Self { name: probe.name.clone(), places: series.places, times: series.times, columns })
        };
        header.probes.iter().zip(places).map(history).collect()
    }

    /// Returns all values of a quantity; None if the probe does not measure it.
    pub fn column(&self, quantity: &str) -> Option<&[f64]> {
        self.columns.iter().find(|(name, _)| *name == quantity).map(|(_, values)| values.as_slice())
    }

    /// Returns the values of a quantity at all points for the sample `index`.
    pub fn sample(&self, quantity: &str, index: usize) -> Option<&[f64]> {
        let points = self.places.len();
        self.column(quantity)?.get(index * points..(index + 1) * points)
    }

    /// Returns the time mean of a column at each point between two times, s, by the trapezoidal
    /// rule.
    pub fn mean_of(&self, column: &[f64], from: f64, to: f64) -> Vec<f64> {
        let points = self.places.len();
        let of_point = |point: usize| {
            let values: Vec<f64> = column.iter().skip(point).step_by(points).copied().collect();
            time_mean(&self.times, &values, from, to)
        };
        (0..points).map(of_point).collect()
    }
}
