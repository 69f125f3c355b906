//! Typical mistakes in a scene: each message names file, line and column, and nearly all say what
//! would be right.
//!
//! The messages as a user sees them stand in `tests/snapshots/`;
//! `INSTA_UPDATE=always cargo test --test mistakes` renews them.

use std::fmt::Write as _;

use miette::{GraphicalReportHandler, GraphicalTheme};
use sphecs::Scene;

const SCENE: &str = include_str!("../scenes/quickstart.ron");

/// Text of the scene, text that a user wrote in its place, and text that the message must suggest;
/// empty where nothing can be.
const MISTAKES: [(&str, &str, &str); 86] = [
    // Names of fields.
    ("dimensions: 2,", "dimension: 2,", "did you mean `dimensions`"),
    ("spacing: 1.25e-3", "spaceing: 1.25e-3", "did you mean `spacing`"),
    ("fluid: (density", "fluids: (density", "did you mean `fluid`"),
    ("density: 1000.0", "densty: 1000.0", "did you mean `density`"),
    ("viscosity: 1.0e-5", "viscocity: 1.0e-5", "did you mean `viscosity`"),
    ("viscosity: 1.0e-5", "nu: 1.0e-5", "`viscosity`"),
    ("sound_speed: 2.0", "soundspeed: 2.0", "did you mean `sound_speed`"),
    ("sound_speed: 2.0", "c0: 2.0", "`sound_speed`"),
    ("domain: Difference", "geometry: Difference", "`domain`"),
    ("inlets: [(", "inlet: [(", "did you mean `inlets`"),
    ("outlets: [(", "outflows: [(", "did you mean `outlets`"),
    ("towards: (1.0, 0.0), condition", "toward: (1.0, 0.0), condition", "did you mean `towards`"),
    ("towards: (1.0, 0.0), condition", "normal: (1.0, 0.0), condition", "`towards`"),
    ("condition: WaveEquation()", "conditions: WaveEquation()", "did you mean `condition`"),
    ("time: (end: 2.0)", "time: (stop: 2.0)", "`end`"),
    ("every: 0.05", "interval: 0.05", "`every`"),
    ("time: (end: 2.0)", "time: (end: 2.0, dt: 1e-4)", "`cfl`"),
    ("probes: [", "probe: [", "did you mean `probes`"),
    ("kind: Line(from: (0.0, 0.0), to", "kind: Line(start: (0.0, 0.0), to", "write `from: …`"),
    ("count: 81", "counts: 81", "did you mean `count`"),
    ("time: (end", "gravity: (0.0, -9.81), time: (end", "called `body_force`"),
    ("spacing: 1.25e-3", "dx: 1.25e-3", "called `spacing`"),
    ("viscosity: 1.0e-5", "mu: 1.0e-2", "ν = μ/ρ0"),
    // Choices.
    (
        "velocity: Normal(\"v0 * 0.5*(1 - cos(pi*min(t/t0, 1))) * (1 - 4*y^2/D^2)\")",
        "velocity: (0.1, 0.0)",
        "`Components((0.1, 0.0))`",
    ),
    (
        "velocity: Normal(\"v0 * 0.5*(1 - cos(pi*min(t/t0, 1))) * (1 - 4*y^2/D^2)\")",
        "velocity: 0.1",
        "`Normal(0.1)`",
    ),
    ("time: (end", "walls: (slip: \"FreSlip\"), time: (end", "did you mean `FreeSlip`"),
    ("domain: Difference([", "domain: Subtract([", "called `Difference`"),
    ("WaveEquation()", "WaveEqation()", "did you mean `WaveEquation`"),
    ("WaveEquation()", "Neumann()", "`Mirror`"),
    ("WaveEquation()", "Hybrd()", "did you mean `Hybrid`"),
    ("WaveEquation()", "Orlansky()", "did you mean `Orlanski`"),
    ("Normal(\"v0", "Parabolic(\"v0", "`PoiseuilleStartup`"),
    ("domain: Difference([", "domain: Substract([", "`Difference`"),
    ("kind: Line(", "kind: line(", "did you mean `Line`"),
    ("time: (end", "scheme: Edac(), time: (end", "did you mean `EdacTvf`"),
    ("time: (end", "scheme: Wcsph(kernel: Wendland), time: (end", "did you mean `WendlandC2`"),
    ("time: (end", "scheme: Wcsph(viscosity: Smagorinsky()), time: (end", "`Sps`"),
    ("time: (end", "walls: (slip: Slip), time: (end", "`FreeSlip`"),
    ("time: (end", "walls: (model: Mirror()), time: (end", "`Image`"),
    ("time: (end", "precision: f32, time: (end", "did you mean `F32`"),
    // Numbers.
    ("spacing: 1.25e-3", "spacing: -1.25e-3", "must be finite and greater than 0"),
    ("spacing: 1.25e-3", "spacing: 0", "must be finite and greater than 0"),
    ("spacing: 1.25e-3", "spacing: 1.25mm", "write `0.00125`"),
    ("spacing: 1.25e-3", "spacing: 1.25 mm", "write `0.00125`"),
    ("spacing: 1.25e-3", "spacing: \"1.25 mm\"", "write `0.00125`"),
    ("sound_speed: 2.0", "sound_speed: 200 cm/s", "write `2`"),
    ("viscosity: 1.0e-5", "viscosity: \"10*1.0 mm^2/s\"", "multiply by `1e-6`"),
    ("spacing: 1.25e-3", "spacing: 2*0.1", "in quotes: \"2*0.1\""),
    ("spacing: 1.25e-3", "spacing: (1 + 2)/800", "in quotes: \"(1 + 2)/800\""),
    ("spacing: 1.25e-3", "spacing: sqrt(2.0e-6)", "in quotes: \"sqrt(…)\""),
    ("spacing: 1.25e-3", "spacing: \"0.1*x\"", "the number is the same everywhere"),
    ("spacing: 1.25e-3", "spacing: \"0.1*q\"", "neither a constant nor a function"),
    ("spacing: 1.25e-3", "spacing: 1,25e-3", "has a point, not a comma"),
    ("spacing: 1.25e-3", "spacing: 1.25e-6", "raise `spacing` to at least"),
    ("dimensions: 2,", "dimensions: 1,", "must be 2 or 3"),
    ("density: 1000.0", "density: \"water\"", "neither a constant nor"),
    ("density: 1000.0", "density: true", "must be a number"),
    ("end: 2.0", "end: -2.0", "must be finite and greater than 0"),
    ("end: 2.0", "end: 1/0", "in quotes"),
    ("time: (end: 2.0)", "time: (end: 2.0, cfl: 3.0)", "must be greater than 0 and at most"),
    ("count: 81", "count: 1", "must be from 2 to"),
    // Vectors and expressions.
    ("at: (0.0, 0.0)", "at: (0.0, 0.0, 0.0)", "has 3, must have 2"),
    ("at: (0.0, 0.0)", "at: 0.0", "must be a list"),
    ("towards: (1.0, 0.0), condition", "towards: (0.0, 0.0), condition", "must not be zero"),
    ("pi*min(t/t0, 1)", "pi*min(t/t1, 1)", "`t0`"),
    ("(1 - cos(", "(1 - Cos(", "did you mean `cos`"),
    ("4*y^2/D^2)", "4*y**2/D^2)", "`^`"),
    ("4*y^2/D^2)", "4*y^2/D^2", "`)`"),
    ("\"-D/2\"", "-D/2", "in quotes"),
    ("tag: \"y > 0\"", "tag: \"y >\"", ""),
    // Gridded fields.
    ("fields: (mean: (1.0, 2.0))", "grid: (mean: (1.0, 2.0))", "`fields`"),
    ("fields: (mean: (1.0, 2.0))", "fields: (spacing: 0.0)", "must be finite and greater than 0"),
    ("fields: (mean: (1.0, 2.0))", "fields: (spacing: 1e-7)", "give the fields a `spacing` of at least"),
    ("fields: (mean: (1.0, 2.0))", "fields: (mean: (2.0, 1.0))", "must rise and end by the end of the run"),
    ("fields: (mean: (1.0, 2.0))", "fields: (mean: (1.0, 3.0))", "must rise and end by the end of the run"),
    ("fields: (mean: (1.0, 2.0))", "fields: (mean_every: 0.1)", "give the interval of time"),
    (
        "fields: (mean: (1.0, 2.0))",
        "fields: (planes: [(name: \"mid\", at: (0, 0), normal: (1, 0))])",
        "leave out `planes`",
    ),
    // Notation.
    ("dimensions: 2,", "dimensions: 2", "`,`"),
    ("dimensions: 2,", "dimensions = 2,", "write `dimensions: …`"),
    ("title: \"Channel with a constriction\",", "title: \"Channel with a constriction,", ""),
    ("L\": 0.2,   // m, length\n    }", "L\": 0.2,   // m, length\n    )", "`}`"),
    // Geometry.
    ("at: (0.0, 0.0),\n", "at: (0.03, 0.0),\n", "must be on the domain's surface"),
    ("outlets: [(at: (\"L\", 0.0)", "outlets: [(at: (0.3, 0.0)", "it begins at (0.2, 0) m"),
    ("towards: (1.0, 0.0), condition", "towards: (-1.0, 0.0), condition", "turn the sign of `towards`"),
    ("from: (0.0, 0.0), to: (\"L\", 0.0)", "from: (0.0, 1.0), to: (\"L\", 1.0)", ""),
    (
        "outlets: [(at: (\"L\", 0.0), towards",
        "periodic: [\"x\"], outlets: [(at: (\"L\", 0.0), towards",
        "take \"x\" out of `periodic`",
    ),
];

