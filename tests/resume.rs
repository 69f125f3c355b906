//! A run that is stopped, killed or damaged and resumed leaves the same bytes as one that was never broken off.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use signal_hook::consts::{SIGINT, SIGTERM, SIGUSR1};
use sphecs::math::column::Columns;
use sphecs::output::checkpoint::container;
use sphecs::output::checkpoint::store::Store;
use tempfile::TempDir;

/// Long enough for any of the short runs below on a busy machine; reached only when something hangs.
const PATIENCE: Duration = Duration::from_secs(120);

/// Frames every 25 steps, rows every 8, at the step of the coarse quick scene.
const OUTPUT: [&str; 4] = ["--set", "output.every=0.013", "--set", "output.monitor_every=0.0043"];

/// Forces in every step, where there are walls.
const BODIES: [&str; 2] =
    ["--set", "bodies=[(part: \"walls\", velocity: 0.1, area: 0.04, mean: (0.0, 0.02))]"];

/// Files of a finished run that depend on the flow alone.
const RESULTS: [&str; 8] = [
    "particles.nc",
    "monitor.nc",
    "monitor.csv",
    "probes.nc",
    "probes.csv",
    "forces.nc",
    "forces.csv",
    "forces_mean.csv",
];

fn sphecs<A: AsRef<OsStr>>(arguments: impl IntoIterator<Item = A>) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sphecs"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).env_remove("RUST_BACKTRACE").args(arguments);
    command
}

fn run(scene: &str, out: &Path, more: &[&str]) -> Command {
    let mut command = sphecs(["run", scene, "--smoke", "--quiet", "--out"]);
    command.arg(out).args(OUTPUT).args(more);
    if scene == QUICK {
        command.args(BODIES);
    }
    command
}

const QUICK: &str = "scenes/quickstart.ron";

fn resume(run: &Path, more: &[&str]) -> Command {
    let mut command = sphecs(["resume"]);
    command.arg(run).args(more);
    command
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn answer(mut command: Command) -> Output {
    command.output().expect("the program starts")
}

/// Ends with this code; what it said on both channels.
#[track_caller]
fn ends(command: Command, code: i32) -> String {
    let output = answer(command);
    let said = text(&output.stdout) + &text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{said}");
    assert!(!said.contains("fault of its own"), "{said}");
    said
}

#[track_caller]
fn refused(command: Command, words: &[&str]) {
    let said = ends(command, 2);
    for word in words {
        assert!(said.contains(word), "no `{word}` in:\n{said}");
    }
}

fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
}

fn checkpoints(run: &Path) -> Vec<PathBuf> {
    Store::of(run).files().expect("read")
}

/// The state of a checkpoint without the log, which holds wall times.
fn state(path: &Path) -> Columns {
    let checkpoint = container::read(&fs::read(path).expect("read")).expect("whole");
    let mut state = checkpoint.state;
    state.take::<u8>("run.log").expect("a log");
    state
}

/// The same state at the end and the same bytes in all results, and nothing half written.
#[track_caller]
fn same(one: &Path, other: &Path, what: &str) {
    let [a, b] = [one, other].map(|run| state(&checkpoints(run)[0]));
    let differ = a.iter().zip(b.iter()).filter(|((_, a), (_, b))| a != b).map(|((name, _), _)| name);
    let differ: Vec<&str> = differ.collect();
    assert!(
        differ.is_empty() && a.iter().count() == b.iter().count(),
        "{what}: the states differ in {differ:?}"
    );
    for name in RESULTS.into_iter().filter(|name| one.join(name).exists()) {
        let [a, b] = [one, other].map(|run| fs::read(run.join(name)).expect(name));
        assert!(a == b, "{what}: `{name}` differs");
    }
    for entry in
        fs::read_dir(other).expect("read").chain(fs::read_dir(other.join("checkpoints")).expect("read"))
    {
        let name = entry.expect("an entry").file_name().to_string_lossy().into_owned();
        assert!(!name.contains("partial") && !name.contains("journal"), "{what}: `{name}` is left over");
    }
}

