//! All scenes under scenes/.

use std::path::{Path, PathBuf};

use crate::faults::SceneErrors;
use crate::model::{BodyForce, Fill, Scene};
use crate::{seeds, summary};
use sphecs_core::particles::zone::Zone;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes")
}

/// Returns the paths of all shipped scenes.
pub(super) fn shipped() -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder()).unwrap();
    let mut paths: Vec<PathBuf> = entries
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "ron"))
        .collect();
    paths.sort();
    paths
}

/// Returns the file names of all shipped scenes.
pub(super) fn names() -> Vec<String> {
    let name = |path: PathBuf| path.file_name().unwrap().to_string_lossy().into_owned();
    shipped().into_iter().map(name).collect()
}

/// Returns the path of a shipped scene.
pub(super) fn path(name: &str) -> PathBuf {
    folder().join(name)
}

fn loaded(scene: Result<Scene, SceneErrors>) -> Scene {
    match scene {
        Ok(scene) => scene,
        Err(faults) => panic!("{:?}", miette::Report::new(faults)),
    }
}

/// Returns a shipped scene.
pub(super) fn scene(name: &str) -> Scene {
    loaded(Scene::from_file(path(name)).load())
}

/// Returns a shipped scene at its smoke spacing.
pub(super) fn smoke(name: &str) -> Scene {
    loaded(Scene::from_file(path(name)).smoke().load())
}

#[test]
fn every_shipped_scene_loads_and_has_fluid() {
    for name in names() {
        let full = scene(&name);
        // Rows of a lattice may misfit at one spacing alone; other fills take long at full size.
        let is_lattice = matches!(full.layout.fill, Fill::Lattice(_)) && full.layout.layered.is_empty();
        let spacings = [Some(full).filter(|_| is_lattice), Some(smoke(&name))];
        for scene in spacings.into_iter().flatten() {
            let seeds = seeds(&scene);
            let summary = summary::summary(&scene, &seeds);
            assert!(summary.by_zone[Zone::Fluid as usize] > 0, "{name}");
            assert!(summary.mach < 0.11 && summary.steps > 100.0, "{name}: {summary:?}");
            // A misfit of more than Δ/4 would remove or add a row.
            let misfit = summary.worst_fit.map_or(0.0, |(_, _, misfit)| misfit);
            assert!(misfit < 0.15, "{name}: {summary:?}");
        }
    }
}

#[test]
fn every_shipped_scene_parses_with_the_ron_crate() {
    use ron::extensions::Extensions;
    let options = ron::Options::default()
        .with_default_extension(Extensions::IMPLICIT_SOME | Extensions::UNWRAP_VARIANT_NEWTYPES);
    for path in shipped() {
        let text = std::fs::read_to_string(&path).unwrap();
        let value: Result<ron::Value, _> = options.from_str(&text);
        assert!(value.is_ok(), "{}: {value:?}", path.display());
    }
}

#[test]
fn every_shipped_scene_states_its_runtime_and_purpose() {
    for path in shipped() {
        let text = std::fs::read_to_string(&path).unwrap();
        for needed in ["// Runs for", "// Look at:", "smoke:"] {
            assert!(text.contains(needed), "{} lacks `{needed}`", path.display());
        }
    }
}

#[test]
fn the_inclined_plates_are_driven_by_the_published_force() {
    let scene = scene("inclined_plates.ron");
    // Eqs. 34 and 35 of the paper that the scene names: 8.0022e-4 m/s² at the inlet, 1.0302e-4 m/s²
    // at the outlet.
    let BodyForce::Expression(force) = &scene.body_force else {
        panic!("the force depends on x");
    };
    assert!((force[0].value(0.0, 0.0, 0.0, 0.0) / 8.002_238e-4 - 1.0).abs() < 1e-6);
    let ratio = force[0].value(4.0e-3, 0.0, 0.0, 0.0) / force[0].value(0.0, 0.0, 0.0, 0.0);
    let widening: f64 = 1.0 + 4.0e-3 * 3.503_f64.to_radians().tan() / 2.5e-4;
    assert!((ratio * widening.powi(3) - 1.0).abs() < 1e-12);
}

#[test]
fn torques_are_about_a_point_at_a_finite_place() {
    for name in ["shaken_box.ron", "cylinder_re20.ron", "taylor_couette.ron", "rushton.ron"] {
        let scene = smoke(name);
        assert!(!scene.bodies.is_empty(), "{name} has no bodies");
        for body in &scene.bodies {
            assert!(body.about.is_finite(), "{name}: {} is at {}", body.name, body.about);
        }
    }
    let about = smoke("shaken_box.ron").bodies[0].about;
    assert!((about - glam::DVec3::new(0.5, 0.2, 0.0)).length() < 1e-12, "{about}");
}
