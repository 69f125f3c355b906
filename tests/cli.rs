//! Exit codes, messages and files of the program.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use signal_hook::consts::{SIGINT, SIGTERM};
use tempfile::TempDir;

/// Time limit of the short runs below, reached only if something hangs.
const PATIENCE: Duration = Duration::from_secs(120);

fn sphecs<A: AsRef<OsStr>>(arguments: impl IntoIterator<Item = A>) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sphecs"));
    // Relative paths are those of the repository.
    command.current_dir(env!("CARGO_MANIFEST_DIR")).env_remove("RUST_BACKTRACE").args(arguments);
    command
}

fn answer<A: AsRef<OsStr>>(arguments: impl IntoIterator<Item = A>) -> Output {
    sphecs(arguments).output().expect("the program starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Asserts the exit code and words on standard error.
#[track_caller]
fn refused(output: &Output, code: i32, words: &[&str]) {
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{message}");
    for word in words {
        assert!(message.contains(word), "no `{word}` in:\n{message}");
    }
    assert!(!message.contains("panicked") && !message.contains("internal error"), "{message}");
}

#[track_caller]
fn done(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(0), "{}\n{}", text(&output.stdout), text(&output.stderr));
    text(&output.stdout)
}

fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
}

/// Returns a run of the quick scene at its smoke spacing.
fn short_run(out: &Path, more: &[&str]) -> Command {
    let mut command = sphecs(["run", "scenes/quickstart.ron", "--smoke", "--out"]);
    command.arg(out).args(more);
    command
}

/// Writes the quick scene with one passage replaced.
fn changed_scene(folder: &Path, passage: &str, by: &str) -> PathBuf {
    let scene =
        fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/quickstart.ron")).expect("the scene");
    assert!(scene.contains(passage), "the scene has no `{passage}`");
    let path = folder.join("changed.ron");
    fs::write(&path, scene.replacen(passage, by, 1)).expect("written");
    path
}

fn summary(run: &Path) -> serde_json::Value {
    let text = fs::read_to_string(run.join("summary.json")).expect("a summary");
    serde_json::from_str(&text).expect("JSON")
}

#[test]
fn invalid_command_line_is_bad_input() {
    refused(&answer::<&str>([]), 2, &["Usage"]);
    refused(&answer(["chekc", "scenes/quickstart.ron"]), 2, &["check"]);
    refused(&answer(["scenes/quickstart.ron", "--theads", "2"]), 2, &["--threads"]);
    refused(&answer(["run", "scenes/quickstart.ron", "--until", "soon"]), 2, &["number"]);
    refused(&answer(["bench", "--case", "4d-f32"]), 2, &["4d-f32", "2d-f32", "3d-sps-f64", "channel"]);
}

/// All ranks end with the first, which reports what stopped the flow.
#[test]
fn ranks_end_when_the_flow_diverges() {
    let folder = folder();
    let force = ["--set", "time.cfl=1.0", "--set", "body_force=(50.0, 0.0)"];
    let report = |ranks: &str| {
        let run = folder.path().join(ranks);
        let shared = ["--until", "2", "--quiet", "--threads", "1", "--ranks", ranks];
        let output = short_run(&run, &[&force[..], &shared].concat()).output().expect("the program starts");
        refused(&output, 3, &["the flow diverged at step"]);
        text(&output.stderr).lines().next().expect("a line").to_owned()
    };
    assert_eq!(report("3"), report("1"));
}

/// As a launcher of MPI starts a program that was built without MPI, twice.
#[test]
#[cfg(not(feature = "mpi"))]
fn several_processes_are_refused_without_mpi() {
    let folder = folder();
    let launchers = [["PMI_RANK", "PMI_SIZE"], ["OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"]];
    for ([rank, size], number) in launchers.into_iter().zip(["0", "1"]) {
        let started =
            |mut command: Command| command.env(rank, number).env(size, "2").output().expect("it starts");
        let run = short_run(&folder.path().join("run"), &[]);
        refused(&started(run), 2, &["2 processes", "--features mpi", "--ranks 2"]);
        refused(
            &started(short_run(&folder.path().join("run"), &["--ranks", "3"])),
            2,
            &["--ranks", "launcher"],
        );
        refused(&started(sphecs(["check", "scenes/quickstart.ron"])), 2, &["2 processes", "start one"]);
        assert_eq!(fs::read_dir(folder.path()).expect("the folder").count(), 0);
    }
    let alone = short_run(&folder.path().join("alone"), &["--steps", "2"]);
    done(&{ alone }.env("PMI_RANK", "0").env("PMI_SIZE", "1").output().expect("it starts"));
}

