//! Round ticks of an axis and their labels.

/// Returns round numbers within a range, at most `most` of them.
pub(crate) fn ticks(low: f64, high: f64, most: usize) -> Vec<f64> {
    let length = high - low;
    if !(length > 0.0 && length.is_finite()) || most == 0 {
        return Vec::new();
    }
    let rough = length / most as f64;
    let decade = 10_f64.powf(rough.log10().floor());
    // Includes an end of the range that is a round number.
    let slack = 1e-9 * length;
    [1.0, 2.0, 5.0, 10.0, 20.0, 50.0]
        .iter()
        .map(|round| {
            let step = round * decade;
            let (first, last) =
                (((low - slack) / step).ceil() as i64, ((high + slack) / step).floor() as i64);
            (first..=last).map(|k| k as f64 * step).collect::<Vec<f64>>()
        })
        .find(|found| found.len() <= most)
        .unwrap_or_default()
}

/// Returns the number of decimals of all ticks.
fn decimals(ticks: &[f64]) -> usize {
    let step = ticks.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
    let step = if step.is_finite() { step } else { ticks.iter().fold(1.0, |_, tick| tick.abs()) };
    // Steps of 0.5 and 0.1 need one decimal; the slack is for the rounding of 0.1.
    if step > 0.0 { (-(step.log10() + 1e-9).floor()).clamp(0.0, 12.0) as usize } else { 0 }
}

/// Returns the labels of ticks and the power of ten by which they are to be multiplied.
pub(crate) fn labels(ticks: &[f64], plain: bool) -> (Vec<String>, i32) {
    let largest = ticks.iter().fold(0.0_f64, |largest, tick| largest.max(tick.abs()));
    let needs_power = !plain && largest > 0.0 && !(1e-2..1e5).contains(&largest);
    let power = if needs_power { largest.log10().floor() as i32 } else { 0 };
    let scaled: Vec<f64> = ticks.iter().map(|tick| tick / 10_f64.powi(power)).collect();
    let decimals = decimals(&scaled);
    let text = |value: &f64| {
        let value = if *value == 0.0 { 0.0 } else { *value };
        format!("{value:.decimals$}").replace('-', "−")
    };
    (scaled.iter().map(text).collect(), power)
}

/// Returns a power of ten with a unit: `10⁻³ m/s`.
pub(crate) fn with_power(unit: &str, power: i32) -> String {
    if power == 0 {
        return unit.to_owned();
    }
    let raised: String = power
        .to_string()
        .chars()
        .map(|digit| match digit {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            other => char::from_u32('⁰' as u32 + other.to_digit(10).unwrap_or(0)).unwrap_or('⁰'),
        })
        .collect();
    format!("10{raised} {unit}").trim_end().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_few() {
        assert_eq!(ticks(0.0, 1.0, 6), [0.0, 0.2, 0.4, 0.6000000000000001, 0.8, 1.0]);
        assert_eq!(ticks(-0.2, 0.2778, 5), [-0.2, -0.1, 0.0, 0.1, 0.2]);
        for (low, high) in [(0.0, 0.306), (-33.1, 12.0), (999.5, 1000.7), (1e-9, 3e-9)] {
            let found = ticks(low, high, 7);
            assert!((2..=7).contains(&found.len()), "{low} to {high}: {found:?}");
        }
        assert!(ticks(1.0, 1.0, 5).is_empty() && ticks(f64::NAN, 1.0, 5).is_empty());
    }

    #[test]
    fn labels_distinguish_ticks() {
        let written = |low, high| labels(&ticks(low, high, 6), false);
        assert_eq!(written(0.0, 0.3).0, ["0.0", "0.1", "0.2", "0.3"]);
        assert_eq!(written(-1.0, 1.0).0, ["−1.0", "−0.5", "0.0", "0.5", "1.0"]);
        let (small, power) = written(0.0, 3e-6);
        assert_eq!((small[0].as_str(), small[small.len() - 1].as_str(), power), ("0", "3", -6));
        assert_eq!(with_power("m/s", power), "10⁻⁶ m/s");
        assert_eq!(with_power("", 12), "10¹²");
    }
}
