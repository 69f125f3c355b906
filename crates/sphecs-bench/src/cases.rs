//! What is timed: stirred periodic boxes, and channels with walls, inlet and outlet.
//!
//! The boxes have Wendland's kernel, laminar viscosity or sub-particle stress, and Fickian shifting: in 2D h = 1.33 Δ
//! (20 neighbours), in 3D h = 2.02 Δ (some 256). Those called `quintic` have the quintic spline at h = 1.2 Δ instead (some 40 and
//! 190 neighbours), those called `edac` that and the scheme `EdacTvf`. Particles lie as a flow leaves them (`bench/stirring.rs`).

use sphecs_run::memory;
use sphecs_scene::faults::SceneErrors;
use sphecs_scene::model::{Precision, Scene};

/// The channel as shipped, part of the program: an installed one has no scenes beside it.
const CHANNEL: &str = include_str!("../../../scenes/constricted_r2.ron");
/// Flows that other codes have been timed on.
const CYLINDER: &str = include_str!("../../../benches/channel_cylinder.ron");
const DUCT: &str = include_str!("../../../benches/duct.ron");

/// A flow that is timed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Case {
    /// A periodic box.
    Box(StirredBox),
    /// The constricted channel, run R2, as shipped.
    Channel,
    /// `benches/channel_cylinder.ron`.
    Cylinder,
    /// `benches/duct.ron`.
    Duct,
}

/// A stirred periodic box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StirredBox {
    /// 2 or 3.
    pub dimensions: usize,
    /// Particles along each axis.
    pub count: usize,
    /// Scalar of the pair sums.
    pub precision: Precision,
    /// Kernel and scheme.
    pub terms: BoxTerms,
}

/// Kernel and scheme of a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoxTerms {
    /// `Wcsph` with Wendland's kernel and laminar viscosity.
    Laminar,
    /// The same with sub-particle stress.
    Stress,
    /// `Wcsph` with the quintic spline and laminar viscosity.
    Quintic,
    /// `EdacTvf` with the quintic spline.
    Evolved,
}

/// How a case is timed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Steps before anything is timed.
    pub warm_up: usize,
    /// Repetitions, of which the fastest counts.
    pub repetitions: usize,
    /// Steps of a repetition.
    pub steps: usize,
}

/// 160 000 particles in 2D.
const PLANE: StirredBox =
    StirredBox { dimensions: 2, count: 400, precision: Precision::F32, terms: BoxTerms::Laminar };
/// 262 144 particles in 3D.
const SPACE: StirredBox = StirredBox { dimensions: 3, count: 64, ..PLANE };
/// 19 683 particles in 3D: whether the cost of a particle depends on how many there are.
const SMALL: StirredBox = StirredBox { count: 27, ..SPACE };
/// A million particles in 3D.
const LARGE: StirredBox = StirredBox { count: 100, ..SPACE };
/// Four million particles in 3D.
const HUGE: StirredBox = StirredBox { count: 160, ..SPACE };

const fn double(single: StirredBox) -> Case {
    Case::Box(StirredBox { precision: Precision::F64, ..single })
}

const fn with(terms: BoxTerms, laminar: StirredBox) -> StirredBox {
    StirredBox { terms, ..laminar }
}

impl Case {
    /// All cases with their names, in the order in which they are timed, the small ones first: see [`memory`](super::memory).
    pub const ALL: [(&'static str, Case); 19] = [
        ("channel", Case::Channel),
        ("channel_cylinder", Case::Cylinder),
        ("2d-f32", Case::Box(PLANE)),
        ("2d-f64", double(PLANE)),
        ("2d-quintic-f32", Case::Box(with(BoxTerms::Quintic, PLANE))),
        ("2d-edac-f32", Case::Box(with(BoxTerms::Evolved, PLANE))),
        ("2d-edac-f64", double(with(BoxTerms::Evolved, PLANE))),
        ("3d-small-f32", Case::Box(SMALL)),
        ("3d-f32", Case::Box(SPACE)),
        ("3d-f64", double(SPACE)),
        ("3d-sps-f32", Case::Box(with(BoxTerms::Stress, SPACE))),
        ("3d-sps-f64", double(with(BoxTerms::Stress, SPACE))),
        ("3d-quintic-f32", Case::Box(with(BoxTerms::Quintic, SPACE))),
        ("3d-edac-f32", Case::Box(with(BoxTerms::Evolved, SPACE))),
        ("3d-edac-f64", double(with(BoxTerms::Evolved, SPACE))),
        ("duct", Case::Duct),
        ("3d-large-f32", Case::Box(LARGE)),
        ("3d-large-f64", double(LARGE)),
        ("3d-huge-f32", Case::Box(HUGE)),
    ];

    /// Name, as on the command line.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, case)| *case == self).map_or("box", |(name, _)| name)
    }

