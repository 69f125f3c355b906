//! A run is written in the folder that `--out` leads to, whatever that folder is.

use std::fs;
use std::os::unix::fs::{MetadataExt, PermissionsExt, chown, symlink};
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::Command;

use crate::program::{QUICK, ends, folder, resume, run, sphecs};

/// User without privileges, as whom a process of the superuser runs the program.
const NOBODY: u32 = 65534;

/// The working folder cannot be renamed, like a mount point.
#[test]
fn working_folder_is_used_in_place() {
    let parent = folder();
    let out = parent.path().join("run");
    fs::create_dir(&out).expect("a folder");
    fs::set_permissions(&out, fs::Permissions::from_mode(0o2750)).expect("set");
    let facts = || fs::metadata(&out).map(|data| (data.ino(), data.mode())).expect("read");
    let before = facts();
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/quickstart.ron");
    let here = |more: &[&str]| {
        let mut command = run(scene, Path::new("."), more);
        command.current_dir(&out);
        command
    };
    ends(here(&["--steps", "2"]), 0);
    let said = ends(here(&["--steps", "3"]), 2);
    assert!(said.contains("--force"), "{said}");
    ends(here(&["--steps", "3", "--force"]), 0);
    let mut resumed = resume(Path::new("."), &["--steps", "5", "--quiet"]);
    resumed.current_dir(&out);
    ends(resumed, 0);
    assert!(out.join("particles.nc").is_file());
    assert_eq!(facts(), before);
    assert_eq!(fs::read_dir(parent.path()).expect("read").count(), 1, "a file is left beside the run");

    fs::write(out.join("thesis.tex"), "years").expect("written");
    fs::remove_file(out.join("scene.ron")).expect("removed");
    ends(here(&["--steps", "3", "--force"]), 2);
    assert!(out.join("thesis.tex").exists());
}

/// Returns a command as a user whom permissions bind.
fn as_user(mut command: Command) -> Command {
    if is_superuser() {
        command.uid(NOBODY);
    }
    command
}

fn is_superuser() -> bool {
    fs::metadata("/proc/self").is_ok_and(|data| data.uid() == 0)
}

fn set_mode(path: &Path, mode: u32) {
    if is_superuser() {
        chown(path, Some(NOBODY), None).expect("owned");
    }
    fs::set_permissions(path, fs::Permissions::from_mode(mode)).expect("set");
}

#[test]
fn only_the_folder_itself_needs_permission() {
    let parent = folder();
    let [out, closed] = ["run", "closed"].map(|name| parent.path().join(name));
    for path in [&out, &closed] {
        fs::create_dir(path).expect("a folder");
    }
    set_mode(&out, 0o755);
    set_mode(&closed, 0o555);
    set_mode(parent.path(), 0o555);
    ends(as_user(run(QUICK, &out, &["--steps", "2"])), 0);
    ends(as_user(run(QUICK, &out, &["--steps", "3", "--force"])), 0);
    assert!(out.join("particles.nc").is_file());
    for path in [&closed, &closed.join("deep/run"), &parent.path().join("other")] {
        let said = ends(as_user(run(QUICK, path, &["--steps", "2"])), 4);
        assert!(said.contains("cannot write to the folder: Permission denied"), "{said}");
    }
    assert_eq!(fs::read_dir(&closed).expect("read").count(), 0);
    set_mode(parent.path(), 0o755);
}

#[test]
fn link_leads_to_the_folder_that_is_written() {
    let parent = folder();
    let [disk, link, broken] = ["disk", "link", "broken"].map(|name| parent.path().join(name));
    fs::create_dir(&disk).expect("a folder");
    symlink(&disk, &link).expect("a link");
    symlink(parent.path().join("nowhere"), &broken).expect("a link");
    ends(run(QUICK, &link, &["--steps", "2"]), 0);
    ends(run(QUICK, &link, &["--steps", "3", "--force"]), 0);
    assert!(disk.join("particles.nc").is_file());
    assert!(fs::symlink_metadata(&link).expect("the link").is_symlink());
    for command in
        [run(QUICK, &broken, &["--steps", "2"]), run(QUICK, &broken.join("run"), &["--steps", "2"])]
    {
        let said = ends(command, 2);
        assert!(said.contains("nowhere`, which does not exist"), "{said}");
    }
    // Nothing of the run is written to the disk of the link: /proc has no space.
    symlink("/proc", parent.path().join("full")).expect("a link");
    let mut command = sphecs(["run", QUICK, "--smoke", "--out"]);
    command.arg(parent.path().join("full/run"));
    let said = ends(command, 4);
    assert!(said.contains("0 B are free"), "{said}");
}
