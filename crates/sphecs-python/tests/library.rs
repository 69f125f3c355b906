//! Library as Python loads it. What its functions do is tested in `python/tests/`, by the library
//! that cargo builds for this test.

use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};

/// Returns the contents of the library, which lies beside this test program.
fn library() -> Vec<u8> {
    let program = std::env::current_exe().expect("a program has a path");
    let path = program.with_file_name(format!("{DLL_PREFIX}sphecs_python{DLL_SUFFIX}"));
    std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn contains(library: &[u8], text: &str) -> bool {
    library.windows(text.len()).any(|window| window == text.as_bytes())
}

#[test]
fn python_finds_the_module() {
    assert!(contains(&library(), "PyInit__sphecs\0"));
}

#[test]
fn no_interpreter_is_linked() {
    // A wheel for every version must take its symbols from the interpreter that loads it.
    assert!(!contains(&library(), "libpython3"));
}