    /// The case of a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().find(|(known, _)| *known == name).map(|(_, case)| *case)
    }

    /// The box, if it is one.
    pub fn stirred(self) -> Option<StirredBox> {
        match self {
            Case::Box(stirred) => Some(stirred),
            Case::Channel | Case::Cylinder | Case::Duct => None,
        }
    }

    /// Whether it is timed only when it is asked for: it takes long, and a gigabyte or two.
    pub fn is_large(self) -> bool {
        matches!(self, Case::Box(StirredBox { count, dimensions, .. }) if count >= LARGE.count && dimensions == 3)
    }

    /// How it is timed: on one slow core and on all of a fast machine in the time that a user waits for.
    pub fn plan(self) -> Plan {
        match self {
            Case::Box(StirredBox { dimensions: 2, .. }) => Plan { warm_up: 20, repetitions: 6, steps: 10 },
            Case::Box(_) if self.is_large() => Plan { warm_up: 1, repetitions: 3, steps: 1 },
            Case::Box(SMALL) => Plan { warm_up: 10, repetitions: 6, steps: 10 },
            Case::Box(_) => Plan { warm_up: 2, repetitions: 4, steps: 1 },
            // The inlet has begun to push by then, and zones change.
            Case::Channel => Plan { warm_up: 300, repetitions: 6, steps: 20 },
            Case::Cylinder => Plan { warm_up: 100, repetitions: 6, steps: 20 },
            Case::Duct => Plan { warm_up: 10, repetitions: 3, steps: 4 },
        }
    }

    /// The scene.
    ///
    /// # Errors
    /// Its faults: more particles than the machine has memory for.
    pub fn scene(self) -> Result<Scene, SceneErrors> {
        match self {
            Case::Box(stirred) => stirred.scene(),
            Case::Channel => Scene::from_text("constricted_r2", CHANNEL).memory(memory::available()).load(),
            Case::Cylinder => {
                Scene::from_text("channel_cylinder", CYLINDER).memory(memory::available()).load()
            }
            Case::Duct => Scene::from_text("duct", DUCT).memory(memory::available()).load(),
        }
    }
}

impl StirredBox {
    /// The scene of the box: vortices of half its edge at 1 m/s, c0 = 10 m/s, ν = 1e-6 m²/s, Δ = 0.01 m.
    ///
    /// # Errors
    /// Its faults: more particles than the machine has memory for.
    pub fn scene(self) -> Result<Scene, SceneErrors> {
        let edge = self.count as f64 * 0.01;
        let (dimensions, precision) = (self.dimensions, self.precision);
        let (zeros, edges, axes, velocity, ratio) = if dimensions == 2 {
            ("0.0, 0.0", format!("{edge}, {edge}"), r#""x", "y""#, r#""sin(k*y)", "cos(k*x)""#, 1.33)
        } else {
            (
                "0.0, 0.0, 0.0",
                format!("{edge}, {edge}, {edge}"),
                r#""x", "y", "z""#,
                r#""sin(k*y)", "cos(k*z)", "sin(k*x)""#,
                2.02,
            )
        };
        let scheme = match self.terms {
            BoxTerms::Laminar => format!("Wcsph(smoothing_ratio: {ratio})"),
            BoxTerms::Stress => format!("Wcsph(smoothing_ratio: {ratio}, viscosity: Sps())"),
            BoxTerms::Quintic => "Wcsph(kernel: QuinticSpline, smoothing_ratio: 1.2)".to_owned(),
            BoxTerms::Evolved => "EdacTvf(smoothing_ratio: 1.2)".to_owned(),
        };
        let text = format!(
            r#"Scene(
            title: "Stirred box", dimensions: {dimensions}, precision: {precision:?}, spacing: 0.01, smoke: 0.02,
            constants: {{ "k": "4*pi/{edge}" }},
            fluid: (density: 1000.0, viscosity: 1.0e-6, sound_speed: 10.0),
            scheme: {scheme},
            domain: Box(min: ({zeros}), max: ({edges})), periodic: [{axes}], walls: None,
            initial: (velocity: ({velocity})),
            time: (end: 1.0), output: (every: 1.0),
        )"#
        );
        Scene::from_text("stirred_box", &text).memory(memory::available()).load()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sphecs_scene::summary::summary;

    #[test]
    fn every_case_has_a_scene_without_faults_and_a_name_of_its_own() {
        for (name, case) in Case::ALL {
            assert_eq!(Case::named(name), Some(case));
            assert_eq!(case.name(), name);
            let scene = match case.scene() {
                Ok(scene) => scene,
                Err(faults) => panic!("{name}: {faults}"),
            };
            let stress = scene.scheme.has_stress();
            assert_eq!(stress, name.contains("sps"));
            if let Case::Box(_) = case {
                assert_eq!(scene.precision == Precision::F32, name.ends_with("f32"));
            }
            assert_eq!(case.is_large(), name.contains("large") || name.contains("huge"));
        }
        assert_eq!(Case::named("3d"), None);
    }

    #[test]
    fn boxes_have_the_particles_that_they_say() {
        let stirred = StirredBox { count: 24, ..PLANE };
        let scene = stirred.scene().expect("a scene");
        let seeds = sphecs_scene::seeds(&scene);
        assert_eq!(seeds.len(), 24 * 24);
        assert_eq!(summary(&scene, &seeds).by_zone[0], 24 * 24);
    }
}