#[test]
fn a_stopped_run_leaves_the_same_bytes_when_resumed() {
    let folder = folder();
    // Cuts between outputs, at an output, and while particles are injected: in the quick scene one crosses every few steps from step 300
    // on, and at its end here a frame is due.
    let scenes: [(&str, &str, &[&str]); 5] = [
        (QUICK, "425", &["173", "310", "333"]),
        ("scenes/taylor_green.ron", "60", &["1", "33"]),
        ("scenes/duct3d.ron", "40", &["17"]),
        ("scenes/acoustic_pulse.ron", "60", &["29"]),
        // Its smoothing length is one that JSON read without care changes by its last bit.
        ("scenes/duct_laminar.ron", "30", &["13"]),
    ];
    for (scene, end, cuts) in scenes {
        let name = Path::new(scene).file_stem().expect("a name").to_string_lossy().into_owned();
        let whole = folder.path().join(&name);
        ends(run(scene, &whole, &["--steps", end, "--threads", "1"]), 0);
        let pieces = folder.path().join(format!("{name}_pieces"));
        ends(run(scene, &pieces, &["--steps", cuts[0], "--threads", "2"]), 0);
        for (cut, threads) in cuts[1..].iter().chain([&end]).zip(["3", "1", "2"]) {
            ends(resume(&pieces, &["--quiet", "--steps", cut, "--threads", threads]), 0);
        }
        same(&whole, &pieces, scene);
    }
}

/// A run that would last for long.
fn long_run(out: &Path, more: &[&str]) -> Child {
    let mut command = run(QUICK, out, &["--until", "1e6", "--allow-oversize"]);
    command.args(more).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("started")
}

