//! Runs stopped by steps, wall time, a signal or a kill, and resumed with bitwise identical
//! results.

use std::ffi::OsStr;
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGUSR1, SIGUSR2, SIGXCPU};
use sphecs_output::checkpoint::container;

use crate::program::{QUICK, checkpoints, ends, folder, long_run, resume, run, same, sphecs, wait_for};

#[test]
fn resumed_run_is_bitwise_identical() {
    let folder = folder();
    // Stops between outputs, at an output, and while particles are injected: in the quick scene one
    // is injected every few steps from step 300 on. At its last step a frame is due.
    let scenes: [(&str, &str, &[&str]); 5] = [
        (QUICK, "425", &["173", "310", "333"]),
        ("scenes/taylor_green.ron", "60", &["1", "33"]),
        ("scenes/duct3d.ron", "40", &["17"]),
        ("scenes/acoustic_pulse.ron", "60", &["29"]),
        // JSON without exact round trips would change the last bit of its smoothing length.
        ("scenes/duct_laminar.ron", "30", &["13"]),
    ];
    for (scene, end, cuts) in scenes {
        let name = Path::new(scene).file_stem().expect("a name").to_string_lossy().into_owned();
        let whole = folder.path().join(&name);
        ends(run(scene, &whole, &["--steps", end, "--threads", "1"]), 0);
        let pieces = folder.path().join(format!("{name}_pieces"));
        ends(run(scene, &pieces, &["--steps", cuts[0], "--threads", "2"]), 0);
        for (cut, (ranks, threads)) in
            cuts[1..].iter().chain([&end]).zip([("4", "1"), ("1", "3"), ("3", "2")])
        {
            let shared = ["--ranks", ranks, "--threads", threads];
            ends(resume(&pieces, &[&["--quiet", "--steps", cut][..], &shared].concat()), 0);
        }
        same(&whole, &pieces, scene);
    }
}

/// Means on grids are sums over all steps of their interval, so that a restart inside it shows.
#[test]
fn gridded_fields_and_their_means_resume_bitwise_identically() {
    let folder = folder();
    let planes = "output.fields=(every: 2e-3, volume: true, mean: (1e-3, 8e-3), mean_every: 1e-6, planes: [\
                  (name: \"mid\", at: (0.0, 0.0, 0.0), normal: (0.0, 0.0, 1.0)), \
                  (name: \"cut\", at: (0.0, 0.0, 0.0), normal: (1.0, 2.0, 0.0))])";
    let plane = "output.fields=(every: 0.04, mean: (0.05, 0.2))";
    let moving = "output.fields=(every: 0.02, mean: (0.01, 0.05), mean_every: 1e-6)";
    let scenes = [
        (QUICK, plane, "300", ["110", "173"]),
        ("scenes/duct3d.ron", planes, "40", ["9", "23"]),
        ("scenes/stirrer.ron", moving, "40", ["13", "29"]),
    ];
    for (scene, fields, end, cuts) in scenes {
        let name = Path::new(scene).file_stem().expect("a name").to_string_lossy().into_owned();
        let whole = folder.path().join(&name);
        ends(run(scene, &whole, &["--set", fields, "--steps", end, "--threads", "1"]), 0);
        let pieces = folder.path().join(format!("{name}_pieces"));
        let shared = ["--threads", "1", "--ranks", "2"];
        ends(run(scene, &pieces, &[&["--set", fields, "--steps", cuts[0]][..], &shared].concat()), 0);
        for (cut, threads) in [cuts[1], end].into_iter().zip(["3", "1"]) {
            ends(resume(&pieces, &["--quiet", "--steps", cut, "--threads", threads]), 0);
        }
        assert!(whole.join("fields.nc").exists(), "{scene}");
        same(&whole, &pieces, scene);
    }
}

fn send(child: &Child, signal: i32) {
    let sent =
        Command::new("kill").arg(format!("-{signal}")).arg(child.id().to_string()).status().expect("kill");
    assert!(sent.success());
}

/// Returns the step of the last checkpoint.
fn reached(run: &Path) -> u64 {
    let bytes = fs::read(&checkpoints(run)[0]).expect("read");
    container::read(&bytes).expect("intact").facts.step
}

/// Resumes a run for some steps and compares it with an uninterrupted run.
#[track_caller]
fn assert_resumes_identically(run_folder: &Path, what: &str) {
    let end = (reached(run_folder) + 60).to_string();
    ends(resume(run_folder, &["--quiet", "--steps", &end]), 0);
    let whole = run_folder.with_extension("whole");
    ends(run(QUICK, &whole, &["--steps", &end]), 0);
    same(&whole, run_folder, what);
}

