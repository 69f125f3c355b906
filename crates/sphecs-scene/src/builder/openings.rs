//! Inlets, emitters and outlets of a scene description.

use serde::Serialize;

use super::description::description;
use super::numbers::{Formula, Number, Vector, VectorFormula};
use super::regions::Shape;
use sphecs_core::boundary::inlet::{Feed, InletPressure};
use sphecs_core::boundary::outlet::OutletCondition;
use sphecs_core::boundary::patch::Extent;

description! {
    /// An inlet: the plane through a point across a direction, with a zone behind it.
    pub struct Inlet {
        /// Sets the name, default `inlet 0` and so on.
        name: String,
        /// Sets a point of the plane inside the domain's section, m.
        at: Vector,
        /// Sets the flat group of facets of a mesh that is the opening, in place of its plane.
        on: String,
        /// Sets the parts of the domain's end that belong to it, default `Connected`.
        extent: Extent,
        /// Sets whether the other parts of the end are deliberately walls, default false.
        closed: bool,
        /// Sets the direction of the flow, into the domain.
        towards: Vector,
        /// Sets the length of the zone, m, rounded up to whole spacings; default five spacings or
        /// the support.
        depth: Number,
        /// Sets the velocity of the inflow.
        velocity: InletVelocity,
        /// Sets the pressure of the inflow.
        pressure: InletPressure,
        /// Sets the supply of particles behind the zone, default `Fed`; `Once` requires a depth.
        feed: Feed,
    }
}

impl Inlet {
    /// Returns an inlet at a point of its plane, m, with the direction of the flow into the domain
    /// and the velocity of the inflow.
    pub fn new(
        at: impl Into<Vector>,
        towards: impl Into<Vector>,
        velocity: impl Into<InletVelocity>,
    ) -> Self {
        Self::default().at(at).towards(towards).velocity(velocity)
    }
}

description! {
    /// A surface of a wall or mover through which fluid enters along the normal.
    pub struct Emitter {
        /// Sets the name, default `emitter 0` and so on.
        name: String,
        /// Sets the mover, wall part or group of a mesh whose surface emits, default the walls.
        on: String,
        /// Sets the region in which the surface emits, of a mover in its place without
        /// displacement; default all of `on`.
        region: Shape,
        /// Sets the velocity of the fluid relative to the surface, along the normal.
        velocity: InletVelocity,
        /// Sets the depth of the inflow zone inside the solid, m, rounded up to whole spacings;
        /// default a little more than the support.
        depth: Number,
    }
}

impl Emitter {
    /// Returns an emitter on the whole surface of a mover, a wall part or a group of a mesh.
    pub fn on_surface(on: impl Into<String>, velocity: impl Into<InletVelocity>) -> Self {
        Self::default().on(on).velocity(velocity)
    }
}

/// Velocity of the inflow; [`MassFlow`], [`MassFlux`] and [`PoiseuilleStartup`] are velocities too.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(transparent)]
#[must_use = "a description does nothing until it is part of a scene"]
pub struct InletVelocity(Kind);

/// The velocities as a scene file names them and their fields.
#[derive(Clone, Debug, PartialEq, Serialize)]
enum Kind {
    Normal(Formula),
    Components(Vec<Formula>),
    TimeTable(TimeTable),
    ProfileTable { file: String },
    MassFlow(MassFlow),
    MassFlux(MassFlux),
    PoiseuilleStartup(PoiseuilleStartup),
}

/// A table in time: rows of (s, m/s), or a CSV file.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
struct TimeTable {
    #[serde(skip_serializing_if = "Option::is_none")]
    rows: Option<Vec<(Number, Number)>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    file: Option<String>,
}

impl InletVelocity {
    /// Returns a speed along the inlet's direction, m/s, on its plane.
    pub fn normal(speed: impl Into<Formula>) -> Self {
        Self(Kind::Normal(speed.into()))
    }

    /// Returns the components of a velocity, m/s, on the inlet's plane.
    pub fn components(velocity: impl Into<VectorFormula>) -> Self {
        Self(Kind::Components(velocity.into().into_list()))
    }

