//! Option `--set path=value`.

use super::shipped::path;
use crate::faults::SceneErrors;
use crate::model::Scene;
use sphecs_core::boundary::outlet::OutletCondition;
use sphecs_core::physics::wall::Slip;

fn with(sets: &[(&str, &str)]) -> Result<Scene, SceneErrors> {
    Scene::from_file(path("constricted_r2.ron")).sets(sets).load()
}

fn loaded(sets: &[(&str, &str)]) -> Scene {
    match with(sets) {
        Ok(scene) => scene,
        Err(faults) => panic!("{:?}", miette::Report::new(faults)),
    }
}

fn advice(sets: &[(&str, &str)]) -> String {
    let faults = match with(sets) {
        Ok(_) => panic!("{sets:?} was accepted"),
        Err(faults) => faults,
    };
    let lines = faults
        .faults()
        .iter()
        .map(|fault| format!("{}: {}; {}", fault.title, fault.label, fault.help.clone().unwrap_or_default()));
    lines.collect::<Vec<_>>().join("\n")
}

#[test]
fn number_is_replaced_and_comments_stay() {
    let scene = loaded(&[("fluid.sound_speed", "1.0"), ("constants.v0", "0.05")]);
    assert_eq!(scene.fluid.sound_speed, 1.0);
    assert!(scene.text.contains("sound_speed: 1.0"));
    assert!(scene.text.contains("\"v0\": 0.05, // m/s, peak of the inflow"));
    assert!((scene.reference_velocity - 2.0 / 3.0 * 0.05 * 0.0889 / 0.0133).abs() < 1e-12);
}

#[test]
fn variant_is_replaced() {
    let scene = loaded(&[("outlets.0.condition", "Orlanski(frame: Fixed)")]);
    assert!(matches!(scene.outlets[0].condition, OutletCondition::Orlanski(_)));
}

#[test]
fn field_missing_in_the_file_is_inserted() {
    let scene = loaded(&[
        ("scheme.tensile_control", "false"),
        ("outlets.0.depth", "0.02"),
        ("precision", "F32"),
        ("outlets.0.condition.frame", "Fixed"),
        ("scheme.shifting", "Off"),
        ("spacing", "1.9e-3"),
    ]);
    assert!(scene.scheme.wcsph().is_some_and(|scheme| !scheme.tensile_control));
    assert!((scene.outlets[0].patch.depth - 11.0 * 1.9e-3).abs() < 1e-12);
    assert!(scene.text.contains("precision: F32"));
    // The text as run can be loaded again.
    let again = Scene::from_text("again", &scene.text)
        .load()
        .unwrap_or_else(|faults| panic!("{:?}", miette::Report::new(faults)));
    assert_eq!(again.outlets[0].condition, scene.outlets[0].condition);
    assert_eq!(again.spacing, scene.spacing);
    assert_eq!(again.text, scene.text);
}

/// A field, a field inside one that the scene does not have, a constant, and a field of a choice
/// that is written without brackets.
#[test]
fn whatever_the_scene_lacks_is_added() {
    let text = "Scene(title: \"t\", dimensions: 2, spacing: 0.05, fluid: (density: 1000.0, viscosity: 1e-3, \
        sound_speed: 10.0), domain: Box(min: (0.0, 0.0), max: (1.0, 0.4)), \
        inlets: [(at: (0.0, 0.2), towards: (1.0, 0.0), velocity: Normal(0.1))], \
        outlets: [(at: (1.0, 0.2), towards: (1.0, 0.0), condition: WaveEquation)], \
        time: (end: 1.0), output: (every: 0.1))";
    let load = |sets: &[(&str, &str)]| match Scene::from_text("t", text).sets(sets).load() {
        Ok(scene) => scene,
        Err(faults) => panic!("{sets:?}: {:?}", miette::Report::new(faults)),
    };
    assert!(load(&[("scheme", "EdacTvf()")]).scheme.wcsph().is_none());
    assert!(load(&[("scheme.tensile_control", "false")]).scheme.wcsph().is_some_and(|s| !s.tensile_control));
    assert_eq!(load(&[("walls.slip", "FreeSlip")]).walls.parts[0].slip, Slip::FreeSlip);
    // A program may write every text in quotes: the name of a choice is known by its field.
    assert_eq!(load(&[("walls.slip", "\"FreeSlip\"")]).walls.parts[0].slip, Slip::FreeSlip);
    let constants = load(&[("constants.a", "2.0e-2"), ("constants.b", "1.0"), ("spacing", "\"a*b\"")]);
    assert_eq!(constants.spacing, 0.02);
    assert_eq!(load(&[("reference.length", "0.3"), ("reference.velocity", "0.2")]).reference_length, 0.3);
    let condition = load(&[("outlets.0.condition.frame", "Fixed")]);
    assert!(condition.text.contains("condition: WaveEquation(frame: Fixed)"), "{}", condition.text);
    let refused = Scene::from_text("t", text).sets([("bodies.0.part", "\"walls\"")]).load();
    assert!(format!("{:?}", miette::Report::new(refused.expect_err("refused"))).contains("no such path"));
}

#[test]
fn unknown_path_gets_the_nearest_as_advice() {
    assert!(advice(&[("fluid.sound_sped", "1.0")]).contains("did you mean `sound_speed`"));
    assert!(advice(&[("fluid.sound_sped", "1.0")]).contains("--set fluid.sound_sped"));
    assert!(advice(&[("fluids.viscosity", "1.0")]).contains("did you mean `fluid.viscosity`"));
    assert!(advice(&[("outlets.3.condition", "Orlanski()")]).contains("did you mean `outlets.0.condition`"));
    assert!(advice(&[("", "1.0")]).contains("no such path"));
}

#[test]
fn a_value_of_the_wrong_kind_is_a_fault() {
    assert!(advice(&[("fluid.viscosity", "[1]")]).contains("is a list, must be a number"));
    assert!(advice(&[("fluid.viscosity", "2*v0")]).contains("an expression has no quotes"));
    assert!(advice(&[("fluid.viscosity", "-1")]).contains("must be finite and not negative"));
    assert!(advice(&[("fluid.viscosity", "(")]).contains("never closed"));
}

/// Faults of values that are in no file are attributed to the command line.
#[test]
fn fault_of_a_value_names_its_set_option() {
    let sets = [
        ("fluid.density", "-1"),
        ("outlets.0.condition", "WaveEquation(pressure: Reference())"),
        ("precision", "F31"),
        ("constants.v0", "0.0445000000"),
        ("inlets.0.velocity", "Normal()"),
    ];
    let all = advice(&sets);
    for (said, count) in [
        ("--set fluid.density: `density` must be finite and greater than 0", 1),
        ("--set outlets.0.condition: `Reference` is not a number or an expression in quotes", 1),
        ("--set precision: `F31` is not a choice", 1),
        ("--set inlets.0.velocity: must be a number or an expression in quotes", 1),
        ("--set", 4),
    ] {
        assert_eq!(all.matches(said).count(), count, "{said} in\n{all}");
    }
    // The later value lies within the earlier one.
    let within =
        advice(&[("outlets.0.condition", "Orlanski(frame: Fixed)"), ("outlets.0.condition.frame", "Fxed")]);
    assert!(within.contains("--set outlets.0.condition.frame: `Fxed`"), "{within}");
}
