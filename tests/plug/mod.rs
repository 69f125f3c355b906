//! Plug flow between an inlet and an outlet, without walls: every particle moves by the same formula.

use sphecs::scene::model::Scene;

/// A fixed outlet pressure holds the uniform state to the last digit: an absorbing one sees the start as a wave.
/// Shifting turns a square lattice into a closer one, from rounding and the faster the stronger it is: weak enough, it
/// takes longer than a passage. The tag says where and when a particle entered.
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

/// The scene with values put in.
pub fn scene(sets: &[(&str, &str)]) -> Scene {
    Scene::from_text("plug", SCENE).sets(sets).load().unwrap_or_else(|faults| panic!("{faults:?}"))
}
