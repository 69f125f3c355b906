//! The invariants of ARCHITECTURE.md. Each failure names the line and the cure.

mod house;

use std::collections::BTreeSet;

use house::{Source, files_under, line_of, read, relative, root, sources};

/// The floors from the ground up, then what stands at the top: a file imports from its own floor or lower ones.
const FLOORS: [&str; 13] = [
    "math",
    "physics",
    "particles",
    "pass",
    "scene",
    "systems",
    "output",
    "simulation",
    "run",
    "bench",
    "validate",
    "cli",
    "main",
];

/// Fails with all faults at once.
fn claim(faults: Vec<String>) {
    assert!(faults.is_empty(), "\n{}\n", faults.join("\n"));
}

/// Index into [`FLOORS`] of a file; None for `lib.rs`, which declares them all.
fn floor(path: &str) -> Option<usize> {
    let room = path.strip_prefix("src/")?;
    let name = room.split('/').next()?.trim_end_matches(".rs");
    FLOORS.iter().position(|floor| *floor == name)
}

/// The first names behind every `crate::` and every chain of `super::` that climbs to the crate's root, with their places.
fn imports(source: &Source) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    for at in source.words("crate") {
        if let Some(rest) = source.code[at + "crate".len()..].strip_prefix("::") {
            found.extend(first_names(rest).into_iter().map(|name| (at, name)));
        }
    }
    // A file lies as deep as its path, its door one less; a module of unit tests one more.
    let parts: Vec<&str> = source.path.trim_end_matches(".rs").split('/').skip(1).collect();
    let depth = parts.len() - usize::from(parts.last() == Some(&"mod"));
    let tests = source.code.find("#[cfg(test)]").unwrap_or(source.code.len());
    let mut climbed_to = 0;
    for at in source.words("super") {
        if at < climbed_to {
            continue;
        }
        let mut rest = &source.code[at..];
        let mut climb = 0;
        while let Some(after) = rest.strip_prefix("super::") {
            rest = after;
            climb += 1;
        }
        climbed_to = source.code.len() - rest.len();
        if climb > 0 && climb == depth + usize::from(at > tests) {
            found.extend(first_names(rest).into_iter().map(|name| (at, name)));
        }
    }
    found
}

/// `a` of `a::b`, or `a`, `c` of `{a::b, c::{d, e}}`.
fn first_names(path: &str) -> Vec<String> {
    let name = |text: &str| -> String {
        text.trim_start().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
    };
    let Some(group) = path.strip_prefix('{') else { return vec![name(path)] };
    let mut depth = 0;
    let mut names = vec![name(group)];
    for (at, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => names.push(name(&group[at + 1..])),
            _ => {}
        }
    }
    names.retain(|name| !name.is_empty());
    names
}

#[test]
fn imports_point_downwards() {
    let mut faults = Vec::new();
    for source in sources(&["src"]) {
        let Some(own) = floor(&source.path) else { continue };
        for (at, name) in imports(&source) {
            if FLOORS.iter().position(|floor| *floor == name).is_some_and(|other| other > own) {
                faults.push(format!(
                    "{}:{}: floor `{}` imports from `{name}` above it: move what is shared to the lower floor, or hand it in as an argument",
                    source.path,
                    line_of(&source.code, at),
                    FLOORS[own],
                ));
            }
        }
    }
    claim(faults);
}

#[test]
fn imports_are_found_however_they_are_written() {
    let text = "use crate::{a::b, c::{d, e}, f};\nfn g() { crate::h::i(); \"crate::no\"; }\n// crate::no\nuse super::super::j::k;
        use super::own;\n#[cfg(test)]\nmod tests { use super::super::own; use super::super::super::l; use super::*; }";
    let found: Vec<String> =
        imports(&Source::new("src/x/y.rs", text)).into_iter().map(|(_, name)| name).collect();
    assert_eq!(found, ["a", "c", "f", "h", "j", "l"]);
    let door = Source::new("src/x/mod.rs", "use super::m::n;");
    assert_eq!(imports(&door).len(), 1);
}

#[test]
fn numeric_floors_know_no_ecs() {
    let mut faults = Vec::new();
    for source in sources(&["src/math", "src/physics", "src/pass"]) {
        for at in source.words("bevy_ecs") {
            faults.push(format!(
                "{}:{}: names `bevy_ecs`: numeric floors take slices and numbers; let a system of src/systems fetch them",
                source.path,
                line_of(&source.code, at),
            ));
        }
    }
    claim(faults);
}

/// Where what the compiler cannot check stands, beside the lanes themselves: packs read whole vectors of their own storage, and
/// HDF5 is told how to end. `scripts/reliability/sanitizer.sh` runs them.
const UNSAFE: [&str; 3] = ["src/math/lanes/", "src/pass/pack/", "src/output/netcdf/mod.rs"];

