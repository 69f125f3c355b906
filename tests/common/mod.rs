//! Scenes and simulations that the test programs share.

#![allow(dead_code, reason = "each test program uses some of the helpers")]

use std::num::NonZeroUsize;
use std::panic::resume_unwind;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::ScopedJoinHandle;

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

/// Runs `work` for each item, several at once: runs on one thread leave cores idle. Returns the
/// results in the order of the items.
pub(crate) fn in_parallel<I: Sync, T: Send>(items: &[I], work: impl Fn(&I) -> T + Sync) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let take = || {
        let mut done = Vec::new();
        while let at = next.fetch_add(1, Ordering::Relaxed)
            && let Some(item) = items.get(at)
        {
            done.push((at, work(item)));
        }
        done
    };
    let cores = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    let mut found: Vec<(usize, T)> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..cores).map(|_| scope.spawn(take)).collect();
        let done =
            |worker: ScopedJoinHandle<'_, Vec<_>>| worker.join().unwrap_or_else(|panic| resume_unwind(panic));
        workers.into_iter().flat_map(done).collect()
    });
    found.sort_by_key(|(at, _)| *at);
    found.into_iter().map(|(_, result)| result).collect()
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
