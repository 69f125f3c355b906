//! Every shipped scene reads without faults and runs at its smoke spacing.

use std::path::{Path, PathBuf};

use sphecs::{Scene, SceneErrors, Simulation};

fn shipped() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut scenes: Vec<PathBuf> = ["scenes", "benches", "assets/templates"]
        .into_iter()
        .flat_map(|folder| std::fs::read_dir(root.join(folder)).expect("a folder of scenes"))
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "ron"))
        .collect();
    scenes.sort();
    assert!(!scenes.is_empty(), "no scene");
    scenes
}

/// Runs a check on every scene and fails with all faults at once.
fn each(check: impl Fn(&Path) -> Result<(), String>) {
    let faults: Vec<String> = shipped()
        .iter()
        .filter_map(|path| check(path).err().map(|fault| format!("{}: {fault}", path.display())))
        .collect();
    assert!(faults.is_empty(), "\n{}\n", faults.join("\n"));
}

fn titles(faults: &SceneErrors) -> String {
    faults.faults().iter().map(|fault| fault.title.clone()).collect::<Vec<_>>().join("; ")
}

#[test]
fn every_scene_reads_as_it_is_shipped() {
    each(|path| Scene::from_file(path).load().map(drop).map_err(|faults| titles(&faults)));
}

#[test]
fn every_scene_takes_steps_at_its_smoke_spacing() {
    each(|path| {
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
