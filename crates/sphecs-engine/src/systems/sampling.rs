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
    by_sight(world, points, |sampler: Sampler<'_, R, D>, points| sampler.sample(points))
}

/// Returns the pressure of [`sample`], Pa.
pub(crate) fn pressure<R: PairReal<D>, const D: usize>(
    world: &World,
    points: &[(DVec3, ProbeSight)],
) -> Vec<Option<f64>> {
    by_sight(world, points, |sampler: Sampler<'_, R, D>, points| sampler.pressure(points))
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

/// Samples the fields of the fluid in rows of nodes and passes them to the sink of each row; with
/// `tagged`, the passive scalar too.
pub(crate) fn sample_rows<R: PairReal<D>, const D: usize>(
    world: &World,
    rows: &[NodeRow],
    sinks: &mut [&mut dyn RowSink],
    tagged: bool,
) {
    let arrays = world.resource::<Arrays<R, D>>();
    let tags = if tagged { tags(world, &arrays.id) } else { Vec::new() };
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
    SurfaceSampler::new(&world.resource::<Grid<D>>().0, arrays, pair, viscosity).sample(points)
}

/// Returns the passive scalars of particles by their numbers, which only their components have.
fn tags(world: &World, ids: &[u32]) -> Vec<f32> {
    let entities = &world.resource::<EntityIndex>().0;
    let tag = |&id: &u32| entities.get(id as usize).and_then(|&entity| world.get::<Tracer>(entity));
    ids.par_iter().with_min_len(CHUNK).map(|id| tag(id).map_or(0.0, |tracer| tracer.tag)).collect()
}

/// Particles that a thread looks up at a time.
const CHUNK: usize = 4096;

/// Returns the mass flows through sections along their normals, kg/s (per metre of depth in 2D).
pub(crate) fn mass_flows<R: PairReal<D>, const D: usize>(world: &World, sections: &[&Section]) -> Vec<f64> {
    section::mass_flows(
        world.resource::<Arrays<R, D>>(),
        world.resource::<Pair>().0.discretisation.mass,
        sections,
    )
}
