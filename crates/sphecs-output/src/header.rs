//! Header of a run: its properties in `summary.json` and in the attributes of the NetCDF files.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::frame::Frame;
use super::meshes::hash_of;
use sphecs_core::particles::zone::Zone;
use sphecs_engine::simulation::Simulation;
use sphecs_scene::field_grid::FieldGrid;
use sphecs_scene::meshes::MeshFile;
use sphecs_scene::model::{Body, BodyReference, Precision, ProbeKind, Scene};

/// Properties of a run that are known at its first step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// File stem of the scene.
    pub scene: String,
    /// Title of the scene.
    pub title: String,
    /// Scene as run, RON. Stored as `scene.ron`, not in `summary.json`.
    #[serde(skip)]
    pub text: String,
    /// Tables that the scene names: path as written, and text. Stored as `tables.json`.
    #[serde(skip)]
    pub tables: Vec<(String, String)>,
    /// Files of meshes and outlines that the scene names. Stored in `meshes/`.
    #[serde(skip)]
    pub meshes: Vec<MeshFile>,
    /// Their paths in the scene and their SHA-256, hexadecimal.
    #[serde(default)]
    pub mesh_hashes: Vec<(String, String)>,
    /// Changes to the scene by `sphecs resume --set`, as path and value, in their order.
    #[serde(default)]
    pub changes: Vec<(String, String)>,
    /// End given on the command line, s.
    #[serde(default)]
    pub until: Option<f64>,
    /// Largest number of steps given on the command line.
    #[serde(default, rename = "most_steps")]
    pub max_steps: Option<u64>,
    /// True if plugins of the program that started the run take part in it.
    #[serde(default)]
    pub has_plugins: bool,
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
    /// Velocity in the Reynolds and Mach numbers, m/s.
    pub reference_velocity: f64,
    /// Length in the Reynolds number, m.
    pub reference_length: f64,
    /// End of the run in the scene, s.
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
    /// Fields on grids.
    #[serde(default)]
    pub fields: Option<FieldsHeader>,
    /// Quantities at the walls.
    #[serde(default)]
    pub wall_quantities: Option<WallsHeader>,
}

/// Quantities at the walls of the scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WallsHeader {
    /// True if a wall with points changes its place.
    pub moves: bool,
    /// Interval of the means, s.
    pub mean: Option<(f64, f64)>,
}

impl WallsHeader {
    /// Returns the header of the quantities at the walls of a scene; None without them.
    pub fn of(scene: &Scene) -> Option<Self> {
        let output = scene.output.walls.as_ref()?;
        let mean = output.mean.map(|(from, to)| (finite(from), finite(to)));
        Some(Self { moves: scene.has_moving_wall_points(), mean })
    }
}

/// Grids of the scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FieldsHeader {
    /// Grids, that of the whole domain first.
    pub grids: Vec<FieldGrid>,
    /// True if the passive scalar is written.
    pub tagged: bool,
    /// True if the mask of the walls depends on time.
    pub has_moving_walls: bool,
    /// Interval of the means, s.
    pub mean: Option<(f64, f64)>,
}

impl FieldsHeader {
    /// Returns the header of the gridded fields of a scene; None without them.
    pub fn of(scene: &Scene) -> Option<Self> {
        let output = scene.output.fields.as_ref()?;
        Some(Self {
            grids: scene.field_grids(),
            tagged: scene.has_tags(),
            has_moving_walls: scene.has_moving_walls(),
            mean: output.mean.map(|(from, to)| (finite(from), finite(to))),
        })
    }
}

/// Body of the walls whose forces are written.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BodyHeader {
    /// Name of the part of the walls.
    pub name: String,
    /// References of its coefficients.
    pub reference: Option<BodyReference>,
    /// Interval of the time mean and of the spectrum, s.
    pub mean: (f64, f64),
    /// True if means and spectrum are computed from the running mean over five rows.
    pub five_point_mean: bool,
    /// True if it moves.
    #[serde(default)]
    pub moves: bool,
}

impl BodyHeader {
    fn of(scene: &Scene, body: &Body) -> Self {
        Self {
            moves: scene.part_moves(body.part),
            name: body.name.clone(),
            reference: body.reference,
            mean: (finite(body.mean.0), finite(body.mean.1)),
            five_point_mean: body.five_point_mean,
        }
    }
}

/// Probe of the scene.
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
    /// Returns the shape of a probe of the scene.
    pub fn of(kind: &ProbeKind) -> Self {
        match kind {
            ProbeKind::Point(_) => Self::Point,
            ProbeKind::Line { .. } => Self::Line,
            ProbeKind::Section { .. } => Self::Section,
        }
    }
}

