//! Baseline of the bench: density and forces neighbour by neighbour in plain f64 over the cells of
//! the engine.
//!
//! A straightforward code without packs, lanes, walls and shifting. Ratios to it are the gain of
//! the pair loops of the engine on this machine in the same minute.

use std::hint::black_box;
use std::time::Instant;

use sphecs_core::math::grid::CellGrid;
use sphecs_core::math::real::Real;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::neighbours::Neighbours;
use sphecs_core::pass::settings::PairSettings;

/// Number of ordered pairs of a repetition: some 0.1 s on one core.
const PAIRS: usize = 2_000_000;

/// Repetitions, of which the fastest counts.
const REPETITIONS: usize = 3;

/// Returns the ordered pairs per second, 1/s, on the current thread, of the fluid from the middle
/// of the arrays on.
pub fn pair_rate<R: Real, const D: usize>(
    pair: &PairSettings,
    grid: &CellGrid<D>,
    particles: &ParticleArrays<R, D>,
) -> f64 {
    let rows = particles.len() / 2..particles.len();
    let mut fastest = 0.0_f64;
    for _ in 0..REPETITIONS {
        let started = Instant::now();
        let mut pairs = 0;
        for row in rows.clone().filter(|&row| particles.zone[row] == Zone::Fluid) {
            pairs += black_box(density_and_force(pair, grid, particles, row)).0;
            if pairs >= PAIRS {
                break;
            }
        }
        fastest = fastest.max(pairs as f64 / started.elapsed().as_secs_f64());
    }
    fastest
}

/// Returns the ordered pairs of a row and the sum of its density and force components, so that no
/// term is optimised out.
pub fn density_and_force<R: Real, const D: usize>(
    pair: &PairSettings,
    grid: &CellGrid<D>,
    particles: &ParticleArrays<R, D>,
    row: usize,
) -> (usize, f64) {
    let neighbours = Neighbours::new(grid, particles);
    let (h, kernel) = (pair.discretisation.smoothing_length, pair.discretisation.kernel);
    let point = std::array::from_fn(|d| particles.position[d][row]);
    let mut density = 0.0;
    neighbours.for_each(point, |_, _, r2| density += kernel.value(D, h, r2.sqrt()));

    let (rho_a, p_a) = (particles.density[row].to_f64(), particles.pressure[row].to_f64());
    let viscous = 4.0 * pair.pair_viscosity();
    let mut pairs = 0;
    let mut acceleration = [0.0; D];
    neighbours.for_each(point, |b, x, r2| {
        let slope = kernel.slope(D, h, r2.sqrt());
        let rho_b = particles.density[b].to_f64();
        let push = (p_a + particles.pressure[b].to_f64()) / rho_b * slope;
        let drag = viscous * slope / (rho_a + rho_b);
        for d in 0..D {
            let v = particles.velocity[d][row].to_f64() - particles.velocity[d][b].to_f64();
            acceleration[d] += drag * v - push * x[d];
        }
        pairs += usize::from(b != row);
    });
    (pairs, density + acceleration.iter().sum::<f64>())
}
