//! The invariants of ARCHITECTURE.md that the compiler does not check. Each failure names the line
//! and the cure.

use std::collections::BTreeMap;

use crate::source_tree::{
    SOURCES, SourceFile, Token, expect_none, files_under, find, read, relative, root, sources,
};

/// Layers inside the numerical core, from the lowest up. Between crates Cargo checks the direction.
const CORE_LAYERS: [&str; 5] = ["math", "physics", "particles", "pass", "boundary"];
const CORE: &str = "crates/sphecs-core/src/";

/// Returns the index into [`CORE_LAYERS`] of a file of the core.
fn core_layer(path: &str) -> Option<usize> {
    let name = path.strip_prefix(CORE)?.split('/').next()?;
    CORE_LAYERS.iter().position(|layer| *layer == name.trim_end_matches(".rs"))
}

/// Returns the first name behind every `crate::`, with its line; of a group all names.
fn imports(source: &SourceFile) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    for at in find(&source.tokens, &["crate", ":", ":"]) {
        let rest = &source.tokens[at + 3..];
        let Some(first) = rest.first() else { continue };
        if first.is_word {
            found.push((first.line, first.text.clone()));
        } else if first.text == "{" {
            found.extend(first_names(&rest[1..]));
        }
    }
    found
}

/// Returns `a` and `c` of the tokens behind the brace of `{a::b, c::{d, e}}`.
fn first_names(tokens: &[Token]) -> Vec<(usize, String)> {
    let mut depth = 0;
    let mut is_first = true;
    let mut names = Vec::new();
    for token in tokens {
        match token.text.as_str() {
            "{" => depth += 1,
            "}" if depth == 0 => break,
            "}" => depth -= 1,
            "," if depth == 0 => is_first = true,
            _ if is_first && token.is_word => {
                names.push((token.line, token.text.clone()));
                is_first = false;
            }
            _ => {}
        }
    }
    names
}

#[test]
fn core_imports_point_downwards() {
    let mut faults = Vec::new();
    for source in sources(&[CORE]) {
        let Some(own) = core_layer(&source.path) else { continue };
        for (line, name) in imports(&source) {
            if CORE_LAYERS.iter().position(|layer| *layer == name).is_some_and(|other| other > own) {
                faults.push(format!(
                    "{}:{line}: layer `{}` imports from `{name}` above it: move what both need to the \
                     lower layer, or pass it as an argument",
                    source.path, CORE_LAYERS[own],
                ));
            }
        }
    }
    expect_none(&faults);
}

#[test]
fn imports_are_found_however_they_are_written() {
    let text = "use crate::{a::b, c::{d, e}, f};\nfn g() { crate::h::i(); \"crate::no\"; }\n// crate::no\n";
    let names: Vec<String> =
        imports(&SourceFile::new("x.rs", text)).into_iter().map(|(_, name)| name).collect();
    assert_eq!(names, ["a", "c", "f", "h"]);
}

/// Places of `unsafe` code: lanes, packs that read whole vectors of their own storage, chunks and
/// the end of HDF5, which `scripts/reliability/sanitizer.sh` runs, and the environment of HDF5,
/// which the program sets before it has a second thread.
const UNSAFE: [&str; 5] = [
    "crates/sphecs-core/src/math/lanes/",
    "crates/sphecs-core/src/pass/pack/",
    "crates/sphecs-output/src/netcdf/chunks.rs",
    "crates/sphecs-output/src/netcdf/file.rs",
    "src/main.rs",
];

#[test]
fn unsafe_code_stays_where_the_sanitizer_looks() {
    let mut faults = Vec::new();
    for source in sources(&SOURCES) {
        if !UNSAFE.iter().any(|place| source.path.starts_with(place)) {
            let fault = |line| format!("{}:{line}: is `unsafe`: only {UNSAFE:?} may be", source.path);
            faults.extend(source.lines_with(&["unsafe"]).map(fault));
        }
    }
    expect_none(&faults);
}

/// The one module that names the crate netcdf.
const NETCDF: &str = "crates/sphecs-output/src/netcdf/";

#[test]
fn one_module_names_the_netcdf_crate() {
    let mut faults = Vec::new();
    for source in sources(&SOURCES) {
        let has_module = find(&source.tokens, &["mod", "netcdf"]).next().is_some()
            || find(&source.tokens, &["use", "crate", ":", ":", "netcdf", ";"]).next().is_some()
            || find(&source.tokens, &["use", "super", ":", ":", "netcdf", ";"]).next().is_some();
        if source.path.starts_with(NETCDF) || has_module {
            continue;
        }
        for at in find(&source.tokens, &["netcdf", ":", ":"]) {
            // `crate::netcdf::…` is the module.
            if at == 0 || source.tokens[at - 1].text != ":" {
                faults.push(format!(
                    "{}:{}: names the crate `netcdf`: only {NETCDF} may; add a function there and call it",
                    source.path, source.tokens[at].line,
                ));
            }
        }
    }
    expect_none(&faults);
}

