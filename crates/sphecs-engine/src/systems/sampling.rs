//! Evaluation of a world between two steps: density at the present positions, fields at points,
//! mass flows.

use bevy_ecs::change_detection::Mut;
use bevy_ecs::world::World;
use glam::DVec3;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use crate::arrays::Arrays;
use crate::components::Tracer;
use crate::resources::entity_index::EntityIndex;
use crate::resources::grid::Grid;
use crate::resources::pair::Pair;
use crate::resources::pair_sums::Sums;
use crate::resources::particle_details::ParticleDetails;
use crate::resources::state_location;
use crate::systems::boundaries::walls::find_dummy_velocity;
use crate::systems::edac::sum_volumes;
use crate::systems::neighbours::sort_particles;
use crate::systems::wcsph::rates::{sum_density, sum_gradients};
use sphecs_core::particles::sample::Sample;
use sphecs_core::pass::column_access::AfterPasses;
use sphecs_core::pass::grid_rows::{NodeRow, RowSampler, RowSink};
use sphecs_core::pass::pair_real::PairReal;
use sphecs_core::pass::sampling::Sampler;
use sphecs_core::pass::section::{self, Section};
use sphecs_core::pass::surface_flow::{SurfaceFlow, SurfacePoint, SurfaceSampler};
use sphecs_scene::model::ProbeSight;

/// Gives rank 0 the particles of all ranks.
pub(crate) fn collect<R: PairReal<D>, const D: usize>(world: &mut World) {
    let ranks = world.resource::<Pair>().0.ranks.clone();
    if ranks.size() > 1 {
        state_location::gather::<R, D>(world);
        world.resource_scope(|world, mut grid: Mut<Grid<D>>| {
            ranks.assemble(&mut grid.0, &mut world.resource_mut::<Arrays<R, D>>().0);
        });
    }
}

/// Sorts the particles at their present positions and sums their density, so that all values belong
/// to one time.
///
/// The next step repeats this from the same positions, so that results are bitwise independent of
/// reads.
pub(crate) fn refresh<R: PairReal<D>, const D: usize>(world: &mut World) {
    state_location::gather::<R, D>(world);
    for run in [
        |world: &mut World| world.run_system_cached(sort_particles::<R, D>),
        |world: &mut World| world.run_system_cached(sum_density::<R, D>),
        |world: &mut World| world.run_system_cached(find_dummy_velocity::<R, D>),
        |world: &mut World| world.run_system_cached(sum_gradients::<R, D>),
    ] {
        // A system fails to run only if a resource is missing, and the builder inserts all of them.
        run(world).expect("all resources are in the world");
    }
}

/// Sorts the particles and sums their density as [`refresh`] does, under `EdacTvf`. The pressure is
/// that of the last step.
pub(crate) fn refresh_volumes<R: PairReal<D>, const D: usize>(world: &mut World) {
    state_location::gather::<R, D>(world);
    for run in [
        |world: &mut World| world.run_system_cached(sort_particles::<R, D>),
        |world: &mut World| world.run_system_cached(sum_volumes::<R, D>),
    ] {
        // As in `refresh`.
        run(world).expect("all resources are in the world");
    }
}

