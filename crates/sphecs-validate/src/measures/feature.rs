//! Features of the profile along a line: extreme values, position, width and reattachment.
//!
//! Positions are distances from the first point of the line, m; the profile is linear between
//! points.

use super::profile::Profile;
use crate::schema::FeatureFile;

/// Feature of a profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Feature {
    /// Value, in the unit of the field or in m.
    pub value: f64,
    /// True if the value is a lower bound because the line ends first.
    pub at_least: bool,
}

/// Returns a feature of profiles along a line; several profiles have only extreme values.
///
/// # Errors
/// A position is requested of several profiles.
pub fn feature(places: &[[f64; 3]], profiles: &[Profile], take: &FeatureFile) -> Result<Feature, String> {
    let all = || profiles.iter().flat_map(|profile| profile.values.iter().copied());
    let extreme = |better: fn(f64, f64) -> bool| {
        all().reduce(|best, value| if better(value, best) || value.is_nan() { value } else { best })
    };
    let plain = |value: Option<f64>| {
        value.map(|value| Feature { value, at_least: false }).ok_or_else(|| "no points".to_owned())
    };
    match take {
        FeatureFile::Largest => return plain(extreme(|value, best| value > best)),
        FeatureFile::Smallest => return plain(extreme(|value, best| value < best)),
        _ => {}
    }
    let [profile] = profiles else {
        return Err("a position or a width needs one profile".to_owned());
    };
    let along: Vec<f64> = places.iter().map(|place| distance(places[0], *place)).collect();
    let values = &profile.values;
    if values.iter().any(|value| value.is_nan()) {
        return Err("some points of the line have no value".to_owned());
    }
    Ok(match take {
        FeatureFile::PlaceOfLargest => Feature { value: along[peak(values)], at_least: false },
        FeatureFile::Width(share) => width(&along, values, share.value),
        _ => reattachment(&along, values),
    })
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum::<f64>().sqrt()
}

fn peak(values: &[f64]) -> usize {
    (0..values.len()).fold(0, |best, at| if values[at] > values[best] { at } else { best })
}

/// Returns the position where the line between two points crosses a level, m.
fn crossing(along: &[f64], values: &[f64], first: usize, level: f64) -> f64 {
    let (low, high) = (values[first], values[first + 1]);
    along[first] + (along[first + 1] - along[first]) * (level - low) / (high - low)
}

fn width(along: &[f64], values: &[f64], share: f64) -> Feature {
    let (top, last) = (peak(values), values.len() - 1);
    let level = share * values[top];
    let before = (0..top).rev().find(|&at| values[at] < level);
    let after = (top + 1..=last).find(|&at| values[at] < level);
    let from = before.map_or(along[0], |at| crossing(along, values, at, level));
    let to = after.map_or(along[last], |at| crossing(along, values, at - 1, level));
    Feature { value: to - from, at_least: before.is_none() || after.is_none() }
}

fn reattachment(along: &[f64], values: &[f64]) -> Feature {
    let last = values.len() - 1;
    let begin = |at: usize| if at == 0 { along[0] } else { crossing(along, values, at - 1, 0.0) };
    let end = |at: usize| if at == last { along[last] } else { crossing(along, values, at, 0.0) };
    let mut longest = (0.0, 0.0, false);
    let mut from = None;
    for at in 0..=last {
        if values[at] < 0.0 {
            let from = *from.get_or_insert_with(|| begin(at));
            if at == last || values[at + 1] >= 0.0 {
                let to = end(at);
                if to - from > longest.1 - longest.0 {
                    longest = (from, to, at == last);
                }
            }
        } else {
            from = None;
        }
    }
    Feature { value: longest.1, at_least: longest.2 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sphecs_scene::notation::tree::Span;
    use sphecs_scene::notation::typed::Spanned;

    /// Returns a feature of a line along y from (1, 2) m with points 0.5 m apart.
    fn of(values: &[f64], take: &FeatureFile) -> Feature {
        let places: Vec<[f64; 3]> = (0..values.len()).map(|at| [1.0, 2.0 + 0.5 * at as f64, 0.0]).collect();
        feature(&places, &[Profile { time: 0.0, values: values.to_vec() }], take).expect("a feature")
    }

    fn exact(value: f64) -> Feature {
        Feature { value, at_least: false }
    }

    #[test]
    fn extremes_and_position_are_found() {
        let values = [1.0, -2.0, 5.0, 0.0];
        assert_eq!(of(&values, &FeatureFile::Largest), exact(5.0));
        assert_eq!(of(&values, &FeatureFile::Smallest), exact(-2.0));
        assert_eq!(of(&values, &FeatureFile::PlaceOfLargest), exact(1.0));
    }

    #[test]
    fn width_ends_where_the_profile_falls_below_the_fraction() {
        let half = Spanned { value: 0.5, span: Span::PLACEHOLDER, head: Span::PLACEHOLDER };
        let half = FeatureFile::Width(half);
        // Above 2 from 0.25 to 1.5 m.
        assert_eq!(of(&[0.0, 4.0, 3.0, 2.0, 1.0, 3.0], &half), exact(1.25));
        assert_eq!(of(&[3.0, 4.0, 0.0], &half), Feature { value: 0.75, at_least: true });
    }

    #[test]
    fn flow_reattaches_after_its_longest_reversed_interval() {
        // A counter-rotating corner eddy, the eddy behind the step, and a short one further on.
        let values = [-0.1, 0.1, -1.0, -1.0, -1.0, 1.0, -0.1, 0.1];
        assert_eq!(of(&values, &FeatureFile::Reattachment), exact(2.25));
        assert_eq!(of(&[1.0, 2.0], &FeatureFile::Reattachment), exact(0.0));
        let open = of(&[1.0, -1.0, -1.0], &FeatureFile::Reattachment);
        assert_eq!(open, Feature { value: 1.0, at_least: true });
    }

    #[test]
    fn position_of_several_profiles_is_an_error() {
        let profile = Profile { time: 0.0, values: vec![1.0] };
        let two = [profile.clone(), profile];
        assert!(feature(&[[0.0; 3]], &two, &FeatureFile::PlaceOfLargest).is_err());
    }
}
