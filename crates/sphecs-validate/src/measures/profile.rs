//! Profiles of a probe and their distances from a reference.

use super::fields;
use super::reference::Reference;
use crate::schema::{FieldFile, NormFile, WhenFile};
use sphecs_output::probes::history::ProbeHistory;

/// Values at the points of a probe at one time or averaged over an interval.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// Time of the sample, or the end of the interval, s.
    pub time: f64,
    /// Values at the points of the probe.
    pub values: Vec<f64>,
}

/// Returns the profiles of a probe at a time or in an interval.
///
/// # Errors
/// The probe has no such field or time.
pub fn profiles(probe: &ProbeHistory, field: &FieldFile, when: &WhenFile) -> Result<Vec<Profile>, String> {
    let column = fields::column(probe, field)?;
    let points = probe.places.len();
    let sample = |index: usize| {
        let values = column.get(index * points..(index + 1) * points).ok_or("a sample is incomplete")?;
        Ok(Profile { time: probe.times[index], values: values.to_vec() })
    };
    match when {
        WhenFile::At(time) => {
            let distance = |index: &usize| (probe.times[*index] - time.value).abs();
            let nearest = (0..probe.times.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
            let nearest = nearest.ok_or_else(|| format!("probe `{}` has no samples", probe.name))?;
            let spacing = probe.times.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
            if distance(&nearest) > spacing.max(1e-12) {
                return Err(format!("probe `{}` has no sample at {} s", probe.name, time.value));
            }
            Ok(vec![sample(nearest)?])
        }
        WhenFile::Mean(from, to) => {
            let values = probe.mean_of(&column, from.value, to.value);
            Ok(vec![Profile { time: to.value, values }])
        }
        WhenFile::Every(from, to) => {
            let inside = |&index: &usize| (from.value..=to.value).contains(&probe.times[index]);
            let found =
                (0..probe.times.len()).filter(inside).map(sample).collect::<Result<Vec<_>, String>>()?;
            if found.is_empty() {
                Err(format!("probe `{}` has no samples in the interval", probe.name))
            } else {
                Ok(found)
            }
        }
    }
}

/// Returns the distances of a probe from its reference at all points and times.
///
/// # Errors
/// Field, time or samples that are missing.
pub fn distances(
    probe: &ProbeHistory,
    field: &FieldFile,
    when: &WhenFile,
    reference: &Reference,
) -> Result<Vec<f64>, String> {
    let of_profile = |profile: &Profile| {
        let pairs = probe.places.iter().zip(&profile.values);
        pairs.map(|(&place, value)| value - reference(place, profile.time)).collect::<Vec<_>>()
    };
    Ok(profiles(probe, field, when)?.iter().flat_map(of_profile).collect())
}

/// Returns times, s, and norms of the distances of a probe from its reference at each sample.
///
/// # Errors
/// Field, time or samples that are missing.
pub fn distance_over_time(
    probe: &ProbeHistory,
    field: &FieldFile,
    reference: &Reference,
    norm_of: NormFile,
) -> Result<Vec<(f64, f64)>, String> {
    let column = fields::column(probe, field)?;
    let of_sample = |(&time, values): (&f64, &[f64])| {
        let distances = probe.places.iter().zip(values).map(|(&place, value)| value - reference(place, time));
        (time, norm(&distances.collect::<Vec<_>>(), norm_of))
    };
    Ok(probe.times.iter().zip(column.chunks_exact(probe.places.len())).map(of_sample).collect())
}

/// Returns the norm of distances; NaN if any of them is NaN.
pub fn norm(distances: &[f64], norm: NormFile) -> f64 {
    match norm {
        NormFile::Largest => {
            distances.iter().fold(0.0, |most, d| if d.abs() > most || d.is_nan() { d.abs() } else { most })
        }
        NormFile::RootMeanSquare => {
            (distances.iter().map(|d| d * d).sum::<f64>() / distances.len() as f64).sqrt()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_over_time_are_computed_for_each_sample() {
        let probe = ProbeHistory {
            name: "line".to_owned(),
            places: vec![[0.0; 3], [1.0, 0.0, 0.0]],
            times: vec![0.0, 2.0],
            columns: vec![("u", vec![1.0, 1.0, 2.0, 7.0])],
        };
        // x + t.
        let reference: Reference = Box::new(|place, time| place[0] + time);
        let found = distance_over_time(&probe, &FieldFile::U, &reference, NormFile::Largest);
        assert_eq!(found.expect("distances"), [(0.0, 1.0), (2.0, 4.0)]);
    }

    #[test]
    fn norms_have_their_definitions() {
        assert_eq!(norm(&[1.0, -3.0, 2.0], NormFile::Largest), 3.0);
        assert_eq!(norm(&[3.0, 4.0], NormFile::RootMeanSquare), 12.5_f64.sqrt());
        assert!(norm(&[1.0, f64::NAN, 2.0], NormFile::Largest).is_nan());
    }
}
