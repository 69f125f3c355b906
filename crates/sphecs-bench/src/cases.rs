//! Flows that are timed: periodic boxes of disordered particles, and channels with walls, inlet and
//! outlet.
//!
//! The boxes have Wendland's kernel, laminar viscosity or sub-particle stress, and Fickian
//! shifting: in 2D h = 1.33 Δ (20 neighbours), in 3D h = 2.02 Δ (some 256). Boxes named `quintic`
//! have the quintic spline at h = 1.2 Δ instead (some 40 and 190 neighbours), boxes named `edac`
//! also the scheme `EdacTvf`. The particle disorder comes from [`tile`](super::tile).

use sphecs_run::memory;
use sphecs_scene::faults::SceneErrors;
use sphecs_scene::model::{Precision, Scene};

/// Shipped channel scene, part of the program.
const CHANNEL: &str = include_str!("../../../scenes/constricted_r2.ron");
/// Flows on which other codes have been timed.
const CYLINDER: &str = include_str!("../../../benches/channel_cylinder.ron");
const DUCT: &str = include_str!("../../../benches/duct.ron");

/// Changes that make the cylinder in the channel a mover.
const TURNING: [(&str, &str); 2] = [
    ("domain", "Box(min: (0.0, 0.0), max: (\"L\", \"H\"))"),
    (
        "movers",
        "[(name: \"cylinder\", shape: Circle(center: (0.5, 0.3), radius: \"r\"), \
         motion: Rotation(about: (0.5, 0.3), rate: \"v0/r*tanh(10*t)\"))]",
    ),
];

/// Flow that is timed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BenchCase {
    /// Periodic box.
    Box(PeriodicBox),
    /// Shipped constricted channel, run R2.
    Channel,
    /// `benches/channel_cylinder.ron`.
    Cylinder,
    /// Channel as above with the cylinder as a mover that turns: what a moving part costs.
    Mover,
    /// `benches/duct.ron`.
    Duct,
}

/// Periodic box of disordered particles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PeriodicBox {
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
    /// `Wcsph` with sub-particle stress.
    Stress,
    /// `Wcsph` with the quintic spline and laminar viscosity.
    Quintic,
    /// `EdacTvf` with the quintic spline.
    Evolved,
}

/// Steps of a timing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Steps before the first timed one.
    pub warm_up: usize,
    /// Repetitions, of which the fastest counts.
    pub repetitions: usize,
    /// Steps of a repetition.
    pub steps: usize,
}

/// 160 000 particles in 2D.
const PLANE: PeriodicBox =
    PeriodicBox { dimensions: 2, count: 400, precision: Precision::F32, terms: BoxTerms::Laminar };
/// 262 144 particles in 3D.
const SPACE: PeriodicBox = PeriodicBox { dimensions: 3, count: 64, ..PLANE };
/// 19 683 particles in 3D, for the dependence of the cost per particle on their number.
const SMALL: PeriodicBox = PeriodicBox { count: 27, ..SPACE };
/// A million particles in 3D.
const LARGE: PeriodicBox = PeriodicBox { count: 100, ..SPACE };
/// Four million particles in 3D.
const HUGE: PeriodicBox = PeriodicBox { count: 160, ..SPACE };

const fn double(single: PeriodicBox) -> BenchCase {
    BenchCase::Box(PeriodicBox { precision: Precision::F64, ..single })
}

const fn with(terms: BoxTerms, laminar: PeriodicBox) -> PeriodicBox {
    PeriodicBox { terms, ..laminar }
}

