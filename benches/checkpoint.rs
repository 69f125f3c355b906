//! What a checkpoint of a million particles costs: what the step waits for, and what the thread that writes does meanwhile.
//!
//! `cargo bench --bench checkpoint`. Divan's bytes are those of the file.

use divan::Bencher;
use divan::counter::BytesCount;
use sphecs::Simulation;
use sphecs_bench::cases::Case;
use sphecs_output::checkpoint::store::Store;
use sphecs_output::checkpoint::{Checkpoint, Facts};

fn main() {
    divan::main();
}

/// The box after a few steps.
fn million() -> Simulation {
    let scene = Case::named("3d-large-f64").expect("a case of the engine").scene().expect("a scene");
    let mut simulation = Simulation::builder(scene).build().expect("a simulation");
    for _ in 0..2 {
        simulation.step().expect("the flow is tame");
    }
    simulation
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn step_waits(bencher: Bencher) {
    let mut simulation = million();
    bencher.bench_local(|| simulation.state());
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn written_to_disk(bencher: Bencher) {
    let checkpoint = Checkpoint { facts: Facts::default(), state: million().state() };
    let folder = tempfile::tempdir().expect("a folder");
    let store = Store::of(folder.path());
    let path = store.write(&checkpoint).expect("a checkpoint");
    let bytes = path.metadata().expect("a file").len();
    bencher.counter(BytesCount::new(bytes)).bench_local(|| store.write(&checkpoint).expect("a checkpoint"));
}