#[test]
fn help_has_examples_and_the_exit_codes() {
    let help = done(&answer(["--help"]));
    // Lines are broken anywhere.
    let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
    for word in ["sphecs scenes/quickstart.ron", "render", "130 interrupted"] {
        assert!(help.contains(word), "no `{word}` in:\n{help}");
    }
    for command in ["run", "resume", "check", "render", "info", "export", "pack", "bench", "new", "explain"] {
        assert!(done(&answer([command, "--help"])).contains("Usage"));
    }
}

#[test]
fn new_scene_passes_the_check_and_is_never_replaced() {
    let folder = folder();
    let name = folder.path().join("flow");
    let new = || answer(["new".as_ref(), "bend".as_ref(), name.as_os_str()]);
    let path = name.with_extension("ron");
    assert!(done(&new()).contains("flow.ron"));
    assert!(done(&answer(["check".as_ref(), path.as_os_str()])).contains("particles"));
    let before = fs::read_to_string(&path).expect("the scene");
    refused(&new(), 2, &["flow.ron", "never replaced"]);
    assert_eq!(fs::read_to_string(&path).expect("the scene"), before);
}

#[test]
fn path_of_the_scene_file_is_explained() {
    let text = done(&answer(["explain", "outlets.0.condition"]));
    for word in ["WaveEquation(…)", "example", "default"] {
        assert!(text.contains(word), "no `{word}` in:\n{text}");
    }
    refused(&answer(["explain", "outlets.conditon"]), 2, &["outlets.conditon", "did you mean `condition`?"]);
    let schema = done(&answer(["schema"]));
    assert!(serde_json::from_str::<serde_json::Value>(&schema).expect("JSON")["properties"].is_object());
}

#[test]
fn missing_scene_is_named() {
    refused(&answer(["scenes/nowhere.ron"]), 2, &["scenes/nowhere.ron"]);
}

#[test]
fn fault_in_a_scene_has_its_place_and_leaves_nothing() {
    let folder = folder();
    let scene = changed_scene(folder.path(), "spacing:", "spacign:");
    let line = 1 + fs::read_to_string(&scene)
        .expect("read")
        .find("spacign")
        .map_or(0, |at| fs::read_to_string(&scene).expect("read")[..at].matches('\n').count());
    let out = folder.path().join("out");
    let output = sphecs([scene.as_os_str(), OsStr::new("--out"), out.as_os_str()]).output().expect("started");
    refused(&output, 2, &["spacign", "spacing", &format!("changed.ron:{line}:")]);
    assert!(!out.exists(), "a folder was made for a scene with faults");
}

#[test]
fn wrong_path_of_a_set_suggests_the_nearest_one() {
    let output = answer(["check", "scenes/quickstart.ron", "--set", "fluid.sound_sped=1.0"]);
    refused(&output, 2, &["sound_sped", "sound_speed"]);
    let output = answer(["check", "scenes/quickstart.ron", "--set", "spacing=-1e-3"]);
    refused(&output, 2, &["spacing"]);
}

#[test]
fn check_prints_the_size_of_a_run_without_running() {
    let report = done(&answer(["check", "scenes/quickstart.ron", "--smoke"]));
    for word in ["fluid", "wall", "Re", "Mach", "steps", "across", "run time", "memory", "disk"] {
        assert!(report.contains(word), "no `{word}` in:\n{report}");
    }
}

#[test]
fn short_run_writes_results_and_pictures() {
    let folder = folder();
    let run = folder.path().join("run");
    let said = done(&short_run(&run, &["--steps", "20", "--threads", "2"]).output().expect("started"));
    for word in ["particles", "completed", "20 steps", "rates", "at the start", "particles.nc"] {
        assert!(said.contains(word), "no `{word}` in:\n{said}");
    }
    let figures = summary(&run);
    assert_eq!(figures["status"], "completed");
    assert_eq!(figures["steps"], 20);
    assert_eq!(figures["threads"], 2);
    assert_eq!(figures["ledger"]["balances"], true);
    for file in ["particles.nc", "monitor.nc", "monitor.csv", "scene.ron"] {
        assert!(run.join(file).is_file(), "no {file}");
    }

    let picture = folder.path().join("speed.png");
    done(
        &sphecs(["render"])
            .arg(&run)
            .args(["--field", "speed", "--width", "400", "-o"])
            .arg(&picture)
            .output()
            .expect("started"),
    );
    assert_eq!(fs::read(&picture).expect("a picture")[1..4], *b"PNG");
    let series = folder.path().join("series/pressure.png");
    done(
        &sphecs(["render"])
            .arg(&run)
            .args(["--field", "pressure", "--all", "--width", "300", "-o"])
            .arg(&series)
            .output()
            .expect("started"),
    );
    let pictures = fs::read_dir(folder.path().join("series")).expect("pictures").count();
    assert_eq!(pictures as u64, figures["frames"].as_u64().expect("a count"));

    let info = done(&sphecs(["info"]).arg(&run).output().expect("started"));
    assert!(info.contains("completed") && info.contains("frames"), "{info}");

    let vtu = folder.path().join("vtu");
    done(&sphecs(["export"]).arg(&run).args(["--vtu", "-o"]).arg(&vtu).output().expect("started"));
    let written: Vec<_> = fs::read_dir(&vtu).expect("a folder").flatten().map(|entry| entry.path()).collect();
    for extension in ["vtu", "pvd"] {
        assert!(
            written.iter().any(|path| path.extension() == Some(OsStr::new(extension))),
            "no .{extension} in {written:?}"
        );
    }

    // Packing a packed run changes nothing and succeeds.
    let before = fs::read(run.join("particles.nc")).expect("results");
    done(&sphecs(["pack"]).arg(&run).output().expect("started"));
    assert_eq!(fs::read(run.join("particles.nc")).expect("results"), before);
}

