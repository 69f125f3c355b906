//! The sorted particle columns as a resource of the world.

use std::ops::{Deref, DerefMut};

use bevy_ecs::resource::Resource;

use sphecs_core::math::real::Real;
use sphecs_core::particles::arrays::ParticleArrays;

/// The columns of the particles: the state of the flow within a step.
///
/// A type of its own, because the crate of the columns knows no ECS.
#[derive(Resource, Clone, Debug, Default)]
pub struct Arrays<R: Real, const D: usize>(pub ParticleArrays<R, D>);

impl<R: Real, const D: usize> Deref for Arrays<R, D> {
    type Target = ParticleArrays<R, D>;

    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl<R: Real, const D: usize> DerefMut for Arrays<R, D> {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.0
    }
}
