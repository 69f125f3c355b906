//! Scenes and simulations that the test programs share.

#![allow(dead_code, reason = "each test program uses some of the helpers")]

use std::path::{Path, PathBuf};

use sphecs::{Scene, Simulation};

/// Changes of a scene: paths and values.
pub(crate) type Sets<'a> = &'a [(&'a str, &'a str)];

/// Returns the path of a shipped scene.
pub(crate) fn scene_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name)
}

/// Returns the paths of all shipped scenes, by name.
pub(crate) fn shipped_scenes() -> Vec<PathBuf> {
    let entries = std::fs::read_dir(scene_path("")).expect("scenes/");
    let mut scenes: Vec<PathBuf> = entries.map(|entry| entry.expect("an entry").path()).collect();
    scenes.retain(|path| path.extension().is_some_and(|extension| extension == "ron"));
    scenes.sort();
    scenes
}

/// Loads a scene from text, with changes.
pub(crate) fn text_scene(name: &str, text: &str, sets: Sets) -> Scene {
    Scene::from_text(name, text).sets(sets).load().unwrap_or_else(|errors| panic!("{name}: {errors:?}"))
}

/// Loads a scene file, with changes.
pub(crate) fn file_scene(path: &Path, sets: Sets) -> Scene {
    let scene = Scene::from_file(path).sets(sets).load();
    scene.unwrap_or_else(|errors| panic!("{}: {errors:?}", path.display()))
}

/// Loads a scene file at its smoke spacing, with changes.
pub(crate) fn smoke_scene(path: &Path, sets: Sets) -> Scene {
    let scene = Scene::from_file(path).smoke().sets(sets).load();
    scene.unwrap_or_else(|errors| panic!("{}: {errors:?}", path.display()))
}

/// Builds a simulation of a scene without plugins.
pub(crate) fn simulation(scene: Scene) -> Simulation {
    Simulation::builder(scene).build().expect("a scene without plugins can be built")
}

/// Takes steps, and fails if the flow diverges.
#[track_caller]
pub(crate) fn advance(simulation: &mut Simulation, steps: u64) {
    for _ in 0..steps {
        simulation.step().unwrap_or_else(|stop| panic!("{stop}"));
    }
}
