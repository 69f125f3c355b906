//! Types of a scene file that RON is read into, before any check of values.
//!
//! Numbers may be literals or expressions of the constants in quotes; a [`Formula`] may also depend
//! on x, y, z (m) and t (s). Vectors have as many components as the scene has dimensions.

use serde::Deserialize;
use serde::de::{self, Deserializer, IgnoredAny, Visitor};

use super::model::{Precision, WhenEmpty};
use super::notation::typed::Spanned;
use sphecs_core::math::kernel::Kernel;
use sphecs_core::physics::integrator::Integrator;
use sphecs_core::physics::shifting::Shifting;
use sphecs_core::physics::viscosity::Viscosity;
use sphecs_core::physics::viscosity::reconstructed::NoiseDamping;

mod bodies;
mod boundaries;
mod emitter;
mod movers;
mod output;
mod shapes;

pub use bodies::BodyFile;
pub use boundaries::{InletFile, InletVelocityFile, OutletFile, WallFillFile, WallPartFile, WallsFile};
pub use emitter::EmitterFile;
pub use movers::{MotionFile, MoverFile};
pub use output::{FieldPlaneFile, FieldsFile, OutputFile, ProbeFile, ProbeKindFile, WallQuantitiesFile};
pub use shapes::{BendSectionFile, ShapeFile};

/// A number with its position.
pub type Number = Spanned<f64>;
/// Two or three numbers with their positions.
pub type Vector = Spanned<Vec<Number>>;
/// Text with its position.
pub type Text = Spanned<String>;

/// An expression of x, y, z, t with its position: a number or text in quotes.
pub type Formula = Spanned<FormulaText>;

/// Content of a [`Formula`].
#[derive(Clone, Debug)]
pub enum FormulaText {
    /// A number.
    Number(f64),
    /// An expression in quotes.
    Text(String),
}

impl<'de> Deserialize<'de> for FormulaText {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct FormulaVisitor;
        impl Visitor<'_> for FormulaVisitor {
            type Value = FormulaText;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a number or an expression in quotes")
            }

            fn visit_f64<E: de::Error>(self, value: f64) -> Result<FormulaText, E> {
                Ok(FormulaText::Number(value))
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<FormulaText, E> {
                Ok(FormulaText::Text(text.to_owned()))
            }
        }
        deserializer.deserialize_any(FormulaVisitor)
    }
}

/// A number or text, marked as an expression of position and time.
#[cfg(feature = "schema")]
impl schemars::JsonSchema for FormulaText {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Expression".into()
    }

    fn json_schema(_generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({ "type": ["number", "string"], "x-expression": true })
    }
}

/// A scene file.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename = "Scene", deny_unknown_fields)]
pub struct SceneFile {
    /// Title, one line.
    pub title: Text,
    /// Number of dimensions, 2 or 3.
    pub dimensions: Spanned<u64>,
    /// Scalar of the pair sums, default `F64`.
    #[serde(default)]
    pub precision: Precision,
    /// Particle spacing Δ, m.
    pub spacing: Number,
    /// Coarser spacing for quick tests, m, default `spacing`.
    #[serde(default)]
    pub smoke: Option<Number>,
    /// Named constants, in any unit, such as `{"v0": 4.45e-2, "D1": "2*R"}`, default none. They are
    /// read before everything else, and each may use those before it.
    #[serde(default)]
    #[cfg_attr(feature = "schema", schemars(with = "Option<std::collections::BTreeMap<String, f64>>"))]
    pub constants: Option<IgnoredAny>,
    /// The fluid.
    pub fluid: FluidFile,
    /// Numerical scheme, default `Wcsph()`.
    #[serde(default)]
    pub scheme: SchemeFile,
    /// Shape that the fluid fills, zones of inlets and outlets not included.
    pub domain: Spanned<ShapeFile>,
    /// Arrangement of the fluid particles, default `Lattice()`.
    #[serde(default)]
    pub fill: Option<Spanned<FillFile>>,
    /// Walls at the surface of the domain that is neither patch nor periodic, default no-slip
    /// images; `None` for no wall.
    #[serde(default = "WallsFile::standard")]
    pub walls: Option<Spanned<WallsFile>>,
    /// Bodies that move, default none.
    #[serde(default)]
    pub movers: Vec<MoverFile>,
    /// Parts of the walls whose force and torque are written, default none.
    #[serde(default)]
    pub bodies: Vec<BodyFile>,
    /// Fields at t = 0, default rest.
    #[serde(default)]
    pub initial: InitialFile,
    /// Openings through which fluid enters, default none.
    #[serde(default)]
    pub inlets: Vec<InletFile>,
    /// Surfaces of walls or movers through which fluid enters along the normal, default none.
    #[serde(default)]
    pub emitters: Vec<EmitterFile>,
    /// Openings through which fluid leaves, default none.
    #[serde(default)]
    pub outlets: Vec<OutletFile>,
    /// Names of periodic axes, `"x"`, `"y"` and `"z"`, default none.
    #[serde(default)]
    pub periodic: Vec<Text>,
    /// Force per mass, m/s², default none.
    #[serde(default)]
    pub body_force: Option<Spanned<Vec<Formula>>>,
    /// Particles stored for the inlets, default `()`.
    #[serde(default)]
    pub reservoir: ReservoirFile,
    /// End and time step.
    pub time: TimeFile,
    /// Output of a run and its times.
    pub output: OutputFile,
    /// Velocity and length of the Reynolds number, default estimated from the scene.
    #[serde(default)]
    pub reference: ReferenceFile,
}

