//! What no machine holds is refused before anything is made of it, with the field to change.

use std::process::Command;

/// Runs a shipped scene for two steps with values set; its exit code, message, and whether it left
/// a folder.
fn run(scene: &str, sets: &[&str], more: &[&str]) -> (Option<i32>, String, bool) {
    let parent = tempfile::tempdir().expect("a folder");
    let out = parent.path().join("run");
    let mut command = Command::new(env!("CARGO_BIN_EXE_sphecs"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).env_remove("RUST_BACKTRACE");
    command.arg("run").arg(format!("scenes/{scene}.ron")).args(["-q", "--threads", "1", "--out"]).arg(&out);
    for set in sets {
        command.args(["--set", set]);
    }
    let output = command.args(more).output().expect("the program starts");
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned(), out.exists())
}

#[track_caller]
fn is_refused(scene: &str, sets: &[&str], code: i32, words: &[&str]) {
    let (found, message, left) = run(scene, sets, &[]);
    assert_eq!(found, Some(code), "{sets:?}: {message}");
    assert!(!left, "{sets:?}: left a folder");
    for word in words {
        assert!(message.contains(word), "{sets:?}: no `{word}` in\n{message}");
    }
}

#[test]
fn more_particles_than_memory_are_refused_with_a_spacing_that_fits() {
    let particles: [(&str, &[&str]); 14] = [
        ("quickstart", &["spacing=1e-6"]),
        ("quickstart", &["spacing=1e-9"]),
        ("quickstart", &["spacing=1e-12"]),
        ("quickstart", &["spacing=1e-300"]),
        ("quickstart", &["constants.L=1e6"]),
        ("quickstart", &["constants.L=1e9"]),
        ("quickstart", &["constants.L=1e18"]),
        ("quickstart", &["constants.D=1e15"]),
        ("duct3d", &["spacing=1e-6"]),
        ("duct3d", &["spacing=1e-9"]),
        ("duct3d", &["spacing=1e-12"]),
        ("square_bend", &["spacing=1e-5"]),
        ("square_bend", &["spacing=1e-12"]),
        ("taylor_green", &["spacing=1e-7"]),
    ];
    for (scene, sets) in particles {
        is_refused(scene, sets, 2, &["too many particles", "spacing", "GB", ".ron:", "--allow-oversize"]);
    }
}

#[test]
fn a_reservoir_beyond_memory_and_particle_numbers_is_refused() {
    for particles in ["1000000000", "1000000000000", "1000000000000000000"] {
        let set = format!("reservoir=(particles: {particles})");
        is_refused("quickstart", &[&set], 2, &["reservoir", "must be", ".ron:"]);
    }
}

#[test]
fn zones_kernels_and_probes_beyond_reason_are_refused() {
    let line = |count: &str| {
        format!("output.probes=[(name: \"a\", kind: Line(from: (0.0, 0.0), to: (0.1, 0.0), count: {count}))]")
    };
    let (long, endless) = (line("1000000000"), line("1000000000000000000"));
    let sets: [(&str, &str); 9] = [
        ("inlets.0.depth=1e9", "depth"),
        ("outlets.0.depth=1e12", "depth"),
        ("scheme=Wcsph(smoothing_ratio: 1e6)", "h/Δ"),
        ("scheme=Wcsph(smoothing_ratio: 1e-6)", "h/Δ"),
        ("spacing=1e999", "spacing"),
        ("spacing=-1.0", "spacing"),
        ("fluid.sound_speed=NaN", "sound_speed"),
        (&long, "1000000"),
        (&endless, "whole number"),
    ];
    for (set, word) in sets {
        is_refused("quickstart", &[set], 2, &[word, ".ron:"]);
    }
}

#[test]
fn more_output_than_the_disk_holds_is_refused_with_an_interval_that_fits() {
    let outputs: [(&[&str], &str); 4] = [
        (&["time.end=1e9", "output.every=1e-9", "output.monitor_every=1e6"], "output.every"),
        (&["time.end=1e12", "output.every=1e3", "output.monitor_every=1e9"], "output.every"),
        (&["time.end=1e12", "output.every=1e11", "output.monitor_every=1e-3"], "output.monitor_every"),
        (&["time.end=1e30", "output.every=1e-12"], "--out"),
    ];
    for (sets, word) in outputs {
        is_refused("quickstart", sets, 4, &[word, "frames", "free", "--allow-oversize"]);
    }
}

#[test]
fn run_beyond_the_disk_starts_with_allow_oversize() {
    let sets = ["time.end=1e12", "output.every=1e3", "output.monitor_every=1e9"];
    let (code, message, left) = run("quickstart", &sets, &["--steps", "2", "--allow-oversize"]);
    assert_eq!(code, Some(0), "{message}");
    assert!(left);
    // Two steps of the same need hardly any space.
    let (code, message, _) = run("quickstart", &sets, &["--steps", "2"]);
    assert_eq!(code, Some(0), "{message}");
}

#[test]
fn scene_too_fine_for_memory_runs_at_its_smoke_spacing() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/quickstart.ron"));
    let fine = text.expect("a scene").replace("spacing: 1.25e-3", "spacing: 1e-9");
    let scene = folder.path().join("fine.ron");
    std::fs::write(&scene, fine).expect("a file");
    let check = |more: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_sphecs"));
        command.arg("run").arg(&scene).args(["-q", "--threads", "1", "--steps", "2", "--smoke"]);
        command.arg("--out").arg(folder.path().join("run")).args(more);
        command.output().expect("the program starts").status.code()
    };
    assert_eq!(check(&["--set", "spacing=1e-9"]), Some(2), "a spacing that is set has precedence");
    assert_eq!(check(&[]), Some(0));
    is_refused("quickstart", &["spacing=-1.0"], 2, &["spacing", ".ron:"]);
}