/// A line with the text between two pieces of it left out, if both are in it.
fn masked(line: &str, before: &str, behind: &str) -> String {
    let line = line.trim_end();
    let place = line.find(behind).and_then(|end| Some((line[..end].rfind(before)? + before.len(), end)));
    place.map_or(line.to_owned(), |(start, end)| format!("{}…{}", &line[..start], &line[end..]))
}

/// The message for a scene, without colours.
fn message(text: &str) -> String {
    let faults = match Scene::from_text("scene.ron", text).memory(16.0e9).load() {
        Ok(_) => return "none".to_owned(),
        Err(faults) => faults,
    };
    let mut report = String::new();
    GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor())
        .with_width(120)
        .render_report(&mut report, &faults)
        .expect("a text takes all");
    // Figures of memory change with the bytes that a particle takes.
    let cut =
        report.lines().map(|line| masked(&masked(line, "; ", " GB are free"), "at least `", "`, or run"));
    cut.collect::<Vec<_>>().join("\n")
}

/// The lines that a message names in this scene.
fn lines(message: &str) -> Vec<usize> {
    let places = message.split("scene.ron:").skip(1);
    places
        .filter_map(|rest| {
            let (line, rest) = rest.split_once(':')?;
            rest.chars().next()?.is_ascii_digit().then(|| line.parse().ok())?
        })
        .collect()
}

