//! Line of vortex shedding in the spectrum of the lift, or the reason why there is none.
//!
//! ```text
//! a² ≥ 30 max(median below, median above),   4/T ≤ f ≤ c0/(10 D)
//! ```
//!
//! A line is the largest maximum of the squared amplitude a² that
//!
//! - has four periods in the interval T, and 30 times the background: the larger of the medians of
//!   a² from f/4 to the line and from the line to 4 f. White noise passes that once in 1e8 trials;
//! - lasts: its amplitude in either half of the interval is a third of that in the other, at least;
//! - is no sound: at f the body of size D is a tenth of an acoustic wavelength, at most. Above the
//!   lowest frequency of sound in the domain, c0/(2 L), the line and its second harmonic have half
//!   of the variance.

use super::spectrum::{HALF_WIDTH, Series};
use sphecs_core::format::{significant, with_digits};

/// Least number of periods in the interval.
const LEAST_PERIODS: f64 = 4.0;

/// Least squared amplitude over that of the background.
const LEAST_RATIO: f64 = 30.0;

/// Least ratio of the amplitudes in the halves of the interval.
const LASTING: f64 = 1.0 / 3.0;

/// Largest size of a body over the wavelength of sound of its line.
const COMPACT: f64 = 0.1;

/// Least share of the variance of a line at a frequency at which the domain resounds.
const DOMINANT: f64 = 0.5;

/// Frequencies that bound those of vortices, 1/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SoundLimits {
    /// Frequency from which on the body is no longer small against a wave of sound.
    pub compact: f64,
    /// Lowest frequency of sound between the ends of the domain.
    pub lowest: f64,
}

impl SoundLimits {
    /// Returns the limits at a sound speed, m/s, for the size of a body and the largest extent of
    /// its domain, m.
    pub fn new(sound_speed: f64, size: f64, extent: f64) -> Self {
        Self { compact: COMPACT * sound_speed / size, lowest: 0.5 * sound_speed / extent }
    }
}

/// Line of vortex shedding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Frequency, 1/s.
    pub frequency: f64,
    /// Periods in the interval.
    pub periods: f64,
    /// Lowest frequency of sound, 1/s, if the line is above it.
    pub above_sound: Option<f64>,
}

/// Reason why a series has no line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoLine {
    /// The interval has too few rows.
    FewRows,
    /// The lift is constant, or has a linear trend, up to rounding.
    Constant,
    /// No maximum stands out of the background.
    Noise {
        /// Frequency of the largest maximum, 1/s, and its squared amplitude over the background;
        /// None without a maximum.
        largest: Option<(f64, f64)>,
    },
    /// The largest part has fewer than four periods in the interval.
    Slow,
    /// The amplitude differs between the halves of the interval.
    Changing {
        /// Frequency, 1/s.
        frequency: f64,
        /// Amplitude in each half.
        halves: [f64; 2],
    },
    /// The line may be sound.
    Sound {
        /// Frequency, 1/s.
        frequency: f64,
        /// Lowest frequency of sound, 1/s.
        lowest: f64,
        /// Share of the variance.
        share: f64,
    },
}

impl NoLine {
    /// Returns the reason in a sentence, with frequencies as Strouhal numbers: times `scale`, s.
    pub fn text(self, scale: f64) -> String {
        let strouhal = |frequency: f64| with_digits(frequency * scale, 3);
        match self {
            NoLine::FewRows => "the interval has fewer than 32 rows".to_owned(),
            NoLine::Constant => "the lift is steady up to rounding".to_owned(),
            NoLine::Noise { largest: None } => "no line stands out of the noise".to_owned(),
            NoLine::Noise { largest: Some((frequency, ratio)) } => format!(
                "no line stands out of the noise: the largest, at {}, has {} times the power of its surroundings, \
                 {LEAST_RATIO} is wanted",
                strouhal(frequency),
                with_digits(ratio, 2)
            ),
            NoLine::Slow => format!(
                "the lift drifts, or oscillates with fewer than {LEAST_PERIODS} periods in the interval: begin `mean` \
                 later or lengthen it"
            ),
            NoLine::Changing { frequency, halves: [first, second] } => format!(
                "the oscillation at {} has amplitude {} in the first half of the interval, {} in the second: begin \
                 `mean` later or lengthen it",
                strouhal(frequency),
                with_digits(first, 3),
                with_digits(second, 3)
            ),
            NoLine::Sound { frequency, lowest, share } => format!(
                "the line at {} may be sound, which begins at {} in this domain: it has {} % of the variance, {} % is \
                 wanted; another `sound_speed` moves sound, not vortices",
                strouhal(frequency),
                strouhal(lowest),
                with_digits(100.0 * share, 2),
                significant(100.0 * DOMINANT)
            ),
        }
    }
}

