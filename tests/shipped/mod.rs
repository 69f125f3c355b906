//! The scenes that are shipped, for tests that run each of them.

use std::path::{Path, PathBuf};

/// Every scene under `scenes/`, by name.
pub fn shipped() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let entries = std::fs::read_dir(folder).expect("scenes/");
    let mut scenes: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
    scenes.retain(|path| path.extension().is_some_and(|extension| extension == "ron"));
    scenes.sort();
    scenes
}
