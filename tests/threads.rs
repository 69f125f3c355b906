//! A run has the same bits on any number of threads.

use sphecs::particles::components::{Density, ParticleId, Position, Velocity};
use sphecs::scene;
use sphecs::simulation::Simulation;

/// More rows than several threads would share out among themselves: inlet, outlet, walls, a force that is a formula.
const CHANNEL: &str = r#"Scene(
    title: "Channel", dimensions: 2, spacing: 0.005, smoke: 0.01,
    fluid: (density: 1000.0, viscosity: 1.0e-3, sound_speed: 10.0),
    scheme: Wcsph(smoothing_ratio: 1.5),
    domain: Box(min: (0.0, -0.15), max: (1.2, 0.15)),
    body_force: ("0.1*cos(y)", "0"),
    inlets: [(at: (0.0, 0.0), towards: (1.0, 0.0), velocity: Normal("min(20*t, 1)*(1 - 40*y^2)"))],
    outlets: [(at: (1.2, 0.0), towards: (1.0, 0.0), condition: WaveEquation())],
    time: (end: 1.0), output: (every: 1.0),
)"#;

/// Bits of position, velocity and density of all particles, by number.
fn bits_after(steps: usize, threads: usize) -> Vec<[u64; 4]> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads can be started");
    pool.install(|| {
        let scene = scene::load_str("channel", CHANNEL, &[]).unwrap_or_else(|faults| panic!("{faults}"));
        let mut simulation = Simulation::from_scene(scene);
        for _ in 0..steps {
            simulation.step().expect("the flow is tame");
        }
        assert!(simulation.ledger().entered[0] > 0, "particles must have crossed the inlet");
        let world = simulation.world_mut();
        let mut state = world.query::<(&ParticleId, &Position, &Velocity, &Density)>();
        let mut bits: Vec<(u32, [u64; 4])> = state
            .iter(world)
            .map(|(id, x, v, rho)| {
                (id.0, [x.0.x.to_bits(), x.0.y.to_bits(), v.0.x.to_bits(), rho.0.to_bits()])
            })
            .collect();
        bits.sort_unstable_by_key(|(id, _)| *id);
        bits.into_iter().map(|(_, bits)| bits).collect()
    })
}

#[test]
fn a_run_has_the_same_bits_on_any_number_of_threads() {
    let alone = bits_after(160, 1);
    assert!(alone.len() > 12_000, "{} rows are too few to be shared out", alone.len());
    assert!(alone == bits_after(160, 3));
}
