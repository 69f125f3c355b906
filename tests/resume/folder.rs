//! Only one process writes a run, and only inside its folder.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Output, Stdio};

use crate::program::{
    QUICK, checkpoints, copy_folder, ends, folder, long_run, resume, run, same, sphecs, text, wait_for,
};

/// A second process is refused for every command that writes a run.
#[test]
#[cfg(unix)]
fn one_process_at_a_time_writes_a_run() {
    let folder = folder();
    let (out, link) = (folder.path().join("run"), folder.path().join("link"));
    std::os::unix::fs::symlink(&out, &link).expect("a link");
    let indirect = folder.path().join("run/../run/.");
    let pack = |path: &Path| sphecs([OsStr::new("pack"), path.as_os_str()]);
    let near = |words: &[&str]| {
        let mut command = sphecs(words);
        command.current_dir(folder.path());
        command
    };
    let forced: &[&str] = &["--force", "--steps", "2"];
    let mut tried = 0;
    let mut all_are_refused = |first: &mut Child| {
        for command in [
            resume(&out, &[]),
            resume(&out, &["--threads", "1", "--steps", "5"]),
            resume(&link, &[]),
            resume(&indirect, &[]),
            near(&["resume", "run"]),
            run(QUICK, &out, forced),
            run(QUICK, &link, forced),
            run("scenes/taylor_green.ron", &indirect, forced),
            pack(&out),
            pack(&link),
            near(&["pack", "./run"]),
        ] {
            let said = ends(command, 4);
            assert!(said.contains("another process"), "{said}");
            tried += 1;
        }
        ends(run(QUICK, &out, &["--steps", "2"]), 2);
        assert!(first.try_wait().expect("a state").is_none(), "the run ended");
        first.kill().expect("killed");
        first.wait().expect("ended");
    };
    let mut first = long_run(&out, &[]);
    wait_for(|| out.join("journal/frame-00000000.nc").exists());
    all_are_refused(&mut first);
    // The lock of a killed process is free; without a checkpoint the run starts again.
    let said = ends(resume(&out, &["--steps", "30"]), 0);
    assert!(said.contains("starts again"), "{said}");
    let whole = folder.path().join("whole");
    ends(run(QUICK, &whole, &["--steps", "30"]), 0);
    same(&whole, &out, "started again");
    // A resumed run holds the lock too.
    let mut command = resume(&out, &["--until", "1e6"]);
    let mut first = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("started");
    wait_for(|| out.join("journal/frame-00000002.nc").exists());
    all_are_refused(&mut first);
    assert_eq!(tried, 22);
}

#[test]
fn concurrent_processes_make_a_folder_once() {
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
    assert_eq!(fs::read_dir(folder.path()).expect("read").count(), 1, "a file is left beside the run");
}

/// Returns the files below a folder except one entry.
fn all_but(folder: &Path, excluded: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).expect("read").map(|entry| entry.expect("an entry").path()) {
        if entry == excluded {
            continue;
        }
        if entry.is_dir() {
            found.extend(all_but(&entry, excluded));
        }
        found.insert(entry.clone(), fs::read(&entry).unwrap_or_default());
    }
    found
}

/// A link in a run to a file or folder elsewhere: nothing there is written, emptied or removed.
#[test]
#[cfg(unix)]
fn links_in_a_run_are_refused() {
    let folder = folder();
    let intact = folder.path().join("intact");
    ends(run(QUICK, &intact, &["--steps", "20"]), 0);
    let resumed: &[&str] = &["resume", "--steps", "30"];
    let packed: &[&str] = &["pack"];
    let forced: &[&str] = &["run", QUICK, "--smoke", "--steps", "2", "--force", "--out"];
    let checkpoint =
        checkpoints(&intact)[0].strip_prefix(&intact).expect("in it").to_string_lossy().into_owned();
    let next = "checkpoints/step-000000000030.checkpoint.partial";
    // Entry, command and exit code. A forced run replaces the whole folder with its links.
    for (name, words, code) in [
        (".lock", resumed, 2),
        (".lock", packed, 2),
        (".lock", forced, 2),
        ("monitor.csv", resumed, 2),
        ("monitor.csv", packed, 2),
        ("monitor.csv", forced, 0),
        ("monitor.nc", resumed, 2),
        ("monitor.nc.partial", resumed, 2),
        ("monitor.nc.partial", packed, 2),
        ("particles.nc", resumed, 2),
        ("particles.nc", forced, 0),
        ("particles.nc.partial", packed, 2),
        ("probes_mean.csv", packed, 2),
        ("probes_points.csv", resumed, 2),
        ("probes/gap.csv", resumed, 2),
        ("probes", resumed, 2),
        ("probes", forced, 0),
        ("summary.json", resumed, 2),
        ("summary.json.partial", resumed, 2),
        ("divergence.nc", resumed, 2),
        (checkpoint.as_str(), resumed, 2),
        (next, resumed, 2),
        ("checkpoints", resumed, 2),
        ("checkpoints", forced, 0),
        ("journal", resumed, 2),
        ("journal", packed, 2),
        ("journal", forced, 0),
        ("journal.packed", packed, 2),
    ] {
        let (out, elsewhere) = (folder.path().join("run"), folder.path().join("elsewhere"));
        copy_folder(&intact, &out);
        let (from, to) = (out.join(name), elsewhere.join("victim"));
        fs::create_dir(&elsewhere).expect("a folder");
        match from.exists() {
            true => fs::rename(&from, &to).expect("moved"),
            false if name.starts_with("journal") => fs::create_dir(&to).expect("a folder"),
            false => fs::write(&to, "mine").expect("written"),
        }
        std::os::unix::fs::symlink(&to, &from).expect("a link");
        let before = all_but(folder.path(), &out);
        let mut command = sphecs(&words[..1]);
        match words == forced {
            true => command.args(&words[1..]).arg(&out),
            false => command.arg(&out).args(&words[1..]),
        };
        let said = ends(command, code);
        assert!(code == 0 || said.contains("is a link"), "{name}, {}: {said}", words[0]);
        assert_eq!(
            all_but(folder.path(), &out).keys().collect::<Vec<_>>(),
            before.keys().collect::<Vec<_>>(),
            "{name}"
        );
        assert!(all_but(folder.path(), &out) == before, "{name}, {}: written through", words[0]);
        fs::remove_dir_all(&out).expect("removed");
        fs::remove_dir_all(&elsewhere).expect("removed");
    }
}