/// Returns the line of vortex shedding in a lift at times, s.
///
/// # Errors
/// [`NoLine`], the reason why there is none.
pub fn shedding_line(times: &[f64], lift: &[f64], limits: SoundLimits) -> Result<Line, NoLine> {
    let series = Series::new(times, lift, limits.compact).ok_or(NoLine::FewRows)?;
    if series.is_constant {
        return Err(NoLine::Constant);
    }
    let spectrum = series.spectrum(4.0 * limits.compact);
    let first = LEAST_PERIODS / series.length;
    let is_maximum = |k: &usize| spectrum[*k].1 > spectrum[k - 1].1 && spectrum[*k].1 >= spectrum[k + 1].1;
    let in_range = |k: &usize| (first..=limits.compact).contains(&spectrum[*k].0);
    let maxima = (1..spectrum.len().saturating_sub(1)).filter(in_range).filter(is_maximum);
    let slowest = spectrum.iter().filter(|(f, _)| *f < first).map(|(_, power)| *power).fold(0.0, f64::max);
    let Some(best) = maxima.max_by(|&a, &b| spectrum[a].1.total_cmp(&spectrum[b].1)) else {
        let is_slow = slowest > spectrum.iter().filter(|(f, _)| *f >= first).map(|(_, power)| *power).sum();
        return Err(if is_slow { NoLine::Slow } else { NoLine::Noise { largest: None } });
    };
    let (frequency, power) = spectrum[best];
    let ratio = power / background(&spectrum, frequency, series.length);
    // NaN, of a force that is not finite, is no line.
    if ratio.is_nan() || ratio < LEAST_RATIO {
        let is_slow = slowest > LEAST_RATIO * power;
        return Err(if is_slow { NoLine::Slow } else { NoLine::Noise { largest: Some((frequency, ratio)) } });
    }
    let frequency = series.refined(frequency);
    lasting(times, lift, frequency, limits)?;
    let share = share(&spectrum, frequency, series.length, limits.compact);
    let above_sound = (frequency > limits.lowest).then_some(limits.lowest);
    if let Some(lowest) = above_sound.filter(|_| share < DOMINANT) {
        return Err(NoLine::Sound { frequency, lowest, share });
    }
    Ok(Line { frequency, periods: frequency * series.length, above_sound })
}

/// Returns the larger median of the spectrum on either side of a line, up to a quarter and to four
/// times its frequency, 1/s.
///
/// The larger one keeps a steep spectrum, as of a drift, from making a line of its own slope.
fn background(spectrum: &[(f64, f64)], frequency: f64, length: f64) -> f64 {
    let width = HALF_WIDTH / length;
    let median = |from: f64, to: f64| {
        let within = |(f, power): &(f64, f64)| (from..=to).contains(f).then_some(*power);
        let mut powers: Vec<f64> = spectrum.iter().filter_map(within).collect();
        powers.sort_by(f64::total_cmp);
        powers.get(powers.len() / 2).copied().unwrap_or(0.0)
    };
    median(0.25 * frequency, frequency - width).max(median(frequency + width, 4.0 * frequency))
}

/// Returns the share of the line and its second harmonic in the variance up to `highest`, 1/s.
fn share(spectrum: &[(f64, f64)], frequency: f64, length: f64, highest: f64) -> f64 {
    let near = |f: f64, line: f64| (f - line).abs() <= HALF_WIDTH / length;
    let (mut of_line, mut total) = (0.0, 0.0);
    for &(f, power) in spectrum.iter().take_while(|(f, _)| *f <= highest) {
        total += power;
        if near(f, frequency) || near(f, 2.0 * frequency) {
            of_line += power;
        }
    }
    of_line / total
}

