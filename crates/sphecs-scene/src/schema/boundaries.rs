//! Walls, inlets and outlets of a scene file.

use serde::Deserialize;

use super::{Formula, MotionFile, Number, ShapeFile, Text, Vector};
use crate::notation::tree::Span;
use crate::notation::typed::Spanned;
use crate::rings::FirstRing;
use sphecs_core::boundary::inlet::{Feed, InletPressure};
use sphecs_core::boundary::outlet::OutletCondition;
use sphecs_core::boundary::patch::Extent;
use sphecs_core::physics::wall::{Slip, WallModel};

/// The walls.
#[derive(Clone, Debug, Default, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename = "Walls", deny_unknown_fields)]
pub struct WallsFile {
    /// Treatment of walls in the sums, default `Image()`.
    #[serde(default)]
    pub model: WallModel,
    /// Slip condition, default `NoSlip`.
    #[serde(default)]
    pub slip: Slip,
    /// Surface velocity, m/s, default rest.
    #[serde(default)]
    pub velocity: Option<Spanned<Vec<Formula>>>,
    /// Motion of all walls together but the movers, default rest; only without openings.
    #[serde(default)]
    pub motion: Option<Spanned<MotionFile>>,
    /// Arrangement of their particles behind the surface, default on the lattice of the fluid.
    #[serde(default)]
    pub fill: Option<Spanned<WallFillFile>>,
    /// Separation of the fluid on the two sides of walls thinner than the support, default false;
    /// take it for plates, baffles and blades of few spacings.
    #[serde(default)]
    pub one_sided: Option<Spanned<bool>>,
    /// Parts with settings of their own, default none.
    #[serde(default)]
    pub parts: Vec<WallPartFile>,
}

impl WallsFile {
    /// Returns the default walls of a scene.
    pub fn standard() -> Option<Spanned<Self>> {
        Some(Spanned { value: Self::default(), span: Span::PLACEHOLDER, head: Span::PLACEHOLDER })
    }
}

/// A part of the walls: the surface inside a region.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename = "WallPart", deny_unknown_fields)]
pub struct WallPartFile {
    /// Name for outputs and messages.
    pub name: Text,
    /// Region whose wall surface belongs to the part; the first part counts where regions overlap.
    pub region: Spanned<ShapeFile>,
    /// Slip condition, default that of the walls.
    #[serde(default)]
    pub slip: Option<Slip>,
    /// Surface velocity, m/s, default rest.
    #[serde(default)]
    pub velocity: Option<Spanned<Vec<Formula>>>,
    /// Arrangement of its particles behind the surface, default that of the walls.
    #[serde(default)]
    pub fill: Option<Spanned<WallFillFile>>,
}

/// Arrangement of the particles of a wall part behind its surface.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", schemars(rename = "WallFill"))]
pub enum WallFillFile {
    /// Layers a spacing apart along a surface of any shape. Take it for walls oblique to the
    /// lattice or curved, above all if they slip.
    Layers,
    /// Rings a spacing apart in a cylinder, in 2D. Take it for a circular cylinder whose surface
    /// the lattice would roughen.
    Concentric {
        /// Centre of the cylinder, m.
        center: Vector,
        /// Radius of the cylinder, m.
        radius: Number,
        /// Place of the first ring, default half a spacing behind the surface.
        #[serde(default)]
        first: FirstRing,
    },
}

/// An inlet.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename = "Inlet", deny_unknown_fields)]
pub struct InletFile {
    /// Name for outputs and messages, default `inlet 0` and so on.
    #[serde(default)]
    pub name: Option<Text>,
    /// A point of its plane inside the domain's section, m, default from `on`.
    #[serde(default)]
    pub at: Option<Vector>,
    /// Name of the solid, group or file of a mesh in the domain whose flat facets are the opening,
    /// in place of `at` and `towards`, default none.
    #[serde(default)]
    pub on: Option<Text>,
    /// Parts of the domain's end in this plane that belong to it, default `Connected`.
    #[serde(default)]
    pub extent: Extent,
    /// True if the other parts of the end are deliberately walls, default false: a note names them.
    #[serde(default)]
    pub closed: bool,
    /// Direction of the flow into the domain, dimensionless, default from `on`.
    #[serde(default)]
    pub towards: Option<Vector>,
    /// Length of its zone, m, rounded up to whole spacings; default five spacings or the support.
    #[serde(default)]
    pub depth: Option<Number>,
    /// Velocity of the inflow.
    pub velocity: Spanned<InletVelocityFile>,
    /// Pressure of the inflow, default `Extrapolated`.
    #[serde(default)]
    pub pressure: InletPressure,
    /// Supply of particles behind its zone, default `Fed`; `Once` requires a `depth`.
    #[serde(default)]
    pub feed: Feed,
}

