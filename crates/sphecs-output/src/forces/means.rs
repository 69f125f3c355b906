//! Means, amplitudes and Strouhal number of the force coefficients of a body over an interval.
//!
//! ```text
//! c̄ = (1/T) ∫ c dt,   rms² = (1/T) ∫ (c − c̄)² dt,   amplitude = (max c − min c)/2,   St = f L/u∞
//! ```
//!
//! f is the frequency of [`shedding_line`], which also gives the reason why there is none. The
//! amplitude contains sound; that of the [periodic fit](super::periodic_fit) with f does not.
//!
//! With `five_point_mean`, c is the running mean over five rows, (c_{n−2} + … + c_{n+2})/5, as in
//! Negi et al. (2020), section 4.6.

use std::path::{Path, PathBuf};

use super::periodic_fit::fitted_amplitude;
use super::shedding::{Line, NoLine, SoundLimits, shedding_line};
use crate::error::OutputError;
use crate::header::Header;
use crate::mean_interval::{cells, covered, note};
use crate::paths::FORCES_MEAN_CSV;
use crate::table::{Table, TableColumn, TableWriter, number};
use sphecs_core::format::with_digits;
use sphecs_scene::body::BodyReference;
use sphecs_scene::result_name::result_name;

/// Name and long name of all quantities.
pub const QUANTITIES: [(&str, &str); 9] = [
    ("c_d_mean", "mean drag coefficient"),
    ("c_d_amplitude", "half of largest minus smallest drag coefficient"),
    ("c_l_mean", "mean lift coefficient"),
    ("c_l_amplitude", "half of largest minus smallest lift coefficient"),
    ("strouhal", "Strouhal number of the lift"),
    (
        "c_d_fitted_amplitude",
        "amplitude of the drag coefficient's part that repeats with the Strouhal number",
    ),
    (
        "c_l_fitted_amplitude",
        "amplitude of the lift coefficient's part that repeats with the Strouhal number",
    ),
    ("c_d_rms", "root mean square of the drag coefficient's deviation from its mean"),
    ("c_l_rms", "root mean square of the lift coefficient's deviation from its mean"),
];

/// Quantities in the order of [`QUANTITIES`]; NaN with less than two rows. Without a line in the
/// lift, Strouhal number and fitted amplitudes are NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Means {
    values: [f64; QUANTITIES.len()],
    /// Part of the interval that the rows cover, s.
    covered: Option<(f64, f64)>,
    /// Line of the lift, or the reason why there is none.
    line: Result<Line, NoLine>,
    /// Reference length over velocity, s.
    scale: f64,
}

impl Means {
    /// Returns the quantity of a name.
    pub fn get(&self, name: &str) -> f64 {
        QUANTITIES.iter().position(|(known, _)| *known == name).map_or(f64::NAN, |index| self.values[index])
    }

    /// Returns the part of the interval that the rows cover, s; None if it has no length.
    pub fn covered(&self) -> Option<(f64, f64)> {
        self.covered
    }

    /// Returns the line of vortex shedding in the lift.
    pub fn line(&self) -> Option<Line> {
        self.line.ok()
    }

    /// Returns a remark on the Strouhal number: the reason why there is none, or that the line may
    /// be sound; empty without one.
    pub fn remark(&self) -> String {
        match self.line {
            Err(reason) => format!("no Strouhal number: {}", reason.text(self.scale)),
            Ok(Line { above_sound: Some(lowest), .. }) => format!(
                "sound begins at St = {} in this domain: compare with another `sound_speed`, which moves sound, not \
                 vortices",
                with_digits(lowest * self.scale, 3)
            ),
            Ok(_) => String::new(),
        }
    }
}

/// Returns the means of all bodies that have coefficients, with their names.
pub(super) fn means_of_bodies(header: &Header, table: &Table) -> Vec<(String, Means)> {
    let column = |name: &str| {
        let index = table.columns.iter().position(|column| column.name == name);
        index.map(|index| table.numbers(index)).unwrap_or_default()
    };
    let times = column("time");
    let mut found = Vec::new();
    for body in &header.bodies {
        let Some(reference) = body.reference else { continue };
        let name = result_name(&body.name);
        let [drag, lift] = ["c_d", "c_l"].map(|coefficient| {
            let values = column(&format!("{coefficient}_{name}"));
            if body.five_point_mean { five_point_mean(&values) } else { values }
        });
        let covered = covered(&times, body.mean);
        let within = |time: f64| time >= body.mean.0 && time <= body.mean.1;
        let rows: Vec<usize> = (0..times.len()).filter(|&row| within(times[row])).collect();
        let cut = |values: &[f64]| rows.iter().map(|&row| values[row]).collect::<Vec<f64>>();
        let (times, drag, lift) = (cut(&times), cut(&drag), cut(&lift));
        let line = shedding_line(&times, &lift, sound_limits(header, reference));
        let frequency = line.map_or(f64::NAN, |line| line.frequency);
        let scale = reference.length / reference.velocity;
        let fitted =
            |values: &[f64]| line.map_or(f64::NAN, |line| fitted_amplitude(&times, values, line.frequency));
        let values = [
            mean(&times, &drag),
            amplitude(&drag),
            mean(&times, &lift),
            amplitude(&lift),
            frequency * scale,
            fitted(&drag),
            fitted(&lift),
            deviation(&times, &drag),
            deviation(&times, &lift),
        ];
        found.push((name, Means { values, covered, line, scale }));
    }
    found
}

