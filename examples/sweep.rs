//! Sweep over the viscosity: one simulation per value, all at the same time.
//!
//! Each simulation runs on one thread of its own. For many short simulations this is faster than
//! one simulation after the other on all threads, and the results are bitwise identical.
//!
//! ```text
//! cargo run --release --example sweep
//! ```

#![expect(clippy::print_stdout, reason = "the program prints its result")]

use std::error::Error;

use rayon::ThreadPoolBuilder;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use sphecs::{Scene, SceneLoader, Simulation};

/// Kinematic viscosities, m²/s.
pub(crate) const VISCOSITIES: [f64; 3] = [1e-5, 2e-5, 4e-5];

/// Runs a scene until a time, s, with each viscosity; returns the largest speeds, m/s.
pub(crate) fn run(scene: &SceneLoader, until: f64) -> Result<Vec<f64>, Box<dyn Error + Send + Sync>> {
    VISCOSITIES.par_iter().map(|&viscosity| largest_speed(scene.clone(), viscosity, until)).collect()
}

fn largest_speed(
    scene: SceneLoader,
    viscosity: f64,
    until: f64,
) -> Result<f64, Box<dyn Error + Send + Sync>> {
    let scene = scene.set("fluid.viscosity", viscosity).load()?;
    let pool = ThreadPoolBuilder::new().num_threads(1).build()?;
    pool.install(|| {
        let mut simulation = Simulation::builder(scene).build()?;
        simulation.run_until(until)?;
        Ok(simulation.monitor_row().largest_speed)
    })
}

fn main() -> Result<(), Box<dyn Error + Send + Sync>> {
    let speeds = run(&Scene::from_file("scenes/quickstart.ron"), 1.0)?;
    for (viscosity, speed) in VISCOSITIES.iter().zip(speeds) {
        println!("ν = {viscosity:.1e} m²/s: largest speed {speed:.4} m/s");
    }
    Ok(())
}
