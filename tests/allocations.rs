//! A step that is warm allocates nothing: its buffers are kept from step to step. In an open flow, but for the rare growth of a
//! list.
//!
//! A program of its own with one test, since the counting allocator counts for the whole process.

use sphecs::scene::Scene;
use sphecs::simulation::Simulation;

#[global_allocator]
static ALLOCATOR: dhat::Alloc = dhat::Alloc;

/// Blocks that the steps allocate, after others that fill the buffers.
fn blocks(simulation: &mut Simulation, warm_up: usize, steps: usize) -> u64 {
    // On a thread of the pool, as a run is: handing a step over to the pool is not part of it.
    rayon::scope(|_| {
        for _ in 0..warm_up {
            simulation.step().expect("a step");
        }
        let before = dhat::HeapStats::get().total_blocks;
        for _ in 0..steps {
            simulation.step().expect("a step");
        }
        dhat::HeapStats::get().total_blocks - before
    })
}

#[test]
fn a_warm_step_allocates_nothing() {
    let _profiler = dhat::Profiler::builder().testing().build();
    let mut found = Vec::new();
    let mut check = |name: &str, text: &str, set: &[(&str, &str)], warm_up: usize, allowed: u64| {
        let scene =
            Scene::from_text(name, text).sets(set).load().unwrap_or_else(|faults| panic!("{faults:?}"));
        let blocks = blocks(&mut Simulation::from_scene(scene), warm_up, 50);
        if blocks > allowed {
            found.push(format!("{name} {set:?}: {blocks} blocks in 50 steps"));
        }
    };
    let vortices = include_str!("../scenes/taylor_green.ron");
    check("taylor_green", vortices, &[("spacing", "0.04")], 50, 0);
    check("taylor_green", vortices, &[("spacing", "0.04"), ("precision", "F32")], 50, 0);
    check("taylor_green", vortices, &[("spacing", "0.04"), ("scheme.viscosity", "Sps()")], 50, 0);
    // More rows than a thread takes at a time, 14 400, so that the work is handed about.
    check("taylor_green", vortices, &[("spacing", "0.008333333333333333")], 20, 0);
    let poiseuille = include_str!("../scenes/poiseuille_periodic.ron");
    check("poiseuille_periodic", poiseuille, &[("spacing", "4.0e-5")], 50, 0);
    let evolved = include_str!("../scenes/taylor_green_edac.ron");
    check("taylor_green_edac", evolved, &[("spacing", "0.04")], 50, 0);
    check("taylor_green_edac", evolved, &[("spacing", "0.04"), ("precision", "F32")], 50, 0);
    let evolved = include_str!("../scenes/poiseuille_edac.ron");
    check("poiseuille_edac", evolved, &[("spacing", "4.0e-5"), ("body_force", "(0.0, 0.0)")], 50, 0);
    // Particles change zone in these. A list of rows may still become longer than it ever was, and doubles its room.
    check("constricted_r2", include_str!("../scenes/constricted_r2.ron"), &[("spacing", "2.22e-3")], 500, 2);
    // Between steps 300 and 350 all columns of the arrays grow, once.
    check("duct3d", include_str!("../scenes/duct3d.ron"), &[("spacing", "0.03")], 400, 2);
    // An even stream: a condition that lets the flow swing makes the reservoir grow.
    let stream = include_str!("../scenes/acoustic_pulse.ron");
    for condition in ["Hybrid()", "Mirror()", "ModifiedDoNothing()"] {
        let sets = [("spacing", "0.02"), ("constants.A", "0.0"), ("outlets.0.condition", condition)];
        check("acoustic_pulse", stream, &sets, 300, 2);
    }
    assert!(found.is_empty(), "{found:#?}");
}
