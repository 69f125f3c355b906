//! Scenes described in Rust.
//!
//! A [`SceneBuilder`] holds the fields of a scene file as typed values and is written as the text
//! of one. The loader reads that text. So a built scene passes the checks of a file, a fault shows
//! its position in the text, and the run folder holds a scene that can be run again. The crate
//! `ron` writes the text; it is read by [`notation`](super::notation), because `ron` gives no
//! positions and stops at the first fault.
//!
//! * [`numbers`]: numbers, formulas, vectors
//! * [`regions`]: regions of space
//! * [`openings`]: inlets, emitters and outlets
//! * [`walls`]: walls and bodies
//! * [`moving_bodies`]: bodies that move
//! * [`scheme`]: fluid and numerical scheme
//! * [`settings`]: filling, initial fields, reservoir, time, references
//! * [`measurements`]: output, probes and gridded fields

use ron::extensions::Extensions;
use ron::ser::PrettyConfig;
use serde::{Serialize, Serializer};

use super::faults::SceneErrors;
use super::loader::SceneLoader;
use super::model::{Precision, Scene};

mod description;
pub mod measurements;
pub mod moving_bodies;
pub mod numbers;
pub mod openings;
pub mod regions;
pub mod scheme;
pub mod settings;
pub mod walls;

pub use measurements::{FieldPlane, Fields, Output, Probe, ProbeKind, WallQuantities};
pub use moving_bodies::{Motion, Mover, Translation, Turning};
pub use numbers::{Components, Formula, Interval, Number, Vector, VectorFormula};
pub use openings::{Emitter, Inlet, InletVelocity, MassFlow, MassFlux, Outlet, PoiseuilleStartup};
pub use regions::{BendSection, Rotation, Shape};
pub use scheme::{EdacTvf, Fluid, Scheme, Wcsph};
pub use settings::{Fill, Initial, Lattice, Packed, Reference, Reservoir, Time, WallFitted};
pub use walls::{Body, Concentric, WallFill, WallPart, Walls};

/// A scene under construction; made by [`Scene::builder`].
///
/// Spacing, fluid, domain, time and output are required. A number may be an expression of the
/// constants, as in a scene file: `"2*R"`.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[must_use = "a scene is made by `build`"]
pub struct SceneBuilder {
    #[serde(skip)]
    name: String,
    #[serde(skip)]
    tables: Vec<(String, String)>,
    title: String,
    dimensions: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    precision: Option<Precision>,
    #[serde(skip_serializing_if = "Option::is_none")]
    spacing: Option<Number>,
    #[serde(skip_serializing_if = "Option::is_none")]
    smoke: Option<Number>,
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "as_map")]
    constants: Vec<(String, Number)>,
    #[serde(skip_serializing_if = "Option::is_none")]
    fluid: Option<Fluid>,
    #[serde(skip_serializing_if = "Option::is_none")]
    scheme: Option<Scheme>,
    #[serde(skip_serializing_if = "Option::is_none")]
    domain: Option<Shape>,
    #[serde(skip_serializing_if = "Option::is_none")]
    fill: Option<Fill>,
    #[serde(skip_serializing_if = "WallChoice::is_standard")]
    walls: WallChoice,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    movers: Vec<Mover>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    bodies: Vec<Body>,
    #[serde(skip_serializing_if = "Option::is_none")]
    initial: Option<Initial>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    inlets: Vec<Inlet>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    emitters: Vec<Emitter>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    outlets: Vec<Outlet>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    periodic: Vec<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    body_force: Option<VectorFormula>,
    #[serde(skip_serializing_if = "Option::is_none")]
    reservoir: Option<Reservoir>,
    #[serde(skip_serializing_if = "Option::is_none")]
    time: Option<Time>,
    #[serde(skip_serializing_if = "Option::is_none")]
    output: Option<Output>,
    #[serde(skip_serializing_if = "Option::is_none")]
    reference: Option<Reference>,
}

/// The walls as the scene file distinguishes them.
#[derive(Clone, Debug, PartialEq)]
enum WallChoice {
    /// Walls of a file without the field.
    Standard,
    /// `None`.
    Absent,
    /// Walls as described.
    Described(Box<Walls>),
}

impl WallChoice {
    fn is_standard(&self) -> bool {
        *self == Self::Standard
    }
}