/// Starts a run without an end through a program that sets how it takes signals.
fn long_run_through(through: &[&str], out: &Path) -> Child {
    let run = run(QUICK, out, &["--until", "1e6", "--allow-oversize"]);
    let mut command = Command::new(through[0]);
    command.args(&through[1..]).arg(run.get_program()).args(run.get_args());
    command.current_dir(env!("CARGO_MANIFEST_DIR")).stdin(Stdio::null()).stdout(Stdio::null());
    let child = command.stderr(Stdio::piped()).spawn().expect("started");
    wait_for(|| out.join("journal/frame-00000003.nc").exists());
    child
}

#[test]
fn signal_leaves_a_checkpoint_and_its_exit_code() {
    // The process that runs the tests may ignore a signal, and its children with it.
    let default = ["env", "--default-signal"];
    for (signal, code) in [(SIGINT, 130), (SIGTERM, 143), (SIGHUP, 129), (SIGXCPU, 152)] {
        let folder = folder();
        let out = folder.path().join("run");
        let mut child = long_run_through(&default, &out);
        send(&child, signal);
        if [SIGHUP, SIGXCPU].contains(&signal) {
            // Terminals and the system repeat these, so a second one does not kill.
            send(&child, signal);
        }
        assert_eq!(child.wait().expect("ended").code(), Some(code));
        assert_eq!(checkpoints(&out).len(), 1);
        // The last row and frame, which an uninterrupted run does not have, are cut off.
        assert_resumes_identically(&out, &format!("signal {signal}"));
    }
}

#[test]
fn run_under_nohup_outlives_its_terminal() {
    let folder = folder();
    let out = folder.path().join("run");
    let mut child = long_run_through(&["nohup"], &out);
    send(&child, SIGHUP);
    let frames = || fs::read_dir(out.join("journal")).map_or(0, Iterator::count);
    let before = frames();
    wait_for(|| frames() > before + 2);
    assert!(child.try_wait().expect("a state").is_none(), "the run ended");
    send(&child, SIGTERM);
    assert_eq!(child.wait().expect("ended").code(), Some(143));
}

/// The system kills a process at this limit unless it handles the signal.
#[test]
fn file_beyond_its_limit_ends_the_run_in_order() {
    let folder = folder();
    let out = folder.path().join("run");
    let quick = run(QUICK, &out, &["--steps", "400"]);
    let mut command = Command::new("sh");
    // Blocks of 512 bytes: the frames and tables fit, the checkpoint does not.
    command.args(["-c", "ulimit -f 200; exec \"$0\" \"$@\""]).arg(quick.get_program()).args(quick.get_args());
    command.current_dir(env!("CARGO_MANIFEST_DIR"));
    let said = ends(command, 4);
    assert!(said.contains("File too large"), "{said}");
    let summary = fs::read_to_string(out.join("summary.json")).expect("a summary");
    assert!(summary.contains("\"failed\""), "{summary}");
}

#[test]
fn checkpoint_is_written_on_request_and_the_run_continues() {
    let folder = folder();
    let out = folder.path().join("run");
    let mut child = long_run(&out, &[]);
    wait_for(|| out.join("journal/frame-00000001.nc").exists());
    for count in 1..=3_usize {
        let before = checkpoints(&out).first().cloned();
        send(&child, if count == 2 { SIGUSR2 } else { SIGUSR1 });
        wait_for(|| checkpoints(&out).first().cloned() != before);
        // The last two are kept; a third may exist until it is removed.
        wait_for(|| checkpoints(&out).len() == count.min(2));
        assert!(child.try_wait().expect("a state").is_none(), "the run ended");
    }
    child.kill().expect("killed");
    child.wait().expect("ended");
    assert_resumes_identically(&out, "kill after SIGUSR1");
}

#[test]
fn wall_time_limit_ends_a_run_with_code_75() {
    let folder = folder();
    let out = folder.path().join("run");
    let mut child = long_run(&out, &["--max-walltime", "0.7s"]);
    assert_eq!(child.wait().expect("ended").code(), Some(75));
    let summary = fs::read_to_string(out.join("summary.json")).expect("a summary");
    assert!(summary.contains("\"out of time\""), "{summary}");
    ends(resume(&out, &["--quiet", "--max-walltime", "0.5s"]), 75);
    assert_resumes_identically(&out, "wall time");
}

/// Kills a run at many moments until it is complete.
#[test]
fn repeatedly_killed_run_is_bitwise_identical() {
    let folder = folder();
    let (whole, killed) = (folder.path().join("whole"), folder.path().join("killed"));
    let end = ["--steps", "700"];
    ends(run(QUICK, &whole, &end), 0);
    let often = ["--checkpoint-every", "0.05s"];
    let mut kills = 0;
    for round in 0_u64.. {
        assert!(round < 400, "the run does not complete");
        let mut command = match killed.exists() {
            false => run(QUICK, &killed, &end),
            true => resume(&killed, &["--quiet"]),
        };
        let mut child = command.args(often).stdout(Stdio::null()).spawn().expect("started");
        // Some kills are before the first frame, some during packing.
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

#[test]
fn tables_of_a_scene_are_kept_for_resuming() {
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
