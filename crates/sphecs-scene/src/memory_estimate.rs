//! Largest resident memory of a run with its output, estimated from its scene.
//!
//! ```text
//! M = M_program + n_probes M_probe + n_particles M_particle
//! ```
//!
//! Measured on two threads with 400 to 1 400 000 particles in 2D and 3D
//! (`docs/notebook/2026-11-26-output.md`); `python/tests/test_memory.py` compares it with the peak
//! of every shipped scene.

use super::model::{Precision, Scene};
use super::scheme::Scheme;

/// Program, libraries and the buffers of two threads, B.
const PROGRAM: f64 = 39e6;

/// A probe: mostly its group in `probes.nc` while the run is packed, B.
const PROBE: f64 = 0.55e6;

/// Returns the memory of a particle, B: components, columns, cells, sums, and at the time of the
/// peak a checkpoint and two frames.
pub fn bytes_per_particle(scheme: &Scheme, precision: Precision) -> f64 {
    let (particle, stress) = match precision {
        Precision::F32 => (610.0, 160.0),
        Precision::F64 => (710.0, 290.0),
    };
    if scheme.has_stress() { particle + stress } else { particle }
}

/// Returns the memory of a run with a number of particles of all zones, B.
pub fn memory(scene: &Scene, particles: f64) -> f64 {
    let probes = scene.output.probes.len() as f64;
    PROGRAM + probes * PROBE + particles * bytes_per_particle(&scene.scheme, scene.precision)
}
