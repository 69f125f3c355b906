//! Faults of every kind: message, marked token, line and column.

mod driven;
mod geometry;
mod movers;
mod notation;
mod values;

use crate::Scene;
use crate::faults::SceneErrors;

/// A scene without faults; tests replace one part of it.
const SOUND: &str = r#"Scene(
    title: "t",
    dimensions: 2,
    spacing: 0.05,
    smoke: 0.1,
    constants: {"v0": 1.0, "H": 0.4},
    fluid: (density: 1000.0, viscosity: 1.0e-3, sound_speed: 10.0),
    scheme: Wcsph(smoothing_ratio: 1.5, viscosity: Laminar(), shifting: Fickian()),
    domain: Box(min: (0.0, 0.0), max: (1.0, "H")),
    walls: (slip: NoSlip),
    initial: (velocity: (0.0, 0.0), pressure: 0.0, tag: "y > 0.2"),
    body_force: (0.0, 0.0),
    periodic: [],
    inlets: [(at: (0.0, 0.2), towards: (1.0, 0.0), depth: 0.25, velocity: Normal("v0 * y"))],
    outlets: [(at: (1.0, 0.2), towards: (1.0, 0.0), depth: 0.4, condition: WaveEquation())],
    time: (end: 1.0, cfl: 0.3),
    output: (every: 0.1, probes: [(name: "p", kind: Point(at: (0.5, 0.2)))]),
)
"#;

fn faults_of(text: &str) -> SceneErrors {
    match Scene::from_text("test.ron", text).load() {
        Ok(_) => panic!("no fault in\n{text}"),
        Err(faults) => faults,
    }
}

/// Replaces `right` by `wrong` and checks that there is one fault, with this title and marked
/// token.
#[track_caller]
fn check(right: &str, wrong: &str, title: &str, token: &str) -> String {
    assert_eq!(SOUND.matches(right).count(), 1, "`{right}` must occur once");
    let text = SOUND.replace(right, wrong);
    let faults = faults_of(&text);
    let report = faults
        .faults()
        .iter()
        .map(|fault| {
            let marked = fault.span.and_then(|span| text.get(span.start..span.end));
            format!(
                "{} | {} | {} | {:?} at {:?}",
                fault.title,
                marked.unwrap_or("-"),
                fault.label,
                fault.help,
                faults.position(fault)
            )
        })
        .collect::<Vec<_>>()
        .join("\n");
    assert_eq!(faults.faults().len(), 1, "{report}");
    let fault = &faults.faults()[0];
    assert!(fault.title.contains(title), "{report}");
    let marked = fault.span.and_then(|span| text.get(span.start..span.end));
    assert_eq!(marked, Some(token), "{report}");
    let (line, column) = faults.position(fault).unwrap_or_default();
    let line_text = text.lines().nth(line - 1).unwrap_or_default();
    let rest: String = line_text.chars().skip(column - 1).collect();
    assert!(rest.starts_with(token.lines().next().unwrap_or_default()), "{report}");
    report
}

#[test]
fn scene_without_changes_has_no_faults() {
    if let Err(faults) = Scene::from_text("test.ron", SOUND).load() {
        panic!("{:?}", miette::Report::new(faults));
    }
}

#[test]
fn all_faults_are_found_in_one_run() {
    let text = SOUND
        .replace("spacing: 0.05", "spacing: -0.05")
        .replace("viscosity: 1.0e-3", "viscosty: 1.0e-3")
        .replace("NoSlip", "NoSlipp")
        .replace("\"v0 * y\"", "\"v0 * velo\"")
        .replace("end: 1.0", "end: ")
        .replace("every: 0.1", "every: [1]")
        .replace("density: 1000.0", "density: \"rho\"")
        .replace("max: (1.0, \"H\")", "max: (-1.0, \"H\")");
    let faults = faults_of(&text);
    let titles: Vec<&str> = faults.faults().iter().map(|f| f.title.as_str()).collect();
    for wanted in [
        "`spacing` must be finite",
        "unknown field `viscosty`",
        "`NoSlipp` is not a choice",
        "unknown name `velo`",
        "a value is missing",
        "`every` is not a number",
        "unknown name `rho`",
        "a box has no extent",
    ] {
        assert!(titles.iter().any(|t| t.contains(wanted)), "{wanted} is not in {titles:?}");
    }
    assert_eq!(titles.len(), 8, "{titles:?}");
    let report = format!("{:?}", miette::Report::new(faults));
    for wanted in ["test.ron has 8 faults", "test.ron:4:14", "did you mean `viscosity`"] {
        assert!(report.contains(wanted), "{wanted} is not in\n{report}");
    }
}
