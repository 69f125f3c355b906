//! Distances of a probe's profile from what it should be.

use super::{Context, reference};
use crate::output::probes::history::ProbeHistory;
use crate::validate::schema::{FieldFile, NormFile, ReferenceFile, WhenFile};

/// What a probe measured at a time, or on the mean over an interval: a value for each of its points.
#[derive(Clone, Debug, PartialEq)]
pub struct Profile {
    /// Time of the sample, or the end of the interval, s.
    pub time: f64,
    /// Values at the points of the probe.
    pub values: Vec<f64>,
}

/// The profiles of a probe at the times asked for.
///
/// # Errors
/// That the probe has no such field or no such time.
pub fn profiles(probe: &ProbeHistory, field: FieldFile, when: &WhenFile) -> Result<Vec<Profile>, String> {
    let name = field.column();
    let lacks = || format!("probe `{}` has no `{name}`", probe.name);
    let sample = |index: usize| {
        let values = probe.sample(name, index).ok_or_else(lacks)?.to_vec();
        Ok(Profile { time: probe.times[index], values })
    };
    match when {
        WhenFile::At(time) => {
            let distance = |index: &usize| (probe.times[*index] - time.value).abs();
            let nearest = (0..probe.times.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
            let nearest = nearest.ok_or_else(|| format!("probe `{}` has no samples", probe.name))?;
            let spacing = probe.times.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
            if distance(&nearest) > spacing.max(1e-12) {
                return Err(format!("probe `{}` has nothing at {} s", probe.name, time.value));
            }
            Ok(vec![sample(nearest)?])
        }
        WhenFile::Mean(from, to) => {
            let values = probe.mean(name, from.value, to.value).ok_or_else(lacks)?;
            Ok(vec![Profile { time: to.value, values }])
        }
        WhenFile::Every(from, to) => {
            let inside = |&index: &usize| (from.value..=to.value).contains(&probe.times[index]);
            let found =
                (0..probe.times.len()).filter(inside).map(sample).collect::<Result<Vec<_>, String>>()?;
            if found.is_empty() {
                Err(format!("probe `{}` has no samples then", probe.name))
            } else {
                Ok(found)
            }
        }
    }
}

/// Distances of a probe of a run from its reference, at every point and time asked for.
///
/// # Errors
/// What is missing.
pub fn distances(
    context: Context<'_>,
    (run, probe): (&str, &str),
    field: FieldFile,
    when: &WhenFile,
    reference: &ReferenceFile,
) -> Result<Vec<f64>, String> {
    let measured = context.run(run)?.probe(probe)?;
    let found = profiles(measured, field, when)?;
    if let Some(function) = reference::function(reference, context.case)? {
        let of_profile = |profile: &Profile| {
            let pairs = measured.places.iter().zip(&profile.values);
            pairs.map(|(&place, value)| value - function(place, profile.time)).collect::<Vec<_>>()
        };
        return Ok(found.iter().flat_map(of_profile).collect());
    }
    let other = reference::run_of(reference)
        .map_or_else(|| Err("no reference".to_owned()), |run| context.run(run))?;
    let expected = profiles(other.probe(probe)?, field, when)?;
    if expected.len() != found.len()
        || expected.iter().zip(&found).any(|(a, b)| a.values.len() != b.values.len())
    {
        return Err(format!("probe `{probe}` has other points or times in the other run"));
    }
    let values = |profiles: Vec<Profile>| profiles.into_iter().flat_map(|profile| profile.values);
    Ok(values(found).zip(values(expected)).map(|(a, b)| a - b).collect())
}

/// Distances put together; a value that is none shows.
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
    fn norms_are_theirs() {
        assert_eq!(norm(&[1.0, -3.0, 2.0], NormFile::Largest), 3.0);
        assert_eq!(norm(&[3.0, 4.0], NormFile::RootMeanSquare), 12.5_f64.sqrt());
        assert!(norm(&[1.0, f64::NAN, 2.0], NormFile::Largest).is_nan());
    }
}