#[test]
fn earlier_run_is_replaced_only_by_force() {
    let folder = folder();
    let run = folder.path().join("run");
    done(&short_run(&run, &["--steps", "2"]).output().expect("started"));
    refused(&short_run(&run, &["--steps", "3"]).output().expect("started"), 2, &["--force"]);
    assert_eq!(summary(&run)["steps"], 2);
    done(&short_run(&run, &["--steps", "3", "--force"]).output().expect("started"));
    assert_eq!(summary(&run)["steps"], 3);

    let other = folder.path().join("thesis");
    fs::create_dir(&other).expect("a folder");
    fs::write(other.join("thesis.tex"), "years").expect("written");
    refused(&short_run(&other, &["--force"]).output().expect("started"), 2, &["thesis"]);
    assert!(other.join("thesis.tex").exists());
}

/// Pictures, planes and times that the run does not have are refused, not replaced by others.
#[test]
fn requests_for_what_a_run_does_not_have_are_refused() {
    let folder = folder();
    let run = folder.path().join("run");
    let said = done(&short_run(&run, &["--steps", "20"]).output().expect("started"));
    let checkpoints = fs::read_dir(run.join("checkpoints")).expect("checkpoints").count();
    for entry in fs::read_dir(&run).expect("read").flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        assert!(name == ".lock" || said.contains(&format!("  {name}")), "no `{name}` in:\n{said}");
    }
    assert!(said.contains(&format!("checkpoints/  {checkpoints} file")), "{said}");

    let render = |more: &[&str]| sphecs(["render"]).arg(&run).args(more).output().expect("started");
    refused(&render(&["--slice", "z"]), 2, &["2D", "leave `--slice` out"]);
    refused(&render(&["--time", "99"]), 2, &["no frame near t = 99 s", "from 0 to"]);
    refused(&render(&["-o", "flow.jpg"]), 2, &["`.png`"]);
    let plan = ["check", "scenes/quickstart.ron", "--slice", "y=0", "--no-timing", "--picture"];
    let plan = sphecs(plan).arg(folder.path().join("plan.png")).output().expect("started");
    refused(&plan, 2, &["leave `--slice` out"]);
    let folder_as_scene = sphecs([run.as_os_str()]).output().expect("started");
    refused(&folder_as_scene, 2, &["is a folder", "sphecs resume", "sphecs info"]);
}

#[test]
fn quiet_prints_nothing_and_verbose_every_frame() {
    let folder = folder();
    let quiet =
        short_run(&folder.path().join("quiet"), &["--steps", "2", "--quiet"]).output().expect("started");
    assert_eq!(done(&quiet), "");
    assert_eq!(text(&quiet.stderr), "");
    let verbose =
        short_run(&folder.path().join("verbose"), &["--steps", "2", "-v"]).output().expect("started");
    assert!(done(&verbose).contains("frame    0"));
}

#[test]
fn closed_standard_output_is_not_an_error() {
    let folder = folder();
    let mut command = short_run(&folder.path().join("run"), &["--steps", "5", "-v"]);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("started");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("ended");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
}

#[test]
fn folder_without_a_run_is_bad_input() {
    let folder = folder();
    for command in ["info", "pack"] {
        refused(&sphecs([command]).arg(folder.path()).output().expect("started"), 2, &["is not a run"]);
    }
}