/// The modules that may spawn, despawn and change roles: at the start, and at the end of a step.
const STRUCTURE: [&str; 2] =
    ["crates/sphecs-engine/src/systems/transitions/", "crates/sphecs-engine/src/spawn.rs"];

const ROLES: [&str; 6] = ["Fluid", "Wall", "Inflow", "Outflow", "Reservoir", "SpsStress"];

#[test]
fn structure_changes_in_one_set() {
    let mut faults = Vec::new();
    for source in sources(&["crates/sphecs-engine/src", "crates/sphecs-output/src", "crates/sphecs-run/src"])
    {
        if STRUCTURE.iter().any(|place| source.path.starts_with(place)) {
            continue;
        }
        let tokens = source.tokens_without_tests();
        for (at, token) in tokens.iter().enumerate() {
            if changes_structure(&tokens[at..]) {
                faults.push(format!(
                    "{}:{}: changes the structure of the world: mark the particle here and let {} act on it",
                    source.path, token.line, STRUCTURE[0],
                ));
            }
        }
    }
    expect_none(&faults);
}

/// Whether tokens begin with a call that spawns, despawns or changes a role.
fn changes_structure(tokens: &[Token]) -> bool {
    let texts: Vec<&str> = tokens.iter().take(7).map(|token| token.text.as_str()).collect();
    match texts.as_slice() {
        [".", "spawn_batch" | "spawn_empty" | "despawn" | "try_despawn", "(", ..] => true,
        // Threads are spawned by a closure.
        [".", "spawn", "(", next, ..] => !matches!(*next, "move" | "|"),
        [".", "insert", "(", "(", role, end, ..] | [".", "insert", "(", role, end, ..] => {
            ROLES.contains(role) && *end != ":"
        }
        [".", "remove", ":", ":", "<", "(", role, ..] | [".", "remove", ":", ":", "<", role, ..] => {
            ROLES.contains(role)
        }
        _ => false,
    }
}

/// Types that a system may keep in a `Local`: buffers that each step fills again, which no
/// checkpoint needs.
const BUFFERS: [&str; 5] = ["OutletBuffers", "PointFlows", "Prescribed", "WaveFound", "DVec3"];

#[test]
fn locals_are_buffers() {
    let mut faults = Vec::new();
    for source in sources(&["crates/sphecs-engine/src"]) {
        for at in find(&source.tokens, &["Local", "<"]) {
            // `'s` is the lifetime in a struct of system parameters.
            let inside = source.tokens[at + 2..]
                .iter()
                .filter(|token| token.is_word && !["s", "Vec"].contains(&token.text.as_str()));
            let kept = inside.map(|token| token.text.as_str()).next().unwrap_or_default();
            if !BUFFERS.contains(&kept) && !kept.ends_with("Buffers") {
                faults.push(format!(
                    "{}:{}: keeps `{kept}` in a `Local`, which a restart forgets: make it a saved resource, or, \
                     if each step fills it again, name its type in BUFFERS",
                    source.path, source.tokens[at].line,
                ));
            }
        }
    }
    expect_none(&faults);
}

#[test]
fn no_prelude_is_imported() {
    let mut faults = Vec::new();
    for source in sources(&["crates", "src", "tests", "benches", "examples"]) {
        let fault = |line| format!("{}:{line}: imports a prelude: name what the file needs", source.path);
        faults.extend(source.lines_with(&["prelude", ":", ":", "*"]).map(fault));
    }
    expect_none(&faults);
}

#[test]
fn every_file_is_a_module_and_every_module_has_a_head() {
    let mut faults = Vec::new();
    let all = sources(&SOURCES);
    for source in &all {
        if !source.text.starts_with("//!") {
            faults.push(format!("{}:1: has no `//!` head that says what the module is", source.path));
        }
        let Some((folder, name)) = source.path.trim_end_matches(".rs").rsplit_once('/') else { continue };
        let (folder, name) = match name {
            "lib" | "main" => continue,
            // Test programs of a crate are compiled one by one.
            _ if folder.starts_with("crates/") && !folder.contains("/src") => continue,
            "mod" => folder.rsplit_once('/').unwrap_or_default(),
            _ => (folder, name),
        };
        let parents = [format!("{folder}/mod.rs"), format!("{folder}/lib.rs"), format!("{folder}.rs")];
        let parent = all.iter().find(|other| parents.contains(&other.path));
        if parent.is_none_or(|parent| find(&parent.tokens, &["mod", name, ";"]).next().is_none()) {
            faults.push(format!(
                "{}:1: no module declares it: add `mod {name};` to {}",
                source.path, parents[0]
            ));
        }
    }
    expect_none(&faults);
}