#[test]
fn unsafe_code_stays_in_its_rooms() {
    let mut faults = Vec::new();
    for source in sources(&["src"]) {
        if UNSAFE.iter().any(|room| source.path.starts_with(room)) {
            continue;
        }
        let lines = source.words("unsafe").map(|at| line_of(&source.code, at));
        faults.extend(lines.map(|line| {
            format!(
                "{}:{line}: is `unsafe`: only {} may be, under a sanitizer",
                source.path,
                UNSAFE.join(", ")
            )
        }));
    }
    claim(faults);
}

#[test]
fn one_room_knows_netcdf() {
    let mut faults = Vec::new();
    for source in sources(&["src"]) {
        if source.path == "src/output/netcdf.rs" || source.path.starts_with("src/output/netcdf/") {
            continue;
        }
        // `super::netcdf` and `crate::output::netcdf` are the room; a path that starts with the word is the crate,
        // unless the file has imported the room.
        let imports_room = ["use super::netcdf;", "use crate::output::netcdf;", "netcdf::{self"]
            .iter()
            .any(|import| source.code.contains(import));
        for at in source.words("netcdf") {
            let path_goes_on = source.code[at + "netcdf".len()..].starts_with("::");
            let is_import = source.code[..at].trim_end().ends_with("use");
            let from_crate = !source.code[..at].trim_end().ends_with("::");
            if from_crate
                && (is_import || path_goes_on && !imports_room)
                && !source.code[..at].ends_with("mod ")
            {
                faults.push(format!(
                    "{}:{}: names the crate `netcdf`: only src/output/netcdf may; add a function there and call it",
                    source.path,
                    line_of(&source.code, at),
                ));
            }
        }
    }
    claim(faults);
}

#[test]
fn structure_changes_in_one_set() {
    // Spawning at the start is the other door: before the first step there is no structure to change.
    const ALLOWED: [&str; 2] = ["src/systems/transitions.rs", "src/systems/setup.rs"];
    const ROLES: [&str; 6] = ["Fluid", "Wall", "Inflow", "Outflow", "Reservoir", "SpsStress"];
    let mut faults = Vec::new();
    for source in sources(&["src"]) {
        if ALLOWED.contains(&source.path.as_str()) || source.path.starts_with("src/systems/transitions/") {
            continue;
        }
        let code = source.code_without_tests();
        let mut places: Vec<usize> = [".spawn_batch(", ".spawn_empty(", ".despawn(", ".try_despawn("]
            .iter()
            .flat_map(|call| code.match_indices(call).map(|(at, _)| at))
            .collect();
        // Threads are spawned too: `thread::Builder::new().spawn(…)` takes a closure.
        places.extend(code.match_indices(".spawn(").map(|(at, _)| at).filter(|at| {
            let arguments = code[at + ".spawn(".len()..].trim_start();
            !arguments.starts_with("move") && !arguments.starts_with('|')
        }));
        for role in ROLES {
            for call in [".insert(", ".insert((", ".remove::<", ".remove::<("] {
                places.extend(code.match_indices(call).map(|(at, _)| at).filter(|at| {
                    let rest = code[at + call.len()..].trim_start();
                    rest.strip_prefix(role).is_some_and(|rest| {
                        !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':')
                    })
                }));
            }
        }
        places.sort_unstable();
        for at in places {
            faults.push(format!(
                "{}:{}: changes the structure of the world: mark the particle here and let {} act on the mark",
                source.path,
                line_of(code, at),
                ALLOWED[0],
            ));
        }
    }
    claim(faults);
}

#[test]
fn locals_are_buffers() {
    // What a system keeps in a `Local` no checkpoint sees: only buffers that each step fills anew may stand there.
    const BUFFERS: [&str; 5] =
        ["OutletBuffers<R, D>", "PointFlows<D>", "Vec<Prescribed>", "Vec<WaveFound>", "Vec<DVec3>"];
    let mut faults = Vec::new();
    for source in sources(&["src"]) {
        for (at, _) in source.code.match_indices("Local<") {
            let rest = &source.code[at + "Local<".len()..];
            if !BUFFERS.iter().any(|buffer| rest.starts_with(&format!("{buffer}>"))) {
                faults.push(format!(
                    "{}:{}: keeps something in a `Local`, which a restart forgets: make it a resource by `Parts::keep`, or, if it is \
                     a buffer that each step fills anew, name its type here",
                    source.path,
                    line_of(&source.code, at),
                ));
            }
        }
    }
    claim(faults);
}

#[test]
fn nothing_hides_behind_a_prelude() {
    let mut faults = Vec::new();
    for source in sources(&["src", "tests", "benches", "examples"]) {
        for (at, _) in source.code.match_indices("prelude::*") {
            faults.push(format!(
                "{}:{}: imports a prelude: name what the file depends on",
                source.path,
                line_of(&source.code, at),
            ));
        }
    }
    claim(faults);
}

