//! `sphecs sweep`: combinations of values, continuation, faults and exit codes.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// Uniform stream whose speed and viscosity are constants.
const SCENE: &str = r#"Scene(
    title: "Uniform stream", dimensions: 2, spacing: 0.05, smoke: 0.1,
    constants: {"u0": 0.25},
    fluid: (density: 1000.0, viscosity: 1.0e-6, sound_speed: 5.0),
    domain: Box(min: (0.0, 0.0), max: (0.5, 0.5)), periodic: ["x", "y"], walls: None,
    initial: (velocity: ("u0", 0.0)),
    time: (end: 0.02),
    output: (every: 0.02, monitor_every: 0.01),
)"#;

fn sweep(folder: &Path, arguments: &[&str]) -> Output {
    fs::write(folder.join("stream.ron"), SCENE).expect("written");
    let mut command = Command::new(env!("CARGO_BIN_EXE_sphecs"));
    command.current_dir(folder).args(["sweep", "stream.ron"]).args(arguments);
    command.output().expect("the program starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn modified(path: &Path) -> std::time::SystemTime {
    fs::metadata(path).and_then(|data| data.modified()).expect("a file")
}

const GRID: [&str; 4] = ["--grid", "constants.u0=0.1,0.2", "--grid", "fluid.viscosity=1e-6,1e-3"];

#[test]
fn each_combination_is_a_run_and_complete_ones_are_used_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = sweep(folder.path(), &GRID);
    let said = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{said}{}", text(&output.stderr));
    assert!(said.contains("4 runs completed"), "{said}");
    let runs = folder.path().join("runs/stream_sweep");
    let index = fs::read_to_string(runs.join("sweep.csv")).expect("an index");
    let lines: Vec<&str> = index.lines().collect();
    assert_eq!(lines[0], "run,constants.u0,fluid.viscosity");
    assert_eq!(lines[2], "u0-0.1_viscosity-1e-3,0.1,1e-3");
    let scene = fs::read_to_string(runs.join("u0-0.2_viscosity-1e-6/scene.ron")).expect("a scene");
    assert!(scene.contains("0.2") && !scene.contains("0.25"), "{scene}");
    // A further value adds two runs; the others stay as they are.
    let kept = runs.join("u0-0.1_viscosity-1e-6/particles.nc");
    let before = modified(&kept);
    let output = sweep(folder.path(), &["--grid", "constants.u0=0.1,0.2,0.3", GRID[2], GRID[3]]);
    assert!(text(&output.stdout).contains("6 runs completed"), "{}", text(&output.stdout));
    assert_eq!(modified(&kept), before);
    assert!(runs.join("u0-0.3_viscosity-1e-3/particles.nc").exists());
}

#[test]
fn one_run_of_a_job_array_is_made_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    let list = text(&sweep(folder.path(), &[&GRID[..], &["--list"]].concat()).stdout);
    assert_eq!(list.lines().count(), 4, "{list}");
    assert!(list.contains("    2  runs/stream_sweep/u0-0.2_viscosity-1e-6"), "{list}");
    assert!(!folder.path().join("runs").exists(), "a list makes nothing");
    let output = sweep(folder.path(), &[&GRID[..], &["--only", "2", "--out", "all"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let made: Vec<String> = fs::read_dir(folder.path().join("all"))
        .expect("a folder")
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .collect();
    assert_eq!(made.len(), 2, "{made:?}");
    assert!(made.contains(&"u0-0.2_viscosity-1e-6".to_owned()), "{made:?}");
    let output = sweep(folder.path(), &[&GRID[..], &["--only", "4"]].concat());
    assert!(text(&output.stderr).contains("indices 0 to 3"), "{}", text(&output.stderr));
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn faults_of_any_run_prevent_all_and_divergence_stops_only_its_own() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = sweep(folder.path(), &["--grid", "fluid.viscosity=1e-6,-1.0,-2.0"]);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("viscosity--1.0") && message.contains("one more run"), "{message}");
    assert!(message.contains("viscosity"), "{message}");
    assert!(!folder.path().join("runs").exists());
    // A stream of 300 times the speed of sound.
    let speeds = r#"initial.velocity=("0.1", "0"),("1500*sin(4*pi*x)", "0")"#;
    let output = sweep(folder.path(), &["--grid", speeds, "--set", "time.end=0.2"]);
    let said = text(&output.stdout);
    assert_eq!(output.status.code(), Some(3), "{said}{}", text(&output.stderr));
    assert!(said.contains("1 run completed, 1 diverged"), "{said}");
}