#[test]
fn folder_that_cannot_be_made_is_a_file_error() {
    let folder = folder();
    fs::write(folder.path().join("file"), "in the way").expect("written");
    let output = short_run(&folder.path().join("file/run"), &["--steps", "1"]).output().expect("started");
    refused(&output, 4, &["file"]);
}

#[test]
fn divergence_is_located_and_frames_are_kept() {
    let folder = folder();
    let run = folder.path().join("run");
    // The force makes the flow supersonic, so the density leaves its bounds within some steps.
    let sets =
        ["--set", "fluid.sound_speed=0.11", "--set", "body_force=(50.0, 0.0)", "--set", "output.every=0.001"];
    let output = short_run(&run, &sets).output().expect("started");
    let report =
        ["in the step: density", "in the last frame, t =", "neighbours", "divergence.nc", "divergence.png"];
    refused(&output, 3, &["diverged", "step", "t =", "particle", "m"]);
    refused(&output, 3, &report);
    let figures = summary(&run);
    assert_eq!(figures["status"], "diverged");
    assert!(run.join("particles.nc").is_file());
    for name in ["divergence.nc", "divergence.png"] {
        assert!(run.join(name).is_file(), "{name}");
    }
}

/// An outlet that accelerates the stream is noted first and named after the divergence; the folder
/// has both.
#[test]
fn failing_outlet_is_named_before_and_after_the_divergence() {
    let folder = folder();
    let run = folder.path().join("run");
    let sets =
        ["--set", "outlets.0.condition=Mirror(variant: Linear)", "--set", "spacing=2.5e-3", "--until", "2"];
    let output = short_run(&run, &sets).output().expect("started");
    refused(&output, 3, &["diverged", "the plane of outlet 0, `Mirror`"]);
    let said = text(&output.stdout);
    assert!(said.contains("note: "), "{said}");
    let notes = summary(&run)["notes"].as_array().expect("notes").clone();
    assert!(notes.iter().any(|note| said.contains(note.as_str().expect("text"))), "{notes:?}\n{said}");
}

/// Starts a run without an end and waits for its first frame.
fn long_run(out: &Path) -> Child {
    let mut command = sphecs(["run", "scenes/quickstart.ron", "--until", "1e6", "--allow-oversize", "--out"]);
    let mut child = command.arg(out).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("started");
    wait_for(|| {
        assert!(child.try_wait().expect("a state").is_none(), "the run ended by itself");
        out.join("journal/frame-00000000.nc").exists()
    });
    child
}

#[track_caller]
fn wait_for(mut happened: impl FnMut() -> bool) {
    let started = Instant::now();
    while !happened() {
        assert!(started.elapsed() < PATIENCE, "timed out");
        std::thread::sleep(Duration::from_millis(20));
    }
}

fn send(child: &Child, signal: i32) {
    let sent =
        Command::new("kill").arg(format!("-{signal}")).arg(child.id().to_string()).status().expect("kill");
    assert!(sent.success());
}

#[test]
fn signal_ends_a_run_with_complete_files() {
    for (signal, code, status) in [(SIGINT, 130, "interrupted"), (SIGTERM, 143, "terminated")] {
        let folder = folder();
        let run = folder.path().join("run");
        let child = long_run(&run);
        send(&child, signal);
        let output = child.wait_with_output().expect("ended");
        let said = text(&output.stdout);
        assert_eq!(output.status.code(), Some(code), "{said}{}", text(&output.stderr));
        assert!(said.contains(status) && said.contains(" step"), "{said}");
        let figures = summary(&run);
        assert_eq!(figures["status"], status);
        assert!(figures["frames"].as_u64() >= Some(1));
        assert!(run.join("particles.nc").is_file() && !run.join("journal").exists());
    }
}

/// Rows are due at every step, frames at the first and the last only.
#[test]
fn row_due_at_the_last_step_is_written_once() {
    let folder = folder();
    let run = folder.path().join("run");
    let output =
        short_run(&run, &["--set", "output.monitor_every=1e-9", "--steps", "7"]).output().expect("started");
    done(&output);
    let rows = std::fs::read_to_string(run.join("monitor.csv")).expect("monitor.csv");
    assert_eq!(rows.lines().count(), 1 + 8, "{rows}");
    assert!(run.join("probes.nc").is_file());
}

#[test]
fn killed_run_is_packed_on_demand() {
    let folder = folder();
    let run = folder.path().join("run");
    let mut child = long_run(&run);
    child.kill().expect("killed");
    child.wait().expect("ended");
    assert!(!run.join("particles.nc").exists());
    done(&sphecs(["pack"]).arg(&run).output().expect("started"));
    assert!(run.join("particles.nc").is_file());
    assert!(done(&sphecs(["info"]).arg(&run).output().expect("started")).contains("running"));
}
