//! Time of steps and sets of systems, and number of pairs of a flow.
//!
//! The fastest of several repetitions counts, for a step and for each set of systems: other load on
//! the machine only makes a repetition slower.

use std::time::Instant;

use rayon::iter::{IntoParallelIterator, ParallelIterator};
use rayon::{ThreadPool, ThreadPoolBuildError};

use super::cases::Plan;
use super::memory;
use super::operations;
use super::scalar;
use super::tile::Tile;
use sphecs_core::math::grid::CellGrid;
use sphecs_core::math::real::Real;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::neighbours::Neighbours;
use sphecs_engine::arrays::Arrays;
use sphecs_engine::resources::grid::Grid;
use sphecs_engine::resources::pair::Pair;
use sphecs_engine::simulation::{Simulation, Stop};
use sphecs_run::rank_messages::RankMessages;
use sphecs_run::ranks::in_process::Followers;
use sphecs_scene::model::{Precision, Scene};
use sphecs_scene::seeds;

/// Results of a flow.
#[derive(Clone, Debug)]
pub struct BenchResult {
    /// Particles, reservoir excluded, walls included.
    pub particles: usize,
    /// Ordered pairs of fluid particles with anything in their support.
    pub pairs: usize,
    /// Floating-point operations of a pair in a step: see [`operations`].
    pub operations: usize,
    /// Ordered pairs per second of the scalar baseline on one thread, 1/s: see [`scalar`].
    pub scalar_rate: f64,
    /// Growth of the largest resident memory of the process, B; None if unknown.
    pub memory: Option<u64>,
    /// Timings by number of threads, in the given order.
    pub timings: Vec<Timing>,
}

/// Time of a step on a number of threads.
#[derive(Clone, Debug)]
pub struct Timing {
    /// Number of threads of all ranks.
    pub threads: usize,
    /// Number of ranks.
    pub ranks: usize,
    /// Messages between the ranks in all repetitions; None for one rank alone.
    pub messages: Option<RankMessages>,
    /// Wall time of a step in the fastest repetition, s.
    pub step: f64,
    /// Simulated time of a step in that repetition, s.
    pub flow: f64,
    /// Wall time per step of each set of systems in its fastest repetition, s, in the order of a
    /// step.
    pub sets: Vec<(&'static str, f64)>,
}

impl BenchResult {
    /// Returns the ordered pairs per second and thread, 1/s.
    pub fn pair_rate(&self, timing: &Timing) -> f64 {
        self.pairs as f64 / (timing.step * timing.threads as f64)
    }

    /// Returns the ratio of the pair rate per thread to that of the scalar baseline.
    pub fn gain(&self, timing: &Timing) -> f64 {
        self.pair_rate(timing) / self.scalar_rate
    }