    /// Returns a speed along the inlet's direction in time, of rows of time (s) and speed (m/s):
    /// linear between rows, constant before the first and behind the last.
    pub fn time_table(rows: impl IntoIterator<Item = (impl Into<Number>, impl Into<Number>)>) -> Self {
        let rows = rows.into_iter().map(|(time, speed)| (time.into(), speed.into())).collect();
        Self(Kind::TimeTable(TimeTable { rows: Some(rows), file: None }))
    }

    /// Returns a speed along the inlet's direction in time, of a CSV file of two columns, time (s)
    /// and speed (m/s).
    pub fn time_table_file(file: impl Into<String>) -> Self {
        Self(Kind::TimeTable(TimeTable { rows: None, file: Some(file.into()) }))
    }

    /// Returns a speed along the inlet's direction over time and the position across, of a CSV
    /// file.
    ///
    /// Its first row holds the positions from the section's middle (m), its first column the times
    /// (s), the rest speeds (m/s).
    pub fn profile_table(file: impl Into<String>) -> Self {
        Self(Kind::ProfileTable { file: file.into() })
    }
}

description! {
    /// Mass that flows in; the speed along the inlet's direction is the profile, scaled so that all
    /// particles across the inlet together carry it.
    pub struct MassFlow {
        /// Sets the rate, kg/s, in 2D kg/s per metre of depth: a number or an expression of t.
        rate: Formula,
        /// Sets the shape of the speed over the plane, an expression of x, y, z of any size;
        /// default uniform.
        profile: Formula,
    }
}

impl MassFlow {
    /// Returns a rate, kg/s, in 2D kg/s per metre of depth: a number or an expression of t.
    pub fn new(rate: impl Into<Formula>) -> Self {
        Self::default().rate(rate)
    }
}

description! {
    /// Mass that flows in per area of the inlet; otherwise as [`MassFlow`].
    pub struct MassFlux {
        /// Sets the flux, kg/(s m²): a number or an expression of t.
        flux: Formula,
        /// Sets the shape of the speed over the plane, an expression of x, y, z of any size;
        /// default uniform.
        profile: Formula,
    }
}

impl MassFlux {
    /// Returns a flux, kg/(s m²): a number or an expression of t.
    pub fn new(flux: impl Into<Formula>) -> Self {
        Self::default().flux(flux)
    }
}

description! {
    /// Exact start-up of plane Poiseuille flow from rest.
    pub struct PoiseuilleStartup {
        /// Sets half the gap, m, default half the section.
        half_width: Number,
        /// Sets the force per mass along the flow, m/s².
        body_force: Number,
    }
}

impl PoiseuilleStartup {
    /// Returns the start-up under a force per mass along the flow, m/s².
    pub fn new(body_force: impl Into<Number>) -> Self {
        Self::default().body_force(body_force)
    }
}

impl From<MassFlow> for InletVelocity {
    fn from(flow: MassFlow) -> Self {
        Self(Kind::MassFlow(flow))
    }
}

impl From<MassFlux> for InletVelocity {
    fn from(flux: MassFlux) -> Self {
        Self(Kind::MassFlux(flux))
    }
}

impl From<PoiseuilleStartup> for InletVelocity {
    fn from(startup: PoiseuilleStartup) -> Self {
        Self(Kind::PoiseuilleStartup(startup))
    }
}

description! {
    /// An outlet: the plane through a point across a direction, with a zone behind it.
    pub struct Outlet {
        /// Sets the name, default `outlet 0` and so on.
        name: String,
        /// Sets a point of the plane inside the domain's section, m.
        at: Vector,
        /// Sets the flat group of facets of a mesh that is the opening, in place of its plane.
        on: String,
        /// Sets the parts of the domain's end that belong to it, default `Connected`.
        extent: Extent,
        /// Sets whether the other parts of the end are deliberately walls, default false.
        closed: bool,
        /// Sets the direction of the flow, out of the domain.
        towards: Vector,
        /// Sets the length of the zone, m, rounded up to whole spacings; default eight spacings or
        /// the support.
        depth: Number,
        /// Sets the condition of the outflow particles, default `WaveEquation()`.
        condition: OutletCondition,
    }
}

impl Outlet {
    /// Returns an outlet at a point of its plane, m, with the direction of the flow out of the
    /// domain.
    pub fn new(at: impl Into<Vector>, towards: impl Into<Vector>) -> Self {
        Self::default().at(at).towards(towards)
    }
}