#[track_caller]
fn wait_for(mut happened: impl FnMut() -> bool) {
    let started = Instant::now();
    while !happened() {
        assert!(started.elapsed() < PATIENCE, "waited in vain");
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn send(child: &Child, signal: i32) {
    let sent =
        Command::new("kill").arg(format!("-{signal}")).arg(child.id().to_string()).status().expect("kill");
    assert!(sent.success());
}

/// Steps of the last checkpoint.
fn reached(run: &Path) -> u64 {
    let bytes = fs::read(&checkpoints(run)[0]).expect("read");
    container::read(&bytes).expect("whole").facts.step
}

/// Resumes a run to some steps beyond where it is, runs the same without a break and compares.
#[track_caller]
fn goes_on_as_if_never_stopped(run_folder: &Path, what: &str) {
    let end = (reached(run_folder) + 60).to_string();
    ends(resume(run_folder, &["--quiet", "--steps", &end]), 0);
    let whole = run_folder.with_extension("whole");
    ends(run(QUICK, &whole, &["--steps", &end]), 0);
    same(&whole, run_folder, what);
}

#[test]
fn a_signal_leaves_a_checkpoint_and_its_exit_code() {
    for (signal, code) in [(SIGINT, 130), (SIGTERM, 143)] {
        let folder = folder();
        let out = folder.path().join("run");
        let mut child = long_run(&out, &[]);
        wait_for(|| out.join("journal/frame-00000003.nc").exists());
        send(&child, signal);
        assert_eq!(child.wait().expect("ended").code(), Some(code));
        assert_eq!(checkpoints(&out).len(), 1);
        // The last row and frame, which an unbroken run does not have, are cut off again.
        goes_on_as_if_never_stopped(&out, &format!("signal {signal}"));
    }
}

#[test]
fn a_checkpoint_is_written_on_request_and_the_run_goes_on() {
    let folder = folder();
    let out = folder.path().join("run");
    let mut child = long_run(&out, &[]);
    wait_for(|| out.join("journal/frame-00000001.nc").exists());
    for count in 1..=3_usize {
        let before = checkpoints(&out).first().cloned();
        send(&child, SIGUSR1);
        wait_for(|| checkpoints(&out).first().cloned() != before);
        // The last two are kept; the third may stand for the moment of its removal.
        wait_for(|| checkpoints(&out).len() == count.min(2));
        assert!(child.try_wait().expect("a state").is_none(), "the run ended");
    }
    child.kill().expect("killed");
    child.wait().expect("ended");
    goes_on_as_if_never_stopped(&out, "kill after SIGUSR1");
}

#[test]
fn the_wall_time_ends_a_run_with_code_75() {
    let folder = folder();
    let out = folder.path().join("run");
    let mut child = long_run(&out, &["--max-walltime", "0.7s"]);
    assert_eq!(child.wait().expect("ended").code(), Some(75));
    let summary = fs::read_to_string(out.join("summary.json")).expect("a summary");
    assert!(summary.contains("\"out of time\""), "{summary}");
    ends(resume(&out, &["--quiet", "--max-walltime", "0.5s"]), 75);
    goes_on_as_if_never_stopped(&out, "wall time");
}

/// Kills a run again and again, whenever it comes to it, until it is done.
#[test]
fn a_run_that_is_killed_again_and_again_comes_to_the_same_end() {
    let folder = folder();
    let (whole, killed) = (folder.path().join("whole"), folder.path().join("killed"));
    let end = ["--steps", "700"];
    ends(run(QUICK, &whole, &end), 0);
    let often = ["--checkpoint-every", "0.05s"];
    let mut kills = 0;
    for round in 0_u64.. {
        assert!(round < 400, "the run does not come to its end");
        let mut command = match killed.exists() {
            false => run(QUICK, &killed, &end),
            true => resume(&killed, &["--quiet"]),
        };
        let mut child = command.args(often).stdout(Stdio::null()).spawn().expect("started");
        // Some before the first frame, some in the packing.
        std::thread::sleep(Duration::from_millis(40 + 47 * (round % 13) + round * 6));
        if let Some(status) = child.try_wait().expect("a state") {
            assert_eq!(status.code(), Some(0), "round {round}");
            break;
        }
        child.kill().expect("killed");
        child.wait().expect("ended");
        kills += 1;
        if killed.exists() {
            ends(sphecs([OsStr::new("info"), killed.as_os_str()]), 0);
        }
    }
    assert!(kills >= 3, "only {kills} kills before the end");
    same(&whole, &killed, &format!("{kills} kills"));
}

/// A run of two checkpoints and the same without a break.
fn twice_stopped(folder: &Path) -> (PathBuf, PathBuf) {
    let (whole, pieces) = (folder.join("whole"), folder.join("pieces"));
    ends(run(QUICK, &whole, &["--steps", "150"]), 0);
    ends(run(QUICK, &pieces, &["--steps", "60"]), 0);
    ends(resume(&pieces, &["--quiet", "--steps", "110"]), 0);
    assert_eq!(checkpoints(&pieces).len(), 2);
    (whole, pieces)
}

#[test]
fn a_damaged_checkpoint_is_named_and_the_one_before_it_taken() {
    let folder = folder();
    let (whole, pieces) = twice_stopped(folder.path());
    let last = checkpoints(&pieces)[0].clone();
    let mut bytes = fs::read(&last).expect("read");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 0x20;
    fs::write(&last, bytes).expect("written");
    let said = ends(resume(&pieces, &["--steps", "150"]), 0);
    for word in ["step-000000000110", "is damaged", "checksum", "the one of step 60 is taken"] {
        assert!(said.contains(word), "no `{word}` in:\n{said}");
    }
    same(&whole, &pieces, "damaged");
}

#[test]
fn a_checkpoint_that_does_not_belong_here_is_not_taken() {
    let folder = folder();
    let (whole, pieces) = twice_stopped(folder.path());
    let [last, before] = [0, 1].map(|at| checkpoints(&pieces)[at].clone());
    let sound = fs::read(&last).expect("read");

    // Of another version of the layout, whole: the versions are named, and nothing is done.
    let mut other = sound.clone();
    other[8..12].copy_from_slice(&9_u32.to_le_bytes());
    let body = other.len() - 32;
    let digest = <sha2::Sha256 as sha2::Digest>::digest(&other[..body]);
    other[body..].copy_from_slice(&digest);
    fs::write(&last, &other).expect("written");
    refused(resume(&pieces, &["--steps", "150"]), &["version 9", "version 2", "step-000000000110"]);
    fs::write(&last, &sound).expect("written");

    // On other lanes: only if asked for. Where a machine has none but the portable ones, there are no others.
    let mut portable = resume(&pieces, &["--steps", "150"]);
    portable.env("SPHECS_LANES", "portable");
    let lanes = sphecs::math::lanes::InstructionSet::best().name();
    if lanes != "portable" {
        refused(portable, &[lanes, "portable", "--allow-other-isa"]);
        let copy = folder.path().join("copy");
        copy_folder(&pieces, &copy);
        let mut allowed = resume(&copy, &["--steps", "115", "--allow-other-isa"]);
        allowed.env("SPHECS_LANES", "portable");
        assert!(ends(allowed, 0).contains("the bits will differ"));
    }

    // Of another scene, under the name of the last; then with nothing whole at all.
    let foreign = folder.path().join("foreign");
    ends(run("scenes/taylor_green.ron", &foreign, &["--steps", "5"]), 0);
    fs::copy(&checkpoints(&foreign)[0], &last).expect("copied");
    let copy = folder.path().join("bare");
    copy_folder(&pieces, &copy);
    for path in checkpoints(&copy) {
        let half = fs::read(&path).expect("read");
        fs::write(&path, &half[..half.len() / 2]).expect("written");
    }
    refused(resume(&copy, &[]), &["no checkpoint can be gone on from", "is damaged", "step-000000000060"]);
    let said = ends(resume(&pieces, &["--steps", "150"]), 0);
    assert!(said.contains("is of another scene") && said.contains("the one of step 60 is taken"), "{said}");
    assert!(before.exists());
    same(&whole, &pieces, "foreign");
}

fn copy_folder(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("a folder");
    for entry in fs::read_dir(from).expect("read").map(|entry| entry.expect("an entry")) {
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy_folder(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).expect("copied");
        }
    }
}

#[test]
fn only_what_does_not_change_the_flow_may_be_changed() {
    let folder = folder();
    let out = folder.path().join("run");
    ends(run(QUICK, &out, &["--steps", "40"]), 0);
    refused(resume(&out, &["--set", "fluid.viscosity=1.0e-5"]), &["fluid.viscosity", "time.end", "anew"]);
    refused(resume(&out, &["--set", "time.end=-1.0"]), &["`end`", "greater than 0"]);
    // At its end: nothing to do is no fault, and changes nothing.
    let before = fs::read(out.join("particles.nc")).expect("results");
    assert!(ends(resume(&out, &[]), 0).contains("is at its end"));
    assert_eq!(fs::read(out.join("particles.nc")).expect("results"), before);
    // Another end and another interval, which stay when it is stopped again.
    let sets = ["--set", "output.every=0.02", "--set", "time.end=2.5"];
    ends(resume(&out, &[&["-q", "--steps", "60"], &sets[..]].concat()), 0);
    let times: Vec<String> = ends(sphecs([OsStr::new("info"), out.as_os_str()]), 0)
        .lines()
        .filter(|line| line.starts_with("frames") || line.starts_with("reached"))
        .map(str::to_owned)
        .collect();
    assert!(times.iter().any(|line| line.contains("of 2.5 s in 60 steps")), "{times:?}");
    ends(resume(&out, &["-q", "--until", "0.06"]), 0);
    let scene = out.join("scene.ron");
    let text = fs::read_to_string(&scene).expect("the scene");
    fs::write(&scene, text.replacen("viscosity:", "viscosity: 2.0 * ", 1)).expect("written");
    refused(resume(&out, &["--until", "0.07"]), &["scene.ron", "has been changed"]);
}

#[test]
fn rows_and_frames_that_are_missing_make_a_checkpoint_unfit() {
    let folder = folder();
    let (_, pieces) = twice_stopped(folder.path());
    let rows = fs::read(pieces.join("monitor.csv")).expect("rows");
    fs::write(pieces.join("monitor.csv"), &rows[..rows.len() / 3]).expect("written");
    refused(resume(&pieces, &["--steps", "150"]), &["monitor.csv", "bytes", "no checkpoint"]);
    fs::write(pieces.join("monitor.csv"), &rows).expect("written");
    fs::remove_file(pieces.join("particles.nc")).expect("removed");
    refused(resume(&pieces, &["--steps", "150"]), &["frames, the run has 0"]);
}

#[test]
fn one_process_at_a_time_writes_a_run() {
    let folder = folder();
    let out = folder.path().join("run");
    let mut child = long_run(&out, &[]);
    wait_for(|| out.join("journal/frame-00000000.nc").exists());
    for _ in 0..3 {
        for command in [
            resume(&out, &[]),
            run(QUICK, &out, &["--force", "--steps", "2"]),
            sphecs([OsStr::new("pack"), out.as_os_str()]),
        ] {
            let said = ends(command, 4);
            assert!(said.contains("another process"), "{said}");
        }
    }
    assert!(child.try_wait().expect("a state").is_none(), "the run ended");
    child.kill().expect("killed");
    child.wait().expect("ended");
    // The lock of a process that is gone holds nobody back; killed before its first checkpoint, the run begins anew.
    let said = ends(resume(&out, &["--steps", "30"]), 0);
    assert!(said.contains("begins anew"), "{said}");
    let whole = folder.path().join("whole");
    ends(run(QUICK, &whole, &["--steps", "30"]), 0);
    same(&whole, &out, "begun anew");
}

#[test]
fn processes_that_make_the_same_folder_take_turns() {
    let folder = folder();
    let out = folder.path().join("run");
    let start = || run(QUICK, &out, &["--steps", "20"]).stdout(Stdio::null()).stderr(Stdio::piped()).spawn();
    let children: Vec<Child> = (0..4).map(|_| start().expect("started")).collect();
    let ended: Vec<Output> =
        children.into_iter().map(|child| child.wait_with_output().expect("ended")).collect();
    let codes: Vec<Option<i32>> = ended.iter().map(|output| output.status.code()).collect();
    assert_eq!(codes.iter().filter(|code| **code == Some(0)).count(), 1, "{codes:?}");
    for output in ended.iter().filter(|output| output.status.code() != Some(0)) {
        let said = text(&output.stderr);
        assert!(said.contains("holds an earlier run"), "{said}");
    }
    assert_eq!(
        fs::read_dir(folder.path()).expect("read").count(),
        1,
        "something is left over beside the run"
    );
}

#[test]
#[cfg(unix)]
fn a_run_whose_files_lead_elsewhere_is_not_gone_on_with() {
    let folder = folder();
    let out = folder.path().join("run");
    ends(run(QUICK, &out, &["--steps", "20"]), 0);
    let elsewhere = folder.path().join("elsewhere.csv");
    fs::rename(out.join("monitor.csv"), &elsewhere).expect("moved");
    std::os::unix::fs::symlink(&elsewhere, out.join("monitor.csv")).expect("a link");
    let before = fs::read(&elsewhere).expect("read");
    refused(resume(&out, &["--steps", "30"]), &["monitor.csv", "is a link"]);
    assert_eq!(fs::read(&elsewhere).expect("read"), before);
}

#[test]
fn the_tables_of_a_scene_come_along() {
    let folder = folder();
    let scene =
        fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/quickstart.ron")).expect("the scene");
    let table = folder.path().join("ramp.csv");
    fs::write(&table, "# s, m/s\n0, 0\n0.1, 0.05\n10, 0.05\n").expect("written");
    let start = scene.find("velocity: Normal(").expect("an inlet");
    let end = start + scene[start..].find(")\"").map_or(0, |at| at + 2);
    let end = end + scene[end..].find(')').expect("its bracket") + 1;
    let path = folder.path().join("table.ron");
    let by = r#"velocity: TimeTable(file: "ramp.csv")"#;
    fs::write(&path, format!("{}{by}{}", &scene[..start], &scene[end..])).expect("written");
    let (whole, pieces) = (folder.path().join("whole"), folder.path().join("pieces"));
    let path = path.to_string_lossy().into_owned();
    ends(run(&path, &whole, &["--steps", "120"]), 0);
    ends(run(&path, &pieces, &["--steps", "50"]), 0);
    fs::remove_file(&table).expect("removed");
    ends(resume(&pieces, &["-q", "--steps", "120"]), 0);
    same(&whole, &pieces, "table");
}
