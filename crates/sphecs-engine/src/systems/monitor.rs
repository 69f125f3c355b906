//! Integral quantities of the flow, computed when a monitor row is due.

use std::ops::Range;

use bevy_ecs::resource::Resource;
use bevy_ecs::world::World;
use glam::DVec3;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use serde::{Deserialize, Serialize};

use crate::arrays::Arrays;
use crate::resources::clock::Clock;
use crate::resources::grid::Grid;
use crate::resources::ledger::Ledger;
use crate::resources::pair::Pair;
use crate::resources::pair_sums::RatesFound;
use crate::resources::scene::ActiveScene;
use crate::systems::boundaries::movers::PresentPoses;
use crate::systems::boundaries::wall_projection::WallProjections;
use sphecs_core::math::exact_sum::ExactSum;
use sphecs_core::math::grid::CellGrid;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::neighbours::Neighbours;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_core::pass::ranks::Ranks;
use sphecs_scene::model::Scene;
use sphecs_scene::movers::WallPoses;

/// Row of `monitor.nc`: integral quantities of the flow at one time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MonitorRow {
    /// Time, s.
    pub time: f64,
    /// Number of steps done.
    pub step: u64,
    /// Size of the last step, s.
    pub time_step: f64,
    /// Particles by zone, in the order of `Zone::ALL`.
    pub count: [u64; 5],
    /// Mass by zone, kg (per metre of depth in 2D).
    pub mass: [f64; 5],
    /// Mean mass flow into the domain through each inlet since the previous row, kg/s (per metre of
    /// depth in 2D).
    pub inlet_mass_flow: Vec<f64>,
    /// Mean mass flow out of the domain through each outlet since the previous row, kg/s (per metre
    /// of depth in 2D).
    pub outlet_mass_flow: Vec<f64>,
    /// Kinetic energy of the fluid, J (per metre of depth in 2D).
    pub kinetic_energy: f64,
    /// Momentum of the fluid, kg m/s (per metre of depth in 2D).
    pub momentum: DVec3,
    /// Angular momentum of the fluid about the origin, kg m²/s (per metre of depth in 2D).
    pub angular_momentum: DVec3,
    /// Largest speed of the fluid, m/s.
    pub largest_speed: f64,
    /// Largest |ρ − ρ0|/ρ0 of the fluid.
    pub largest_density_deviation: f64,
    /// Largest |∇·v| of the fluid, 1/s.
    pub largest_divergence: f64,
    /// Mean pressure of the fluid, Pa.
    pub mean_pressure: f64,
    /// Number of projections of fluid particles back from a wall since the previous row.
    pub held_at_walls: u64,
    /// Number of fluid particles behind a wall surface.
    pub through_walls: u64,
    /// Number of pairs of fluid particles closer than half a spacing.
    pub close_pairs: u64,
    /// Closest of those pairs; None without any.
    pub closest_pair: Option<ClosestPair>,
}

/// Two fluid particles closer than half a spacing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClosestPair {
    /// Distance, m.
    pub distance: f64,
    /// Position of the first particle, m.
    pub position: DVec3,
}

impl ClosestPair {
    /// Returns the closer of two pairs; of two as close, the one at the lower place, by x first.
    fn closer(first: Option<Self>, second: Option<Self>) -> Option<Self> {
        let numbers = |pair: &Self| {
            let [x, y, z] = pair.position.to_array();
            [pair.distance, x, y, z]
        };
        match (first, second) {
            (Some(a), Some(b)) if numbers(&b) < numbers(&a) => Some(b),
            (a, b) => a.or(b),
        }
    }
}

/// Counts and time at the previous row, since which the mass flows are averaged.
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PreviousRow {
    time: f64,
    held: u64,
    entered: Vec<i64>,
    left: Vec<i64>,
}

/// Distance, over the spacing, below which two fluid particles count as a close pair.
const CLOSE: f64 = 0.5;

/// Distance outside the container, over the spacing, beyond which a particle counts as behind a
/// wall.
const BEHIND: f64 = 1e-6;

/// Returns the net crossings of each patch.
fn net(out: &[u64], back: &[u64]) -> Vec<i64> {
    out.iter().zip(back).map(|(&out, &back)| out as i64 - back as i64).collect()
}

