//! Probes selected by a name or pattern, and the quantities of a probe.

use std::borrow::Cow;

use crate::schema::FieldFile;
use sphecs_output::probes::history::ProbeHistory;

/// Wildcard for any letters in the name of a probe.
const ANY: char = '*';

/// Returns true if a name matches a pattern, whose `*` stand for any letters.
pub fn matches(pattern: &str, name: &str) -> bool {
    let Some((head, tail)) = pattern.split_once(ANY) else { return pattern == name };
    let Some(rest) = name.strip_prefix(head) else { return false };
    let starts = rest.char_indices().map(|(at, _)| at).chain([rest.len()]);
    starts.into_iter().any(|at| matches(tail, &rest[at..]))
}

/// Returns the probe of a name, or one with the points of all probes that match a pattern, in their
/// order.
///
/// # Errors
/// There is none.
pub fn probe<'a>(probes: &'a [ProbeHistory], pattern: &str) -> Result<Cow<'a, ProbeHistory>, String> {
    let found: Vec<&ProbeHistory> = probes.iter().filter(|probe| matches(pattern, &probe.name)).collect();
    match found[..] {
        [] => Err(format!("no probe `{pattern}`")),
        [single] => Ok(Cow::Borrowed(single)),
        [first, ..] => {
            let count = common_times(&found, pattern)?;
            Ok(Cow::Owned(ProbeHistory {
                name: pattern.to_owned(),
                places: found.iter().flat_map(|probe| probe.places.iter().copied()).collect(),
                times: first.times[..count].to_vec(),
                columns: first
                    .columns
                    .iter()
                    .filter(|(name, _)| found.iter().all(|probe| probe.column(name).is_some()))
                    .map(|&(name, _)| (name, joined(&found, name, count)))
                    .collect(),
            }))
        }
    }
}

/// Returns the number of times that all probes have; a kill may leave one probe a row behind.
fn common_times(probes: &[&ProbeHistory], pattern: &str) -> Result<usize, String> {
    let count = probes.iter().map(|probe| probe.times.len()).min().unwrap_or(0);
    let times = &probes[0].times[..count];
    match probes.iter().find(|probe| probe.times[..count] != *times) {
        Some(other) => Err(format!(
            "`{pattern}`: the probes `{}` and `{}` are sampled at different times, must have the same `every`",
            probes[0].name, other.name
        )),
        None => Ok(count),
    }
}

/// Returns a column of all probes, with the values of all probes at the first time before those at
/// the next.
fn joined(probes: &[&ProbeHistory], name: &str, times: usize) -> Vec<f64> {
    (0..times)
        .flat_map(|index| probes.iter().filter_map(move |probe| probe.sample(name, index)).flatten().copied())
        .collect()
}

/// Returns all values of a field: all points at the first time, then all at the next.
///
/// # Errors
/// The probe does not measure it.
pub fn column<'a>(probe: &'a ProbeHistory, field: &FieldFile) -> Result<Cow<'a, [f64]>, String> {
    let of = |name: &str| probe.column(name).ok_or_else(|| format!("probe `{}` has no `{name}`", probe.name));
    let weighted = |direction: [f64; 3]| {
        let [u, v, w] = [of("u")?, of("v")?, of("w")?];
        let along = |at: usize| direction[0] * u[at] + direction[1] * v[at] + direction[2] * w[at];
        Ok(Cow::Owned((0..u.len()).map(along).collect()))
    };
    match field {
        FieldFile::U => of("u").map(Cow::Borrowed),
        FieldFile::V => of("v").map(Cow::Borrowed),
        FieldFile::W => of("w").map(Cow::Borrowed),
        FieldFile::Pressure => of("pressure").map(Cow::Borrowed),
        FieldFile::Density => of("density").map(Cow::Borrowed),
        FieldFile::Speed => {
            let [u, v, w] = [of("u")?, of("v")?, of("w")?];
            let speed = |at: usize| f64::hypot(f64::hypot(u[at], v[at]), w[at]);
            Ok(Cow::Owned((0..u.len()).map(speed).collect()))
        }
        FieldFile::Along(direction) => {
            let component = |axis: usize| direction.value.get(axis).map_or(0.0, |number| number.value);
            weighted([0, 1, 2].map(component))
        }
        FieldFile::Slope(field) => {
            let (values, points) = (column(probe, field)?, probe.places.len());
            if points < 2 {
                return Err(format!("probe `{}` has one point and no slope", probe.name));
            }
            Ok(Cow::Owned(values.chunks(points).flat_map(|line| slopes(line, &probe.places)).collect()))
        }
    }
}