impl Serialize for WallChoice {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Standard | Self::Absent => serializer.serialize_none(),
            Self::Described(walls) => walls.serialize(serializer),
        }
    }
}

/// Writes constants as a map in their order: each may use those before it.
fn as_map<S: Serializer>(constants: &[(String, Number)], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(constants.iter().map(|(name, value)| (name, value)))
}

/// Returns a value as RON, in the notation of scene files.
pub(super) fn ron_text(value: &impl Serialize) -> String {
    let options = ron::Options::default()
        .with_default_extension(Extensions::IMPLICIT_SOME | Extensions::UNWRAP_VARIANT_NEWTYPES)
        .without_recursion_limit();
    let layout = PrettyConfig::new().new_line("\n").depth_limit(3);
    options.to_string_pretty(value, layout).expect("texts, numbers and enums can be written as RON")
}

impl Scene {
    /// Begins to describe a scene in 2 or 3 dimensions.
    ///
    /// ```
    /// use sphecs_core::boundary::outlet::OutletCondition;
    /// use sphecs_scene::Scene;
    /// use sphecs_scene::builder::{
    ///     Fluid, Initial, Inlet, InletVelocity, Outlet, Output, Probe, Shape, Time,
    /// };
    ///
    /// # fn main() -> Result<(), sphecs_scene::SceneErrors> {
    /// let block = |bottom, top| Shape::cuboid((0.06, bottom), (0.10, top));
    /// let inflow = "v0 * 0.5*(1 - cos(pi*min(t/t0, 1))) * (1 - 4*y^2/D^2)";
    /// let axis = Probe::line("axis", (0.0, 0.0), ("L", 0.0), 81);
    /// let scene = Scene::builder(2)
    ///     .title("Channel with a constriction")
    ///     .spacing(2.5e-3)
    ///     .constant("v0", 0.1) // m/s, peak of the inflow
    ///     .constant("t0", 0.5) // s, start
    ///     .constant("D", 0.04) // m, width of the channel
    ///     .constant("d", 0.02) // m, width of the gap
    ///     .constant("L", 0.2) // m, length
    ///     .fluid(Fluid::new().density(1000.0).viscosity(1e-5).sound_speed(2.0))
    ///     .domain(Shape::difference([
    ///         Shape::cuboid((0.0, "-D/2"), ("L", "D/2")),
    ///         block("d/2", "D"),
    ///         block("-D", "-d/2"),
    ///     ]))
    ///     .initial(Initial::new().tag("y > 0"))
    ///     .inlet(Inlet::new((0.0, 0.0), (1.0, 0.0), InletVelocity::normal(inflow)))
    ///     .outlet(Outlet::new(("L", 0.0), (1.0, 0.0)))
    ///     .time(Time::until(2.0))
    ///     .output(Output::at_interval(0.05).probe(axis))
    ///     .build()?;
    /// assert!(matches!(scene.outlets[0].condition, OutletCondition::WaveEquation(_)));
    /// # Ok(())
    /// # }
    /// ```
    pub fn builder(dimensions: usize) -> SceneBuilder {
        SceneBuilder {
            name: "scene".to_owned(),
            tables: Vec::new(),
            title: "Scene".to_owned(),
            dimensions,
            precision: None,
            spacing: None,
            smoke: None,
            constants: Vec::new(),
            fluid: None,
            scheme: None,
            domain: None,
            fill: None,
            walls: WallChoice::Standard,
            movers: Vec::new(),
            bodies: Vec::new(),
            initial: None,
            inlets: Vec::new(),
            emitters: Vec::new(),
            outlets: Vec::new(),
            periodic: Vec::new(),
            body_force: None,
            reservoir: None,
            time: None,
            output: None,
            reference: None,
        }
    }
}

impl SceneBuilder {
    /// Sets the name of the scene, which its run folder takes, default `scene`.
    pub fn name(mut self, name: impl Into<String>) -> Self {
        self.name = name.into();
        self
    }

