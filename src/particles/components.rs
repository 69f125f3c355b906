//! The components of a particle: the truth between steps, what is saved, inspected and selected by role.
//!
//! Every particle has one [`ParticleId`], the state components and exactly one role:
//! [`Fluid`], [`Wall`], [`Inflow`], [`Outflow`] or [`Reservoir`].

use bevy_ecs::bundle::Bundle;
use bevy_ecs::component::Component;
use glam::DVec3;

/// Number of a particle: dense from 0, stable for the whole run. It is the `particle` index of `particles.nc`.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ParticleId(pub u32);

/// Position, m. z = 0 in 2D.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
pub struct Position(pub DVec3);

/// Velocity, m/s. For a wall: the velocity of its surface.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
pub struct Velocity(pub DVec3);

/// Velocity one step earlier, m/s (Verlet).
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
pub struct PreviousVelocity(pub DVec3);

/// Rate of change of velocity of the last step, m/s².
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
pub struct Acceleration(pub DVec3);

/// Density, kg/m³.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
pub struct Density(pub f64);

/// Pressure, Pa.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
pub struct Pressure(pub f64);

/// Passive scalar carried along.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq)]
pub struct Tag(pub f64);

/// How often the particle was taken from the reservoir and injected again.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Passage(pub u32);

/// Whether the next step is a plain one instead of a leapfrog, because the role has just changed.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fresh(pub bool);

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
    /// Velocity one step earlier.
    pub previous_velocity: PreviousVelocity,
    /// Acceleration.
    pub acceleration: Acceleration,
    /// Density.
    pub density: Density,
    /// Pressure.
    pub pressure: Pressure,
    /// Passive scalar.
    pub tag: Tag,
    /// Injections.
    pub passage: Passage,
    /// Plain step next.
    pub fresh: Fresh,
}
