//! Faults of openings that a pressure drives.

use crate::Scene;

/// Returns the faults of a channel with these openings, as text.
fn faults(openings: &str) -> String {
    let text = format!(
        r#"Scene(
    title: "Driven", dimensions: 2, spacing: 0.002,
    fluid: (density: 1000.0, viscosity: 1e-5, sound_speed: 2.0),
    domain: Box(min: (0.0, 0.0), max: (0.2, 0.04)),
    {openings}
    time: (end: 1.0), output: (every: 0.5),
)"#
    );
    let errors = Scene::from_text("driven", text).load().err();
    let faults = errors.iter().flat_map(|errors| errors.faults());
    let texts = faults.map(|fault| format!("{} | {} | {:?}", fault.title, fault.label, fault.help));
    texts.collect::<Vec<_>>().join("\n")
}

const INLET: &str = "inlets: [(at: (0.0, 0.02), towards: (1.0, 0.0), velocity: Normal(0.1))],";

fn outlet(condition: &str) -> String {
    format!("outlets: [(at: (0.2, 0.02), towards: (1.0, 0.0), condition: {condition})],")
}

#[test]
fn quantities_of_openings_are_checked() {
    let cases = [
        ("Pressure()", "in 0 of the forms"),
        ("Pressure(value: 1.0, rows: [(0.0, 1.0)])", "in 2 of the forms"),
        ("Pressure(value: \"4*x\")", "must depend on t alone"),
        ("Pressure(value: \"4*q\")", "q"),
        ("Pressure(value: \"sqrt(0.5 - t)\")", "is not finite"),
        ("Pressure(rows: [(1.0, 0.0), (0.5, 0.0)])", "do not rise"),
        ("Pressure(rows: [])", "is empty"),
        ("TotalPressure(file: \"missing.csv\")", "cannot be read"),
        ("Resistance(resistance: -1.0)", "not negative"),
        ("Windkessel(proximal: 1.0, compliance: 0.0, distal: 1.0)", "greater than 0"),
        ("FlowShare(share: 2.0)", "from 0 to 1"),
        ("FlowShare(share: 1.0)", "nothing sets the pressure"),
    ];
    for (condition, expected) in cases {
        let found = faults(&format!("{INLET} {}", outlet(condition)));
        assert!(found.contains(expected), "{condition}: {found}");
    }
    assert_eq!(faults(&format!("{INLET} {}", outlet("Pressure(rows: [(0.0, 0.0), (1.0, 4.0)])"))), "");
    let found = faults(&outlet("FlowShare(share: 0.5)"));
    assert!(found.contains("`FlowShare` without an inlet"), "{found}");
}

#[test]
fn pressures_at_inlets_are_led_to_the_outlets() {
    for inlet in [
        "inlets: [(at: (0.0, 0.02), towards: (1.0, 0.0), velocity: Normal(0.1), condition: Pressure(value: 4.0))],",
        "inlets: [(at: (0.0, 0.02), towards: (1.0, 0.0), velocity: Normal(0.1), pressure: Pressure(value: 4.0))],",
    ] {
        let found = faults(&format!("{inlet} {}", outlet("WaveEquation()")));
        assert!(found.contains("write it under `outlets`"), "{found}");
    }
}
