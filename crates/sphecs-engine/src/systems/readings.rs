//! What is read of a world between two steps: density at the present positions, fields at points, mass flows.

use bevy_ecs::world::World;
use glam::DVec3;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use super::edac::sum_volumes;
use super::home;
use super::neighbours::{Grid, sort_particles};
use super::pair::Pair;
use super::rates::{sum_density, sum_gradients};
use crate::arrays::Arrays;
use sphecs_core::math::real::Real;
use sphecs_core::particles::sample::Sample;
use sphecs_core::pass::sampling::Sampler;
use sphecs_core::pass::section::{self, Section};
use sphecs_scene::model::ProbeSight;

/// Sorts the particles at their present positions and sums their density, so that what is read belongs to one instant. The next
/// step does the same from the same positions: reading changes no bit of a run.
pub fn refresh<R: Real, const D: usize>(world: &mut World) {
    home::gather::<R, D>(world);
    for run in [
        |world: &mut World| world.run_system_cached(sort_particles::<R, D>),
        |world: &mut World| world.run_system_cached(sum_density::<R, D>),
        |world: &mut World| world.run_system_cached(sum_gradients::<R, D>),
    ] {
        // A system of this crate with resources that `build` inserts cannot fail to run.
        run(world).expect("sort and density find their resources");
    }
}

/// The same where the pressure evolves: it is what the last step left.
pub fn refresh_volumes<R: Real, const D: usize>(world: &mut World) {
    home::gather::<R, D>(world);
    for run in [
        |world: &mut World| world.run_system_cached(sort_particles::<R, D>),
        |world: &mut World| world.run_system_cached(sum_volumes::<R, D>),
    ] {
        // As above.
        run(world).expect("sort and volumes find their resources");
    }
}

/// The fields of what is seen at each point; None where nothing of it is near.
pub fn sample<R: Real, const D: usize>(world: &World, points: &[(DVec3, ProbeSight)]) -> Vec<Option<Sample>> {
    let (grid, arrays) = (&world.resource::<Grid<D>>().0, world.resource::<Arrays<R, D>>());
    let pair = &world.resource::<Pair>().0;
    let fluid = Sampler::new(grid, arrays, pair, |zone| ProbeSight::Fluid.sees(zone));
    let flow = Sampler::new(grid, arrays, pair, |zone| ProbeSight::Flow.sees(zone));
    let of = |&(point, sight): &(DVec3, ProbeSight)| match sight {
        ProbeSight::Fluid => fluid.sample(point),
        ProbeSight::Flow => flow.sample(point),
    };
    points.par_iter().map(of).collect()
}

/// Mass flows through sections along their normals, kg/s (per metre of depth in 2D).
pub fn mass_flows<R: Real, const D: usize>(world: &World, sections: &[&Section]) -> Vec<f64> {
    section::mass_flows(world.resource::<Arrays<R, D>>(), world.resource::<Pair>().0.mass, sections)
}
