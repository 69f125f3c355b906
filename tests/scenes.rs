//! Every shipped scene reads without faults and runs at its smoke spacing.

mod common;

use std::path::{Path, PathBuf};

use common::in_parallel;
use sphecs::{Scene, SceneErrors, Simulation};

/// Returns the scenes of some folders.
fn scenes(folders: &[&str]) -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut scenes: Vec<PathBuf> = folders
        .iter()
        .flat_map(|folder| std::fs::read_dir(root.join(folder)).expect("a folder of scenes"))
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "ron"))
        .collect();
    scenes.sort();
    assert!(!scenes.is_empty(), "no scene");
    scenes
}

/// Runs a check on every scene of some folders and fails with all faults at once.
fn each(folders: &[&str], check: impl Fn(&Path) -> Result<(), String> + Sync) {
    let fault = |path: &PathBuf| check(path).err().map(|fault| format!("{}: {fault}", path.display()));
    let faults: Vec<String> = in_parallel(&scenes(folders), fault).into_iter().flatten().collect();
    assert!(faults.is_empty(), "\n{}\n", faults.join("\n"));
}

fn titles(faults: &SceneErrors) -> String {
    faults.faults().iter().map(|fault| fault.title.clone()).collect::<Vec<_>>().join("; ")
}

/// The scenes of `scenes/` are read by the tests of the crate sphecs-scene.
#[test]
fn benches_and_templates_read_as_they_are_shipped() {
    each(&["benches", "assets/templates"], |path| {
        Scene::from_file(path).load().map(drop).map_err(|faults| titles(&faults))
    });
}

#[test]
fn every_scene_takes_steps_at_its_smoke_spacing() {
    each(&["scenes", "benches", "assets/templates"], |path| {
        let mut simulation =
            Simulation::builder(Scene::from_file(path).smoke().load().map_err(|faults| titles(&faults))?)
                .build()
                .expect("a simulation");
        for _ in 0..10 {
            simulation.step().map_err(|stop| stop.to_string())?;
        }
        match simulation.ledger() {
            ledger if ledger.balances() => Ok(()),
            ledger => Err(format!("the ledger does not balance: {ledger:?}")),
        }
    });
}
