//! Output during a run does not change the flow.

use std::path::Path;

use sphecs::{Scene, Simulation};
use sphecs_output::frame::Frame;

fn simulation(scene: &str, precision: &str) -> Simulation {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(scene);
    let sets = [("precision", precision)];
    Simulation::builder(Scene::from_file(&path).smoke().sets(sets).load().expect("a shipped scene reads"))
        .build()
        .expect("a simulation")
}

/// Returns all bits of the state in a frame.
fn bits(simulation: &mut Simulation) -> Vec<u64> {
    simulation.world_mut();
    let frame = Frame::of(simulation);
    let wide = frame.position.iter().flatten().map(|x| x.to_bits());
    let narrow = frame.velocity.iter().chain([&frame.density, &frame.pressure]).flatten();
    let counts =
        frame.zone.iter().map(|zone| u64::from(*zone)).chain(frame.passage.iter().map(|n| u64::from(*n)));
    wide.chain(narrow.map(|x| u64::from(x.to_bits()))).chain(counts).collect()
}

#[track_caller]
fn check(scene: &str, precision: &str) {
    let (mut sampled, mut undisturbed) = (simulation(scene, precision), simulation(scene, precision));
    let points: Vec<_> = sampled.scene().inlets.iter().map(|inlet| inlet.patch.at).collect();
    for step in 0..100 {
        if step % 7 == 0 {
            sampled.monitor_row();
            sampled.sample(&points);
            bits(&mut sampled);
        }
        sampled.step().expect("a step");
        undisturbed.step().expect("a step");
        let (with, without) = (sampled.clock(), undisturbed.clock());
        assert_eq!(with.time.to_bits(), without.time.to_bits(), "{scene}, {precision}: step {step} differs");
    }
    assert!(
        bits(&mut sampled) == bits(&mut undisturbed),
        "{scene}, {precision}: the state differs after 100 steps"
    );
}

#[test]
fn sampled_flow_is_bitwise_identical() {
    for scene in ["quickstart.ron", "poiseuille_periodic.ron", "duct3d.ron"] {
        for precision in ["F64", "F32"] {
            check(scene, precision);
        }
    }
}
