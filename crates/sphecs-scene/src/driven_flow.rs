//! Flow that pressures drive, before a run: their range, and the speed that they can cause.
//!
//! ```text
//! v = min(√(2 Δp/ρ0), Δp D²/(32 μ L))
//! ```
//!
//! The first is the speed of an ideal fluid (Bernoulli), the second the mean speed in a pipe of
//! diameter D and length L (Hagen–Poiseuille), μ = ρ0 ν. D is the largest hydraulic diameter of the
//! openings and L their largest distance. Both are upper bounds of an order of magnitude.

use super::model::{Outlet, Scene};
use super::sampled_times::largest_in_time;

/// Returns the largest difference of the pressures that the openings of a scene are given, Pa, at
/// one time of the run; 0 unless two openings have given pressures.
pub fn pressure_difference(scene: &Scene) -> f64 {
    let driven: Vec<&Outlet> = scene.outlets.iter().filter(|outlet| sets_pressure(outlet)).collect();
    if driven.len() < 2 {
        return 0.0;
    }
    let pressure = |outlet: &Outlet, time: f64| match &outlet.given {
        Some(given) => given.at(time),
        None => outlet.condition.parameters().references().pressure,
    };
    let spread = |time: f64| {
        let (low, high) = driven
            .iter()
            .map(|outlet| pressure(outlet, time))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
        high - low
    };
    largest_in_time(scene.time.end, spread).max(0.0)
}

/// Returns true if an outlet has a pressure that drives a flow.
fn sets_pressure(outlet: &Outlet) -> bool {
    outlet.condition.parameters().needs().uses_through_flow
}

/// Returns the largest pressure in absolute value that an opening is given, Pa.
pub fn largest_pressure(scene: &Scene) -> f64 {
    let given = scene.outlets.iter().filter_map(|outlet| outlet.given.as_ref());
    given.map(|given| largest_in_time(scene.time.end, |time| given.at(time).abs())).fold(0.0, f64::max)
}

/// Returns an estimate of the largest speed that the given pressures cause, m/s.
pub fn driven_speed(scene: &Scene) -> f64 {
    let (difference, density) = (pressure_difference(scene), scene.fluid.density);
    let ideal = (2.0 * difference / density).sqrt();
    let outlets = || scene.outlets.iter().map(|outlet| &outlet.patch);
    let length = outlets().flat_map(|one| outlets().map(|two| one.at.distance(two.at))).fold(0.0, f64::max);
    let diameter = outlets().map(|patch| patch.hydraulic_diameter()).fold(0.0, f64::max);
    let viscosity = density * scene.fluid.viscosity;
    let viscous = difference * diameter * diameter / (32.0 * viscosity * length);
    if viscous.is_finite() && scene.layout.walled { ideal.min(viscous) } else { ideal }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speed_of_a_viscous_flow_follows_from_the_difference_of_pressures() {
        let text = r#"Scene(
    title: "Driven", dimensions: 2, spacing: 0.0005,
    fluid: (density: 1000.0, viscosity: 1e-5, sound_speed: 2.0),
    domain: Box(min: (0.0, 0.0), max: (0.1, 0.01)),
    outlets: [
        (at: (0.1, 0.005), towards: (1.0, 0.0), condition: Pressure(value: 20.0)),
        (at: (0.0, 0.005), towards: (-1.0, 0.0), condition: Pressure(value: "20 + 4*sin(pi*t)")),
    ],
    time: (end: 1.0), output: (every: 0.5),
)"#;
        let scene = Scene::from_text("driven", text.to_owned()).load().expect("a scene");
        assert!((pressure_difference(&scene) - 4.0).abs() < 1e-4);
        assert!((largest_pressure(&scene) - 24.0).abs() < 1e-4);
        // Between plates the mean speed is Δp D²/(48 μ L), the peak 1.5 times that.
        assert!((driven_speed(&scene) - 4.0 * 4e-4 / (32.0 * 0.01 * 0.1)).abs() < 1e-3);
        assert!((scene.reference_velocity - driven_speed(&scene)).abs() < 1e-12);
    }
}