#[test]
fn every_room_is_listed_by_its_door() {
    let mut faults = Vec::new();
    let all = sources(&["src"]);
    for source in &all {
        let (folder, name) = match source.path.trim_end_matches(".rs").rsplit_once('/') {
            Some((_, "lib" | "main")) | None => continue,
            Some((folder, "mod")) => match folder.rsplit_once('/') {
                Some(split) => split,
                None => continue,
            },
            Some(split) => split,
        };
        let door_path = if folder == "src" { "src/lib.rs".to_owned() } else { format!("{folder}/mod.rs") };
        let Some(door) = all.iter().find(|source| source.path == door_path) else {
            faults.push(format!("{}:1: stands in a folder without a door: write {door_path}", source.path));
            continue;
        };
        if !door.words(name).any(|at| door.code[..at].ends_with("mod ")) {
            faults.push(format!("{door_path}:1: does not list its room {}: add `mod {name};`", source.path));
        }
        if !door.text.starts_with("//!") {
            faults.push(format!("{door_path}:1: a door says in `//!` what its rooms are for"));
        }
    }
    faults.sort();
    faults.dedup();
    claim(faults);
}

#[test]
fn rooms_are_small() {
    let mut faults = Vec::new();
    for source in sources(&["src"]) {
        let most = if source.path == "src/main.rs" { 40 } else { 400 };
        let lines = source.text.lines().count();
        if lines > most {
            faults.push(format!(
                "{}:{most}: has {lines} lines, must have at most {most}: split off a method with its tests",
                source.path,
            ));
        }
    }
    claim(faults);
}

#[test]
fn map_fits_a_screenful_and_names_what_exists() {
    let lines = read("ARCHITECTURE.md").lines().count();
    let mut faults = Vec::new();
    if lines > 150 {
        faults.push(format!(
            "ARCHITECTURE.md:150: has {lines} lines, must have at most 150: a map that is not read is no map"
        ));
    }
    for document in ["ARCHITECTURE.md", "README.md", "CONTRIBUTING.md", "docs/REFERENCES.md"] {
        for (number, line) in read(document).lines().enumerate() {
            for name in line.split('`').skip(1).step_by(2).filter(|name| is_path(name)) {
                let name = name.trim_start_matches("./").trim_end_matches('/');
                if !root().join(name).exists() && !root().join("src").join(name).exists() {
                    faults.push(format!(
                        "{document}:{}: names `{name}`, which is not there: mend the path or the tree",
                        number + 1
                    ));
                }
            }
        }
    }
    claim(faults);
}

/// Whether a quoted word of a document is meant as a path of the repository: results of runs and commands are not.
fn is_path(name: &str) -> bool {
    let plain = name.chars().all(|c| c.is_alphanumeric() || "/._-".contains(c));
    let ours = [
        "src/",
        "tests/",
        "scenes/",
        "docs/",
        "assets/",
        "benches/",
        "scripts/",
        "examples/",
        "python/",
        ".ci/",
        "./scripts/",
    ];
    // `mod.rs` is any door.
    let file = name != "mod.rs" && [".rs", ".md"].iter().any(|end| name.ends_with(end));
    plain
        && (file
            || ours.iter().any(|start| name.starts_with(start))
            || FLOORS.iter().any(|floor| name.starts_with(&format!("{floor}/"))))
}

#[test]
fn house_is_as_the_floors_say() {
    let known: BTreeSet<&str> = FLOORS.into_iter().chain(["lib"]).collect();
    let mut faults = Vec::new();
    for source in sources(&["src"]) {
        let name = source.path["src/".len()..].split('/').next().unwrap_or_default().trim_end_matches(".rs");
        if !known.contains(name) {
            faults.push(format!("{}:1: `{name}` is no floor: put it on one of {FLOORS:?}, or name the floor in ARCHITECTURE.md and here", source.path));
        }
    }
    claim(faults);
}

#[test]
fn no_test_is_passed_over() {
    let mut faults = Vec::new();
    for source in sources(&["src", "tests"]) {
        for (at, _) in source.code.match_indices("#[ignore") {
            faults.push(format!(
                "{}:{}: a test that is not run proves nothing: make it quick or delete it",
                source.path,
                line_of(&source.code, at)
            ));
        }
    }
    claim(faults);
}

#[test]
fn scenes_have_a_head_that_says_what_to_look_at() {
    let mut scenes = Vec::new();
    files_under(&root().join("scenes"), "ron", &mut scenes);
    let mut faults = Vec::new();
    for scene in scenes {
        let path = relative(&scene);
        if !read(&path).starts_with("//") {
            faults.push(format!("{path}:1: has no comment head: say what flow, which paper and section, how long it takes, what to look at"));
        }
    }
    claim(faults);
}