/// Names that lead out of a folder, in every place where a user gives a name.
#[test]
fn names_do_not_lead_out_of_the_folder() {
    let folder = folder();
    let inner = folder.path().join("deep/inner");
    fs::create_dir_all(&inner).expect("folders");
    let text =
        fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/quickstart.ron")).expect("the scene");
    let quick = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/quickstart.ron");
    let near = |words: &[&str]| {
        let mut command = sphecs(words);
        command.current_dir(&inner);
        command
    };
    // Probes and bodies: letters and digits of their names go into the names of files.
    let absolute = folder.path().join("absolute").to_string_lossy().into_owned();
    let out = inner.join("run");
    let name = text.find("name: \"").expect("a probe") + 7;
    let end = name + text[name..].find('"').expect("its end");
    for name_of_a_probe in
        ["../../escape", absolute.as_str(), "..", ".", "a/b", "c:\\\\x", "x.nc", "-rf", "~/x"]
    {
        let before = all_but(folder.path(), &out);
        let scene = format!("{}{name_of_a_probe}{}", &text[..name], &text[end..]);
        let path = inner.join("named.ron");
        fs::write(&path, scene).expect("written");
        ends(near(&["run", "named.ron", "--smoke", "-q", "--steps", "3", "--force", "--out", "run"]), 0);
        fs::remove_file(&path).expect("removed");
        assert!(all_but(folder.path(), &out) == before, "{name_of_a_probe}");
    }
    fs::remove_dir_all(&out).expect("removed");
    // A scene in `...ron` has the name `..`, which cannot be that of a folder.
    fs::write(inner.join("...ron"), &text).expect("written");
    let before = all_but(folder.path(), &out);
    let said = ends(near(&["run", "...ron", "--smoke", "--steps", "3"]), 2);
    assert!(said.contains("--out"), "{said}");
    // Cases: their names and those of their runs, plots and pictures are parts of file names.
    let case = |name: &str, runs: &str, more: &str| {
        fs::write(
            inner.join(name),
            format!(
                "Case(title: \"t\", source: \"s\", setting: \"s\", runs: [(name: \"{runs}\", scene: \"{quick}\", tier: Quick, set: [(\"time.end\", \"0.005\"), (\"output.probes\", \"[]\"), (\"output.fields\", \"()\")])], figures: [], {more})"
            ),
        )
        .expect("written");
    };
    let curve = "curves: [Series(run: \"a\", table: \"monitor\", column: \"kinetic_energy\", label: \"k\")]";
    for (file, runs, more) in [
        ("case.ron", "../../a", String::new()),
        ("case.ron", absolute.as_str(), String::new()),
        ("case.ron", "a", format!("plots: [(name: \"../../b\", title: \"b\", across: \"t\", upward: \"k\", {curve})]")),
        ("case.ron", "a", "pictures: [(name: \"/b\", title: \"b\", run: \"a\", field: \"speed\", times: [0.0], range: (0.0, 1.0))]".to_owned()),
        // The name `..` is replaced.
        ("...ron", "a", String::new()),
    ] {
        case(file, runs, &more);
        let before = all_but(folder.path(), &out);
        let code = if file == "...ron" { 0 } else { 2 };
        ends(near(&["validate", "--case", &format!("./{file}"), "--quick", "--out", "run"]), code);
        assert!(all_but(folder.path(), &out) == before, "{file}, {runs}, {more}");
        fs::remove_file(inner.join(file)).expect("removed");
    }
    assert_eq!(before.keys().filter(|path| path.is_dir()).count(), 2);
}
