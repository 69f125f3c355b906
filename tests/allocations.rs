//! Allocations of a step after warm-up: none, except for the rare growth of a list in an open flow.
//!
//! A separate test program, since the counting allocator counts for the whole process.

mod common;

use common::{simulation, text_scene};
use sphecs::Simulation;

#[global_allocator]
static ALLOCATOR: dhat::Alloc = dhat::Alloc;

/// Returns the number of blocks that the steps allocate after the warm-up.
fn blocks(simulation: &mut Simulation, warm_up: usize, steps: usize) -> u64 {
    // On a thread of the pool, as in a run, so that the hand-over to the pool is not counted.
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
fn step_after_warm_up_allocates_nothing() {
    let _profiler = dhat::Profiler::builder().testing().build();
    let mut found = Vec::new();
    let mut check = |name: &str, text: &str, set: &[(&str, &str)], warm_up: usize, allowed: u64| {
        let blocks = blocks(&mut simulation(text_scene(name, text, set)), warm_up, 50);
        if blocks > allowed {
            found.push(format!("{name} {set:?}: {blocks} blocks in 50 steps"));
        }
    };
    let vortices = include_str!("../scenes/taylor_green.ron");
    check("taylor_green", vortices, &[("spacing", "0.04")], 50, 0);
    check("taylor_green", vortices, &[("spacing", "0.04"), ("precision", "F32")], 50, 0);
    check("taylor_green", vortices, &[("spacing", "0.04"), ("scheme.viscosity", "Sps()")], 50, 0);
    // 14 400 rows, more than one task takes.
    check("taylor_green", vortices, &[("spacing", "0.008333333333333333")], 20, 0);
    let poiseuille = include_str!("../scenes/poiseuille_periodic.ron");
    check("poiseuille_periodic", poiseuille, &[("spacing", "4.0e-5")], 50, 0);
    let evolved = include_str!("../scenes/taylor_green_edac.ron");
    check("taylor_green_edac", evolved, &[("spacing", "0.04")], 50, 0);
    check("taylor_green_edac", evolved, &[("spacing", "0.04"), ("precision", "F32")], 50, 0);
    let evolved = include_str!("../scenes/poiseuille_edac.ron");
    check("poiseuille_edac", evolved, &[("spacing", "4.0e-5"), ("body_force", "(0.0, 0.0)")], 150, 0);
    // Particles change zone here, the first leave after some 550 steps. A list of rows may still
    // reach a new maximum and double its capacity.
    check("constricted_r2", include_str!("../scenes/constricted_r2.ron"), &[("spacing", "2.22e-3")], 800, 2);
    // All columns of the arrays grow once between steps 300 and 350.
    check("duct3d", include_str!("../scenes/duct3d.ron"), &[("spacing", "0.03")], 400, 2);
    // A uniform flow: if the flow oscillated, the reservoir would grow.
    let stream = include_str!("../scenes/acoustic_pulse.ron");
    for condition in ["Hybrid()", "Mirror()", "ModifiedDoNothing()", "Pressure(value: 0.0)"] {
        let sets = [("spacing", "0.02"), ("constants.A", "0.0"), ("outlets.0.condition", condition)];
        check("acoustic_pulse", stream, &sets, 300, 2);
    }
    assert!(found.is_empty(), "{found:#?}");
}