/// Checks that a line has about the same amplitude in both halves of the interval.
fn lasting(times: &[f64], lift: &[f64], frequency: f64, limits: SoundLimits) -> Result<(), NoLine> {
    let (Some(first), Some(last)) = (times.first(), times.last()) else { return Err(NoLine::FewRows) };
    let middle = times.partition_point(|&t| t < 0.5 * (first + last));
    let half = |times: &[f64], lift: &[f64]| {
        Series::new(times, lift, limits.compact).map(|series| series.amplitude_near(frequency))
    };
    let first = half(&times[..middle], &lift[..middle]).ok_or(NoLine::FewRows)?;
    let second = half(&times[middle..], &lift[middle..]).ok_or(NoLine::FewRows)?;
    if first.min(second) < LASTING * first.max(second) {
        return Err(NoLine::Changing { frequency, halves: [first, second] });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// Sound from 0.4 1/s on, vortices up to 1 1/s.
    const LIMITS: SoundLimits = SoundLimits { compact: 1.0, lowest: 0.4 };

    /// Rows 0.02 s apart, with steps that vary.
    fn times(length: f64) -> Vec<f64> {
        (0..(50.0 * length) as u32).map(|k| 0.02 * (f64::from(k) + 0.5 * f64::from(k % 7) / 7.0)).collect()
    }

    /// Noise from −1 to 1 by a linear congruential generator.
    fn noise(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        }
    }

    fn line(length: f64, lift: impl FnMut(f64) -> f64) -> Result<Line, NoLine> {
        let times = times(length);
        let lift: Vec<f64> = times.iter().copied().map(lift).collect();
        shedding_line(&times, &lift, LIMITS)
    }

    fn assert_frequency(found: Result<Line, NoLine>, frequency: f64) {
        let found = found.expect("a line").frequency;
        assert!((found / frequency - 1.0).abs() < 2e-3, "{found}, not {frequency}");
    }

    #[test]
    fn sine_below_strong_sound_is_found() {
        // Three resonances of the domain, each stronger than the lift, above the highest frequency
        // of vortices.
        let mut noise = noise(1);
        let sound =
            |t: f64| 2.0 * (TAU * 1.9 * t).sin() + 1.5 * (TAU * 4.6 * t).cos() + (TAU * 9.3 * t).sin();
        let found = line(60.0, |t| (TAU * 0.2053 * t + 0.3).sin() + sound(t) + noise());
        assert_frequency(found, 0.2053);
        assert_eq!(found.expect("a line").above_sound, None);
    }

    #[test]
    fn noise_has_no_line() {
        for seed in 0..200 {
            let mut noise = noise(seed);
            let found = line(40.0, |_| 1.0 + noise());
            assert!(matches!(found, Err(NoLine::Noise { .. })), "{seed}: {found:?}");
        }
    }

    #[test]
    fn random_walk_has_no_line() {
        for seed in 0..100 {
            let (mut noise, mut at) = (noise(seed), 0.0);
            let found = line(60.0, |_| {
                at += noise();
                at
            });
            assert!(found.is_err(), "{seed}: {found:?}");
        }
    }

    #[test]
    fn drift_has_no_line() {
        assert_eq!(line(40.0, |t| 0.3 * t), Err(NoLine::Constant));
        assert_eq!(line(40.0, |t| (-t / 8.0).exp()), Err(NoLine::Slow));
        let mut noise = noise(5);
        assert_eq!(line(40.0, |t| 20.0 * (-t / 8.0).exp() + 0.1 * noise()), Err(NoLine::Slow));
    }

    #[test]
    fn larger_of_two_lines_is_found() {
        let two =
            |a: f64, b: f64| line(60.0, move |t| a * (TAU * 0.15 * t).sin() + b * (TAU * 0.31 * t).sin());
        assert_frequency(two(1.0, 0.5), 0.15);
        assert_frequency(two(0.5, 1.0), 0.31);
    }

    #[test]
    fn short_record_has_no_line() {
        assert_eq!(line(15.0, |t| (TAU * 0.2 * t).sin()), Err(NoLine::Slow));
        assert_frequency(line(25.0, |t| (TAU * 0.2 * t).sin()), 0.2);
        assert_eq!(line(0.5, |t| (TAU * 0.2 * t).sin()), Err(NoLine::FewRows));
    }

    #[test]
    fn steady_force_with_rounding_has_no_line() {
        assert_eq!(line(40.0, |_| 2.0), Err(NoLine::Constant));
        assert_eq!(line(40.0, |_| 0.0), Err(NoLine::Constant));
        let mut noise = noise(3);
        let found = line(40.0, |_| f64::from((1.37 + 1e-7 * noise()) as f32));
        assert!(matches!(found, Err(NoLine::Noise { .. })), "{found:?}");
    }

    #[test]
    fn force_that_is_not_finite_has_no_line() {
        assert!(line(40.0, |t| if t > 20.0 { f64::NAN } else { (TAU * 0.2 * t).sin() }).is_err());
    }

    #[test]
    fn oscillation_that_begins_or_dies_has_no_line() {
        let begun = line(60.0, |t| if t > 30.0 { (TAU * 0.25 * t).sin() } else { 0.0 });
        assert!(matches!(begun, Err(NoLine::Changing { halves, .. }) if halves[1] > 0.9), "{begun:?}");
        let mut noise = noise(9);
        let dying = line(60.0, |t| (-t / 10.0).exp() * (TAU * 0.25 * t).sin() + 1e-2 * noise());
        assert!(matches!(dying, Err(NoLine::Changing { .. })), "{dying:?}");
    }

    #[test]
    fn line_among_resonances_must_dominate() {
        let with = |own: f64| {
            let mut noise = noise(4);
            let sound = |t: f64| 0.8 * (TAU * 0.62 * t).sin() + 0.7 * (TAU * 0.76 * t + 1.0).sin();
            line(60.0, move |t| own * (TAU * 0.45 * t).sin() + sound(t) + 0.1 * noise())
        };
        assert!(matches!(with(0.9), Err(NoLine::Sound { lowest: 0.4, .. })), "{:?}", with(0.9));
        assert_frequency(with(2.0), 0.45);
        assert_eq!(with(2.0).expect("a line").above_sound, Some(0.4));
    }

    #[test]
    fn reasons_have_the_figures_as_strouhal_numbers() {
        let text = NoLine::Noise { largest: Some((3.0, 12.4)) }.text(0.1);
        assert!(text.contains("at 0.3, has 12 times") && text.contains("30 is wanted"), "{text}");
        let text = NoLine::Sound { frequency: 20.0, lowest: 8.33, share: 0.2 }.text(0.1);
        assert!(text.contains("at 2 may be sound, which begins at 0.833") && text.contains("20 %"), "{text}");
    }
}
