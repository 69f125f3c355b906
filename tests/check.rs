//! Report, picture and exit code of `sphecs check`.

use std::ffi::OsStr;
use std::fs;
use std::path::Path;
use std::process::Command;

fn sphecs<A: AsRef<OsStr>>(arguments: impl IntoIterator<Item = A>) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sphecs"));
    // Relative paths are those of the repository.
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args(arguments);
    command
}

/// Runs a command, asserts its exit code, and returns its standard output.
#[track_caller]
fn ends(code: i32, mut command: Command) -> String {
    let output = command.output().expect("the program starts");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(code), "{text}\n{}", String::from_utf8_lossy(&output.stderr));
    text
}

#[test]
fn strict_check_has_an_exit_code_for_notes() {
    let coarse = ["check", "scenes/quickstart.ron", "--smoke", "--no-timing", "--strict"];
    // 8 particles across the gap.
    let text = ends(1, sphecs(coarse));
    assert!(text.contains("note: the narrowest passage has 8.0 particles across"), "{text}");
    let fine = [
        "check",
        "scenes/quickstart.ron",
        "--until",
        "6",
        "--no-timing",
        "--strict",
        "--set",
        "output.probes=[]",
        "--set",
        "output.fields=()",
    ];
    ends(0, sphecs(fine));
}

#[test]
fn overlapping_wall_parts_are_noted() {
    let parts = r#"walls=(parts: [
        (name: "upper", region: Box(min: (-1.0, 0.0), max: (1.0, 1.0))),
        (name: "blocks", region: Box(min: (0.05, -1.0), max: (0.11, 1.0))),
    ])"#;
    let words = ["check", "scenes/quickstart.ron", "--smoke", "--no-timing", "--set", parts];
    let text = ends(0, sphecs(words));
    assert!(text.contains("`upper` and `blocks` overlap"), "{text}");
}

#[test]
fn shares_of_ranks_are_those_of_a_run() {
    let scene = ["scenes/stirrer.ron", "--smoke"];
    let check = [&["check"][..], &scene[..], &["--no-timing", "--ranks", "3"]].concat();
    let text = ends(0, sphecs(check));
    let shares = text.lines().find(|line| line.trim_start().starts_with("ranks")).expect("a row on ranks");
    assert!(shares.contains("as fast as one, without messages"), "{shares}");
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("run");
    let out = out.to_str().expect("a path of UTF-8");
    let run = [&["run"][..], &scene[..], &["--ranks", "3", "--threads", "1", "--steps", "1", "--out", out]];
    let text = ends(0, sphecs(run.concat()));
    let found =
        text.lines().find(|line| line.trim_start().starts_with("ranks  3, each owns")).expect("a row");
    // The domains are those of the particles at the start.
    let count = |text: &str, after: &str| {
        let digits = text.split(after).nth(1).expect("the number").trim_start();
        digits.chars().take_while(|c| !c.is_alphabetic()).filter(char::is_ascii_digit).collect::<String>()
    };
    assert_eq!(count(shares, "owns at most"), count(found, "owns at most"), "{shares}\n{found}");
}

#[test]
fn check_draws_the_scene_and_writes_nothing_else() {
    let folder = tempfile::tempdir().expect("a folder");
    let picture = folder.path().join("plan.png");
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/quickstart.ron");
    let words =
        ["check".as_ref(), scene.as_os_str(), "--smoke".as_ref(), "--picture".as_ref(), picture.as_os_str()];
    let mut command = sphecs(words);
    command.current_dir(folder.path());
    assert!(ends(0, command).contains("plan.png"));
    assert!(fs::read(&picture).expect("the picture").starts_with(b"\x89PNG"));
    assert_eq!(fs::read_dir(folder.path()).expect("the folder").count(), 1);
}

#[test]
fn results_take_no_more_disk_than_the_check_says() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    for scene in ["scenes/quickstart.ron", "scenes/cylinder_re20.ron"] {
        let until = if scene.contains("quickstart") { "0.15" } else { "2.0" };
        let scene = [scene, "--smoke", "--until", until];
        let report = ends(0, sphecs(["check", "--no-timing"].into_iter().chain(scene)));
        let said = said_bytes(report.split_once("at most ").expect("a size").1);
        let mut run = sphecs(["run", "--quiet", "--force"].into_iter().chain(scene));
        run.arg("--out").arg(&out);
        ends(0, run);
        let taken = size(&out) as f64;
        assert!(taken <= said && said <= 2.5 * taken, "{scene:?}: {said} B said, {taken} B taken");
    }
}

/// Returns the bytes at the beginning of a text such as `12 MB: …`.
fn said_bytes(text: &str) -> f64 {
    let mut words = text.split([' ', ':', ',']);
    let number: f64 = words.next().and_then(|word| word.parse().ok()).expect("a number");
    let unit = words.next().expect("a unit");
    number
        * ["B", "kB", "MB", "GB"]
            .iter()
            .position(|name| *name == unit)
            .map_or(1.0, |power| 1e3_f64.powi(power as i32))
}

/// Returns the size of all files in a folder, B.
fn size(folder: &Path) -> u64 {
    fs::read_dir(folder)
        .expect("a folder")
        .map(|entry| {
            let entry = entry.expect("an entry");
            let data = entry.metadata().expect("its data");
            if data.is_dir() { size(&entry.path()) } else { data.len() }
        })
        .sum()
}

/// Libraries ignore these variables if they are misspelt.
#[test]
fn misspelt_environment_variable_is_bad_input() {
    let with = |name, value, code| {
        let mut command = sphecs(["check", "scenes/quickstart.ron", "--smoke", "--no-timing"]);
        let output = command.env(name, value).output().expect("the program starts");
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{message}");
        message
    };
    let lanes = with("SPHECS_LANES", "avx3", 2);
    assert!(lanes.contains("`SPHECS_LANES`: is `avx3`") && lanes.contains("`portable`"), "{lanes}");
    assert!(with("RAYON_NUM_THREADS", "all", 2).contains("whole number"));
    with("SPHECS_LANES", "", 0);
    with("SPHECS_LANES", "portable", 0);
}
