//! Verdicts, pages and exit codes of `sphecs validate`, and the quick tier.

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

fn validate(arguments: &[&str], out: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sphecs"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).env_remove("RUST_BACKTRACE").arg("validate");
    command.args(arguments).arg("--out").arg(out).output().expect("the program starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn cases_are_listed_with_their_titles() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = validate(&["--list"], folder.path());
    let list = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(list.lines().count() > 20 && list.contains("poiseuille  "), "{list}");
}

/// Uniform periodic flow of 0.25 m/s along x with probes.
const SCENE: &str = r#"Scene(
    title: "Uniform stream", dimensions: 2, spacing: 0.05, smoke: 0.1,
    fluid: (density: 1000.0, viscosity: 1.0e-6, sound_speed: 5.0),
    domain: Box(min: (0.0, 0.0), max: (0.5, 0.5)), periodic: ["x", "y"], walls: None,
    initial: (velocity: (0.25, 0.0)),
    time: (end: 0.05),
    output: (every: 0.05, monitor_every: 0.01, probes: [
        (name: "line", kind: Line(from: (0.0, 0.25), to: (0.5, 0.25), count: 6)),
        (name: "flow", kind: Section(at: (0.25, 0.25), normal: (1.0, 0.0))),
    ]),
)"#;

/// Writes a case of that flow with the reference speed `speed`.
fn case(folder: &Path, speed: f64) -> String {
    let text = format!(
        r#"Case(
    title: "Uniform stream", source: "nobody", setting: "A stream | that stays.",
    constants: {{ "speed": {speed} }},
    runs: [
        (name: "stream", scene: "stream.ron", tier: Quick),
        (name: "twins", scene: "stream.ron", tier: Quick, again: (
            set: "initial.velocity", to: ["(0.27, 0.0)", "(0.29, 0.0)"], tier: Quick)),
        (name: "later", scene: "stream.ron", set: [("time.end", "0.06")], tier: Usual),
    ],
    figures: [
        (name: "off", what: "distance from the speed, m/s", must: AtMost(1e-9), value: Profile(
            run: "stream", probe: "line", field: u, when: Every(0.0, 1.0), reference: Formula("speed"), norm: Largest)),
        (name: "flow", what: "flow, kg/(s m)", must: Near(value: 125.0, by: 1e-6), value: Series(
            run: "stream", table: "flow", column: "mass_flow", over: (0.0, 1.0), take: Mean)),
        (name: "twice", what: "twice that", value: Formula("2*flow")),
        (name: "mean", what: "mean speed of the twins, m/s", value: Feature(
            run: "twins", probe: "l*e", field: Along((1.0, 0.0)), when: At(0.05), take: Largest)),
        (name: "sure", what: "its error", must: Near(value: 0.011547, by: 1e-5), value: Formula("mean_error")),
        (name: "spread", what: "distance of two twins, m/s", must: Near(value: 0.028284, by: 1e-5), value: Profile(
            run: "twins", probe: "line", field: speed, when: At(0.05), reference: Members, norm: RootMeanSquare)),
        (name: "same", what: "distance from the other run", must: AtMost(1.0), value: Profile(
            run: "stream", probe: "line", field: u, when: At(0.05), reference: Run("later"), norm: Largest)),
    ],
    plots: [(name: "line", title: "u", across: "x, m", upward: "u, m/s", curves: [
        Profile(run: "stream", probe: "line", field: u, when: At(0.05), axis: x, reference: Some(Formula("speed")), label: "u"),
        Distance(run: "stream", probe: "line", field: u, reference: Formula(0.0), norm: Largest, label: "|u|"),
    ])],
    pictures: [(name: "speed", title: "Speed", run: "twins", field: "speed", times: [0.0, 0.05], width: 300)],
)"#
    );
    fs::write(folder.join("stream.ron"), SCENE).expect("written");
    let path = folder.join("uniform.ron");
    fs::write(&path, text).expect("written");
    path.to_string_lossy().into_owned()
}

