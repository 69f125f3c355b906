//! What a run is: the facts that `summary.json` and the attributes of the NetCDF files state.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::frame::Frame;
use sphecs_core::particles::zone::Zone;
use sphecs_scene::model::{Body, BodyReference, Precision, ProbeKind, Scene};

/// Facts of a run that stand from its first step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// File stem of the scene.
    pub scene: String,
    /// One line for people.
    pub title: String,
    /// The scene as run, RON. Stored as `scene.ron`, not in `summary.json`.
    #[serde(skip)]
    pub text: String,
    /// The tables that the scene names: the path as written, and the text. Stored as `tables.json`.
    #[serde(skip)]
    pub tables: Vec<(String, String)>,
    /// What was changed in the scene since, by `sphecs resume --set`: path and value, in their order.
    #[serde(default)]
    pub changes: Vec<(String, String)>,
    /// End that the user gave in place of the scene's, s.
    #[serde(default)]
    pub until: Option<f64>,
    /// Most steps that the user gave.
    #[serde(default)]
    pub most_steps: Option<u64>,
    /// SHA-256 of `text`, hexadecimal.
    pub sha256: String,
    /// Version of sphecs.
    pub version: String,
    /// 2 or 3.
    pub dimensions: usize,
    /// Scalar of the pair sums: `f32` or `f64`.
    pub precision: String,
    /// Name of the smoothing kernel.
    pub kernel: String,
    /// Smoothing length h, m.
    pub smoothing_length: f64,
    /// Initial particle spacing Δ, m.
    pub spacing: f64,
    /// Sound speed c0, m/s.
    pub sound_speed: f64,
    /// Reference density ρ0, kg/m³.
    pub reference_density: f64,
    /// Kinematic viscosity ν, m²/s.
    pub viscosity: f64,
    /// Velocity of the Reynolds and Mach numbers, m/s.
    pub reference_velocity: f64,
    /// Length of the Reynolds number, m.
    pub reference_length: f64,
    /// End of the run as the scene has it, s.
    pub end: f64,
    /// Interval between frames, s.
    pub every: f64,
    /// Lower and upper corner of the box around all particles at the start, walls included, m.
    pub bounds: [[f64; 3]; 2],
    /// Particles at the start, walls and reservoir included.
    pub particles: u64,
    /// Wall particles.
    pub walls: u64,
    /// Names of the inlets.
    pub inlets: Vec<String>,
    /// Names of the outlets.
    pub outlets: Vec<String>,
    /// Names of the wall parts.
    pub wall_parts: Vec<String>,
    /// Declared probes.
    pub probes: Vec<ProbeHeader>,
    /// Bodies whose forces are written.
    #[serde(default)]
    pub bodies: Vec<BodyHeader>,
}

/// A body as its results need it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BodyHeader {
    /// Name of the part of the walls.
    pub name: String,
    /// References of its coefficients.
    pub reference: Option<BodyReference>,
    /// Interval of the time mean and of the spectrum, s.
    pub mean: (f64, f64),
    /// Whether means and spectrum are of the running mean over five rows.
    pub five_point_mean: bool,
}

impl BodyHeader {
    fn of(body: &Body) -> Self {
        Self {
            name: body.name.clone(),
            reference: body.reference,
            mean: (finite(body.mean.0), finite(body.mean.1)),
            five_point_mean: body.five_point_mean,
        }
    }
}

/// A probe as its results need it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProbeHeader {
    /// Name in the scene.
    pub name: String,
    /// Shape of its results.
    pub kind: ProbeShape,
    /// Interval of the time mean, s.
    pub mean: Option<(f64, f64)>,
}

/// Shape of a probe's results.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ProbeShape {
    /// Fields at one point.
    Point,
    /// Fields at points of a line.
    Line,
    /// Mass flow and mean pressure.
    Section,
}

impl ProbeShape {
    /// Shape of a scene's probe.
    pub fn of(kind: &ProbeKind) -> Self {
        match kind {
            ProbeKind::Point(_) => Self::Point,
            ProbeKind::Line { .. } => Self::Line,
            ProbeKind::Section { .. } => Self::Section,
        }
    }
}

impl Header {
    /// The facts of a scene whose state at the start is `first`.
    pub fn new(scene: &Scene, first: &Frame) -> Self {
        Self {
            scene: scene.name.clone(),
            title: scene.title.clone(),
            text: scene.text.clone(),
            tables: scene.tables.clone(),
            changes: Vec::new(),
            until: None,
            most_steps: None,
            sha256: hexadecimal(&Sha256::digest(scene.text.as_bytes())),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            dimensions: scene.dimensions,
            precision: match scene.precision {
                Precision::F32 => "f32".to_owned(),
                Precision::F64 => "f64".to_owned(),
            },
            kernel: format!("{:?}", scene.scheme.kernel()),
            smoothing_length: scene.discretisation.smoothing_length,
            spacing: scene.spacing,
            sound_speed: scene.fluid.sound_speed,
            reference_density: scene.fluid.density,
            viscosity: scene.fluid.viscosity,
            reference_velocity: scene.reference_velocity,
            reference_length: scene.reference_length,
            end: finite(scene.time.end),
            every: finite(scene.output.every),
            bounds: first.bounds().unwrap_or_default(),
            particles: first.len() as u64,
            walls: first.slots_of(Zone::Wall).count() as u64,
            inlets: scene.inlets.iter().map(|inlet| inlet.patch.name.clone()).collect(),
            outlets: scene.outlets.iter().map(|outlet| outlet.patch.name.clone()).collect(),
            wall_parts: scene.walls.parts.iter().map(|part| part.name.clone()).collect(),
            probes: scene
                .output
                .probes
                .iter()
                .map(|probe| ProbeHeader {
                    name: probe.name.clone(),
                    kind: ProbeShape::of(&probe.kind),
                    mean: probe.mean.map(|(from, to)| (finite(from), finite(to))),
                })
                .collect(),
            bodies: scene.bodies.iter().map(BodyHeader::of).collect(),
        }
    }

    /// SHA-256 of the scene and its tables, hexadecimal: a checkpoint goes on only with what it was written with.
    pub fn fingerprint(&self) -> String {
        let mut hash = Sha256::new();
        let parts = self.tables.iter().flat_map(|(path, text)| [path, text]);
        for part in std::iter::once(&self.text).chain(parts) {
            // With its length, so that no two lists of texts run together to the same bytes.
            hash.update((part.len() as u64).to_le_bytes());
            hash.update(part.as_bytes());
        }
        hexadecimal(&hash.finalize())
    }

    /// Whether `scene.ron` is as it was when the run began.
    pub fn is_scene_unchanged(&self) -> bool {
        hexadecimal(&Sha256::digest(self.text.as_bytes())) == self.sha256
    }

    /// Takes over what a resumed run may change.
    pub fn change(&mut self, scene: &Scene, changes: Vec<(String, String)>) {
        self.end = finite(scene.time.end);
        self.every = finite(scene.output.every);
        // The interval of a mean may follow from the end.
        self.bodies = scene.bodies.iter().map(BodyHeader::of).collect();
        self.changes = changes;
    }

    /// Names of the present axes.
    pub fn axes(&self) -> &'static [&'static str] {
        if self.dimensions == 2 { &["x", "y"] } else { &["x", "y", "z"] }
    }
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// JSON has no infinity: "for ever" is the largest number.
fn finite(value: f64) -> f64 {
    value.clamp(-f64::MAX, f64::MAX)
}
