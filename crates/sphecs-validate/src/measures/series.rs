//! Columns over time and their statistics.

use super::{FORCES, MONITOR, RunResults, slope};
use crate::schema::{CoefficientFile, SignalFile, TakeFile};

/// Returns times, s, and values of a column of the monitor, of the forces on bodies or of a probe;
/// the mean over its points if it has several.
///
/// # Errors
/// There is no such column.
pub fn column(run: &RunResults, table: &str, column: &str) -> Result<(Vec<f64>, Vec<f64>), String> {
    if table != MONITOR && table != FORCES {
        let probe = run.probe(table)?;
        let values = probe.column(column).ok_or_else(|| format!("probe `{table}` has no `{column}`"))?;
        let points = probe.places.len().max(1);
        let means = values.chunks(points).map(|sample| sample.iter().sum::<f64>() / points as f64);
        return Ok((probe.times.clone(), means.collect()));
    }
    let (columns, what) = match table {
        MONITOR => (&run.monitor, "the monitor has"),
        _ => (&run.forces.columns, "the forces on bodies have"),
    };
    let of = |name: &str| columns.iter().find(|(known, _)| known == name).map(|(_, values)| values.clone());
    let values = of(column).ok_or_else(|| format!("{what} no `{column}`"))?;
    Ok((of("time").ok_or_else(|| format!("{what} no times"))?, values))
}

/// Returns a coefficient of a body over the interval given by its scene.
///
/// # Errors
/// The run has no such body, or one without coefficients.
pub fn coefficient(run: &RunResults, body: &str, take: CoefficientFile) -> Result<f64, String> {
    let found = run.forces.means.iter().find(|(name, _)| name == body);
    let (_, means) = found.ok_or_else(|| format!("the run has no coefficients of a body `{body}`"))?;
    Ok(means.get(match take {
        CoefficientFile::DragMean => "c_d_mean",
        CoefficientFile::DragAmplitude => "c_d_amplitude",
        CoefficientFile::LiftMean => "c_l_mean",
        CoefficientFile::LiftAmplitude => "c_l_amplitude",
        CoefficientFile::Strouhal => "strouhal",
        CoefficientFile::DragFittedAmplitude => "c_d_fitted_amplitude",
        CoefficientFile::LiftFittedAmplitude => "c_l_fitted_amplitude",
        CoefficientFile::DragRms => "c_d_rms",
        CoefficientFile::LiftRms => "c_l_rms",
    }))
}

/// Returns a statistic of a column in an interval, s.
///
/// # Errors
/// The interval has no samples.
pub fn statistic(times: &[f64], values: &[f64], over: (f64, f64), take: TakeFile) -> Result<f64, String> {
    let inside: Vec<(f64, f64)> = times
        .iter()
        .copied()
        .zip(values.iter().copied())
        .filter(|(time, _)| (over.0..=over.1).contains(time))
        .collect();
    let Some(&(_, last)) = inside.last() else {
        return Err(format!("no samples from {} to {} s", over.0, over.1));
    };
    let all = || inside.iter().map(|(_, value)| *value);
    let mean = all().sum::<f64>() / inside.len() as f64;
    // NaN must not be hidden.
    let extreme = |better: fn(f64, f64) -> bool| {
        all()
            .fold(inside[0].1, |best, value| if better(value, best) || value.is_nan() { value } else { best })
    };
    Ok(match take {
        TakeFile::Mean => mean,
        TakeFile::Deviation => {
            (all().map(|value| (value - mean).powi(2)).sum::<f64>() / inside.len() as f64).sqrt()
        }
        TakeFile::Largest => extreme(|value, best| value > best),
        TakeFile::Smallest => extreme(|value, best| value < best),
        TakeFile::Last => last,
        TakeFile::Drift => slope(&inside),
    })
}

/// Times, s, and values of a column.
type SeriesColumn<'a> = (&'a [f64], &'a [f64]);

