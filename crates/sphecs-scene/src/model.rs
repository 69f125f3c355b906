//! The validated scene: what a simulation is built from.
//!
//! Made only by [`SceneLoader::load`](super::SceneLoader::load); a value of these types obeys the
//! rules that their doc lines state.
//!
//! Vectors are `DVec3` in 2D too, with z = 0 everywhere.

use glam::DVec3;

pub use super::body::{Body, BodyReference, ForcesEvery};
pub use super::emitters::Emitter;
use super::expression::Expression;
pub use super::field_grid::{FieldOutput, FieldPlane};
use super::geometry::Shape;
use super::lattice::Lattice;
use super::meshes::{MeshFile, MeshReport};
use super::motion::Motion;
pub use super::movers::Mover;
pub use super::output_settings::OutputSettings;
pub use super::probe::{Probe, ProbeKind, ProbeSight};
pub use super::rings::Rings;
pub use super::scheme::{EdacTvf, Scheme, Wcsph};
use super::time_value::TimeValue;
use sphecs_core::boundary::inlet::{Feed, InletPressure};
use sphecs_core::boundary::outlet::OutletCondition;
pub use sphecs_core::boundary::patch::Patch;
use sphecs_core::discretisation::Discretisation;
use sphecs_core::physics::eos::Tait;
use sphecs_core::physics::wall::{Slip, WallModel};

/// A complete, checked scene.
#[derive(Clone, Debug)]
pub struct Scene {
    /// File stem of the scene, used for the run folder.
    pub name: String,
    /// Title, one line.
    pub title: String,
    /// The scene as run: the RON text with `--set` values.
    pub text: String,
    /// The tables that it names: the path as written, and the text.
    pub tables: Vec<(String, String)>,
    /// The files of meshes and outlines that it names.
    pub meshes: Vec<MeshFile>,
    /// Reports on them.
    pub mesh_reports: Vec<MeshReport>,
    /// 2 or 3.
    pub dimensions: usize,
    /// Scalar of the pair sums.
    pub precision: Precision,
    /// Initial particle spacing Δ, m, > 0.
    pub spacing: f64,
    /// Spacing, smoothing length, support and mass of the particles.
    pub discretisation: Discretisation,
    /// Coarser spacing for quick tests, m.
    pub smoke_spacing: f64,
    /// The fluid.
    pub fluid: FluidProperties,
    /// Numerical scheme.
    pub scheme: Scheme,
    /// Body force per mass, m/s².
    pub body_force: BodyForce,
    /// The domain: what the fluid fills at the start, zones not included.
    pub domain: Shape,
    /// Domain ∪ extruded zones: a particle outside it has penetrated a wall.
    pub container: Shape,
    /// Bodies that move.
    pub movers: Vec<Mover>,
    /// Motion of all other walls; None at rest.
    pub casing_motion: Option<Motion>,
    /// Layout of particles in domain, zones and walls.
    pub layout: Layout,
    /// Walls.
    pub walls: Walls,
    /// Parts of the wall whose force and torque are written.
    pub bodies: Vec<Body>,
    /// Inlets; a particle's `patch` is an index into this.
    pub inlets: Vec<Inlet>,
    /// Emitters; a particle's `patch` is the number of inlets plus an index into this.
    pub emitters: Vec<Emitter>,
    /// Outlets; a particle's `patch` is an index into this.
    pub outlets: Vec<Outlet>,
    /// For each axis, lower and upper bound of the periodic direction, m.
    pub periodic: [Option<(f64, f64)>; 3],
    /// Initial fields.
    pub initial: Initial,
    /// Reservoir at the start, and what happens when it is empty.
    pub reservoir: Reservoir,
    /// End and time step.
    pub time: TimeSettings,
    /// Output of a run and its times.
    pub output: OutputSettings,
    /// Velocity for Reynolds and Mach numbers, m/s: given in the scene or estimated from inlets and
    /// initial fields.
    pub reference_velocity: f64,
    /// Length for the Reynolds number, m: given in the scene or the narrowest patch or domain
    /// width.
    pub reference_length: f64,
}

impl Scene {
    /// Distance between the outermost patches and movers along a direction, m, at least ten
    /// spacings.
    pub fn extent_along(&self, direction: DVec3) -> f64 {
        let inlets = self.inlets.iter().map(|inlet| inlet.patch.at);
        let outlets = self.outlets.iter().map(|outlet| outlet.patch.at);
        let movers = self.movers.iter().map(|mover| self.wetted_end(mover, direction));
        let (low, high) = inlets
            .chain(outlets)
            .chain(movers)
            .map(|at| at.dot(direction))
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        (high - low).max(10.0 * self.spacing)
    }
}

