//! Shipped scenes at their smoke spacings: no particle behind a wall, no clump, and particle counts
//! that balance at every step.

use sphecs::Simulation;

use crate::smoke;

/// Steps between two rows of the monitor.
const ROW_EVERY: u64 = 25;

/// Extremes over the rows of a run.
#[derive(Debug, Default)]
struct Worst {
    through_walls: u64,
    close_pairs: u64,
    density_deviation: f64,
    held_at_walls: u64,
}

/// Runs a shipped scene while a condition holds.
fn watch(name: &str, continues: impl Fn(&Simulation) -> bool) -> Worst {
    let mut simulation = smoke(name, &[]);
    let mut worst = Worst::default();
    while continues(&simulation) {
        simulation.step().unwrap_or_else(|stop| panic!("{name}: {stop}"));
        let ledger = simulation.ledger();
        assert!(ledger.balances(), "{name}: {:?}, {ledger:?}", simulation.clock());
        if simulation.clock().step.is_multiple_of(ROW_EVERY) {
            let row = simulation.monitor_row();
            worst.through_walls = worst.through_walls.max(row.through_walls);
            worst.close_pairs = worst.close_pairs.max(row.close_pairs);
            worst.density_deviation = worst.density_deviation.max(row.largest_density_deviation);
            worst.held_at_walls += row.held_at_walls;
        }
    }
    worst
}

/// The ramp of Alvarado-Rodríguez et al. (2017), Eq. 39, and the first wave of the inertia of the
/// throat. With six particles across the throat a particle could occasionally cut one of its sharp
/// corners.
#[test]
fn constricted_channel_starts_without_voids_clumps_or_leaks() {
    let worst = watch("constricted_r2.ron", |simulation| simulation.clock().time < 0.35);
    assert_eq!((worst.through_walls, worst.close_pairs), (0, 0), "{worst:?}");
    assert!(worst.density_deviation < 0.05, "{worst:?}");
    assert!(worst.held_at_walls < 100, "the walls themselves keep nearly all of the fluid back: {worst:?}");
}

#[test]
fn no_shipped_scene_leaks_in_its_first_steps() {
    for name in [
        "constricted_r1.ron",
        "constricted_r3.ron",
        "duct3d.ron",
        "inclined_plates.ron",
        "poiseuille.ron",
        "poiseuille_periodic.ron",
        "quickstart.ron",
        "taylor_green.ron",
    ] {
        let worst = watch(name, |simulation| simulation.clock().step < 300);
        assert_eq!(worst.through_walls, 0, "{name}");
    }
}
