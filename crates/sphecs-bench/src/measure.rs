//! Steps, sets of systems and pairs of a flow, timed.
//!
//! The fastest of several repetitions counts, of a step as of each set of systems: whatever else a machine does makes a
//! repetition slower, never faster.

use std::time::Instant;

use rayon::ThreadPool;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::cases::Plan;
use super::memory;
use super::operations;
use super::scalar;
use super::stirring::Tile;
use sphecs_core::math::grid::CellGrid;
use sphecs_core::math::real::Real;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::neighbours::Neighbours;
use sphecs_engine::arrays::Arrays;
use sphecs_engine::simulation::{Simulation, Stop};
use sphecs_engine::systems::neighbours::Grid;
use sphecs_engine::systems::pair::Pair;
use sphecs_scene::model::{Precision, Scene};
use sphecs_scene::seeds;

/// What was found of a flow.
#[derive(Clone, Debug)]
pub struct Figures {
    /// Particles, reservoir excluded, walls included.
    pub particles: usize,
    /// Ordered pairs of fluid particles with anything in their support.
    pub pairs: usize,
    /// Floating-point operations of a pair in a step: see [`operations`].
    pub operations: usize,
    /// Ordered pairs a second of the scalar baseline on one thread, 1/s: see [`scalar`].
    pub scalar_rate: f64,
    /// Growth of the process's largest resident memory, B; None where the system does not tell.
    pub memory: Option<u64>,
    /// One for each number of threads, in the order asked for.
    pub timings: Vec<Timing>,
}

/// The time of a step on a number of threads.
#[derive(Clone, Debug)]
pub struct Timing {
    /// Threads.
    pub threads: usize,
    /// Wall time of a step in the fastest repetition, s.
    pub step: f64,
    /// Flow time of a step in that repetition, s.
    pub flow: f64,
    /// Wall time of each set of systems in its fastest repetition, s a step, in the order of a step.
    pub sets: Vec<(&'static str, f64)>,
}

impl Figures {
    /// Ordered pairs a second and thread, 1/s.
    pub fn pair_rate(&self, timing: &Timing) -> f64 {
        self.pairs as f64 / (timing.step * timing.threads as f64)
    }

    /// How many times the pairs of the scalar baseline, thread by thread.
    pub fn gain(&self, timing: &Timing) -> f64 {
        self.pair_rate(timing) / self.scalar_rate
    }