/// Scalar type of the pair sums.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Precision {
    /// Single precision. Take it for long or large runs once a short run in each gave the same
    /// figures.
    F32,
    /// Double precision. Take it unless memory or time is short.
    #[default]
    F64,
}

/// Material of the fluid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FluidProperties {
    /// Reference density ρ0, kg/m³, > 0.
    pub density: f64,
    /// Kinematic viscosity ν, m²/s, ≥ 0.
    pub viscosity: f64,
    /// Sound speed c0, m/s, > 0.
    pub sound_speed: f64,
}

impl FluidProperties {
    /// Tait's equation with this fluid's constants.
    pub fn tait(&self) -> Tait {
        Tait { reference_density: self.density, sound_speed: self.sound_speed }
    }
}

/// Force per mass on the fluid, m/s².
#[derive(Clone, Debug)]
pub enum BodyForce {
    /// Uniform force.
    Constant(DVec3),
    /// Components as expressions of x, y, z, t.
    Expression([Expression; 3]),
}

/// The walls of a scene: everything at the domain's surface that is neither patch nor periodic.
#[derive(Clone, Debug)]
pub struct Walls {
    /// Treatment of walls in the sums.
    pub model: WallModel,
    /// True if thin walls separate the fluid on their two sides.
    pub one_sided: bool,
    /// Parts, in the order of the scene; a wall particle's `patch` is an index into this. The first
    /// part is the remaining surface.
    pub parts: Vec<WallPart>,
}

/// Layout of particles in domain, zones and walls, from which [`seeds`](super::spawn::seeds) makes
/// them.
#[derive(Clone, Debug)]
pub struct Layout {
    /// Arrangement of the particles.
    pub fill: Fill,
    /// Domain ∪ zones, each zone extended beyond its far end by more than the support, so that
    /// there is no wall at the far end.
    pub confines: Shape,
    /// Regions without the bodies that move.
    pub casing: Casing,
    /// The extended zones: inlets, then outlets.
    pub zones: Vec<Shape>,
    /// Regions of the wall parts from the second on; the first part is the remaining surface.
    pub wall_regions: Vec<Shape>,
    /// Cylinders whose wall particles lie on rings.
    pub rings: Vec<Rings>,
    /// Indices of the wall parts whose particles lie in layers along the surface.
    pub layered: Vec<u16>,
    /// Parts of ends of the domain that are walls because no opening covers them.
    pub unopened: Vec<UnopenedPart>,
    /// True if there are walls at all.
    pub walled: bool,
}

/// Regions that all walls but the bodies that move enclose.
#[derive(Clone, Debug)]
pub struct Casing {
    /// Domain.
    pub domain: Shape,
    /// Domain ∪ extruded zones.
    pub container: Shape,
    /// Domain ∪ extended zones.
    pub confines: Shape,
}

/// A part of an end of the domain that is a wall because the opening there does not cover it.
#[derive(Clone, Debug, PartialEq)]
pub struct UnopenedPart {
    /// Name of the opening of the end.
    pub opening: String,
    /// A point of the part, m.
    pub at: DVec3,
    /// Area, m² (length in m in 2D), to a quarter of a spacing along its edge.
    pub area: f64,
}

/// Arrangement of the particles.
#[derive(Clone, Debug)]
pub enum Fill {
    /// Square or cubic lattice.
    Lattice(Lattice),
    /// A lattice relaxed onto the walls, see [`packing`](super::packing).
    Packed(Lattice),
    /// Rows at constant fractions of the width of a 2D channel along x.
    WallFitted {
        /// y of the lower wall as a function of x, m.
        lower: Expression,
        /// y of the upper wall as a function of x, m.
        upper: Expression,
        /// Number of rows.
        rows: usize,
    },
}

impl Fill {
    /// Returns a vector of the arrangement in the coordinates of the scene.
    pub fn turned(&self, vector: DVec3) -> DVec3 {
        match self {
            Fill::Lattice(lattice) | Fill::Packed(lattice) => lattice.turned(vector),
            Fill::WallFitted { .. } => vector,
        }
    }

    /// Returns true if the particles form no rows along a direction.
    pub fn is_oblique(&self, direction: DVec3) -> bool {
        match self {
            Fill::Lattice(lattice) => lattice.is_oblique(direction),
            // Its zones have columns along their normals.
            Fill::Packed(_) => false,
            Fill::WallFitted { .. } => direction.abs().max_element() < 1.0 - 1e-9,
        }
    }
}

