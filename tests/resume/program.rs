//! Calls of the program, and comparison of the results of two runs.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use sphecs_core::math::column::Columns;
use sphecs_output::checkpoint::container;
use sphecs_output::checkpoint::store::Store;
use tempfile::TempDir;

/// Time limit of the short runs, reached only if something hangs.
pub(crate) const PATIENCE: Duration = Duration::from_secs(120);

/// Frames every 25 and rows every 8 steps of the quick scene at its smoke spacing.
pub(crate) const OUTPUT: [&str; 4] = ["--set", "output.every=0.013", "--set", "output.monitor_every=0.0043"];

/// Forces on the walls in every step.
pub(crate) const BODIES: [&str; 2] =
    ["--set", "bodies=[(part: \"walls\", velocity: 0.1, area: 0.04, mean: (0.0, 0.02))]"];

/// Files of a finished run that depend only on the flow.
pub(crate) const RESULTS: [&str; 12] = [
    "fields.nc",
    "particles.nc",
    "monitor.nc",
    "monitor.csv",
    "probes.nc",
    "probes_points.csv",
    "probes/inlet.csv",
    "probes/gap.csv",
    "probes/axis.csv",
    "forces.nc",
    "forces.csv",
    "forces_mean.csv",
];

pub(crate) fn sphecs<A: AsRef<OsStr>>(arguments: impl IntoIterator<Item = A>) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sphecs"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).env_remove("RUST_BACKTRACE").args(arguments);
    command
}

pub(crate) fn run(scene: &str, out: &Path, more: &[&str]) -> Command {
    let mut command = sphecs(["run", scene, "--smoke", "--quiet", "--out"]);
    command.arg(out).args(OUTPUT).args(more);
    if scene == QUICK {
        command.args(BODIES);
    }
    command
}

pub(crate) const QUICK: &str = "scenes/quickstart.ron";

pub(crate) fn resume(run: &Path, more: &[&str]) -> Command {
    let mut command = sphecs(["resume"]);
    command.arg(run).args(more);
    command
}

pub(crate) fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

pub(crate) fn answer(mut command: Command) -> Output {
    command.output().expect("the program starts")
}

/// Asserts the exit code and returns standard output and error.
#[track_caller]
pub(crate) fn ends(command: Command, code: i32) -> String {
    let output = answer(command);
    let said = text(&output.stdout) + &text(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{said}");
    assert!(!said.contains("internal error"), "{said}");
    said
}

#[track_caller]
pub(crate) fn refused(command: Command, words: &[&str]) {
    let said = ends(command, 2);
    for word in words {
        assert!(said.contains(word), "no `{word}` in:\n{said}");
    }
}

pub(crate) fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
}

pub(crate) fn checkpoints(run: &Path) -> Vec<PathBuf> {
    Store::of(run).files().expect("read")
}

/// Returns the state of a checkpoint without that of the run loop, which has wall times.
pub(crate) fn state(path: &Path) -> Columns {
    let checkpoint = container::read(&fs::read(path).expect("read")).expect("intact");
    let mut state = checkpoint.state;
    state.take::<u8>("run.log").expect("the run loop");
    state
}

/// Asserts equal final states, bitwise identical results and no incomplete files.
#[track_caller]
pub(crate) fn same(one: &Path, other: &Path, what: &str) {
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
        assert!(!name.contains("partial") && !name.contains("journal"), "{what}: `{name}` is left");
    }
}

/// Starts a run without an end.
pub(crate) fn long_run(out: &Path, more: &[&str]) -> Child {
    let mut command = run(QUICK, out, &["--until", "1e6", "--allow-oversize"]);
    command.args(more).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("started")
}

#[track_caller]
pub(crate) fn wait_for(mut happened: impl FnMut() -> bool) {
    let started = Instant::now();
    while !happened() {
        assert!(started.elapsed() < PATIENCE, "timed out");
        std::thread::sleep(Duration::from_millis(5));
    }
}

pub(crate) fn copy_folder(from: &Path, to: &Path) {
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