/// Returns the frequencies that bound those of vortices behind a body.
fn sound_limits(header: &Header, reference: BodyReference) -> SoundLimits {
    let width = if header.dimensions == 2 { reference.area } else { reference.area.sqrt() };
    let [low, high] = header.bounds;
    let extent = low.iter().zip(high).map(|(low, high)| high - low).fold(0.0, f64::max);
    SoundLimits::new(header.sound_speed, width.min(reference.length), extent)
}

/// Writes `forces_mean.csv`, if any body has coefficients.
pub(super) fn write(
    folder: &Path,
    header: &Header,
    found: &[(String, Means)],
) -> Result<Option<PathBuf>, OutputError> {
    if found.is_empty() {
        return Ok(None);
    }
    let path = folder.join(FORCES_MEAN_CSV);
    let mut columns =
        vec![TableColumn::of_text("body"), TableColumn::new("from", "s"), TableColumn::new("to", "s")];
    columns.extend(QUANTITIES.map(|(name, _)| TableColumn::new(name, "1")));
    columns.push(TableColumn::of_text("remark"));
    let mut writer = TableWriter::create(&path, &columns)?;
    let with_reference = header.bodies.iter().filter(|body| body.reference.is_some());
    for (body, (_, means)) in with_reference.zip(found) {
        let mut row = vec![body.name.clone()];
        row.extend(cells(means.covered));
        row.extend(means.values.map(number));
        row.push(means.remark());
        writer.append([row])?;
    }
    Ok(Some(path))
}

/// Returns a note on each body whose interval the run did not complete.
pub(super) fn notes(header: &Header, table: &Table) -> Vec<String> {
    let times = table.columns.iter().position(|column| column.name == "time");
    let times = times.map(|index| table.numbers(index)).unwrap_or_default();
    let with_reference = header.bodies.iter().filter(|body| body.reference.is_some());
    with_reference.filter_map(|body| note(&[body.name.as_str()], &times, body.mean)).collect()
}

/// Returns the running mean over five values, over fewer at the ends.
fn five_point_mean(values: &[f64]) -> Vec<f64> {
    let around = |at: usize| {
        let near = &values[at.saturating_sub(2)..values.len().min(at + 3)];
        near.iter().sum::<f64>() / near.len() as f64
    };
    (0..values.len()).map(around).collect()
}

/// Returns the mean over time by the trapezoidal rule.
fn mean(times: &[f64], values: &[f64]) -> f64 {
    let pairs = times.windows(2).zip(values.windows(2));
    let integral: f64 = pairs.map(|(t, c)| (t[1] - t[0]) * 0.5 * (c[0] + c[1])).sum();
    match (times.first(), times.last()) {
        (Some(first), Some(last)) if last > first => integral / (last - first),
        _ => f64::NAN,
    }
}

/// Returns the root mean square of the deviation from the mean.
fn deviation(times: &[f64], values: &[f64]) -> f64 {
    let middle = mean(times, values);
    let squares: Vec<f64> = values.iter().map(|value| (value - middle).powi(2)).collect();
    mean(times, &squares).sqrt()
}

fn amplitude(values: &[f64]) -> f64 {
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if values.len() > 1 { 0.5 * (largest - least) } else { f64::NAN }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn five_point_mean_is_as_published() {
        assert_eq!(five_point_mean(&[1.0, 2.0, 6.0, 3.0, 8.0, 1.0]), [3.0, 3.0, 4.0, 4.0, 4.5, 4.0]);
    }

    #[test]
    fn mean_and_amplitude_are_independent_of_the_steps() {
        let times: Vec<f64> = (0..2001).map(|k| f64::from(k) * 1e-2 + 3e-3 * f64::from(k % 3)).collect();
        let values: Vec<f64> = times.iter().map(|t| 1.4 + 0.05 * (std::f64::consts::PI * t).sin()).collect();
        assert!((mean(&times, &values) - 1.4).abs() < 1e-4, "{}", mean(&times, &values));
        assert!((amplitude(&values) - 0.05).abs() < 1e-5);
        assert!((deviation(&times, &values) - 0.05 / 2.0_f64.sqrt()).abs() < 1e-4);
        assert!(mean(&times[..1], &values[..1]).is_nan() && amplitude(&values[..1]).is_nan());
    }
}