/// The fluid.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename = "Fluid", deny_unknown_fields)]
pub struct FluidFile {
    /// Reference density ρ0, kg/m³.
    pub density: Number,
    /// Kinematic viscosity ν, m²/s.
    pub viscosity: Number,
    /// Sound speed c0, m/s; at least ten times the largest speed of the flow.
    pub sound_speed: Number,
}

/// Numerical scheme.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", schemars(rename = "Scheme"))]
pub enum SchemeFile {
    /// Weakly compressible SPH of Alvarado-Rodríguez et al. (2017). Take it for channels, ducts and
    /// jets.
    Wcsph {
        /// Smoothing kernel, default `WendlandC2`.
        #[serde(default)]
        kernel: Option<Kernel>,
        /// Smoothing length over spacing, h/Δ, dimensionless, default 1.5 in 2D and 1.7 in 3D for
        /// `WendlandC2`, 1.2 for `QuinticSpline`.
        #[serde(default)]
        smoothing_ratio: Option<Number>,
        /// Viscous term, default `Laminar()`.
        #[serde(default)]
        viscosity: Option<Spanned<Viscosity>>,
        /// Damping of the noise of single particles, default `Off`.
        #[serde(default)]
        noise_damping: Option<Spanned<NoiseDamping>>,
        /// Particle shifting, default `Fickian()`.
        #[serde(default)]
        shifting: Option<Spanned<Shifting>>,
        /// True if p_b − p_a takes the place of p_a + p_b where p_a < 0, default true.
        #[serde(default)]
        tensile_control: Option<bool>,
        /// Time integrator, default `KickDrift`.
        #[serde(default)]
        integrator: Option<Spanned<Integrator>>,
    },
    /// Evolved pressure and transport velocity of Negi et al. (2020). Take it for vortices and
    /// wakes.
    EdacTvf {
        /// Smoothing kernel, default `QuinticSpline`.
        #[serde(default)]
        kernel: Option<Kernel>,
        /// Smoothing length over spacing, h/Δ, dimensionless, default 1.5 in 2D and 1.7 in 3D for
        /// `WendlandC2`, 1.2 for `QuinticSpline`.
        #[serde(default)]
        smoothing_ratio: Option<Number>,
        /// Damping α of the pressure, dimensionless, default 0.5; ν_edac = α h c0/8.
        #[serde(default)]
        alpha: Option<Number>,
        /// Background pressure over ρ0 c0², dimensionless, default 1.
        #[serde(default)]
        background: Option<Number>,
        /// True if the mean pressure of the neighbours is subtracted, default true.
        #[serde(default)]
        average_pressure: Option<bool>,
        /// True if ν and ν_edac are divided by their lattice coefficient, default true.
        #[serde(default)]
        lattice_normalised: Option<bool>,
        /// Rate at which the pressure relaxes to that of the summed density, over c0/h,
        /// dimensionless, default 0, as published.
        #[serde(default)]
        relaxation: Option<Number>,
        /// True for the published η² = 0.01 h² in the denominator of the viscous sums, default
        /// false.
        #[serde(default)]
        as_published: Option<bool>,
    },
}

