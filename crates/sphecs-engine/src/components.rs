//! The components of a particle: the truth between steps, what is saved, inspected and selected by role.
//!
//! Every particle has one [`ParticleId`], the state components and exactly one role:
//! [`Fluid`], [`Wall`], [`Inflow`], [`Outflow`] or [`Reservoir`]. bevy keeps 8 B of change ticks for each component of each
//! entity, so few are wide; what only the integrator needs stays in the
//! [arrays](super::arrays::ParticleArrays), where a step left it.

use bevy_ecs::bundle::Bundle;
use bevy_ecs::component::Component;
use glam::DVec3;

/// Number of a particle: dense from 0, stable for the whole run; where a scene deletes what leaves, its number is given anew. It is
/// the `particle` index of `particles.nc`.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ParticleId(pub u32);

/// Position, m. z = 0 in 2D.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
pub struct Position(pub DVec3);

/// Velocity, m/s. For a wall: the velocity of its surface.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
pub struct Velocity(pub DVec3);

/// Density and pressure. Of fluid particles both are summed anew in every step.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
pub struct Thermodynamics {
    /// Density, kg/m³.
    pub density: f64,
    /// Pressure, Pa.
    pub pressure: f64,
}

/// What a particle carries along.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
pub struct Tracer {
    /// Passive scalar.
    pub tag: f32,
    /// How often the particle was taken from the reservoir and injected again, or its number was given anew.
    pub passages: u32,
}

/// Role: moves by the equations of motion.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct Fluid;

/// Role: a fixed image particle of the wall part `part`.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct Wall {
    /// Index into the scene's wall parts.
    pub part: u16,
}

/// Where a wall particle stands behind its surface.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct WallSurface {
    /// Distance behind the surface, m.
    pub distance: f64,
    /// Unit normal of the surface at the nearest point, into the fluid.
    pub normal: DVec3,
}

/// Role: upstream of the inlet `inlet`.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct Inflow {
    /// Index into the scene's inlets.
    pub inlet: u16,
}

/// Mark of an inflow particle that came back from the fluid: it may still have the particle that followed it in.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct Returned;

/// Role: downstream of the outlet `outlet`.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct Outflow {
    /// Index into the scene's outlets.
    pub outlet: u16,
}

/// Role: stored outside the flow.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct Reservoir;

/// Sub-particle stress T/ρ² (xx, yy, zz, xy, yz, zx), m⁵/(kg s²), of particles in a scene with `Sps` viscosity.
#[derive(Component, Clone, Copy, Debug, Default)]
pub struct SpsStress(pub [f64; 6]);

/// The state that every particle has.
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
    /// Passive scalar and injections.
    pub tracer: Tracer,
}