    /// How many times as fast as on one thread; None if one thread was not timed.
    pub fn speed_up(&self, timing: &Timing) -> Option<f64> {
        self.timings.iter().find(|single| single.threads == 1).map(|single| single.step / timing.step)
    }
}

/// The fastest run of each set of systems.
#[derive(Clone, Debug)]
pub struct FastestSets {
    before: Vec<(&'static str, f64)>,
    fastest: Vec<(&'static str, f64)>,
}

impl FastestSets {
    /// Begins before the first step that counts.
    pub fn begin(simulation: &Simulation) -> Self {
        let before = simulation.stage_times();
        let fastest = before.iter().map(|(name, _)| (*name, f64::INFINITY)).collect();
        Self { before, fastest }
    }

    /// Takes note of the steps, so many, since the last call.
    pub fn record(&mut self, simulation: &Simulation, steps: usize) {
        let after = simulation.stage_times();
        for ((fastest, before), after) in self.fastest.iter_mut().zip(&self.before).zip(&after) {
            fastest.1 = fastest.1.min((after.1 - before.1) / steps as f64);
        }
        self.before = after;
    }

    /// Name and seconds a step of each set, in the order of a step; infinite before the first record.
    pub fn seconds(self) -> Vec<(&'static str, f64)> {
        self.fastest
    }
}

/// Builds a flow, paves it with the tile if there is one, warms it up on the last pool and times it on each. `at_rest` is the resident memory of the process before
/// its first flow, B.
///
/// # Errors
/// [`Stop`] when the flow blew up.
pub fn measure(
    scene: Scene,
    tile: Option<&Tile>,
    plan: Plan,
    pools: &[ThreadPool],
    at_rest: Option<u64>,
) -> Result<Figures, Stop> {
    let growth = memory::Growth::begin(at_rest);
    let operations = operations::per_pair(&scene);
    let build = || -> Result<Simulation, Stop> {
        let mut simulation = paved(scene, tile);
        for _ in 0..plan.warm_up {
            simulation.step()?;
        }
        Ok(simulation)
    };
    let mut simulation = match pools.last() {
        Some(pool) => pool.install(build)?,
        None => build()?,
    };
    let mut timings = Vec::new();
    for pool in pools {
        timings.push(pool.install(|| time(&mut simulation, plan))?);
    }
    // Before the pairs are counted: that looks at the components, which a run does not hold twice.
    let memory = growth.and_then(memory::Growth::bytes);
    let mut look = || (count(&mut simulation), scalar_rate(&mut simulation));
    let ((particles, pairs), scalar_rate) = match pools.last() {
        Some(pool) => pool.install(look),
        None => look(),
    };
    Ok(Figures { particles, pairs, operations, scalar_rate, memory, timings })
}

/// Returns the flow of a scene, paved with the tile if there is one.
pub fn paved(scene: Scene, tile: Option<&Tile>) -> Simulation {
    let mut seeds = seeds(&scene);
    if let Some(tile) = tile {
        tile.pave(&mut seeds);
    }
    Simulation::from_seeds(scene, seeds, &[])
}

/// Times steps on the threads of the present pool.
fn time(simulation: &mut Simulation, plan: Plan) -> Result<Timing, Stop> {
    // The first step of a pool brings its threads their buffers, the first after a look at the components their state.
    simulation.step()?;
    let mut sets = FastestSets::begin(simulation);
    let (mut step, mut flow) = (f64::INFINITY, 0.0);
    for _ in 0..plan.repetitions {
        let (started, begin) = (Instant::now(), simulation.clock().time);
        for _ in 0..plan.steps {
            simulation.step()?;
        }
        let taken = started.elapsed().as_secs_f64() / plan.steps as f64;
        if taken < step {
            (step, flow) = (taken, (simulation.clock().time - begin) / plan.steps as f64);
        }
        sets.record(simulation, plan.steps);
    }
    Ok(Timing { threads: rayon::current_num_threads(), step, flow, sets: sets.seconds() })
}

/// Ordered pairs a second of the scalar baseline over the particles of a simulation, 1/s: see [`scalar`].
pub fn scalar_rate(simulation: &mut Simulation) -> f64 {
    match (simulation.scene().precision, simulation.scene().dimensions) {
        (Precision::F64, 2) => scalar_rate_typed::<f64, 2>(simulation),
        (Precision::F64, _) => scalar_rate_typed::<f64, 3>(simulation),
        (Precision::F32, 2) => scalar_rate_typed::<f32, 2>(simulation),
        (Precision::F32, _) => scalar_rate_typed::<f32, 3>(simulation),
    }
}

fn scalar_rate_typed<R: Real, const D: usize>(simulation: &mut Simulation) -> f64 {
    let world = simulation.world();
    let arrays = world.resource::<Arrays<R, D>>();
    scalar::pair_rate(&world.resource::<Pair>().0, &world.resource::<Grid<D>>().0, arrays)
}

/// Particles of a simulation outside the reservoir, and [`ordered_pairs`] of them.
pub fn count(simulation: &mut Simulation) -> (usize, usize) {
    match (simulation.scene().precision, simulation.scene().dimensions) {
        (Precision::F64, 2) => count_typed::<f64, 2>(simulation),
        (Precision::F64, _) => count_typed::<f64, 3>(simulation),
        (Precision::F32, 2) => count_typed::<f32, 2>(simulation),
        (Precision::F32, _) => count_typed::<f32, 3>(simulation),
    }
}

fn count_typed<R: Real, const D: usize>(simulation: &mut Simulation) -> (usize, usize) {
    let world = simulation.world();
    let arrays = world.resource::<Arrays<R, D>>();
    (arrays.len(), ordered_pairs(&world.resource::<Grid<D>>().0, arrays))
}

/// Ordered pairs of fluid particles with anything else in their support, in arrays sorted by the grid.
pub fn ordered_pairs<R: Real, const D: usize>(grid: &CellGrid<D>, particles: &ParticleArrays<R, D>) -> usize {
    let neighbours = Neighbours::new(grid, particles);
    let pairs_of = |row: usize| {
        let point = std::array::from_fn(|d| particles.position[d][row]);
        let mut pairs = 0;
        neighbours.for_each(point, |other, _, _| pairs += usize::from(other != row));
        pairs
    };
    let rows = (0..particles.len()).into_par_iter();
    rows.filter(|&row| particles.zone[row] == Zone::Fluid).map(pairs_of).sum()
}

#[cfg(test)]
mod tests {
    use rayon::ThreadPoolBuilder;

    use super::*;
    use crate::cases::{BoxTerms, StirredBox};

    /// Small boxes on one thread and on two: what must hold on any machine, however busy.
    fn check(stirred: StirredBox) {
        let plan = Plan { warm_up: 1, repetitions: 2, steps: 2 };
        let pools = [1, 2]
            .map(|threads| ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start"));
        let figures =
            measure(stirred.scene().expect("a scene"), None, plan, &pools, None).expect("a tame flow");
        assert_eq!(figures.particles, stirred.count.pow(stirred.dimensions as u32));
        // Neighbours within 2h, from the volume of the support: 22.2 in 2D, 276 in 3D, and the particle itself is none.
        let neighbours = figures.pairs as f64 / figures.particles as f64;
        let expected = if stirred.dimensions == 2 { 20.0..23.0 } else { 250.0..280.0 };
        assert!(expected.contains(&neighbours), "{neighbours} neighbours");
        assert_eq!(figures.timings.iter().map(|timing| timing.threads).collect::<Vec<_>>(), [1, 2]);
        for timing in &figures.timings {
            assert!(timing.step > 0.0 && timing.step.is_finite() && timing.flow > 0.0);
            let sets: f64 = timing.sets.iter().map(|(_, seconds)| seconds).sum();
            assert!(sets > 0.0 && sets <= timing.step, "sets take {sets} s of {} s", timing.step);
            assert!(figures.pair_rate(timing).is_finite() && figures.scalar_rate > 0.0);
            assert!(figures.speed_up(timing).is_some_and(f64::is_finite));
        }
        assert_eq!(figures.speed_up(&figures.timings[0]), Some(1.0));
    }

    #[test]
    fn small_boxes_have_finite_figures() {
        let plane =
            StirredBox { dimensions: 2, count: 32, precision: Precision::F64, terms: BoxTerms::Laminar };
        check(plane);
        check(StirredBox { dimensions: 3, count: 12, precision: Precision::F32, terms: BoxTerms::Stress });
    }
}
