//! Plug flow between an inlet and an outlet, without walls: all particles have the same velocity.

use sphecs::Scene;

/// Plug flow whose uniform state is exact to the last digit.
///
/// The outlet pressure is fixed, since other conditions treat the start as a wave. Strong shifting
/// transforms the square lattice into a denser one; here it is weak enough to take longer than a
/// passage. The tag records position and time of the injection.
const SCENE: &str = r#"Scene(
    title: "Plug flow",
    dimensions: 2,
    spacing: 0.01,
    smoke: 0.01,
    constants: { "u": 0.1 },
    fluid: (density: 1000.0, viscosity: 1.0e-6, sound_speed: 1.0),
    scheme: Wcsph(shifting: Fickian(coefficient: 2.0)),
    domain: Box(min: (0.0, 0.0), max: (0.16, 0.08)),
    walls: None,
    periodic: ["y"],
    initial: (velocity: ("u", 0.0), tag: "y + 10*t"),
    inlets: [(at: (0.0, 0.04), towards: (1.0, 0.0), velocity: Normal("u"))],
    outlets: [(at: (0.16, 0.04), towards: (1.0, 0.0), condition: WaveEquation(pressure: Reference(0.0)))],
    reservoir: (particles: 40),
    time: (end: 100.0),
    output: (every: 1.0),
)"#;

/// Returns the scene with changed values.
pub(crate) fn scene(sets: &[(&str, &str)]) -> Scene {
    Scene::from_text("plug", SCENE).sets(sets).load().unwrap_or_else(|faults| panic!("{faults:?}"))
}
