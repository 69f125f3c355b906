//! Components of a particle: its state between two steps, for output, inspection and selection by
//! role.
//!
//! Every particle has a [`ParticleId`], the state components and exactly one role: [`Fluid`],
//! [`Wall`], [`Inflow`], [`Outflow`] or [`Reservoir`]. As bevy stores 8 B of change ticks per
//! component and entity, the components are few and wide. Values that only the integrator needs
//! remain in the [arrays](crate::arrays::Arrays).

use bevy_ecs::bundle::Bundle;
use bevy_ecs::component::Component;
use glam::DVec3;

use sphecs_scene::model::ParticleSeed;

/// Number of a particle: dense from 0, constant during a run, and the `particle` index of
/// `particles.nc`.
///
/// In a scene that deletes outflowing particles, the number of a deleted particle is reused.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ParticleId(pub u32);

/// Position, m. z = 0 in 2D.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
pub struct Position(pub DVec3);

/// Velocity, m/s. For a wall: the velocity of its surface.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
pub struct Velocity(pub DVec3);

/// Density and pressure.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
pub struct Thermodynamics {
    /// Density, kg/m³.
    pub density: f64,
    /// Pressure, Pa.
    pub pressure: f64,
}

/// Quantities advected with a particle.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
pub struct Tracer {
    /// Passive scalar.
    pub tag: f32,
    /// Number of injections from the reservoir, or of reuses of the particle's number.
    pub passages: u32,
}

/// Role: fluid particle, which moves by the equations of motion.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct Fluid;

/// Role: wall particle of the wall part `part`.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct Wall {
    /// Index into the scene's wall parts.
    pub part: u16,
}

/// Position of a wall particle relative to the wall surface.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
pub struct WallSurface {
    /// Distance behind the surface, m.
    pub distance: f64,
    /// Unit normal of the surface at the nearest point, into the fluid.
    pub normal: DVec3,
    /// Thickness of the solid, m, where it is thin and one-sided; else 0.
    pub thickness: f64,
}

impl WallSurface {
    /// Returns the place of an initial wall particle.
    pub(crate) fn of_seed(seed: &ParticleSeed) -> Self {
        Self { distance: seed.wall_distance, normal: seed.wall_normal, thickness: seed.wall_thickness }
    }
}

/// Role: inflow particle, upstream of the inlet `inlet`.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct Inflow {
    /// Index into the scene's inlets.
    pub inlet: u16,
}

/// Role: outflow particle, downstream of the outlet `outlet`.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct Outflow {
    /// Index into the scene's outlets.
    pub outlet: u16,
}

/// Role: particle in the reservoir, outside the flow.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct Reservoir;

/// Sub-particle stress T/ρ² (xx, yy, zz, xy, yz, zx), m⁵/(kg s²), in a scene with `Sps` viscosity.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct SpsStress(pub [f64; 6]);

/// Components that every particle has.
#[derive(Bundle, Clone, Copy, Debug)]
pub struct ParticleBundle {
    /// Number.
    pub id: ParticleId,
    /// Position.
    pub position: Position,
    /// Velocity.
    pub velocity: Velocity,
    /// Density and pressure.
    pub thermodynamics: Thermodynamics,
    /// Passive scalar and number of injections.
    pub tracer: Tracer,
}
