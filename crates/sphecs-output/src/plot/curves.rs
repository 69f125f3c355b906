//! Values of a result over time, or along a line at a time or in the mean.

use super::PlotOptions;
use super::names::Found;
use crate::error::OutputError;
use crate::mean_interval::covered;
use crate::probes::history::ProbeHistory;
use sphecs_core::format::significant;

/// Quantity of the horizontal axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Abscissa {
    /// Time, s.
    Time,
    /// Coordinate along an axis of space, m.
    Axis(usize),
    /// Distance from the first point of the line, m.
    Distance,
}

/// A curve with its name.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Measured {
    /// Name of the quantity.
    pub(super) name: String,
    /// Unit as written.
    pub(super) unit: String,
    /// Time or interval of a profile, if there are several or none was given.
    pub(super) when: Option<String>,
    pub(super) abscissa: Abscissa,
    /// Positions on the abscissa, distances from the first point, and values.
    values: Vec<[f64; 3]>,
}

impl Measured {
    /// Returns the points over the abscissa of the curve, or the distance from its first point.
    pub(super) fn points(&self, is_along_one_axis: bool) -> Vec<(f64, f64)> {
        let has_own = is_along_one_axis || self.abscissa == Abscissa::Time;
        self.values
            .iter()
            .map(|&[own, distance, value]| (if has_own { own } else { distance }, value))
            .collect()
    }
}

/// Returns the curves of a result.
///
/// # Errors
/// [`OutputError::Request`] when the options do not match the result, or it has no samples there.
pub(super) fn measured(found: &Found<'_>, options: &PlotOptions) -> Result<Vec<Measured>, OutputError> {
    match found {
        Found::Series { name, unit, times, values } => {
            let option = if options.mean.is_some() { "--mean" } else { "--time" };
            if options.mean.is_some() || !options.times.is_empty() {
                return Err(OutputError::Request(format!(
                    "`{option}`: is for profiles of line probes, `{name}` is a series over time: leave it out, or \
                     draw a part of the time by `--over`"
                )));
            }
            let (from, to) = options.over.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
            let all = times.iter().zip(values).map(|(&time, &value)| [time, time, value]);
            let inside: Vec<[f64; 3]> = all.filter(|[time, ..]| (from..=to).contains(time)).collect();
            if !inside.iter().any(|[.., value]| value.is_finite()) {
                return Err(nothing(
                    name,
                    times,
                    &format!("from {} to {} s", significant(from), significant(to)),
                ));
            }
            let (name, unit) = (name.clone(), unit.clone());
            Ok(vec![Measured { name, unit, when: None, abscissa: Abscissa::Time, values: inside }])
        }
        Found::Profile { name, unit, probe, values } => profiles((name, unit), probe, values, options),
    }
}

fn profiles(
    (name, unit): (&str, &str),
    probe: &ProbeHistory,
    values: &[f64],
    options: &PlotOptions,
) -> Result<Vec<Measured>, OutputError> {
    if options.over.is_some() {
        return Err(OutputError::Request(format!(
            "`--over`: is for series over time, `{name}` is a profile along a line: give `--time` or `--mean`"
        )));
    }
    let (abscissa, places) = along(&probe.places);
    let curve = |when: String, profile: &[f64]| Measured {
        name: name.to_owned(),
        unit: unit.to_owned(),
        when: Some(when),
        abscissa,
        values: places.iter().zip(profile).map(|(&[own, distance], &value)| [own, distance, value]).collect(),
    };
    if let Some((from, to)) = options.mean {
        let wanted = format!("from {} to {} s", significant(from), significant(to));
        let part = covered(&probe.times, (from, to)).ok_or_else(|| nothing(name, &probe.times, &wanted))?;
        let when = format!("mean of {} to {} s", significant(part.0), significant(part.1));
        return Ok(vec![curve(when, &probe.mean_of(values, part.0, part.1))]);
    }
    let last = probe.times.last().copied().ok_or_else(|| nothing(name, &[], "at any time"))?;
    let times = if options.times.is_empty() { vec![last] } else { options.times.clone() };
    let points = probe.places.len();
    let at = |time: f64| {
        let index = nearest(&probe.times, time)
            .ok_or_else(|| nothing(name, &probe.times, &format!("near t = {} s", significant(time))))?;
        let when = format!("t = {} s", significant(probe.times[index]));
        Ok(curve(when, &values[index * points..(index + 1) * points]))
    };
    times.into_iter().map(at).collect()
}

