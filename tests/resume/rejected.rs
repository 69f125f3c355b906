//! Checkpoints that are damaged, foreign or without their output, and changes that resuming
//! refuses.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

use crate::program::{QUICK, checkpoints, copy_folder, ends, folder, refused, resume, run, same, sphecs};

/// Makes a run with two checkpoints and an uninterrupted one.
fn twice_stopped(folder: &Path) -> (PathBuf, PathBuf) {
    let (whole, pieces) = (folder.join("whole"), folder.join("pieces"));
    ends(run(QUICK, &whole, &["--steps", "150"]), 0);
    ends(run(QUICK, &pieces, &["--steps", "60"]), 0);
    ends(resume(&pieces, &["--quiet", "--steps", "110"]), 0);
    assert_eq!(checkpoints(&pieces).len(), 2);
    (whole, pieces)
}

#[test]
fn damaged_checkpoint_is_named_and_the_one_before_it_used() {
    let folder = folder();
    let (whole, pieces) = twice_stopped(folder.path());
    let last = checkpoints(&pieces)[0].clone();
    let mut bytes = fs::read(&last).expect("read");
    // Among the values of a column, not in the lengths between columns.
    let name = b"arrays.velocity.0";
    let column = bytes.windows(name.len()).position(|bytes| bytes == name).expect("a column");
    bytes[column + name.len() + 1000] ^= 0x20;
    fs::write(&last, bytes).expect("written");
    let said = ends(resume(&pieces, &["--steps", "150"]), 0);
    for word in ["step-000000000110", "is damaged", "checksum", "resuming from the checkpoint of step 60"] {
        assert!(said.contains(word), "no `{word}` in:\n{said}");
    }
    same(&whole, &pieces, "damaged");
}

#[test]
fn foreign_checkpoint_is_not_used() {
    let folder = folder();
    let (whole, pieces) = twice_stopped(folder.path());
    let [last, before] = [0, 1].map(|at| checkpoints(&pieces)[at].clone());
    let intact = fs::read(&last).expect("read");

    let ours = format!("version {}", sphecs_output::checkpoint::container::VERSION);
    // Intact with another version of the format: the versions are named, and nothing is changed.
    let mut other = intact.clone();
    other[8..12].copy_from_slice(&9_u32.to_le_bytes());
    let body = other.len() - 32;
    let digest = <sha2::Sha256 as sha2::Digest>::digest(&other[..body]);
    other[body..].copy_from_slice(&digest);
    fs::write(&last, &other).expect("written");
    refused(resume(&pieces, &["--steps", "150"]), &["version 9", &ours, "step-000000000110"]);
    fs::write(&last, &intact).expect("written");

    // Other lanes are used only on request. A machine may have the portable ones only.
    let mut portable = resume(&pieces, &["--steps", "150"]);
    portable.env("SPHECS_LANES", "portable");
    let lanes = sphecs_core::math::lanes::InstructionSet::best().name();
    if lanes != "portable" {
        refused(portable, &[lanes, "portable", "--allow-other-isa"]);
        let copy = folder.path().join("copy");
        copy_folder(&pieces, &copy);
        let mut allowed = resume(&copy, &["--steps", "115", "--allow-other-isa"]);
        allowed.env("SPHECS_LANES", "portable");
        assert!(ends(allowed, 0).contains("the results will differ bitwise"));
    }

    // A checkpoint of another scene under the name of the last; then no intact checkpoint.
    let foreign = folder.path().join("foreign");
    ends(run("scenes/taylor_green.ron", &foreign, &["--steps", "5"]), 0);
    fs::copy(&checkpoints(&foreign)[0], &last).expect("copied");
    let copy = folder.path().join("bare");
    copy_folder(&pieces, &copy);
    for path in checkpoints(&copy) {
        let half = fs::read(&path).expect("read");
        fs::write(&path, &half[..half.len() / 2]).expect("written");
    }
    refused(resume(&copy, &[]), &["no checkpoint can be resumed from", "is damaged", "step-000000000060"]);
    let said = ends(resume(&pieces, &["--steps", "150"]), 0);
    assert!(
        said.contains("belongs to another scene") && said.contains("resuming from the checkpoint of step 60"),
        "{said}"
    );
    assert!(before.exists());
    same(&whole, &pieces, "foreign");
}

#[test]
fn only_changes_without_effect_on_the_flow_are_accepted() {
    let folder = folder();
    let out = folder.path().join("run");
    ends(run(QUICK, &out, &["--steps", "40"]), 0);
    refused(
        resume(&out, &["--set", "fluid.viscosity=1.0e-5"]),
        &["fluid.viscosity", "time.end", "from its start"],
    );
    refused(resume(&out, &["--set", "time.end=-1.0"]), &["`end`", "greater than 0"]);
    // A complete run: resuming succeeds and changes nothing.
    let before = fs::read(out.join("particles.nc")).expect("results");
    assert!(ends(resume(&out, &[]), 0).contains("is complete"));
    assert_eq!(fs::read(out.join("particles.nc")).expect("results"), before);
    // Another end and another interval, which are kept when it is stopped again.
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
    refused(resume(&out, &["--until", "0.07"]), &["scene.ron", "was changed"]);
}

#[test]
fn checkpoint_without_its_rows_or_frames_is_rejected() {
    let folder = folder();
    let (_, pieces) = twice_stopped(folder.path());
    let rows = fs::read(pieces.join("monitor.csv")).expect("rows");
    fs::write(pieces.join("monitor.csv"), &rows[..rows.len() / 3]).expect("written");
    refused(resume(&pieces, &["--steps", "150"]), &["monitor.csv", "bytes", "no checkpoint"]);
    fs::write(pieces.join("monitor.csv"), &rows).expect("written");
    fs::remove_file(pieces.join("particles.nc")).expect("removed");
    refused(resume(&pieces, &["--steps", "150"]), &["frames, the run has 0"]);
}
