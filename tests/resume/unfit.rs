//! A checkpoint that is damaged, of something else or without its output, and changes that a resumed run may not have.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

use crate::program::{QUICK, checkpoints, copy_folder, ends, folder, refused, resume, run, same, sphecs};

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

    let ours = format!("version {}", sphecs_output::checkpoint::container::VERSION);
    // Of another version of the layout, whole: the versions are named, and nothing is done.
    let mut other = sound.clone();
    other[8..12].copy_from_slice(&9_u32.to_le_bytes());
    let body = other.len() - 32;
    let digest = <sha2::Sha256 as sha2::Digest>::digest(&other[..body]);
    other[body..].copy_from_slice(&digest);
    fs::write(&last, &other).expect("written");
    refused(resume(&pieces, &["--steps", "150"]), &["version 9", &ours, "step-000000000110"]);
    fs::write(&last, &sound).expect("written");

    // On other lanes: only if asked for. Where a machine has none but the portable ones, there are no others.
    let mut portable = resume(&pieces, &["--steps", "150"]);
    portable.env("SPHECS_LANES", "portable");
    let lanes = sphecs_core::math::lanes::InstructionSet::best().name();
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