/// A part of the wall.
#[derive(Clone, Debug)]
pub struct WallPart {
    /// Name for outputs and messages.
    pub name: String,
    /// Slip condition.
    pub slip: Slip,
    /// Surface velocity, m/s, as expressions of x, y, z, t.
    pub velocity: [Expression; 3],
    /// Index of the body that moves whose surface it is; None for a part of the other walls.
    pub mover: Option<u16>,
}

/// An inlet.
#[derive(Clone, Debug)]
pub struct Inlet {
    /// Its plane and zone.
    pub patch: Patch,
    /// Velocity of inflow particles.
    pub velocity: InletVelocity,
    /// Pressure of inflow particles.
    pub pressure: InletPressure,
    /// Supply of particles behind the zone.
    pub feed: Feed,
}

/// Velocity of inflow particles.
#[derive(Clone, Debug)]
pub enum InletVelocity {
    /// Speed along `towards`, m/s.
    Normal(Expression),
    /// Components, m/s.
    Components([Expression; 3]),
    /// Speed along `towards` from a table in time: (s, m/s), linear between rows, constant beyond
    /// the ends.
    TimeTable(Vec<(f64, f64)>),
    /// Speed along `towards`, bilinear in time and in the coordinate along `across[0]` from the
    /// centre of the section, constant beyond the ends.
    ProfileTable {
        /// Times, s, rising.
        times: Vec<f64>,
        /// Positions from the centre of the section, m, rising.
        positions: Vec<f64>,
        /// Speeds, m/s, as `speeds[time][position]`.
        speeds: Vec<Vec<f64>>,
    },
    /// Speed along `towards` from a prescribed mass flow: rate(t) × profile(x) × `scale`.
    MassFlow {
        /// Mass flow in time, kg/s (per metre of depth in 2D), or mass flux, kg/(s m²).
        rate: Expression,
        /// Shape over the plane.
        profile: Expression,
        /// Speed divided by rate and profile: see [`mass_flow`](super::check::mass_flow).
        scale: f64,
    },
    /// Exact start-up of plane Poiseuille flow from rest between walls at ± `half_width` (m) about
    /// `at`, driven by `body_force` (m/s²), with the fluid's viscosity.
    PoiseuilleStartup {
        /// Half the gap, m.
        half_width: f64,
        /// Force per mass along the flow, m/s².
        body_force: f64,
    },
}

/// An outlet.
#[derive(Clone, Debug)]
pub struct Outlet {
    /// Its plane and zone.
    pub patch: Patch,
    /// Condition of its particles.
    pub condition: OutletCondition,
    /// Quantity that its condition is given in time; None if it has none.
    pub given: Option<TimeValue>,
}

/// Fields at t = 0.
#[derive(Clone, Debug)]
pub struct Initial {
    /// Velocity, m/s.
    pub velocity: [Expression; 3],
    /// Pressure, Pa.
    pub pressure: Expression,
    /// Passive tag carried by each particle.
    pub tag: Expression,
}

/// Particles stored for the inlets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reservoir {
    /// Particles at the start.
    pub initial: usize,
    /// True if particles that leave are stored and injected again; else they are deleted and new
    /// ones created.
    pub recycle: bool,
    /// Action when an inlet needs a particle and there is none.
    pub when_empty: WhenEmpty,
}

/// Action when the reservoir is empty.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum WhenEmpty {
    /// It grows; the ledger counts the grown particles. Take it unless the number of particles must
    /// stay the same.
    #[default]
    Grow,
    /// The run stops with an error. Take it if the number of particles must stay the same.
    Stop,
}

/// End and time step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeSettings {
    /// End of the run, s.
    pub end: f64,
    /// Courant factor.
    pub cfl: f64,
    /// Viscous factor: Δt ≤ factor h²/ν, default 0.125.
    pub viscous: f64,
}

/// A particle at t = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParticleSeed {
    /// Position, m.
    pub position: DVec3,
    /// Zone and patch (or wall part) index.
    pub zone: sphecs_core::particles::zone::Zone,
    /// Index of inlet, outlet or wall part.
    pub patch: u16,
    /// Velocity, m/s.
    pub velocity: DVec3,
    /// Pressure, Pa.
    pub pressure: f64,
    /// Passive tag.
    pub tag: f64,
    /// Wall: distance behind the surface, m. Others: 0.
    pub wall_distance: f64,
    /// Wall: unit normal of the surface at the nearest point, into the fluid. Others: 0.
    pub wall_normal: DVec3,
    /// Particle of a thin wall that is one-sided: thickness of the solid, m. Others: 0.
    pub wall_thickness: f64,
}