/// Returns the index of the sample nearest to a time, s, at most one interval beyond the ends.
fn nearest(times: &[f64], time: f64) -> Option<usize> {
    let interval = times.windows(2).map(|pair| pair[1] - pair[0]).fold(1e-6 * time.abs(), f64::max);
    let distance = |index: &usize| (times[*index] - time).abs();
    let found = (0..times.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
    let outside = time < times[0] - interval || time > times[times.len() - 1] + interval;
    (!outside).then_some(found)
}

/// Returns the abscissa of points of a line, their positions on it and distances from the first, m.
fn along(places: &[[f64; 3]]) -> (Abscissa, Vec<[f64; 2]>) {
    let first = places.first().copied().unwrap_or_default();
    let offset = |place: &[f64; 3]| [0, 1, 2].map(|axis| place[axis] - first[axis]);
    let length = |[x, y, z]: [f64; 3]| x.hypot(y).hypot(z);
    let extent = places.last().map_or([0.0; 3], offset);
    let is_axis = |axis: &usize| extent[*axis].abs() > (1.0 - 1e-9) * length(extent);
    let axis = (0..3).find(is_axis).filter(|_| length(extent) > 0.0);
    let position = |place: &[f64; 3]| {
        let distance = length(offset(place));
        [axis.map_or(distance, |axis| place[axis]), distance]
    };
    (axis.map_or(Abscissa::Distance, Abscissa::Axis), places.iter().map(position).collect())
}

fn nothing(name: &str, times: &[f64], wanted: &str) -> OutputError {
    let samples = match (times.first(), times.last()) {
        (Some(&first), Some(&last)) => {
            format!("its samples are from {} to {} s", significant(first), significant(last))
        }
        _ => "it has no samples yet".to_owned(),
    };
    OutputError::Request(format!("`{name}`: has no values {wanted}, {samples}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn line_along_an_axis_is_drawn_over_its_coordinate() {
        let (abscissa, places) = along(&[[0.1, 0.3, 0.0], [0.1, 0.2, 0.0]]);
        assert_eq!(abscissa, Abscissa::Axis(1));
        assert!((places[1][0] - 0.2).abs() < 1e-12 && (places[1][1] - 0.1).abs() < 1e-12);
        let (abscissa, places) = along(&[[0.0; 3], [0.3, 0.4, 0.0]]);
        assert_eq!(abscissa, Abscissa::Distance);
        assert!((places[1][0] - 0.5).abs() < 1e-12);
    }

    #[test]
    fn profile_is_that_of_the_nearest_sample_or_of_the_mean() {
        let probe = ProbeHistory {
            name: "line".to_owned(),
            places: vec![[0.0; 3], [1.0, 0.0, 0.0]],
            times: vec![0.0, 1.0, 2.0],
            columns: Vec::new(),
        };
        let values = [0.0, 10.0, 1.0, 11.0, 2.0, 12.0];
        let drawn = |options: PlotOptions| profiles(("line.u", "m/s"), &probe, &values, &options);
        let values_of = |curve: &Measured| curve.points(true);
        let times = PlotOptions { times: vec![0.9, 2.0], ..PlotOptions::default() };
        let curves = drawn(times).expect("two profiles");
        assert_eq!(values_of(&curves[0]), [(0.0, 1.0), (1.0, 11.0)]);
        assert_eq!(curves[1].when.as_deref(), Some("t = 2 s"));
        let mean = PlotOptions { mean: Some((0.5, 9.0)), ..PlotOptions::default() };
        let curves = drawn(mean).expect("a mean");
        assert_eq!(values_of(&curves[0]), [(0.0, 1.25), (1.0, 11.25)]);
        assert_eq!(curves[0].when.as_deref(), Some("mean of 0.5 to 2 s"));
        for late in [
            PlotOptions { times: vec![5.0], ..PlotOptions::default() },
            PlotOptions { mean: Some((5.0, 6.0)), ..PlotOptions::default() },
        ] {
            let refused = drawn(late).expect_err("refused").to_string();
            assert!(refused.contains("samples are from 0 to 2 s"), "{refused}");
        }
    }
}