#[test]
fn case_of_the_user_is_run_measured_and_evaluated() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let path = case(folder.path(), 0.25);
    let output = validate(&["--quick", "--case", &path], &out);
    let said = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{said}\n{}", text(&output.stderr));
    assert!(said.contains("all required bands are met"), "{said}");
    assert!(!said.contains("the other run"), "its second run is not in this tier:\n{said}");
    assert!(said.contains("figures, 1 not measured"), "{said}");

    let page = fs::read_to_string(out.join("uniform.md")).expect("a page");
    for words in [
        "# Uniform stream\n\nUniform stream: **met** (4 of 4 required bands met, 1 required but not measured).\n\n![u]",
        "| flow, kg/(s m) | 125 | 125 ±",
        "| twice that | 250 |",
        "uniform_line.svg",
        "| mean speed of the twins, m/s | 0.27 ± 0.012 |",
        "| twins.3 |",
        "![Speed, t = 0 s](uniform_speed_1.png)",
        "Required but not measured, because the runs belong to another tier or have no results: distance from the other run.",
    ] {
        assert!(page.contains(words), "no `{words}` in\n{page}");
    }
    let picture = fs::read_to_string(out.join("uniform_line.svg")).expect("a plot");
    assert!(picture.starts_with("<svg") && picture.contains("reference"));
    assert!(fs::read(out.join("uniform_speed_2.png")).expect("a picture").starts_with(b"\x89PNG"));
    let report: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(out.join("report.json")).expect("a report")).expect("JSON");
    assert_eq!(report["figures"].as_array().map(Vec::len), Some(6));
    assert_eq!(
        report["figures"][2]["value"],
        2.0 * report["figures"][1]["value"].as_f64().expect("a number")
    );

    // Complete runs are reused; the other tier adds its run.
    let first = fs::read(out.join("uniform/stream/summary.json")).expect("a summary");
    let output = validate(&["--reuse", "--case", &path], &out);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stdout));
    assert!(text(&output.stdout).contains("distance from the other run"));
    assert!(text(&output.stdout).contains("all required bands are met; pages"), "{}", text(&output.stdout));
    let page = fs::read_to_string(out.join("uniform.md")).expect("a page");
    assert!(!page.contains("another build"), "{page}");
    assert_eq!(fs::read(out.join("uniform/stream/summary.json")).expect("a summary"), first);
    // A run of another build is reused and reported.
    let summary = out.join("uniform/stream/summary.json");
    let of_another =
        fs::read_to_string(&summary).expect("a summary").replace("\"build\": \"", "\"build\": \"0");
    fs::write(&summary, of_another).expect("written");
    validate(&["--reuse", "--case", &path], &out);
    let page = fs::read_to_string(out.join("uniform.md")).expect("a page");
    assert!(page.contains("Reused from another build of this version: stream."), "{page}");
}

#[test]
fn stopped_run_is_resumed_and_shortened_run_is_not_reused() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let path = case(folder.path(), 0.25);
    let arguments = ["--quick", "--reuse", "--case", path.as_str()];
    let stream = out.join("uniform/stream");
    let sphecs = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_sphecs"));
        command.args(arguments).arg("--out").arg(&stream).output().expect("the program starts").status
    };
    let steps = |folder: &Path| {
        let text = fs::read_to_string(folder.join("summary.json")).expect("a summary");
        let summary: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        (summary["status"].clone(), summary["steps"].as_u64().expect("a number"))
    };
    let scene = folder.path().join("stream.ron").to_string_lossy().into_owned();

    // With an end after three steps it is complete, but is not the run of the case.
    assert!(sphecs(&["run", &scene, "--steps", "3"]).success());
    assert_eq!(steps(&stream), ("completed".into(), 3));
    assert_eq!(validate(&arguments, &out).status.code(), Some(0));
    let (status, whole) = steps(&stream);
    assert!(status == "completed" && whole > 5, "{whole}");
    let monitor = fs::read(stream.join("monitor.csv")).expect("rows");

    // At its wall-time limit after the first step it has a checkpoint, which is resumed.
    fs::remove_dir_all(&stream).expect("removed");
    assert_eq!(sphecs(&["run", &scene, "--max-walltime", "0.000001s"]).code(), Some(75));
    assert!(steps(&stream).1 < whole);
    let begun = fs::metadata(stream.join("scene.ron")).and_then(|file| file.modified()).expect("a time");
    assert_eq!(validate(&arguments, &out).status.code(), Some(0));
    assert_eq!(steps(&stream), ("completed".into(), whole));
    assert_eq!(fs::read(stream.join("monitor.csv")).expect("rows"), monitor);
    let ended = fs::metadata(stream.join("scene.ron")).and_then(|file| file.modified()).expect("a time");
    assert_eq!(begun, ended, "it was run from its start");

    // Without a readable checkpoint it is run from its start.
    fs::remove_dir_all(&stream).expect("removed");
    assert_eq!(sphecs(&["run", &scene, "--max-walltime", "0.000001s"]).code(), Some(75));
    for file in fs::read_dir(stream.join("checkpoints")).expect("a folder") {
        fs::write(file.expect("a file").path(), b"nothing").expect("written");
    }
    assert_eq!(validate(&arguments, &out).status.code(), Some(0));
    assert_eq!(steps(&stream), ("completed".into(), whole));
}