/// Returns the derivatives at the points of a line by central differences, one-sided at the ends.
fn slopes(line: &[f64], places: &[[f64; 3]]) -> Vec<f64> {
    let last = line.len() - 1;
    let between = |a: usize, b: usize| {
        let distance = (0..3).map(|axis| (places[b][axis] - places[a][axis]).powi(2)).sum::<f64>().sqrt();
        (line[b] - line[a]) / distance
    };
    (0..line.len()).map(|at| between(at.saturating_sub(1), (at + 1).min(last))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(name: &str, x: f64, u: [f64; 4]) -> ProbeHistory {
        ProbeHistory {
            name: name.to_owned(),
            places: vec![[x, 0.0, 0.0], [x, 1.0, 0.0]],
            times: vec![0.0, 1.0],
            columns: vec![("u", u.to_vec()), ("v", vec![4.0; 4]), ("w", vec![0.0; 4])],
        }
    }

    #[test]
    fn star_matches_any_letters() {
        for (pattern, name, wanted) in [
            ("axis", "axis", true),
            ("axis", "axis 2", false),
            ("across_*cm", "across_10cm", true),
            ("across_*cm", "across_middle", false),
            ("*", "anything", true),
            ("a*b*c", "a-b-b-c", true),
            ("a*b*c", "acb", false),
        ] {
            assert_eq!(matches(pattern, name), wanted, "{pattern}, {name}");
        }
    }

    #[test]
    fn pattern_combines_the_points_of_all_its_probes() {
        let probes = [
            line("a1", 0.0, [1.0, 2.0, 3.0, 4.0]),
            line("b", 9.0, [0.0; 4]),
            line("a2", 1.0, [5.0, 6.0, 7.0, 8.0]),
        ];
        let combined = probe(&probes, "a*").expect("a probe");
        assert_eq!(combined.places.iter().map(|place| place[0]).collect::<Vec<_>>(), [0.0, 0.0, 1.0, 1.0]);
        assert_eq!(combined.sample("u", 1), Some(&[3.0, 4.0, 7.0, 8.0][..]));
        assert!(probe(&probes, "c*").is_err());
    }

    #[test]
    fn slopes_are_central_differences_along_a_line() {
        let probe = ProbeHistory {
            name: "a".to_owned(),
            places: vec![[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]],
            times: vec![0.0, 1.0],
            columns: vec![("u", vec![0.0, 0.25, 1.0, 4.0, 1.0, 1.0, 1.0, 3.0])],
        };
        let slope = FieldFile::Slope(Box::new(FieldFile::U));
        assert_eq!(
            column(&probe, &slope).expect("slopes")[..],
            [0.5, 1.0, 2.5, 3.0, 0.0, 0.0, 4.0 / 3.0, 2.0]
        );
        let point = ProbeHistory { places: vec![[0.0; 3]], ..probe };
        assert!(column(&point, &slope).is_err());
    }

    #[test]
    fn speed_and_velocity_along_follow_from_the_components() {
        let probe = line("a", 0.0, [3.0; 4]);
        assert_eq!(column(&probe, &FieldFile::Speed).expect("a column")[..], [5.0; 4]);
        assert_eq!(column(&probe, &FieldFile::V).expect("a column")[..], [4.0; 4]);
        assert!(column(&probe, &FieldFile::Pressure).is_err());
    }
}