/// Returns the mean mass flow of each patch, kg/s, from its crossings and the interval, s.
fn mean_flow(now: &[i64], before: &[i64], mass: f64, interval: f64) -> Vec<f64> {
    now.iter()
        .enumerate()
        .map(|(patch, &count)| {
            let crossed = count - before.get(patch).copied().unwrap_or(0);
            if interval > 0.0 { crossed as f64 * mass / interval } else { 0.0 }
        })
        .collect()
}

/// Computes the row of the present state and starts a new interval of the mean flows.
///
/// The arrays must be sorted and have the density at the present positions. All ranks call it
/// together.
pub(crate) fn monitor_row<R: PairReal<D>, const D: usize>(world: &mut World) -> MonitorRow {
    let clock = *world.resource::<Clock>();
    let ledger = world.resource::<Ledger>();
    let now = PreviousRow {
        time: clock.time,
        held: world.resource::<WallProjections>().0,
        entered: net(&ledger.entered, &ledger.entered_back),
        left: net(&ledger.left, &ledger.left_back),
    };
    let before = world.resource::<PreviousRow>().clone();
    let row = quantities::<R, D>(world, &clock, &now, &before);
    world.insert_resource(now);
    row
}

fn quantities<R: PairReal<D>, const D: usize>(
    world: &World,
    clock: &Clock,
    now: &PreviousRow,
    before: &PreviousRow,
) -> MonitorRow {
    let scene = &world.resource::<ActiveScene>().0;
    let mass = scene.discretisation.mass;
    let ledger = world.resource::<Ledger>();
    let arrays = world.resource::<Arrays<R, D>>();
    let interval = clock.time - before.time;
    let mut row = MonitorRow {
        time: clock.time,
        step: clock.step,
        time_step: clock.time_step,
        count: ledger.by_zone,
        mass: ledger.by_zone.map(|count| count as f64 * mass),
        inlet_mass_flow: mean_flow(&now.entered, &before.entered, mass, interval),
        outlet_mass_flow: mean_flow(&now.left, &before.left, mass, interval),
        held_at_walls: now.held - before.held,
        largest_divergence: world.resource::<RatesFound>().largest_divergence,
        ..MonitorRow::default()
    };
    let poses = &world.resource::<PresentPoses>().0;
    let grid = &world.resource::<Grid<D>>().0;
    let ranks = &world.resource::<Pair>().0.ranks;
    let sums = fluid_sums((scene, poses), grid, arrays, &ranks.own_rows(grid)).of_all(ranks);
    row.kinetic_energy = 0.5 * mass * sums.square_speed.value();
    let of_fluid = |sums: &[ExactSum; 3]| mass * DVec3::from_array(sums.each_ref().map(ExactSum::value));
    row.momentum = of_fluid(&sums.velocity);
    row.angular_momentum = of_fluid(&sums.moment);
    row.largest_speed = sums.largest_speed;
    row.largest_density_deviation = sums.largest_density_deviation;
    row.mean_pressure = if sums.count > 0 { sums.pressure.value() / sums.count as f64 } else { 0.0 };
    row.through_walls = sums.through_walls;
    row.close_pairs = sums.close_pairs;
    row.closest_pair = sums.closest_pair;
    row
}

/// Sums and extremes over the fluid, which do not depend on the order of the particles.
#[derive(Debug, Default)]
struct FluidSums {
    count: u64,
    /// Σ |v|², m²/s².
    square_speed: ExactSum,
    /// Σ v, m/s.
    velocity: [ExactSum; 3],
    /// Σ x × v, m²/s.
    moment: [ExactSum; 3],
    /// Σ p, Pa.
    pressure: ExactSum,
    largest_speed: f64,
    largest_density_deviation: f64,
    through_walls: u64,
    close_pairs: u64,
    closest_pair: Option<ClosestPair>,
}

impl FluidSums {
    fn join(mut self, other: Self) -> Self {
        self.count += other.count;
        self.square_speed += &other.square_speed;
        for (sums, others) in [(&mut self.velocity, &other.velocity), (&mut self.moment, &other.moment)] {
            sums.iter_mut().zip(others).for_each(|(sum, other)| *sum += other);
        }
        self.pressure += &other.pressure;
        self.largest_speed = self.largest_speed.max(other.largest_speed);
        self.largest_density_deviation = self.largest_density_deviation.max(other.largest_density_deviation);
        self.through_walls += other.through_walls;
        self.close_pairs += other.close_pairs;
        self.closest_pair = ClosestPair::closer(self.closest_pair, other.closest_pair);
        self
    }

