//! A run killed at any moment keeps every frame that was reported as written.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use sphecs::MonitorRow;
use sphecs_output::folder::RunFolder;
use sphecs_output::frame::Frame;
use sphecs_output::header::Header;
use sphecs_output::pack::pack;
use sphecs_output::probes::ProbeSet;
use sphecs_output::results::Results;

const FOLDER: &str = "SPHECS_KILLED_RUN_FOLDER";

/// A frame whose every number follows from its index; the reservoir grows as it goes.
fn frame(index: u64) -> Frame {
    let mut frame = Frame::absent(500 + 3 * index as usize);
    for slot in 0..frame.len() {
        frame.zone[slot] = if slot % 5 == 0 { 1 } else { 0 };
        frame.position[0][slot] = slot as f64 * 0.01;
        frame.position[1][slot] = if slot % 5 == 0 { 0.0 } else { index as f64 };
        frame.position[2][slot] = 0.0;
        frame.pressure[slot] = index as f32;
        frame.passage[slot] = index as u32;
    }
    // New slots are no walls: walls stand from the first frame on.
    frame.zone[500..].fill(0);
    frame.time = 0.5 * index as f64;
    frame.step = 10 * index;
    frame
}

fn header() -> Header {
    Header {
        scene: "killed".to_owned(),
        text: "Scene()".to_owned(),
        dimensions: 2,
        spacing: 0.01,
        ..Header::default()
    }
}

/// The body of the process that is killed: writes frames and reports them, without end.
#[test]
fn child_writes_and_reports() {
    let Ok(folder) = std::env::var(FOLDER) else {
        return;
    };
    let mut run =
        RunFolder::create(Path::new(&folder), false, &header(), &ProbeSet::default()).expect("a run folder");
    let mut reported = 0;
    for index in 0.. {
        run.submit(frame(index)).expect("accepted");
        let row = MonitorRow { step: index, ..MonitorRow::default() };
        run.monitor(&row).expect("written");
        while reported < run.frames_written() {
            println!("frame {reported} written");
            reported += 1;
        }
    }
}

/// Starts the child, kills it some time after it reported `after` frames, and returns how many it reported.
fn kill_after(folder: &Path, after: u64, delay: Duration) -> u64 {
    let mut child = Command::new(std::env::current_exe().expect("this test"))
        .args(["--exact", "child_writes_and_reports", "--nocapture"])
        .env(FOLDER, folder)
        .stdout(Stdio::piped())
        .spawn()
        .expect("started");
    let mut lines = BufReader::new(child.stdout.take().expect("its output")).lines();
    let mut reported = 0;
    let mut count = |line: std::io::Result<String>| {
        reported += u64::from(line.is_ok_and(|line| line.ends_with(" written")));
        reported
    };
    for line in lines.by_ref() {
        if count(line) == after {
            break;
        }
    }
    std::thread::sleep(delay);
    child.kill().expect("killed");
    // What it had reported before the kill still stands in the pipe.
    let last = lines.map(count).last().unwrap_or(after);
    child.wait().expect("ended");
    last
}

#[test]
fn every_reported_frame_survives_a_kill() {
    let parent = tempfile::tempdir().expect("a folder");
    for round in 0..8 {
        let folder = parent.path().join(format!("run{round}"));
        let reported = kill_after(&folder, 1 + round, Duration::from_millis(3 * round));
        let check = |results: &Results, stage: &str| {
            assert!(
                results.len() as u64 >= reported,
                "{stage}: {} frames of {reported} reported",
                results.len()
            );
            for index in 0..results.len() {
                let found = results.frame(index).expect("a whole frame");
                let wanted = frame(index as u64);
                assert_eq!((found.time, found.step), (wanted.time, wanted.step));
                let present = &found.zone[..wanted.len()];
                assert_eq!(present, wanted.zone, "{stage}: frame {index}");
                assert_eq!(found.position[1][..wanted.len()], wanted.position[1]);
                assert!(found.zone[wanted.len()..].iter().all(|&zone| zone == 255));
            }
        };
        check(&Results::open(&folder).expect("a run"), "journal");
        let packed = pack(&folder).expect("packed");
        assert!(packed.frames as u64 >= reported);
        assert!(!folder.join("journal").exists());
        check(&Results::open(&folder).expect("a run"), "packed");
        // Packing what is packed changes nothing.
        assert_eq!(pack(&folder).expect("packed").frames, 0);
    }
}

#[test]
fn run_being_written_is_left_alone() {
    let parent = tempfile::tempdir().expect("a folder");
    let folder = parent.path().join("run");
    let _run = RunFolder::create(&folder, false, &header(), &ProbeSet::default()).expect("a run");
    for error in [
        pack(&folder).expect_err("refused"),
        RunFolder::create(&folder, true, &header(), &ProbeSet::default()).expect_err("refused"),
    ] {
        let message = error.to_string();
        assert!(message.contains("another process"), "{message}");
    }
}