/// Returns the fields at each point, from the particles that its [`ProbeSight`] selects; None at a
/// point without such particles nearby.
pub(crate) fn sample<R: PairReal<D>, const D: usize>(
    world: &World,
    points: &[(DVec3, ProbeSight)],
) -> Vec<Option<Sample>> {
    let at = |points: &[_]| by_sight(world, points, |sampler: Sampler<'_, R, D>, at| sampler.sample(at));
    let write = |sample: &Sample| {
        let [u, v, w] = sample.velocity.to_array();
        [u, v, w, sample.pressure, sample.density]
    };
    let read =
        |[u, v, w, pressure, density]: [f64; 5]| Sample { velocity: DVec3::new(u, v, w), pressure, density };
    by_owner::<D, _, _, 5>(world, points, |point| point.0, at, (&write, &read))
}

/// Returns the pressure of [`sample`], Pa.
pub(crate) fn pressure<R: PairReal<D>, const D: usize>(
    world: &World,
    points: &[(DVec3, ProbeSight)],
) -> Vec<Option<f64>> {
    let at = |points: &[_]| by_sight(world, points, |sampler: Sampler<'_, R, D>, at| sampler.pressure(at));
    by_owner::<D, _, _, 1>(
        world,
        points,
        |point| point.0,
        at,
        (&|&pressure| [pressure], &|[pressure]| pressure),
    )
}

/// Returns results at points, each from the rank that owns the cell of the point. Rank 0 gets all,
/// and any other rank has its own. `write` turns a result into `N` numbers, and `read` turns them
/// back.
fn by_owner<const D: usize, P: Copy, T: Clone, const N: usize>(
    world: &World,
    points: &[P],
    place: impl Fn(&P) -> DVec3,
    at: impl Fn(&[P]) -> Vec<Option<T>>,
    (write, read): (&dyn Fn(&T) -> [f64; N], &dyn Fn([f64; N]) -> T),
) -> Vec<Option<T>> {
    let ranks = &world.resource::<Pair>().0.ranks;
    if ranks.size() < 2 {
        return at(points);
    }
    let (grid, own) = (&world.resource::<Grid<D>>().0, ranks.own_cells());
    let is_own = |&index: &usize| {
        let place = place(&points[index]);
        own.has(grid.nearest_cell(std::array::from_fn(|axis| place[axis])))
    };
    let chosen: Vec<usize> = (0..points.len()).filter(is_own).collect();
    let results = at(&chosen.iter().map(|&index| points[index]).collect::<Vec<P>>());
    // Numbers of 64 bits: the index of a point and its result.
    let mut message = Vec::new();
    for (index, result) in chosen.iter().zip(&results) {
        if let Some(result) = result {
            message.extend((*index as u64).to_ne_bytes());
            message.extend(write(result).into_iter().flat_map(f64::to_ne_bytes));
        }
    }
    let mut found = vec![None; points.len()];
    for message in ranks.to_first(message) {
        for result in message.as_chunks::<8>().0.chunks_exact(1 + N) {
            let numbers = std::array::from_fn(|number| f64::from_ne_bytes(result[1 + number]));
            found[u64::from_ne_bytes(result[0]) as usize] = Some(read(numbers));
        }
    }
    found
}

/// Samples the points of each sight at once and returns the results in the order of the points.
fn by_sight<R: PairReal<D>, T: Clone, const D: usize>(
    world: &World,
    points: &[(DVec3, ProbeSight)],
    at: impl Fn(Sampler<'_, R, D>, &[DVec3]) -> Vec<Option<T>>,
) -> Vec<Option<T>> {
    let (grid, arrays) = (&world.resource::<Grid<D>>().0, world.resource::<Arrays<R, D>>());
    let pair = &world.resource::<Pair>().0;
    let sides = world.resource::<Sums<R, D>>().0.sides.read(AfterPasses);
    let mut found = vec![None; points.len()];
    for sight in [ProbeSight::Fluid, ProbeSight::Flow] {
        let sees = match sight {
            ProbeSight::Fluid => |zone| ProbeSight::Fluid.sees(zone),
            ProbeSight::Flow => |zone| ProbeSight::Flow.sees(zone),
        };
        let chosen: Vec<usize> = (0..points.len()).filter(|&index| points[index].1 == sight).collect();
        let places: Vec<DVec3> = chosen.iter().map(|&index| points[index].0).collect();
        let samples = at(Sampler::new(grid, arrays, pair, sees).with_sides(sides), &places);
        chosen.into_iter().zip(samples).for_each(|(index, sample)| found[index] = sample);
    }
    found
}

/// Samples the fields of the fluid in rows of nodes and passes them to the sink of each row, on
/// rank 0; with `tagged`, the passive scalar too.
pub(crate) fn sample_rows<R: PairReal<D>, const D: usize>(
    world: &World,
    rows: &[NodeRow],
    sinks: &mut [&mut dyn RowSink],
    tagged: bool,
) {
    let arrays = world.resource::<Arrays<R, D>>();
    let ranks = &world.resource::<Pair>().0.ranks;
    let find = |ids: &[u32]| tags(world, ids);
    let tags = if tagged { ranks.answers_of_first(&arrays.id, find) } else { Vec::new() };
    let sampler = RowSampler {
        grid: &world.resource::<Grid<D>>().0,
        particles: arrays,
        pair: &world.resource::<Pair>().0,
        tags: &tags,
        sides: Some(world.resource::<Sums<R, D>>().0.sides.read(AfterPasses)),
    };
    sampler.sample(rows, sinks, |sink, fields| sink.take(fields));
}

/// Returns the flow at points of the walls of a fluid of a kinematic viscosity, m²/s; None at a
/// point without fluid nearby.
pub(crate) fn sample_surface<R: PairReal<D>, const D: usize>(
    world: &World,
    points: &[SurfacePoint],
    viscosity: f64,
) -> Vec<Option<SurfaceFlow>> {
    let arrays = world.resource::<Arrays<R, D>>();
    let pair = &world.resource::<Pair>().0;
    let sampler = SurfaceSampler::new(&world.resource::<Grid<D>>().0, arrays, pair, viscosity);
    let write = |flow: &SurfaceFlow| [flow.pressure, flow.shear.x, flow.shear.y, flow.shear.z];
    let read = |[pressure, x, y, z]: [f64; 4]| SurfaceFlow { pressure, shear: DVec3::new(x, y, z) };
    let at = |points: &[SurfacePoint]| sampler.sample(points);
    by_owner::<D, _, _, 4>(world, points, |point| point.position, at, (&write, &read))
}

/// Returns the passive scalars of particles by their numbers, which the arrays do not have.
fn tags(world: &World, ids: &[u32]) -> Vec<f32> {
    if let Some(details) = world.get_resource::<ParticleDetails>() {
        return ids.par_iter().with_min_len(CHUNK).map(|&id| details.tracer(id).tag).collect();
    }
    let index = world.resource::<EntityIndex>();
    let tag = |&id: &u32| index.get(id).and_then(|entity| world.get::<Tracer>(entity));
    ids.par_iter().with_min_len(CHUNK).map(|id| tag(id).map_or(0.0, |tracer| tracer.tag)).collect()
}

/// Particles that a thread looks up at a time.
const CHUNK: usize = 4096;

/// Returns the mass flows through sections along their normals, kg/s (per metre of depth in 2D).
pub(crate) fn mass_flows<R: PairReal<D>, const D: usize>(world: &World, sections: &[&Section]) -> Vec<f64> {
    let pair = &world.resource::<Pair>().0;
    let own = pair.ranks.own_rows(&world.resource::<Grid<D>>().0);
    let mut sums = section::flow_sums(&world.resource::<Arrays<R, D>>().0, &own, sections);
    pair.ranks.sum_exactly(&mut sums);
    sums.iter().map(|sum| pair.discretisation.mass * sum.value()).collect()
}
