//! Start-up of plane Poiseuille flow from rest.
//!
//! ```text
//! v(y, t) = f/(2ν) (d² − y²)
//!         − Σ_n 16 (−1)^n d² f/(ν π³ (2n+1)³) cos((2n+1)πy/(2d)) exp(−(2n+1)² π² ν t/(4d²))
//! ```
//!
//! This is the series of Morris et al. (1997), as in Alvarado-Rodríguez et al. (2017), Eq. 31. The
//! walls are at y = ± d, and f is the force per mass along the flow. With F = −f = −2 ν v0/d² their
//! series is this one.

use std::f64::consts::PI;

/// Returns the velocity, m/s, at a distance `y` (m) from the centre and a time `t` (s). The walls
/// are at ± `half_width` (m); `body_force` is per mass (m/s²), the viscosity kinematic (m²/s). It
/// is 0 outside the gap.
pub fn startup_velocity(y: f64, t: f64, half_width: f64, body_force: f64, viscosity: f64) -> f64 {
    let d = half_width;
    if y.abs() >= d || t <= 0.0 {
        return 0.0;
    }
    let steady = body_force / (2.0 * viscosity) * (d * d - y * y);
    let scale = 16.0 * d * d * body_force / (viscosity * PI.powi(3));
    let mut transient = 0.0;
    let mut sign = 1.0;
    for n in 0..2000 {
        let k = f64::from(2 * n + 1);
        let decay = (-k * k * PI * PI * viscosity * t / (4.0 * d * d)).exp();
        transient += sign * (k * PI * y / (2.0 * d)).cos() * decay / (k * k * k);
        sign = -sign;
        // The next term is smaller than the rounding error of the sum.
        if decay / (k * k * k) < 1e-17 {
            break;
        }
    }
    steady - scale * transient
}

#[cfg(test)]
mod tests {
    use super::*;

    const HALF: f64 = 5e-4;
    const FORCE: f64 = 1e-4;
    const NU: f64 = 1e-6;

    #[test]
    fn matches_the_reference_table() {
        // y (m), then v (m/s) at 0.01, 0.03, 0.07, 0.15 and 1 s: assets/poiseuille_startup.csv.
        let rows = [
            (-2.5e-4, [9.77614425e-07, 2.56721121e-06, 4.80288311e-06, 7.29937792e-06, 9.37452818e-06]),
            (0.0, [9.99903717e-07, 2.93872984e-06, 6.03595529e-06, 9.56462867e-06, 1.24993327e-05]),
        ];
        for (y, speeds) in rows {
            for (t, expected) in [0.01, 0.03, 0.07, 0.15, 1.0].into_iter().zip(speeds) {
                let v = startup_velocity(y, t, HALF, FORCE, NU);
                assert!((v - expected).abs() < 1e-8 * 1.25e-5, "v({y}, {t}) = {v}, not {expected}");
            }
        }
    }

    #[test]
    fn satisfies_the_momentum_equation() {
        let (y, t, dy, dt) = (1.3e-4, 0.07, 1e-6, 1e-4);
        let v = |y: f64, t: f64| startup_velocity(y, t, HALF, FORCE, NU);
        let rate = (v(y, t + dt) - v(y, t - dt)) / (2.0 * dt);
        let laplacian = (v(y + dy, t) - 2.0 * v(y, t) + v(y - dy, t)) / (dy * dy);
        // Second-order differences in dt over a decay time of 0.1 s leave 1e-6 of f.
        assert!((rate - FORCE - NU * laplacian).abs() < 1e-4 * FORCE);
    }

    #[test]
    fn the_flow_starts_from_rest_and_does_not_slip() {
        assert_eq!(startup_velocity(1e-4, 0.0, HALF, FORCE, NU), 0.0);
        assert!(startup_velocity(0.999_999 * HALF, 0.5, HALF, FORCE, NU).abs() < 1e-10);
    }
}
