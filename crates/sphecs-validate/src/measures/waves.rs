//! Growth rate and reflection coefficient of waves.

use std::f64::consts::TAU;

use super::fields::column;
use super::slope;
use crate::schema::FieldFile;
use sphecs_output::probes::history::ProbeHistory;

/// Smallest number of samples for a growth rate.
const MIN_SAMPLES: usize = 4;

/// Returns the complex amplitude 2 Σ f exp(−i k x)/N of a wave along a line at each sample.
///
/// The last point of the line is the first of the next period. For a single point the amplitude is
/// its deviation from the first sample.
fn amplitudes(probe: &ProbeHistory, column: &[f64], waves: f64) -> Vec<(f64, f64)> {
    if probe.places.len() == 1 {
        return column.iter().map(|value| (value - column[0], 0.0)).collect();
    }
    let points = probe.places.len() - 1;
    let amplitude = |values: &[f64]| {
        let (mut real, mut imaginary) = (0.0, 0.0);
        for (point, value) in values.iter().take(points).enumerate() {
            let (sine, cosine) = (TAU * waves * point as f64 / points as f64).sin_cos();
            real += value * cosine;
            imaginary -= value * sine;
        }
        (2.0 * real / points as f64, 2.0 * imaginary / points as f64)
    };
    column.chunks_exact(points + 1).map(amplitude).collect()
}

/// Returns the growth rate of a wave along a line, 1/s, as the least-squares slope of the logarithm
/// of its amplitude.
///
/// The fit starts where the amplitude exceeds the lower bound and ends where it exceeds the upper
/// one.
///
/// # Errors
/// Too few samples are between the bounds.
pub fn growth(probe: &ProbeHistory, column: &[f64], waves: f64, between: (f64, f64)) -> Result<f64, String> {
    let mut fitted = Vec::new();
    for (&time, (real, imaginary)) in probe.times.iter().zip(amplitudes(probe, column, waves)) {
        let amplitude = f64::hypot(real, imaginary);
        if amplitude > between.1 {
            break;
        }
        if amplitude >= between.0 {
            fitted.push((time, amplitude.ln()));
        }
    }
    if fitted.len() < MIN_SAMPLES {
        let (low, high) = between;
        return Err(format!("the amplitude is between {low} and {high} in only {} samples", fitted.len()));
    }
    Ok(slope(&fitted))
}

/// Returns the reflection coefficient, largest |p' − Z u'| in the second interval (s) over largest
/// |p' + Z u'| in the first.
///
/// Measured at a point or for a wave along a line across, with the velocity of a field;
/// `impedance` Z = ρ c/cos θ in kg/(m² s).
///
/// # Errors
/// The probe has no such fields or times.
pub fn reflection(
    probe: &ProbeHistory,
    velocity: &FieldFile,
    waves: f64,
    impedance: f64,
    [incident, reflected]: [(f64, f64); 2],
) -> Result<f64, String> {
    let pressure = amplitudes(probe, &column(probe, &FieldFile::Pressure)?, waves);
    let velocity = amplitudes(probe, &column(probe, velocity)?, waves);
    let largest = |(from, to): (f64, f64), sign: f64| {
        let inside = (0..probe.times.len()).filter(|&index| (from..=to).contains(&probe.times[index]));
        let characteristic = |at: usize| {
            let part = |p: f64, u: f64| p + sign * impedance * u;
            f64::hypot(part(pressure[at].0, velocity[at].0), part(pressure[at].1, velocity[at].1))
        };
        inside.map(characteristic).fold(f64::NAN, f64::max)
    };
    Ok(largest(reflected, -1.0) / largest(incident, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn growth_rate_is_found_below_saturation() {
        let times: Vec<f64> = (0..60).map(|n| 0.01 * f64::from(n)).collect();
        let places: Vec<[f64; 3]> = (0..41).map(|n| [0.01 * f64::from(n), 0.0, 0.0]).collect();
        let values = |t: f64| {
            let amplitude = (1e-3 * (12.0 * t).exp()).min(0.1);
            places
                .iter()
                .map(move |[x, ..]| amplitude * (TAU * 4.0 * x / 0.4 + 3.0 * t).sin() + 0.3)
                .collect::<Vec<_>>()
        };
        let column = times.iter().flat_map(|&t| values(t)).collect();
        let probe = ProbeHistory {
            places: places.clone(),
            times: times.clone(),
            columns: vec![("v", column)],
            ..Default::default()
        };
        let rate = growth(&probe, probe.column("v").expect("v"), 4.0, (2e-3, 5e-2)).expect("a rate");
        assert!((rate - 12.0).abs() < 1e-6, "{rate}");
        assert!(growth(&probe, probe.column("v").expect("v"), 4.0, (0.9, 1.0)).is_err());
    }

    #[test]
    fn reflected_pulse_is_separated_from_the_incident_one() {
        let pulse = |t: f64, at: f64| (-((t - at) / 0.05_f64).powi(2)).exp();
        let times: Vec<f64> = (0..200).map(|n| 0.01 * f64::from(n)).collect();
        let (rho_c, reflection_coefficient) = (1500.0, -0.2);
        let pressure =
            times.iter().map(|&t| 7.0 + pulse(t, 0.5) + reflection_coefficient * pulse(t, 1.5)).collect();
        let velocity = times
            .iter()
            .map(|&t| 0.1 + (pulse(t, 0.5) - reflection_coefficient * pulse(t, 1.5)) / rho_c)
            .collect();
        let columns = vec![("u", velocity), ("pressure", pressure)];
        let probe = ProbeHistory { places: vec![[0.0; 3]], times, columns, ..Default::default() };
        let found =
            reflection(&probe, &FieldFile::U, 0.0, rho_c, [(0.0, 1.0), (1.0, 2.0)]).expect("a coefficient");
        assert!((found - 0.2).abs() < 1e-9, "{found}");
    }
}
