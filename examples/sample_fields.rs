//! Velocity profile across a channel, sampled into an array and printed as CSV.
//!
//! ```text
//! cargo run --release --example sample_fields > profile.csv
//! ```

#![expect(clippy::print_stdout, reason = "the program prints its result")]

use std::error::Error;

use sphecs::glam::DVec3;
use sphecs::{Sample, Scene, Simulation};

/// Number of points across the channel.
const POINTS: usize = 21;

/// Runs a scene until a time, s; samples the fields at points across the channel at x = 20 mm.
///
/// A point without fluid nearby has no sample.
pub(crate) fn run(scene: Scene, until: f64) -> Result<Vec<(DVec3, Option<Sample>)>, Box<dyn Error>> {
    let mut simulation = Simulation::builder(scene).build()?;
    simulation.run_until(until)?;
    let half_width = 0.02;
    let points: Vec<DVec3> = (0..POINTS)
        .map(|point| point as f64 / (POINTS - 1) as f64)
        .map(|across| DVec3::new(0.02, (2.0 * across - 1.0) * half_width, 0.0))
        .collect();
    let samples = simulation.sample(&points);
    Ok(points.into_iter().zip(samples).collect())
}

fn main() -> Result<(), Box<dyn Error>> {
    let scene = Scene::from_file("scenes/quickstart.ron").load()?;
    println!("y / m,u / (m/s),v / (m/s),p / Pa");
    for (point, sample) in run(scene, 1.0)? {
        if let Some(Sample { velocity, pressure, .. }) = sample {
            println!("{},{},{},{pressure}", point.y, velocity.x, velocity.y);
        }
    }
    Ok(())
}