impl InletFile {
    /// Returns the place of its plane in the file.
    pub fn place(&self) -> Span {
        place(self.at.as_ref(), self.on.as_ref(), self.name.as_ref())
    }
}

impl OutletFile {
    /// Returns the place of its plane in the file.
    pub fn place(&self) -> Span {
        place(self.at.as_ref(), self.on.as_ref(), self.name.as_ref())
    }
}

fn place(at: Option<&Vector>, on: Option<&Text>, name: Option<&Text>) -> Span {
    let given = at.map(|at| at.span).or(on.map(|on| on.span)).or(name.map(|name| name.span));
    given.unwrap_or(Span::PLACEHOLDER)
}

/// Velocity of the inflow.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", schemars(rename = "InletVelocity"))]
pub enum InletVelocityFile {
    /// Speed along `towards`, m/s, on the plane of the inlet; all particles of a row have it. Take
    /// it for a profile given as a formula.
    Normal(Formula),
    /// Components, m/s, on the plane. Take it for an inflow that is not along the normal.
    Components(Spanned<Vec<Formula>>),
    /// Speed along `towards` in time, from `rows` or from a CSV `file` of two columns. Take it for
    /// a measured speed that is uniform over the section.
    TimeTable {
        /// Rows of time and speed, s and m/s, default none.
        #[serde(default)]
        rows: Option<Vec<(Number, Number)>>,
        /// CSV file in the folder of the scene with the columns time (s) and speed (m/s), default
        /// none.
        #[serde(default)]
        file: Option<Text>,
    },
    /// Speed along `towards`, m/s, over time and the position across, from a CSV file. Its first
    /// row holds the positions from the centre of the section (m), its first column the times (s).
    /// Take it for a measured profile.
    ProfileTable {
        /// CSV file in the folder of the scene.
        file: Text,
    },
    /// Mass flow, kg/s, in 2D per metre of depth. The speed along `towards` is the profile, scaled
    /// so that all rows of particles together carry it. Take it if the mass flow is known.
    MassFlow {
        /// Rate, kg/s: a number or an expression of t.
        rate: Formula,
        /// Profile of the speed over the plane, in any unit, an expression of x, y, z; default
        /// uniform.
        #[serde(default)]
        profile: Option<Formula>,
    },
    /// Mass flow per area of the inlet, kg/(s m²), otherwise as `MassFlow`. Take it if the mass
    /// flow per area is known.
    MassFlux {
        /// Flux, kg/(s m²): a number or an expression of t.
        flux: Formula,
        /// Profile of the speed over the plane, in any unit, an expression of x, y, z; default
        /// uniform.
        #[serde(default)]
        profile: Option<Formula>,
    },
    /// Exact start-up of plane Poiseuille flow from rest. Take it to compare a starting channel
    /// flow with its exact solution.
    PoiseuilleStartup {
        /// Half the gap, m, default half the section.
        #[serde(default)]
        half_width: Option<Number>,
        /// Force per mass along the flow, m/s².
        body_force: Number,
    },
}

/// An outlet.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename = "Outlet", deny_unknown_fields)]
pub struct OutletFile {
    /// Name for outputs and messages, default `outlet 0` and so on.
    #[serde(default)]
    pub name: Option<Text>,
    /// A point of its plane inside the domain's section, m, default from `on`.
    #[serde(default)]
    pub at: Option<Vector>,
    /// Name of the solid, group or file of a mesh in the domain whose flat facets are the opening,
    /// in place of `at` and `towards`, default none.
    #[serde(default)]
    pub on: Option<Text>,
    /// Parts of the domain's end in this plane that belong to it, default `Connected`.
    #[serde(default)]
    pub extent: Extent,
    /// True if the other parts of the end are deliberately walls, default false: a note names them.
    #[serde(default)]
    pub closed: bool,
    /// Direction of the flow out of the domain, dimensionless, default from `on`.
    #[serde(default)]
    pub towards: Option<Vector>,
    /// Length of its zone, m, rounded up to whole spacings; default eight spacings or the support.
    #[serde(default)]
    pub depth: Option<Number>,
    /// Condition of its particles, default `WaveEquation()`.
    #[serde(default)]
    pub condition: Option<Spanned<OutletCondition>>,
}