#[test]
fn concurrent_runs_are_all_stopped_by_a_signal() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    fs::write(folder.path().join("stream.ron"), SCENE).expect("written");
    let path = folder.path().join("endless.ron");
    let case = r#"Case(title: "Endless streams", source: "nobody", setting: "Two.", runs: [
        (name: "one", scene: "stream.ron", set: [("time.end", "1.0e4")], tier: Quick),
        (name: "other", scene: "stream.ron", set: [("time.end", "2.0e4")], tier: Quick),
    ], figures: [(name: "steps", what: "none", value: Formula("1"))])"#;
    fs::write(&path, case).expect("written");
    let status = |run: &str| {
        let text = fs::read_to_string(out.join("endless").join(run).join("summary.json")).ok()?;
        let summary: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        Some(summary["status"].as_str().expect("a word").to_owned())
    };
    let begun = || status("one").is_some() && status("other").is_some();

    let mut command = Command::new(env!("CARGO_BIN_EXE_sphecs"));
    command.args(["validate", "--threads", "2", "--case"]).arg(&path).arg("--out").arg(&out);
    let mut child = command.stdout(Stdio::null()).spawn().expect("the program starts");
    while !begun() && child.try_wait().expect("a child").is_none() {
        std::thread::sleep(Duration::from_millis(20));
    }
    assert!(begun(), "the second waits for the first");
    Command::new("kill").arg(child.id().to_string()).status().expect("kill");
    assert_eq!(child.wait().expect("a child").code(), Some(143));
    for run in ["one", "other"] {
        assert_eq!(status(run).as_deref(), Some("terminated"), "{run}");
        let checkpoints = fs::read_dir(out.join("endless").join(run).join("checkpoints")).expect("a folder");
        assert!(checkpoints.count() > 0, "{run} has no checkpoint");
    }
}

/// A lid over a shear of 1/s with ν = 0.1 m²/s: the drag on 0.5 m² per metre of depth is 50 N, 0.2
/// of ½ρU²A.
#[test]
fn forces_on_bodies_are_measured() {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = r#"Scene(
    title: "Plane Couette flow", dimensions: 2, spacing: 0.05, smoke: 0.1,
    fluid: (density: 1000.0, viscosity: 0.1, sound_speed: 10.0),
    domain: Box(min: (0.0, 0.0), max: (0.5, 1.0)), periodic: ["x"],
    walls: (parts: [(name: "the lid", region: Box(min: (-1.0, 0.9), max: (2.0, 2.0)), velocity: (1.0, 0.0))]),
    initial: (velocity: ("y", 0.0)),
    bodies: [(part: "the lid", velocity: 1.0, area: 0.5, mean: (0.01, 0.1))],
    time: (end: 0.1), output: (every: 0.1, monitor_every: 0.01),
)"#;
    let case = r#"Case(
    title: "Lid", source: "exact", setting: "",
    runs: [(name: "lid", scene: "lid.ron", tier: Quick)],
    figures: [
        (name: "drag", what: "drag", must: Near(value: -0.2, by: 0.01), value: Body(run: "lid", body: "the lid", take: DragMean)),
        (name: "force", what: "force, N/m", must: Near(value: -50.0, by: 2.5), value: Series(
            run: "lid", table: "forces", column: "viscous_force_x_the_lid", over: (0.01, 0.1), take: Mean)),
    ],
)"#;
    fs::write(folder.path().join("lid.ron"), scene).expect("written");
    let path = folder.path().join("forces.ron");
    fs::write(&path, case).expect("written");
    let output = validate(&["--quick", "--case", &path.to_string_lossy()], &folder.path().join("out"));
    assert_eq!(output.status.code(), Some(0), "{}\n{}", text(&output.stdout), text(&output.stderr));
}