impl BenchCase {
    /// All cases with their names in the order of their timing, the small ones first: see
    /// [`memory`](super::memory).
    pub const ALL: [(&'static str, BenchCase); 20] = [
        ("channel", BenchCase::Channel),
        ("channel_cylinder", BenchCase::Cylinder),
        ("channel_mover", BenchCase::Mover),
        ("2d-f32", BenchCase::Box(PLANE)),
        ("2d-f64", double(PLANE)),
        ("2d-quintic-f32", BenchCase::Box(with(BoxTerms::Quintic, PLANE))),
        ("2d-edac-f32", BenchCase::Box(with(BoxTerms::Evolved, PLANE))),
        ("2d-edac-f64", double(with(BoxTerms::Evolved, PLANE))),
        ("3d-small-f32", BenchCase::Box(SMALL)),
        ("3d-f32", BenchCase::Box(SPACE)),
        ("3d-f64", double(SPACE)),
        ("3d-sps-f32", BenchCase::Box(with(BoxTerms::Stress, SPACE))),
        ("3d-sps-f64", double(with(BoxTerms::Stress, SPACE))),
        ("3d-quintic-f32", BenchCase::Box(with(BoxTerms::Quintic, SPACE))),
        ("3d-edac-f32", BenchCase::Box(with(BoxTerms::Evolved, SPACE))),
        ("3d-edac-f64", double(with(BoxTerms::Evolved, SPACE))),
        ("duct", BenchCase::Duct),
        ("3d-large-f32", BenchCase::Box(LARGE)),
        ("3d-large-f64", double(LARGE)),
        ("3d-huge-f32", BenchCase::Box(HUGE)),
    ];

    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, case)| *case == self).map_or("box", |(name, _)| name)
    }

    /// Returns the case of a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().find(|(known, _)| *known == name).map(|(_, case)| *case)
    }

    /// Returns the box of a case that is one.
    pub fn periodic_box(self) -> Option<PeriodicBox> {
        match self {
            BenchCase::Box(periodic_box) => Some(periodic_box),
            BenchCase::Channel | BenchCase::Cylinder | BenchCase::Mover | BenchCase::Duct => None,
        }
    }

    /// Returns true for cases that are timed on request only, since they need minutes and
    /// gigabytes.
    pub fn is_large(self) -> bool {
        matches!(self, BenchCase::Box(PeriodicBox { count, dimensions, .. }) if count >= LARGE.count && dimensions == 3)
    }

    /// Returns the steps of the timing, short enough for one slow core and long enough for all
    /// cores of a fast machine.
    pub fn plan(self) -> Plan {
        match self {
            BenchCase::Box(PeriodicBox { dimensions: 2, .. }) => {
                Plan { warm_up: 20, repetitions: 6, steps: 10 }
            }
            BenchCase::Box(_) if self.is_large() => Plan { warm_up: 1, repetitions: 3, steps: 1 },
            BenchCase::Box(SMALL) => Plan { warm_up: 10, repetitions: 6, steps: 10 },
            BenchCase::Box(_) => Plan { warm_up: 2, repetitions: 4, steps: 1 },
            // By then the inlet has started and particles change zones.
            BenchCase::Channel => Plan { warm_up: 300, repetitions: 6, steps: 20 },
            BenchCase::Cylinder | BenchCase::Mover => Plan { warm_up: 100, repetitions: 6, steps: 20 },
            BenchCase::Duct => Plan { warm_up: 10, repetitions: 3, steps: 4 },
        }
    }

    /// Returns the scene.
    ///
    /// # Errors
    /// Faults of the scene, such as more particles than fit into the memory.
    pub fn scene(self) -> Result<Scene, SceneErrors> {
        match self {
            BenchCase::Box(periodic_box) => periodic_box.scene(),
            BenchCase::Channel => load_shipped("constricted_r2", CHANNEL, &[]),
            BenchCase::Cylinder => load_shipped("channel_cylinder", CYLINDER, &[]),
            BenchCase::Mover => load_shipped("channel_mover", CYLINDER, &TURNING),
            BenchCase::Duct => load_shipped("duct", DUCT, &[]),
        }
    }
}

impl PeriodicBox {
    /// Returns the scene of the box: vortices of half its edge at 1 m/s, c0 = 10 m/s, ν = 1e-6
    /// m²/s, Δ = 0.01 m.
    ///
    /// # Errors
    /// Faults of the scene, such as more particles than fit into the memory.
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
            title: "Disordered periodic box", dimensions: {dimensions}, precision: {precision:?}, spacing: 0.01, smoke: 0.02,
            constants: {{ "k": "4*pi/{edge}" }},
            fluid: (density: 1000.0, viscosity: 1.0e-6, sound_speed: 10.0),
            scheme: {scheme},
            domain: Box(min: ({zeros}), max: ({edges})), periodic: [{axes}], walls: None,
            initial: (velocity: ({velocity})),
            time: (end: 1.0), output: (every: 1.0),
        )"#
        );
        load_shipped("periodic_box", &text, &[])
    }
}

/// Loads a scene from its text with changes, within the available memory.
fn load_shipped(name: &str, text: &str, sets: &[(&str, &str)]) -> Result<Scene, SceneErrors> {
    Scene::from_text(name, text).sets(sets).memory(memory::available()).load()
}

#[cfg(test)]
mod tests {
    use super::*;
    use sphecs_scene::summary::summary;

    #[test]
    fn every_case_has_a_valid_scene_and_a_distinct_name() {
        for (name, case) in BenchCase::ALL {
            assert_eq!(BenchCase::named(name), Some(case));
            assert_eq!(case.name(), name);
            let scene = match case.scene() {
                Ok(scene) => scene,
                Err(faults) => panic!("{name}: {faults}"),
            };
            let stress = scene.scheme.has_stress();
            assert_eq!(stress, name.contains("sps"));
            if let BenchCase::Box(_) = case {
                assert_eq!(scene.precision == Precision::F32, name.ends_with("f32"));
            }
            assert_eq!(case.is_large(), name.contains("large") || name.contains("huge"));
        }
        assert_eq!(BenchCase::named("3d"), None);
    }

    #[test]
    fn boxes_have_the_declared_number_of_particles() {
        let periodic_box = PeriodicBox { count: 24, ..PLANE };
        let scene = periodic_box.scene().expect("a scene");
        let seeds = sphecs_scene::seeds(&scene);
        assert_eq!(seeds.len(), 24 * 24);
        assert_eq!(summary(&scene, &seeds).by_zone[0], 24 * 24);
    }
}
