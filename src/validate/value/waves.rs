//! Waves: how fast one grows, how much of one comes back.

use std::f64::consts::TAU;

use super::slope;
use crate::output::probes::history::ProbeHistory;

/// Fewest samples that a growth rate is fitted to.
const FEWEST: usize = 4;

/// Growth rate, 1/s, of the wave with so many waves on a line whose last point is the first of the next period: slope of
/// the logarithm of the amplitude 2|Σ f exp(−i k x)|/N over time, by least squares, from the first time that the amplitude
/// is above the lower bound until it passes the upper one.
///
/// # Errors
/// That the amplitude is hardly ever between the bounds.
pub fn growth(probe: &ProbeHistory, field: &str, waves: f64, between: (f64, f64)) -> Result<f64, String> {
    let points = probe.places.len().saturating_sub(1);
    let mut fitted = Vec::new();
    for (index, &time) in probe.times.iter().enumerate() {
        let values =
            probe.sample(field, index).ok_or_else(|| format!("probe `{}` has no `{field}`", probe.name))?;
        let (mut cosine, mut sine) = (0.0, 0.0);
        for (point, value) in values.iter().take(points).enumerate() {
            let phase = TAU * waves * point as f64 / points as f64;
            cosine += value * phase.cos();
            sine += value * phase.sin();
        }
        let amplitude = 2.0 * f64::hypot(cosine, sine) / points as f64;
        if amplitude > between.1 {
            break;
        }
        if amplitude >= between.0 {
            fitted.push((time, amplitude.ln()));
        }
    }
    if fitted.len() < FEWEST {
        return Err(format!(
            "the amplitude is between {} and {} in {} samples only",
            between.0,
            between.1,
            fitted.len()
        ));
    }
    Ok(slope(&fitted))
}

/// Reflection coefficient at a point: largest |p' − ρ c u'| in the second interval over largest |p' + ρ c u'| in the first
/// (s), of the deviations from the first sample; `impedance` ρ c in kg/(m² s).
///
/// # Errors
/// That the probe has no such fields or times.
pub fn reflection(
    probe: &ProbeHistory,
    impedance: f64,
    [incident, reflected]: [(f64, f64); 2],
) -> Result<f64, String> {
    let column =
        |name: &str| probe.column(name).ok_or_else(|| format!("probe `{}` has no `{name}`", probe.name));
    let (pressure, velocity) = (column("pressure")?, column("u")?);
    if probe.places.len() != 1 {
        return Err(format!("probe `{}` has many points", probe.name));
    }
    let largest = |(from, to): (f64, f64), sign: f64| {
        let inside = (0..probe.times.len()).filter(|&index| (from..=to).contains(&probe.times[index]));
        let waves = inside
            .map(|at| (pressure[at] - pressure[0] + sign * impedance * (velocity[at] - velocity[0])).abs());
        waves.fold(f64::NAN, f64::max)
    };
    Ok(largest(reflected, -1.0) / largest(incident, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn growth_of_a_wave_is_found_below_its_saturation() {
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
        let rate = growth(&probe, "v", 4.0, (2e-3, 5e-2)).expect("a rate");
        assert!((rate - 12.0).abs() < 1e-6, "{rate}");
        assert!(growth(&probe, "v", 4.0, (0.9, 1.0)).is_err());
    }

    #[test]
    fn a_reflected_pulse_is_told_from_the_incident_one() {
        let pulse = |t: f64, at: f64| (-((t - at) / 0.05_f64).powi(2)).exp();
        let times: Vec<f64> = (0..200).map(|n| 0.01 * f64::from(n)).collect();
        let (rho_c, back) = (1500.0, -0.2);
        let pressure = times.iter().map(|&t| 7.0 + pulse(t, 0.5) + back * pulse(t, 1.5)).collect();
        let velocity = times.iter().map(|&t| 0.1 + (pulse(t, 0.5) - back * pulse(t, 1.5)) / rho_c).collect();
        let columns = vec![("u", velocity), ("pressure", pressure)];
        let probe = ProbeHistory { places: vec![[0.0; 3]], times, columns, ..Default::default() };
        let found = reflection(&probe, rho_c, [(0.0, 1.0), (1.0, 2.0)]).expect("a coefficient");
        assert!((found - 0.2).abs() < 1e-9, "{found}");
    }
}