#[test]
fn typical_mistakes_are_named_with_place_and_cure() {
    let mut all = String::new();
    let (mut elsewhere, mut bare) = (Vec::new(), Vec::new());
    for (right, wrong, suggestion) in MISTAKES {
        assert!(SCENE.contains(right), "`{right}` is not in the scene");
        let text = SCENE.replacen(right, wrong, 1);
        let message = message(&text);
        let changed = SCENE[..SCENE.find(right).unwrap_or(0)].lines().count().max(1);
        let lines = lines(&message);
        assert!(!lines.is_empty(), "without a place: {wrong}\n{message}");
        if !lines.iter().any(|line| line.abs_diff(changed) <= 1) {
            elsewhere.push(wrong);
        }
        if suggestion.is_empty() || !message.contains(suggestion) {
            bare.push(wrong);
        }
        writeln!(all, "──── {right} → {wrong}\n{message}\n").expect("a text takes all");
    }
    // Text that is not closed runs on to the next quote.
    assert_eq!(elsewhere, ["title: \"Channel with a constriction,"], "{all}");
    assert!(10 * bare.len() <= MISTAKES.len(), "without a cure: {bare:#?}\n{all}");
    insta::with_settings!({ omit_expression => true, prepend_module_to_snapshot => false }, {
        insta::assert_snapshot!("mistakes", all);
    });
}
