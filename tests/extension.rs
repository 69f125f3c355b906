//! One method, one file: a new condition touches its file, the `mod.rs` with its enum, and
//! docs/REFERENCES.md.
//!
//! The tests search the source for files that name a variant of such an enum. Unit tests,
//! integration tests, scenes and documentation may name variants.

use std::fs;
use std::path::{Path, PathBuf};

/// Rust files below a folder.
fn rust_files(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display())) {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            rust_files(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
}

/// The source files of all crates, with their path from the root and their text before the unit
/// tests.
fn sources() -> Vec<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    rust_files(&root.join("src"), &mut files);
    for entry in fs::read_dir(root.join("crates")).expect("crates") {
        rust_files(&entry.expect("a crate").path().join("src"), &mut files);
    }
    let name = |path: &Path| {
        let relative = path.strip_prefix(root).expect("below the root");
        relative.to_str().expect("UTF-8").replace('\\', "/")
    };
    let is_test = |name: &str| name.contains("/tests/") || name.ends_with("/tests.rs");
    let mut sources: Vec<(String, String)> = files
        .iter()
        .map(|path| (name(path), fs::read_to_string(path).expect("UTF-8 text")))
        .filter(|(name, _)| !is_test(name))
        .map(|(name, text)| (name, code(&text)))
        .collect();
    sources.sort();
    sources
}

/// The text of a file without comments and without its unit tests.
fn code(text: &str) -> String {
    let code = text.split("#[cfg(test)]").next().unwrap_or_default();
    let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
    lines.collect::<Vec<_>>().join("\n")
}

/// The variants of an enum in the text of a file.
fn variants(text: &str, name: &str) -> Vec<String> {
    let head = format!("pub enum {name} {{");
    let body = text.split(&head).nth(1).unwrap_or_else(|| panic!("no `{head}`"));
    let body = body.split("\n}").next().unwrap_or_default();
    let variant = |line: &str| {
        let word: String = line.trim().chars().take_while(|c| c.is_alphanumeric()).collect();
        // Variants are indented once; fields of a variant deeper.
        let is_variant = line.starts_with("    ") && !line.starts_with("     ");
        (is_variant && word.starts_with(char::is_uppercase)).then_some(word)
    };
    body.lines().filter_map(variant).collect()
}

/// Checks that only the file of an enum names its variants.
fn check_enum(file: &str, name: &str) {
    let sources = sources();
    let (_, text) = sources.iter().find(|(other, _)| other == file).unwrap_or_else(|| panic!("no `{file}`"));
    let variants = variants(text, name);
    assert!(variants.len() >= 2, "`{name}` has the variants {variants:?}");
    let names_one = |text: &str| {
        variants.iter().find(|variant| {
            let path = format!("{name}::{variant}");
            text.match_indices(&path).any(|(at, _)| {
                let next = text[at + path.len()..].chars().next();
                !next.is_some_and(|next| next.is_alphanumeric() || next == '_')
            })
        })
    };
    let others: Vec<String> = sources
        .iter()
        .filter(|(other, _)| other != file)
        .filter_map(|(other, text)| names_one(text).map(|variant| format!("{other}: `{name}::{variant}`")))
        .collect();
    assert!(
        others.is_empty(),
        "a new `{name}` would have to touch more than its file, `{file}` and docs/REFERENCES.md:\n{}",
        others.join("\n")
    );
}

#[test]
fn only_one_file_names_outlet_conditions() {
    check_enum("crates/sphecs-core/src/boundary/outlet/mod.rs", "OutletCondition");
}

#[test]
fn only_one_file_names_inlet_pressures() {
    check_enum("crates/sphecs-core/src/boundary/inlet/mod.rs", "InletPressure");
}

#[test]
fn only_one_file_names_wall_models() {
    check_enum("crates/sphecs-core/src/physics/wall/mod.rs", "WallModel");
}

#[test]
fn only_one_file_names_viscosities() {
    check_enum("crates/sphecs-core/src/physics/viscosity/mod.rs", "Viscosity");
}

#[test]
fn only_one_file_names_shiftings() {
    check_enum("crates/sphecs-core/src/physics/shifting/mod.rs", "Shifting");
}

#[test]
fn variants_are_read_from_the_text_of_an_enum() {
    let text = "pub enum Shape {\n    #[default]\n    Disc,\n    Box {\n        Side: f64,\n    },\n    Ring(Ring),\n}\n";
    assert_eq!(variants(text, "Shape"), ["Disc", "Box", "Ring"]);
}

#[test]
fn comments_and_unit_tests_may_name_variants() {
    let text = "//! Shape::Disc\nfn area() {}\n#[cfg(test)]\nmod tests { use Shape::Disc; }\n";
    assert_eq!(code(text), "fn area() {}");
}
