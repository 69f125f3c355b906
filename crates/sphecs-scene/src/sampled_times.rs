//! Times of a run at which the prescribed quantities of a scene are evaluated before it.
//!
//! ```text
//! t_2k = k T/N,   t_2k+1 = (k + frac((k + 1) φ)) T/N,   φ = (√5 − 1)/2
//! ```
//!
//! The ends of N equal intervals, and one time within each. The ends meet a pole at a round time,
//! but all of them may meet zeros of a sine.

/// Number of intervals N.
const INTERVALS: u32 = 1000;

/// Fractional part of the golden ratio: its multiples fill the unit interval evenly.
const GOLDEN: f64 = 0.618_033_988_749_894_8;

/// Returns rising times of a run to `end`, s, from 0 to `end`; zeros for an end that is infinite.
pub fn sampled_times(end: f64) -> impl Iterator<Item = f64> + Clone {
    let end = if end.is_finite() { end } else { 0.0 };
    (0..=2 * INTERVALS).map(move |index| {
        let interval = f64::from(index / 2);
        let share = if index % 2 == 0 { 0.0 } else { ((interval + 1.0) * GOLDEN).fract() };
        end * ((interval + share) / f64::from(INTERVALS))
    })
}

/// Returns the largest value of a function of time over a run to `end`, s: the largest of the
/// samples, improved between the neighbours of its time by a golden-section search. NaN is ignored.
pub fn largest_in_time(end: f64, value: impl Fn(f64) -> f64) -> f64 {
    let times: Vec<f64> = sampled_times(end).collect();
    let mut found = (0, f64::NEG_INFINITY);
    for (index, time) in times.iter().enumerate() {
        let value = value(*time);
        if value > found.1 {
            found = (index, value);
        }
    }
    let (index, mut largest) = found;
    if largest.is_infinite() {
        return largest;
    }
    let (mut low, mut high) = (times[index.saturating_sub(1)], times[(index + 1).min(times.len() - 1)]);
    for _ in 0..40 {
        let left = high - GOLDEN * (high - low);
        let right = low + GOLDEN * (high - low);
        let (at_left, at_right) = (value(left), value(right));
        largest = largest.max(at_left).max(at_right);
        if at_left < at_right { low = left } else { high = right }
    }
    largest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_rise_from_zero_to_the_end() {
        let times: Vec<f64> = sampled_times(2.0).collect();
        assert_eq!((times[0], *times.last().expect("times")), (0.0, 2.0));
        assert!(times.is_sorted());
        let longest = times.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
        assert!(longest <= 2.0 / 1000.0, "{longest}");
        assert!(times.contains(&0.5));
    }

    #[test]
    fn peak_of_a_sine_is_found_whatever_its_period() {
        // At 250 Hz all of 1000 equidistant times of 2 s are zeros.
        for frequency in [0.05, 10.0, 37.3, 100.0, 250.0] {
            let largest = largest_in_time(2.0, |t| (std::f64::consts::TAU * frequency * t).sin());
            assert!(
                (largest - if frequency > 0.1 { 1.0 } else { 0.587_785_252 }).abs() < 1e-6,
                "{frequency}: {largest}"
            );
        }
    }

    #[test]
    fn constant_is_found_exactly() {
        assert_eq!(largest_in_time(f64::INFINITY, |_| 0.1), 0.1);
        assert_eq!(largest_in_time(1.0, |t| if t > 0.5 { f64::NAN } else { 0.1 }), 0.1);
    }
}