/// Initial particles of a run, as a header tells them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct InitialParticles {
    /// Lower and upper corner of the box around them, m; None without any.
    pub bounds: Option<[[f64; 3]; 2]>,
    /// Count of the particles, those in the reservoir included.
    pub count: u64,
    /// Count of the wall particles.
    pub walls: u64,
}

impl InitialParticles {
    /// Returns the particles of a frame.
    pub fn of_frame(first: &Frame) -> Self {
        let walls = first.slots_of(Zone::Wall).count() as u64;
        Self { bounds: first.bounds(), count: first.len() as u64, walls }
    }

    /// Returns the particles of a simulation before its first step, without the memory of a frame.
    pub fn of(simulation: &mut Simulation) -> Self {
        let mut found = Self::default();
        simulation.for_each_position(&mut |zone, position| {
            let place = position.to_array();
            let [lower, upper] = found.bounds.get_or_insert([place; 2]);
            for axis in 0..3 {
                lower[axis] = lower[axis].min(place[axis]);
                upper[axis] = upper[axis].max(place[axis]);
            }
            found.count += 1;
            found.walls += u64::from(zone == Zone::Wall);
        });
        found
    }
}

impl Header {
    /// Returns the numbers that all particles share, as arrays with which the filters of ParaView
    /// need no typing: mass, kg (kg/m in 2D), spacing, m, and smoothing length, m.
    pub(crate) fn particle_constants(&self) -> [(&'static str, f32); 3] {
        let mass = self.reference_density * self.spacing.powi(self.dimensions as i32);
        [
            ("mass", mass as f32),
            ("spacing", self.spacing as f32),
            ("smoothing_length", self.smoothing_length as f32),
        ]
    }

    /// Returns the header of a scene with its initial particles.
    pub fn new(scene: &Scene, first: &InitialParticles) -> Self {
        Self {
            scene: scene.name.clone(),
            title: scene.title.clone(),
            text: scene.text.clone(),
            tables: scene.tables.clone(),
            meshes: scene.meshes.clone(),
            mesh_hashes: scene.meshes.iter().map(|mesh| (mesh.path.clone(), hash_of(mesh))).collect(),
            changes: Vec::new(),
            until: None,
            max_steps: None,
            has_plugins: false,
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
            bounds: first.bounds.unwrap_or_default(),
            particles: first.count,
            walls: first.walls,
            inlets: scene.source_names().map(str::to_owned).collect(),
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
            bodies: scene.bodies.iter().map(|body| BodyHeader::of(scene, body)).collect(),
            fields: FieldsHeader::of(scene),
            wall_quantities: WallsHeader::of(scene),
        }
    }

    /// Returns the SHA-256 of the scene, its tables and its meshes, hexadecimal, which a checkpoint
    /// must match.
    pub fn fingerprint(&self) -> String {
        let mut hash = Sha256::new();
        let parts = self.tables.iter().chain(&self.mesh_hashes).flat_map(|(path, text)| [path, text]);
        for part in std::iter::once(&self.text).chain(parts) {
            // The lengths make sure that different lists of texts have different bytes.
            hash.update((part.len() as u64).to_le_bytes());
            hash.update(part.as_bytes());
        }
        hexadecimal(&hash.finalize())
    }

    /// Returns true if `scene.ron` is unchanged since the start of the run.
    pub fn is_scene_unchanged(&self) -> bool {
        hexadecimal(&Sha256::digest(self.text.as_bytes())) == self.sha256
    }

    /// Applies the changes of a resumed run.
    pub fn change(&mut self, scene: &Scene, changes: Vec<(String, String)>) {
        self.end = finite(scene.time.end);
        self.every = finite(scene.output.every);
        // The interval of a mean may depend on the end.
        self.bodies = scene.bodies.iter().map(|body| BodyHeader::of(scene, body)).collect();
        self.changes = changes;
    }

    /// Returns the names of the axes.
    pub fn axes(&self) -> &'static [&'static str] {
        if self.dimensions == 2 { &["x", "y"] } else { &["x", "y", "z"] }
    }

    /// Returns the names of the axes that a rotation or a torque may have.
    pub fn rotation_axes(&self) -> &'static [&'static str] {
        if self.dimensions == 2 { &["z"] } else { &["x", "y", "z"] }
    }
}

/// Returns bytes as hexadecimal digits.
pub(crate) fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Returns the value with infinities replaced by the largest numbers, as JSON has no infinity.
fn finite(value: f64) -> f64 {
    value.clamp(-f64::MAX, f64::MAX)
}