/// Returns a comparison of a column with a function of time in an interval, s.
///
/// # Errors
/// The interval has no samples, or the function is 0 at all of them.
pub fn signal(
    (times, values): SeriesColumn<'_>,
    over: (f64, f64),
    function: impl Fn(f64) -> f64,
    take: SignalFile,
) -> Result<f64, String> {
    let inside = times.iter().zip(values).filter(|(time, _)| (over.0..=over.1).contains(*time));
    let pairs: Vec<(f64, f64)> = inside.map(|(time, value)| (*value, function(*time))).collect();
    if pairs.is_empty() {
        return Err(format!("no samples from {} to {} s", over.0, over.1));
    }
    let squares = pairs.iter().map(|(value, expected)| (value - expected).powi(2)).sum::<f64>();
    Ok(match take {
        SignalFile::Factor => {
            let product = pairs.iter().map(|(value, expected)| value * expected).sum::<f64>();
            let square = pairs.iter().map(|(_, expected)| expected * expected).sum::<f64>();
            if square == 0.0 {
                return Err(format!("the reference is 0 from {} to {} s", over.0, over.1));
            }
            product / square
        }
        SignalFile::RootMeanSquare => (squares / pairs.len() as f64).sqrt(),
        // NaN must not be hidden.
        SignalFile::Largest => pairs
            .iter()
            .map(|(value, expected)| (value - expected).abs())
            .fold(0.0, |largest: f64, error| if error > largest || error.is_nan() { error } else { largest }),
    })
}

/// Returns √(Σ (f − f_other)²/Σ f_other²) over the samples of the first column in an interval (s).
///
/// Samples outside the times of the other column are omitted.
///
/// # Errors
/// There is no sample to compare, or the other column is 0 throughout.
pub fn departure(
    (times, values): SeriesColumn<'_>,
    (other_times, other): SeriesColumn<'_>,
    over: (f64, f64),
) -> Result<f64, String> {
    let (mut squares, mut reference) = (0.0, 0.0);
    for (&time, &value) in times.iter().zip(values).filter(|(time, _)| (over.0..=over.1).contains(*time)) {
        let after = other_times.partition_point(|&other| other < time);
        let expected = match (after.checked_sub(1), other_times.get(after)) {
            (_, Some(&at)) if at == time => other[after],
            (Some(before), Some(&at)) => {
                let share = (time - other_times[before]) / (at - other_times[before]);
                other[before] + share * (other[after] - other[before])
            }
            _ => continue,
        };
        squares += (value - expected).powi(2);
        reference += expected * expected;
    }
    if reference > 0.0 {
        Ok((squares / reference).sqrt())
    } else {
        Err(format!("the other run has only 0 from {} to {} s", over.0, over.1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn departure_is_relative_to_the_other_run_and_interpolated() {
        let other = (&[0.0, 2.0, 4.0][..], &[0.0, 4.0, 8.0][..]);
        let of = |values: [f64; 3], over| departure((&[1.0, 2.0, 3.0], &values), other, over);
        assert_eq!(of([2.0, 4.0, 6.0], (0.0, 4.0)), Ok(0.0));
        assert_eq!(of([2.0, 4.0, 9.0], (2.5, 9.0)), Ok(0.5));
        assert_eq!(of([4.0, 0.0, 6.0], (0.0, 2.5)), Ok((20.0_f64 / 20.0).sqrt()));
        // Samples after the end of the other are omitted; without any other there is no value.
        assert_eq!(departure((&[3.0, 5.0], &[6.0, 77.0]), other, (0.0, 9.0)), Ok(0.0));
        assert!(departure((&[5.0], &[77.0]), other, (0.0, 9.0)).is_err());
    }

    #[test]
    fn signal_is_compared_with_a_function_of_time() {
        let column = (&[0.0, 1.0, 2.0, 3.0][..], &[50.0, 2.0, 4.0, 7.0][..]);
        let of = |take| signal(column, (1.0, 3.0), |time| 2.0 * time, take).expect("a value");
        assert!((of(SignalFile::Factor) - (4.0 + 16.0 + 42.0) / 56.0).abs() < 1e-15);
        assert!((of(SignalFile::RootMeanSquare) - (1.0_f64 / 3.0).sqrt()).abs() < 1e-15);
        assert_eq!(of(SignalFile::Largest), 1.0);
        assert!(signal(column, (4.0, 5.0), |_| 1.0, SignalFile::Largest).is_err());
        assert!(signal(column, (1.0, 3.0), |_| 0.0, SignalFile::Factor).is_err());
    }

    #[test]
    fn statistics_use_the_interval_only() {
        let times = [0.0, 1.0, 2.0, 3.0, 4.0];
        let values = [100.0, 1.0, 5.0, 3.0, -100.0];
        let of = |what| statistic(&times, &values, (1.0, 3.0), what).expect("a value");
        assert_eq!(of(TakeFile::Mean), 3.0);
        assert_eq!((of(TakeFile::Largest), of(TakeFile::Smallest), of(TakeFile::Last)), (5.0, 1.0, 3.0));
        assert!((of(TakeFile::Deviation) - (8.0_f64 / 3.0).sqrt()).abs() < 1e-15);
        assert_eq!(of(TakeFile::Drift), 1.0);
        assert!(statistic(&times, &values, (5.0, 6.0), TakeFile::Mean).is_err());
    }
}