/// Most lines of a file, of `main.rs` and of a function.
const MOST_LINES: usize = 400;
const MOST_LINES_OF_MAIN: usize = 40;
const MOST_LINES_OF_A_FUNCTION: usize = 80;

#[test]
fn files_are_short() {
    let mut faults = Vec::new();
    for source in sources(&SOURCES) {
        let most = if source.path == "src/main.rs" { MOST_LINES_OF_MAIN } else { MOST_LINES };
        let lines = source.text.lines().count();
        if lines > most {
            faults.push(format!(
                "{}:{most}: has {lines} lines, must have at most {most}: split off a method with its tests",
                source.path,
            ));
        }
    }
    expect_none(&faults);
}

#[test]
fn functions_are_short() {
    let mut faults = Vec::new();
    for source in sources(&SOURCES) {
        if source.path.contains("/tests/") || source.path.ends_with("tests.rs") {
            continue;
        }
        for (name, first, lines) in functions(source.tokens_without_tests()) {
            if lines > MOST_LINES_OF_A_FUNCTION {
                faults.push(format!(
                    "{}:{first}: `{name}` has {lines} lines, must have at most {MOST_LINES_OF_A_FUNCTION}: \
                     give a part of it a name of its own",
                    source.path,
                ));
            }
        }
    }
    expect_none(&faults);
}

/// Returns name, first line and number of lines of every function with a body.
fn functions(tokens: &[Token]) -> Vec<(String, usize, usize)> {
    let mut found = Vec::new();
    for (at, token) in tokens.iter().enumerate() {
        let Some(name) = tokens.get(at + 1).filter(|name| token.text == "fn" && name.is_word) else {
            continue;
        };
        let Some(length) = body_end(&tokens[at..]) else { continue };
        let last = tokens[at + length].line;
        found.push((name.text.clone(), token.line, last - token.line + 1));
    }
    found
}

/// Returns the index of the brace that closes the body of the function that tokens begin with.
fn body_end(tokens: &[Token]) -> Option<usize> {
    let mut depth = 0;
    for (at, token) in tokens.iter().enumerate() {
        match token.text.as_str() {
            // A function without a body, or an array type in the signature.
            ";" if depth == 0 => return None,
            "(" | "[" | "{" => depth += 1,
            ")" | "]" => depth -= 1,
            "}" => {
                depth -= 1;
                if depth == 0 {
                    return Some(at);
                }
            }
            _ => {}
        }
    }
    None
}

#[test]
fn functions_are_measured_from_name_to_brace() {
    let source = SourceFile::new(
        "x.rs",
        "trait A { fn b(x: [u8; 2]); }\nfn c(x: [u8; 2]) -> u8 {\n    x[0]\n}\nfn d() {}\n",
    );
    let found = functions(&source.tokens);
    assert_eq!(found, [("c".to_owned(), 2, 3), ("d".to_owned(), 5, 1)]);
}

#[test]
fn no_test_is_ignored() {
    let mut faults = Vec::new();
    for source in sources(&["crates", "src", "tests"]) {
        let fault = |line| format!("{}:{line}: ignores a test: make it quick or delete it", source.path);
        faults.extend(source.lines_with(&["#", "[", "ignore"]).map(fault));
    }
    expect_none(&faults);
}

#[test]
fn scenes_have_a_head() {
    let mut scenes = Vec::new();
    files_under(&root().join("scenes"), &["ron"], &mut scenes);
    let mut faults = Vec::new();
    for scene in scenes {
        let path = relative(&scene);
        if !read(&path).starts_with("//") {
            faults.push(format!(
                "{path}:1: has no comment head: say which flow, paper and section, how long it takes, and \
                 what to look at"
            ));
        }
    }
    expect_none(&faults);
}

/// Names that several folders have for good reason.
const SHARED_NAMES: [&str; 6] = ["mod.rs", "lib.rs", "main.rs", "tests.rs", "error.rs", "build.rs"];

#[test]
fn neighbouring_folders_share_no_file_names() {
    let mut places: BTreeMap<(String, String), Vec<String>> = BTreeMap::new();
    for source in sources(&SOURCES) {
        let mut parts: Vec<&str> = source.path.split('/').collect();
        let (Some(name), Some(folder)) = (parts.pop(), parts.pop()) else { continue };
        // `check` has the checks of the file of that name in `schema`, `tests` their tests.
        let is_counterpart = matches!(folder, "check" | "tests") || parts.contains(&"tests");
        if !SHARED_NAMES.contains(&name) && !is_counterpart {
            places.entry((parts.join("/"), name.to_owned())).or_default().push(source.path.clone());
        }
    }
    let faults: Vec<String> = places
        .into_values()
        .filter(|paths| paths.len() > 1)
        .map(|paths| format!("{}:1: has the name of {}: say the difference", paths[0], paths[1..].join(", ")))
        .collect();
    expect_none(&faults);
}