    /// Returns the speed-up over one thread; None if one thread was not timed.
    pub fn speed_up(&self, timing: &Timing) -> Option<f64> {
        self.timings.iter().find(|single| single.threads == 1).map(|single| single.step / timing.step)
    }
}

/// Error that ends the measurement of a flow.
#[derive(Debug, thiserror::Error)]
pub enum MeasureError {
    /// The flow diverged.
    #[error(transparent)]
    Flow(#[from] Stop),
    /// The threads of a rank could not be started.
    #[error(transparent)]
    Threads(#[from] ThreadPoolBuildError),
}

/// Fastest repetition of each set of systems.
#[derive(Clone, Debug)]
pub struct FastestSets {
    before: Vec<(&'static str, f64)>,
    fastest: Vec<(&'static str, f64)>,
}

impl FastestSets {
    /// Starts before the first timed step.
    pub fn begin(simulation: &Simulation) -> Self {
        let before = simulation.stage_times();
        let fastest = before.iter().map(|(name, _)| (*name, f64::INFINITY)).collect();
        Self { before, fastest }
    }

    /// Records the steps since the last call.
    pub fn record(&mut self, simulation: &Simulation, steps: usize) {
        let after = simulation.stage_times();
        for ((fastest, before), after) in self.fastest.iter_mut().zip(&self.before).zip(&after) {
            fastest.1 = fastest.1.min((after.1 - before.1) / steps as f64);
        }
        self.before = after;
    }

    /// Returns name and time per step, s, of each set in the order of a step; infinite before the
    /// first record.
    pub fn seconds(self) -> Vec<(&'static str, f64)> {
        self.fastest
    }
}

/// Builds a flow, fills it with copies of the tile, warms it up on the last pool and times it on
/// each, by one rank and then by each of these numbers of ranks.
///
/// `at_rest` is the resident memory of the process before its first flow, B.
///
/// # Errors
/// [`MeasureError`] when the flow diverged, or the system refuses a thread.
pub fn measure(
    scene: Scene,
    tile: Option<&Tile>,
    plan: Plan,
    (pools, ranks): (&[ThreadPool], &[usize]),
    at_rest: Option<u64>,
) -> Result<BenchResult, MeasureError> {
    let growth = memory::Growth::begin(at_rest);
    let operations = operations::per_pair(&scene);
    let build = || -> Result<Simulation, Stop> {
        let mut simulation = filled_with_tiles(scene, tile);
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
        timings.push(pool.install(|| time(&mut simulation, 1, plan))?);
    }
    // Before the pairs are counted, since counting makes copies that a run does not have.
    let memory = growth.and_then(memory::Growth::bytes);
    for &ranks in ranks.iter().filter(|&&ranks| ranks > 1) {
        for pool in pools {
            timings.push(pool.install(|| time_ranks(&mut simulation, ranks, plan))?);
        }
    }
    let mut count_pairs = || (count(&mut simulation), scalar_rate(&mut simulation));
    let ((particles, pairs), scalar_rate) = match pools.last() {
        Some(pool) => pool.install(count_pairs),
        None => count_pairs(),
    };
    Ok(BenchResult { particles, pairs, operations, scalar_rate, memory, timings })
}

/// Returns the flow of a scene, filled with copies of the tile if there is one.
pub fn filled_with_tiles(scene: Scene, tile: Option<&Tile>) -> Simulation {
    let mut seeds = seeds(&scene);
    if let Some(tile) = tile {
        tile.fill(&mut seeds);
    }
    // Only plugins and saved states can be wrong.
    Simulation::builder(scene).particles(seeds).build().expect("a scene without plugins can be built")
}

/// Times steps of a copy of a simulation that several ranks share, each with as many threads as the
/// current pool.
fn time_ranks(simulation: &mut Simulation, ranks: usize, plan: Plan) -> Result<Timing, MeasureError> {
    let (scene, state) = (simulation.scene().clone(), simulation.state());
    let mut copy = Simulation::builder(scene).state(state).build().expect("the state is of the same scene");
    let followers = Followers::start(&mut copy, ranks, rayon::current_num_threads())?;
    // The simulation is dropped first, with which the other ranks end.
    let mut led = (copy, followers);
    Ok(time(&mut led.0, ranks, plan)?)
}

/// Times steps on the current pool.
fn time(simulation: &mut Simulation, ranks: usize, plan: Plan) -> Result<Timing, Stop> {
    // The first step on a pool allocates the buffers of its threads.
    simulation.step()?;
    let mut sets = FastestSets::begin(simulation);
    let (before, all) = (simulation.traffic(), Instant::now());
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
    let wall_time = all.elapsed().as_secs_f64();
    let traffic: Vec<_> =
        simulation.traffic().iter().zip(&before).map(|(now, before)| now.since(before)).collect();
    let steps = (plan.repetitions * plan.steps) as u64;
    let messages = (!traffic.is_empty()).then_some(RankMessages { traffic, steps, wall_time });
    let threads = ranks * rayon::current_num_threads();
    Ok(Timing { threads, ranks, messages, step, flow, sets: sets.seconds() })
}

/// Returns the ordered pairs per second of the scalar baseline over the particles of a simulation,
/// 1/s.
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

/// Returns the number of particles outside the reservoir and of their [`ordered_pairs`].
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

/// Returns the number of ordered pairs of a fluid particle and any other in its support, in sorted
/// arrays.
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
    use crate::cases::{BoxTerms, PeriodicBox};

    /// Checks small boxes on one and two threads for properties that hold on any machine under any
    /// load.
    fn check(periodic_box: PeriodicBox) {
        let plan = Plan { warm_up: 1, repetitions: 2, steps: 2 };
        let pools = [1, 2]
            .map(|threads| ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start"));
        let figures = measure(periodic_box.scene().expect("a scene"), None, plan, (&pools, &[1, 3]), None)
            .expect("a stable flow");
        assert_eq!(figures.particles, periodic_box.count.pow(periodic_box.dimensions as u32));
        // Neighbours within 2h from the volume of the support: 22.2 in 2D, 276 in 3D, minus the
        // particle itself.
        let neighbours = figures.pairs as f64 / figures.particles as f64;
        let expected = if periodic_box.dimensions == 2 { 20.0..23.0 } else { 250.0..280.0 };
        assert!(expected.contains(&neighbours), "{neighbours} neighbours");
        let counts: Vec<_> = figures.timings.iter().map(|timing| (timing.ranks, timing.threads)).collect();
        assert_eq!(counts, [(1, 1), (1, 2), (3, 3), (3, 6)]);
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
    fn small_boxes_have_finite_results() {
        let plane =
            PeriodicBox { dimensions: 2, count: 32, precision: Precision::F64, terms: BoxTerms::Laminar };
        check(plane);
        check(PeriodicBox { dimensions: 3, count: 12, precision: Precision::F32, terms: BoxTerms::Stress });
    }
}