    /// Returns what is no exact sum as numbers, for a message to the other ranks: counts, extremes,
    /// distance and position of the closest pair, which are NaN without any.
    fn numbers(&self) -> [f64; NUMBERS] {
        let [distance, x, y, z] = self.closest_pair.map_or([f64::NAN; 4], |pair| {
            let [x, y, z] = pair.position.to_array();
            [pair.distance, x, y, z]
        });
        [
            self.count as f64,
            self.through_walls as f64,
            self.close_pairs as f64,
            self.largest_speed,
            self.largest_density_deviation,
            distance,
            x,
            y,
            z,
        ]
    }

    /// Returns the sums of [`Self::numbers`].
    fn of_numbers(numbers: [f64; NUMBERS]) -> Self {
        let [count, through_walls, close_pairs, speed, deviation, distance, x, y, z] = numbers;
        let closest = ClosestPair { distance, position: DVec3::new(x, y, z) };
        Self {
            count: count as u64,
            through_walls: through_walls as u64,
            close_pairs: close_pairs as u64,
            largest_speed: speed,
            largest_density_deviation: deviation,
            closest_pair: (!distance.is_nan()).then_some(closest),
            ..Self::default()
        }
    }

    /// Joins the sums of all ranks, each of which has those of its own particles.
    fn of_all(self, ranks: &Ranks) -> Self {
        if ranks.size() < 2 {
            return self;
        }
        let join = |a, b| Self::of_numbers(a).join(Self::of_numbers(b)).numbers();
        let others = Self::of_numbers(ranks.joined(self.numbers(), join));
        let Self { square_speed, velocity: [u, v, w], moment: [x, y, z], pressure, .. } = self;
        let mut sums = [square_speed, pressure, u, v, w, x, y, z];
        ranks.sum_exactly(&mut sums);
        let [square_speed, pressure, u, v, w, x, y, z] = sums;
        Self { square_speed, pressure, velocity: [u, v, w], moment: [x, y, z], ..others }
    }
}

/// Numbers of [`FluidSums::numbers`].
const NUMBERS: usize = 9;

/// Rows that a thread adds at a time.
const CHUNK: usize = 4096;

fn fluid_sums<R: PairReal<D>, const D: usize>(
    (scene, poses): (&Scene, &WallPoses),
    grid: &CellGrid<D>,
    arrays: &ParticleArrays<R, D>,
    own: &[Range<usize>],
) -> FluidSums {
    let container = &scene.layout.casing.container;
    let close = Neighbours::within(CLOSE * scene.spacing, grid, arrays);
    let add = |mut sums: FluidSums, rows: Range<usize>| {
        for a in rows {
            if arrays.zone[a] != Zone::Fluid {
                continue;
            }
            sums.count += 1;
            let v = arrays.velocity_of(a);
            sums.square_speed += v.length_squared();
            let point = arrays.position_of(a);
            for (sums, vector) in [(&mut sums.velocity, v), (&mut sums.moment, point.cross(v))] {
                sums.iter_mut().zip(vector.to_array()).for_each(|(sum, component)| *sum += component);
            }
            sums.largest_speed = sums.largest_speed.max(v.length());
            let deviation = (arrays.density[a].to_f64() / scene.fluid.density - 1.0).abs();
            sums.largest_density_deviation = sums.largest_density_deviation.max(deviation);
            sums.pressure += arrays.pressure[a].to_f64();
            // The signed distance of a scene is costly, and only a particle next to a wall can be
            // behind it.
            let near_wall = arrays.wall_distance[a].to_f64() < 0.5 * scene.spacing;
            if near_wall && scene.nearest_wall(container, poses, point).0 > BEHIND * scene.spacing {
                sums.through_walls += 1;
            }
            // Each pair once, at its first particle.
            close.for_each_rare(a + 1, std::array::from_fn(|axis| point[axis]), |b, squared| {
                if arrays.zone[b] == Zone::Fluid {
                    let pair = ClosestPair { distance: squared.sqrt(), position: point };
                    sums.close_pairs += 1;
                    sums.closest_pair = ClosestPair::closer(sums.closest_pair, Some(pair));
                }
            });
        }
        sums
    };
    let chunks_of = |rows: &Range<usize>| {
        let end = rows.end;
        rows.clone().step_by(CHUNK).map(move |from| from..end.min(from + CHUNK))
    };
    let chunks: Vec<Range<usize>> = own.iter().flat_map(chunks_of).collect();
    chunks.into_par_iter().fold(FluidSums::default, add).reduce(FluidSums::default, FluidSums::join)
}
