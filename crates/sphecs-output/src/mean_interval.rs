//! Interval of a time mean: the part of it that the rows of a run cover, and the note on what is
//! missing.

use crate::table::number;
use sphecs_core::format::significant;

/// Returns the part of an interval from `interval.0` to `interval.1`, s, that rows at rising
/// `times`, s, cover; None if that part has no length.
pub(crate) fn covered(times: &[f64], interval: (f64, f64)) -> Option<(f64, f64)> {
    let (first, last) = (times.first()?, times.last()?);
    let part = (first.max(interval.0), last.min(interval.1));
    (part.0 < part.1).then_some(part)
}

/// Returns the cells `from` and `to` of a table of means, NaN without a covered part.
pub(crate) fn cells(covered: Option<(f64, f64)>) -> [String; 2] {
    let (from, to) = covered.unwrap_or((f64::NAN, f64::NAN));
    [number(from), number(to)]
}

/// Returns a note on the means of `names`, which have the same interval, if the run ended before
/// the interval did.
pub(crate) fn note(names: &[&str], times: &[f64], interval: (f64, f64)) -> Option<String> {
    let last = times.last().copied().unwrap_or(0.0);
    // A row has the time at the beginning of its step, so that the last one of a complete run may
    // precede the end by a row.
    let row = times.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    let (names, from, to) = (names.join(", "), significant(interval.0), significant(interval.1));
    match covered(times, interval) {
        None => Some(format!(
            "the run ended at {} s, the means of {names} begin at {from} s: they are NaN",
            significant(last)
        )),
        Some((_, end)) if end < interval.1 - 1.01 * row => Some(format!(
            "the run ended at {} s: the means of {names} cover {from} to {} s of {from} to {to} s",
            significant(last),
            significant(end)
        )),
        Some(_) => None,
    }
}

/// Returns a note on means that were sampled during a run, `what`, if the run ended before their
/// interval did; None as `covered` stands for means that did not begin.
pub(crate) fn sampled_note(
    what: &str,
    (from, to): (f64, f64),
    covered: Option<(f64, f64)>,
) -> Option<String> {
    let Some((first, last)) = covered else {
        return Some(format!(
            "the run ended before the {what} begin, at {} s: they are left out",
            significant(from)
        ));
    };
    (last < to * (1.0 - 1e-9)).then(|| {
        format!(
            "the {what} cover {} to {} s of {} to {} s: the run ended earlier",
            significant(first),
            significant(last),
            significant(from),
            significant(to)
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_cover_what_lies_between_the_first_and_the_last() {
        let times = [0.0, 1.0, 2.5];
        assert_eq!(covered(&times, (0.5, 2.0)), Some((0.5, 2.0)));
        assert_eq!(covered(&times, (1.0, 3.0)), Some((1.0, 2.5)));
        assert_eq!(covered(&times, (10.0, 20.0)), None);
        assert_eq!(covered(&[], (0.0, 1.0)), None);
        assert_eq!(cells(None), ["NaN", "NaN"]);
    }

    #[test]
    fn note_states_what_a_run_left_out() {
        let times = [0.0, 1.0, 2.0, 3.0];
        assert_eq!(note(&["a"], &times, (1.0, 3.9)), None);
        let text = note(&["a", "b"], &times, (1.0, 8.0)).expect("a note");
        assert_eq!(text, "the run ended at 3 s: the means of `a`, `b` cover 1 to 3 s of 1 to 8 s");
        let text = note(&["a"], &times, (4.0, 8.0)).expect("a note");
        assert_eq!(text, "the run ended at 3 s, the means of `a` begin at 4 s: they are NaN");
    }
}