#[test]
fn missed_band_is_reported_with_exit_code_1() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let path = case(folder.path(), 0.3);
    let output = validate(&["--quick", "--case", &path], &out);
    let said = text(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("MISSED") && said.contains("required bands missed: uniform"), "{said}");
    assert!(fs::read_to_string(out.join("uniform.md")).expect("a page").contains("| MISSED |"));
}

#[test]
fn diverged_flow_is_a_miss_with_its_reason() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let path = case(folder.path(), 0.25);
    // Two thousand times the sound speed for one column.
    let scene = SCENE.replace("velocity: (0.25, 0.0)", r#"velocity: ("1e4*(x < 0.05)", 0.0)"#);
    fs::write(folder.path().join("stream.ron"), scene).expect("written");
    let output = validate(&["--quick", "--case", &path], &out);
    let said = text(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{said}\n{}", text(&output.stderr));
    assert!(said.contains("run `stream` has no results"), "{said}");
    assert!(fs::read_to_string(out.join("uniform.md")).expect("a page").contains("| failed: "));
}

#[test]
fn permitted_divergence_is_reported_and_not_a_miss() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let path = case(folder.path(), 0.25);
    let scene = SCENE.replace("velocity: (0.25, 0.0)", r#"velocity: ("1e4*(x < 0.05)", 0.0)"#);
    fs::write(folder.path().join("stream.ron"), scene).expect("written");
    let text_of_case = fs::read_to_string(&path).expect("the case");
    // The twins have another velocity and do not diverge.
    let twins = r#"(name: "twins", scene: "stream.ron", "#;
    let calm = r#"set: [("initial.velocity", "(0.25, 0.0)")], "#;
    let text_of_case = text_of_case.replace(twins, &format!("{twins}{calm}"));
    let stream = r#"(name: "stream", scene: "stream.ron", "#;
    fs::write(&path, text_of_case.replace(stream, &format!("{stream}may_fail: true, "))).expect("written");
    let output = validate(&["--quick", "--case", &path], &out);
    let said = text(&output.stdout);
    assert!(!said.contains("has no results") && said.contains("mean speed of the twins"), "{said}");
    assert!(!said.contains("flow, kg/(s m)"), "figures of the run are omitted:\n{said}");
    assert!(fs::read_to_string(out.join("uniform.md")).expect("a page").contains("| failed: "));
    assert_eq!(output.status.code(), Some(0), "{said}");
}

#[test]
fn faults_of_a_case_prevent_all_runs() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let path = case(folder.path(), 0.25);
    let bad = fs::read_to_string(&path).expect("the case").replace("probe: \"line\"", "probe: \"lines\"");
    fs::write(&path, bad).expect("written");
    let output = validate(&["--case", &path], &out);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("run `stream` has no probe `lines`") && message.contains("line"), "{message}");
    assert!(!out.exists());

    let output = validate(&["--case", "poisseuille"], &out);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("poiseuille"), "{}", text(&output.stderr));
}

#[test]
fn quick_tier_meets_all_required_bands() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = validate(&["--quick"], folder.path());
    assert_eq!(output.status.code(), Some(0), "{}\n{}", text(&output.stdout), text(&output.stderr));
}