impl Default for SchemeFile {
    fn default() -> Self {
        SchemeFile::Wcsph {
            kernel: None,
            smoothing_ratio: None,
            viscosity: None,
            noise_damping: None,
            shifting: None,
            tensile_control: None,
            integrator: None,
        }
    }
}

/// Arrangement of the particles that fill the domain.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", schemars(rename = "Fill"))]
pub enum FillFile {
    /// A square or cubic lattice. Take it unless walls are inclined or curved.
    Lattice {
        /// Angle by which its axes are turned anticlockwise from those of the scene, degrees,
        /// default that of the walls if one angle serves three quarters of them and none lies along
        /// an axis, else 0. Walls oblique to the lattice are rough.
        #[serde(default)]
        angle: Option<Number>,
        /// Axis of the rotation in 3D, dimensionless, default z.
        #[serde(default)]
        axis: Option<Vector>,
        /// Corner at which cells of the lattice meet, m, default chosen so that walls lie between
        /// cells.
        #[serde(default)]
        anchor: Option<Vector>,
        /// Largest initial displacement of fluid particles from the lattice over the spacing,
        /// dimensionless, default 0; at most 0.2. Along each axis it is a uniform random number
        /// from −jitter to jitter that depends on the lattice point alone.
        #[serde(default)]
        jitter: Option<Number>,
    },
    /// A lattice relaxed onto the walls: layers of wall particles along all of them, and fluid and
    /// zones of even density up to them, with the mass of their volume. Take it for curved or
    /// oblique walls, above all in narrow sections and around bodies.
    Packed {
        /// Angle of the lattice in the midst of the fluid, degrees, default as of `Lattice`.
        #[serde(default)]
        angle: Option<Number>,
        /// Axis of the rotation in 3D, dimensionless, default z.
        #[serde(default)]
        axis: Option<Vector>,
        /// Corner at which cells of the lattice meet, m, default as of `Lattice`.
        #[serde(default)]
        anchor: Option<Vector>,
    },
    /// Rows that follow the inclined or curved walls of a channel along x, in 2D. Take it for
    /// channels with such walls.
    WallFitted {
        /// Position y of the lower wall as a function of x, m.
        lower: Formula,
        /// Position y of the upper wall as a function of x, m.
        upper: Formula,
    },
}

/// Fields at t = 0.
#[derive(Clone, Debug, Default, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename = "Initial", deny_unknown_fields)]
pub struct InitialFile {
    /// Velocity of fluid and zones, m/s, default rest.
    #[serde(default)]
    pub velocity: Option<Spanned<Vec<Formula>>>,
    /// Pressure of the outflow particles, Pa, default 0. It does not act on the fluid, whose
    /// density is summed before the first step and determines its pressure.
    #[serde(default)]
    pub pressure: Option<Formula>,
    /// Passive tag that particles carry along, dimensionless, default 0.
    #[serde(default)]
    pub tag: Option<Formula>,
}

/// Particles stored for the inlets.
#[derive(Clone, Debug, Default, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename = "Reservoir", deny_unknown_fields)]
pub struct ReservoirFile {
    /// Number of particles, default as many as the inflow zones hold.
    #[serde(default)]
    pub particles: Option<Spanned<u64>>,
    /// Action when an inlet needs a particle and there is none, default `Grow`.
    #[serde(default)]
    pub when_empty: WhenEmpty,
    /// True if particles that leave are stored and injected again, default true. With false they
    /// are deleted and new ones with free numbers are created.
    #[serde(default)]
    pub recycle: Option<Spanned<bool>>,
}

/// End and time step.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename = "Time", deny_unknown_fields)]
pub struct TimeFile {
    /// End of the run, s.
    pub end: Number,
    /// Courant factor, dimensionless, default 0.5, with `Verlet` 0.3, of `EdacTvf` 0.25.
    #[serde(default)]
    pub cfl: Option<Number>,
    /// Viscous factor, dimensionless, default 0.125; Δt ≤ factor h²/ν.
    #[serde(default)]
    pub viscous: Option<Number>,
}

/// Velocity and length of the Reynolds number.
#[derive(Clone, Debug, Default, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename = "Reference", deny_unknown_fields)]
pub struct ReferenceFile {
    /// Velocity of the Reynolds number, m/s, default the largest given speed.
    #[serde(default)]
    pub velocity: Option<Number>,
    /// Length of the Reynolds number, m, default the width of the narrowest inlet or outlet, or of
    /// the domain.
    #[serde(default)]
    pub length: Option<Number>,
}
