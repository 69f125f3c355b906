//! Output of a scene file.

use serde::Deserialize;

use super::{Number, Text, Vector};
use crate::model::{ForcesEvery, ProbeSight};
use crate::notation::typed::Spanned;

/// Output of a run and its times.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename = "Output", deny_unknown_fields)]
pub struct OutputFile {
    /// Interval between frames, s.
    pub every: Number,
    /// Interval between rows of the monitor, of points and of sections, s, default a tenth of
    /// `every`.
    #[serde(default)]
    pub monitor_every: Option<Number>,
    /// Interval at which the forces on bodies are written, default `Step`.
    #[serde(default)]
    pub forces: ForcesEvery,
    /// Interval between checkpoints, s of wall time, default 600.
    #[serde(default)]
    pub checkpoint_every: Option<Number>,
    /// Points, lines and sections at which the run measures, default none.
    #[serde(default)]
    pub probes: Vec<ProbeFile>,
    /// Fields on a regular grid, default none.
    #[serde(default)]
    pub fields: Option<Spanned<FieldsFile>>,
    /// Pressure and shear stress at the walls, default none.
    #[serde(default)]
    pub walls: Option<Spanned<WallQuantitiesFile>>,
}

/// Pressure, wall shear stress and y⁺ at points of the walls about a spacing apart. Take it for
/// pressure coefficients, separation, friction, and the shear indices of haemodynamics.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename = "WallQuantities", deny_unknown_fields)]
pub struct WallQuantitiesFile {
    /// Names of the wall parts, `walls` for what no part names, default all.
    #[serde(default)]
    pub parts: Option<Vec<Text>>,
    /// Interval between the times that are written, s, default that of the frames.
    #[serde(default)]
    pub every: Option<Number>,
    /// Interval of time means and of the oscillatory shear index, s, default none.
    #[serde(default)]
    pub mean: Option<Spanned<(Number, Number)>>,
    /// Interval between the samples of the means, s, default the time in which the reference
    /// velocity passes half a spacing.
    #[serde(default)]
    pub mean_every: Option<Number>,
}

/// Fields of the flow on a regular grid: velocity, pressure, density, vorticity, fluid fraction
/// and, if the scene has one, tag. Take it for maps, time means and Reynolds stresses.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename = "Fields", deny_unknown_fields)]
pub struct FieldsFile {
    /// Distance of the nodes, m, default the particle spacing. It is adjusted along each axis so
    /// that the cells fill the box around the domain.
    #[serde(default)]
    pub spacing: Option<Number>,
    /// Interval between the times that are written, s, default that of the frames.
    #[serde(default)]
    pub every: Option<Number>,
    /// Interval of time means, variances and Reynolds stresses, s, default none.
    #[serde(default)]
    pub mean: Option<Spanned<(Number, Number)>>,
    /// Interval between the samples of the means, s, default the time in which the reference
    /// velocity passes half a cell.
    #[serde(default)]
    pub mean_every: Option<Number>,
    /// True to write the whole domain, default true without planes.
    #[serde(default)]
    pub volume: Option<bool>,
    /// Planes of a 3D scene that have grids of their own, default none.
    #[serde(default)]
    pub planes: Vec<FieldPlaneFile>,
}

/// A plane with a grid.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename = "FieldPlane", deny_unknown_fields)]
pub struct FieldPlaneFile {
    /// Name, which must differ from the others in letters a to z or digits.
    pub name: Text,
    /// A point of the plane, m.
    pub at: Vector,
    /// Direction of its normal, dimensionless.
    pub normal: Vector,
}

/// A declared measurement.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename = "Probe", deny_unknown_fields)]
pub struct ProbeFile {
    /// Name, which must differ from the others in letters a to z or digits.
    pub name: Text,
    /// Place and quantities.
    pub kind: Spanned<ProbeKindFile>,
    /// Interval between samples, s, default that of the frames for lines and that of the monitor
    /// for points and sections.
    #[serde(default)]
    pub every: Option<Number>,
    /// Interval of the time mean, s, default no mean.
    #[serde(default)]
    pub mean: Option<Spanned<(Number, Number)>>,
    /// Particles that it measures, default `Fluid`.
    #[serde(default)]
    pub sees: ProbeSight,
}

/// Place and quantities of a probe.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", schemars(rename = "ProbeKind"))]
pub enum ProbeKindFile {
    /// Velocity, pressure and density at a point. Take it for a signal in time.
    Point {
        /// Position of the point, m.
        at: Vector,
    },
    /// Velocity, pressure and density at points along a line, ends included. Take it for profiles.
    Line {
        /// First point, m.
        from: Vector,
        /// Last point, m.
        to: Vector,
        /// Number of points, at least 2.
        count: Spanned<u64>,
    },
    /// Mass flow and mean pressure through a plane section of the domain; the mass flow is that of
    /// the particles, the pressure is interpolated. Take it for mass balances and pressure losses.
    Section {
        /// A point of the section, m.
        at: Vector,
        /// Direction of positive flow, dimensionless.
        normal: Vector,
    },
}
