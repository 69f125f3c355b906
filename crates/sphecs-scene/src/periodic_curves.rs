//! Parts of curves within one period.
//!
//! The distance from a periodic wall repeats, so that the curves of its layers continue beyond the
//! seams. What lies there is the image of what lies within.

use glam::DVec3;

/// Returns the parts of a curve within the periods (m) of the periodic directions. A curve that
/// ends at its first point may be cut into fewer parts than it leaves the period: its first and
/// last are one.
pub fn within_periods(curve: Vec<DVec3>, periods: &[Option<(f64, f64)>; 3]) -> Vec<Vec<DVec3>> {
    let mut parts = vec![curve];
    for (axis, period) in periods.iter().enumerate() {
        if let Some((low, high)) = *period {
            parts = parts.into_iter().flat_map(|part| cut(part, axis, (low, high))).collect();
        }
    }
    parts
}

/// Returns the parts of a curve between two planes normal to an axis.
fn cut(curve: Vec<DVec3>, axis: usize, (low, high): (f64, f64)) -> Vec<Vec<DVec3>> {
    let is_within = |point: &DVec3| (low..=high).contains(&point[axis]);
    if curve.iter().all(is_within) {
        return vec![curve];
    }
    let mut parts: Vec<Vec<DVec3>> = Vec::new();
    let mut part: Vec<DVec3> = Vec::new();
    for pair in curve.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        // Shares of the segment at which it enters and leaves the slab.
        let share = |plane: f64| (plane - from[axis]) / (to[axis] - from[axis]);
        let (mut enters, mut leaves) = (0.0, if is_within(&from) { 1.0 } else { 0.0 });
        if from[axis] != to[axis] {
            let (one, other) = (share(low), share(high));
            (enters, leaves) = (one.min(other).max(0.0), one.max(other).min(1.0));
        }
        if enters >= leaves {
            // The segment before it may have ended in a plane.
            parts.extend((!part.is_empty()).then(|| std::mem::take(&mut part)));
            continue;
        }
        if part.is_empty() {
            part.push(from.lerp(to, enters));
        }
        part.push(from.lerp(to, leaves));
        if leaves < 1.0 {
            parts.push(std::mem::take(&mut part));
        }
    }
    if !part.is_empty() {
        parts.push(part);
    }
    join_ends(&curve, &mut parts);
    parts
}

/// Joins the last part of a closed curve with the first where the curve begins within the planes.
fn join_ends(curve: &[DVec3], parts: &mut Vec<Vec<DVec3>>) {
    let (Some(first), Some(last)) = (curve.first(), curve.last()) else { return };
    let begins = parts.first().is_some_and(|part| part.first() == Some(first));
    let ends = parts.last().is_some_and(|part| part.last() == Some(last));
    if first == last && begins && ends && parts.len() > 1 {
        let mut joined = parts.pop().unwrap_or_default();
        joined.extend(parts[0].iter().skip(1));
        parts[0] = joined;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: [Option<(f64, f64)>; 3] = [Some((0.0, 2.0)), None, None];

    fn points(places: &[[f64; 2]]) -> Vec<DVec3> {
        places.iter().map(|[x, y]| DVec3::new(*x, *y, 0.0)).collect()
    }

    fn length(part: &[DVec3]) -> f64 {
        part.windows(2).map(|pair| pair[0].distance(pair[1])).sum()
    }

    #[test]
    fn line_ends_at_the_seams() {
        let line = points(&[[-0.5, 1.0], [0.5, 1.0], [1.5, 1.0], [2.5, 1.0]]);
        assert_eq!(
            within_periods(line, &PERIOD),
            [points(&[[0.0, 1.0], [0.5, 1.0], [1.5, 1.0], [2.0, 1.0]])]
        );
    }

    #[test]
    fn curve_with_a_point_in_the_seam_ends_there() {
        let bow = points(&[[1.5, 0.0], [2.0, 0.0], [2.5, 0.5], [2.0, 1.0], [1.5, 1.0]]);
        let ends = [points(&[[1.5, 0.0], [2.0, 0.0]]), points(&[[2.0, 1.0], [1.5, 1.0]])];
        assert_eq!(within_periods(bow, &PERIOD), ends);
    }

    #[test]
    fn curves_within_and_without_periods_are_unchanged() {
        let square = points(&[[0.5, 0.0], [1.5, 0.0], [1.5, 1.0], [0.5, 0.0]]);
        for periods in [PERIOD, [None; 3]] {
            assert_eq!(within_periods(square.clone(), &periods), std::slice::from_ref(&square));
        }
        assert_eq!(within_periods(points(&[[3.0, 0.0], [4.0, 0.0]]), &PERIOD), Vec::<Vec<DVec3>>::new());
    }

    #[test]
    fn closed_curve_across_a_seam_is_one_part_on_each_side() {
        // A square about (2, 0) that begins within the period: half of it is within.
        let square = points(&[[1.5, 0.0], [1.5, -0.5], [2.5, -0.5], [2.5, 0.5], [1.5, 0.5], [1.5, 0.0]]);
        let parts = within_periods(square, &PERIOD);
        assert_eq!(parts.len(), 1, "{parts:?}");
        assert!((length(&parts[0]) - 2.0).abs() < 1e-12);
        assert_eq!((parts[0][0].x, parts[0].last().map(|end| end.x)), (2.0, Some(2.0)));
    }
}