    /// Sets the title, one line for people.
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = title.into();
        self
    }

    /// Sets the scalar of the pair sums, default `F64`.
    pub fn precision(mut self, precision: Precision) -> Self {
        self.precision = Some(precision);
        self
    }

    /// Sets the particle spacing Δ, m.
    pub fn spacing(mut self, spacing: impl Into<Number>) -> Self {
        self.spacing = Some(spacing.into());
        self
    }

    /// Sets a coarser spacing for quick tests, m, default the spacing.
    pub fn smoke(mut self, spacing: impl Into<Number>) -> Self {
        self.smoke = Some(spacing.into());
        self
    }

    /// Adds a named constant for expressions; it may be an expression of those before it.
    pub fn constant(mut self, name: impl Into<String>, value: impl Into<Number>) -> Self {
        self.constants.push((name.into(), value.into()));
        self
    }

    /// Sets the fluid.
    pub fn fluid(mut self, fluid: Fluid) -> Self {
        self.fluid = Some(fluid);
        self
    }

    /// Sets the numerical scheme, default `Wcsph`.
    pub fn scheme(mut self, scheme: impl Into<Scheme>) -> Self {
        self.scheme = Some(scheme.into());
        self
    }

    /// Sets the shape that the fluid fills, zones of inlets and outlets not included.
    pub fn domain(mut self, shape: Shape) -> Self {
        self.domain = Some(shape);
        self
    }

    /// Sets the arrangement of the fluid particles, default a lattice.
    pub fn fill(mut self, fill: impl Into<Fill>) -> Self {
        self.fill = Some(fill.into());
        self
    }

    /// Sets the walls, default no-slip images at rest.
    pub fn walls(mut self, walls: Walls) -> Self {
        self.walls = WallChoice::Described(Box::new(walls));
        self
    }

    /// Leaves the domain's surface without walls.
    pub fn without_walls(mut self) -> Self {
        self.walls = WallChoice::Absent;
        self
    }

    /// Adds a body that moves.
    pub fn mover(mut self, mover: Mover) -> Self {
        self.movers.push(mover);
        self
    }

    /// Adds a part of the walls whose force and torque are written.
    pub fn body(mut self, body: Body) -> Self {
        self.bodies.push(body);
        self
    }

    /// Sets the fields at t = 0, default rest.
    pub fn initial(mut self, fields: Initial) -> Self {
        self.initial = Some(fields);
        self
    }

    /// Adds an inlet.
    pub fn inlet(mut self, inlet: Inlet) -> Self {
        self.inlets.push(inlet);
        self
    }

    /// Adds a surface through which fluid enters along the normal.
    pub fn emitter(mut self, emitter: Emitter) -> Self {
        self.emitters.push(emitter);
        self
    }

    /// Adds an outlet.
    pub fn outlet(mut self, outlet: Outlet) -> Self {
        self.outlets.push(outlet);
        self
    }

    /// Makes an axis periodic: `x`, `y` or `z`.
    pub fn periodic(mut self, axis: impl Into<String>) -> Self {
        self.periodic.push(axis.into());
        self
    }

    /// Sets the force per mass on the fluid, m/s², default none.
    pub fn body_force(mut self, force: impl Into<VectorFormula>) -> Self {
        self.body_force = Some(force.into());
        self
    }

    /// Sets the storage of particles for the inlets.
    pub fn reservoir(mut self, reservoir: Reservoir) -> Self {
        self.reservoir = Some(reservoir);
        self
    }

    /// Sets end and time step.
    pub fn time(mut self, time: Time) -> Self {
        self.time = Some(time);
        self
    }

    /// Sets the output of a run and its times.
    pub fn output(mut self, output: Output) -> Self {
        self.output = Some(output);
        self
    }

    /// Sets velocity and length of the Reynolds number, default estimated.
    pub fn reference(mut self, reference: Reference) -> Self {
        self.reference = Some(reference);
        self
    }

    /// Adds the text of a CSV table, under the path by which an inlet names it; tables that are not
    /// added are read from the present folder.
    pub fn table(mut self, path: impl Into<String>, text: impl Into<String>) -> Self {
        self.tables.push((path.into(), text.into()));
        self
    }

    /// Returns the text of the scene file with this content.
    pub fn to_ron(&self) -> String {
        format!("Scene{}\n", ron_text(self))
    }

    /// Returns the loader of the text, for values to change and limits to set before it is read.
    pub fn loader(&self) -> SceneLoader {
        Scene::from_text(&self.name, self.to_ron()).tables(self.tables.clone())
    }

    /// Checks the description and makes the scene of it.
    ///
    /// # Errors
    /// All faults of the description, each with its place in the text that [`to_ron`](Self::to_ron)
    /// returns.
    pub fn build(&self) -> Result<Scene, SceneErrors> {
        self.loader().load()
    }
}
