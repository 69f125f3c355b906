//! Law of the wall: friction of a wall whose boundary layer is thinner than the spacing.
//!
//! ```text
//! y⁺ = u⁺ + e^(−κB) [e^(κu⁺) − 1 − κu⁺ − (κu⁺)²/2 − (κu⁺)³/6]
//! u⁺ = u/u_τ,  y⁺ = y u_τ/ν,  τ_w = ρ u_τ²
//! ```
//!
//! This is the law of Spalding (1961) with his κ = 0.4 and B = 5.5 (e^(−κB) = 0.1108). The term of
//! the fourth power is omitted, which he says fits as well. One formula covers the viscous
//! sublayer, u⁺ = y⁺, and the logarithmic layer, u⁺ = ln(y⁺)/κ + B. Given y and u(y), it is solved
//! for u⁺ in u⁺ y⁺(u⁺) = u y/ν.

/// von Kármán's constant.
const KAPPA: f64 = 0.4;

/// The constant of the logarithmic law.
const B: f64 = 5.5;

/// Largest number of steps of Newton's method; six suffice from its first guess for u y/ν of 1e-12
/// to 1e12.
const MAX_STEPS: usize = 30;

/// Relative change of u⁺ at which the method ends.
const TOLERANCE: f64 = 1e-14;

/// Returns y⁺ of u⁺ and its derivative.
fn distance(u_plus: f64) -> (f64, f64) {
    let s = KAPPA * u_plus;
    let e = (-KAPPA * B).exp();
    // The bracket loses all its digits where s is small; its series there is s⁴/24 (1 + s/5 + s²/30
    // …).
    let (rest, slope) = if s < 0.1 {
        let series = 1.0 + s / 5.0 * (1.0 + s / 6.0 * (1.0 + s / 7.0 * (1.0 + s / 8.0)));
        let of_slope = 1.0 + s / 4.0 * (1.0 + s / 5.0 * (1.0 + s / 6.0 * (1.0 + s / 7.0)));
        (s.powi(4) / 24.0 * series, s.powi(3) / 6.0 * of_slope)
    } else {
        (s.exp() - 1.0 - s - s * s / 2.0 - s.powi(3) / 6.0, s.exp() - 1.0 - s - s * s / 2.0)
    };
    (u_plus + e * rest, 1.0 + KAPPA * e * slope)
}

/// Returns u_τ, m/s, for a tangential speed (m/s) at a distance (m) from the wall; 0 at rest and
/// for an inviscid fluid.
pub fn friction_velocity(speed: f64, y: f64, viscosity: f64) -> f64 {
    let reynolds = speed * y / viscosity;
    if !(reynolds > 0.0 && reynolds.is_finite()) {
        return 0.0;
    }
    // u⁺ ≤ √(u y/ν), since y⁺ ≥ u⁺; for u⁺ ≥ 1 about the logarithm at y⁺ = u y/ν.
    let mut u_plus = reynolds.sqrt().min((1.0 + reynolds).ln() / KAPPA + B);
    for _ in 0..MAX_STEPS {
        let (y_plus, slope) = distance(u_plus);
        // Newton's method for ln(u⁺ y⁺) = ln(u y/ν) in ln u⁺: nearly a straight line where u⁺ = y⁺.
        let step = -(u_plus * y_plus / reynolds).ln() / (1.0 + u_plus * slope / y_plus);
        u_plus *= step.exp();
        if step.abs() < TOLERANCE {
            break;
        }
    }
    speed / u_plus
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks u_τ for speed and distance in wall units, for ν = 1.
    fn check(u_plus: f64, y_plus: f64, u_tau: f64, tolerance: f64) {
        let found = friction_velocity(u_plus * u_tau, y_plus / u_tau, 1.0);
        assert!((found / u_tau - 1.0).abs() < tolerance, "{found}, not {u_tau}, at y+ = {y_plus}");
    }

    #[test]
    fn the_sublayer_is_linear() {
        for y_plus in [1e-6, 1e-3, 0.1, 1.0] {
            check(y_plus, y_plus, 0.3, 1e-3);
        }
        // A shear of u/y: τ = ρ ν u/y.
        let u_tau = friction_velocity(1e-3, 2.0, 5.0);
        assert!((u_tau * u_tau / (5.0 * 1e-3 / 2.0) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn the_outer_layer_is_logarithmic() {
        for y_plus in [300.0, 1e3, 1e5] {
            check(f64::ln(y_plus) / KAPPA + B, y_plus, 0.05, 1e-2);
        }
    }

    #[test]
    fn the_equation_is_solved_for_any_reynolds_number() {
        let mut before = 0.0;
        for power in -24..=24 {
            let reynolds = 10_f64.powf(0.5 * f64::from(power));
            let u_tau = friction_velocity(reynolds, 1.0, 1.0);
            let (y_plus, _) = distance(reynolds / u_tau);
            assert!((y_plus / u_tau - 1.0).abs() < 1e-12, "u y/ν = {reynolds}: {y_plus}, not {u_tau}");
            assert!(u_tau > before);
            before = u_tau;
        }
    }

    #[test]
    fn the_slope_is_the_derivative_on_both_sides_of_the_series() {
        for u_plus in [0.01, 0.2499, 0.2501, 3.0, 20.0] {
            let step = 1e-5 * u_plus;
            let slope = (distance(u_plus + step).0 - distance(u_plus - step).0) / (2.0 * step);
            assert!((distance(u_plus).1 / slope - 1.0).abs() < 1e-8, "u+ = {u_plus}");
        }
        let (below, above) = (distance(0.25 - 1e-12), distance(0.25 + 1e-12));
        assert!((below.0 - above.0).abs() < 1e-11 && (below.1 - above.1).abs() < 1e-10);
    }

    #[test]
    fn there_is_no_friction_at_rest_or_without_viscosity() {
        assert_eq!(friction_velocity(0.0, 0.1, 1e-6), 0.0);
        assert_eq!(friction_velocity(1.0, 0.1, 0.0), 0.0);
    }
}
