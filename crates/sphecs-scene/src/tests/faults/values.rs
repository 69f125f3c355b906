//! Faults of numbers, expressions, tables and probes.

use super::{SOUND, check, faults_of};
use crate::Scene;
use sphecs_core::boundary::outlet::OutletCondition;
use sphecs_core::boundary::outlet::pressure::{OutletPressure, Waves};
use sphecs_core::boundary::outlet::wave_equation::WaveEquation;
use sphecs_core::physics::wall::Slip;
use sphecs_core::physics::wave_sums::{ReferenceFrame, TransverseOperator};

#[test]
fn numbers_out_of_bounds_are_faults() {
    check("spacing: 0.05", "spacing: -0.05", "`spacing` must be finite and greater than 0", "-0.05");
    check("spacing: 0.05", "spacing: NaN", "`spacing` must be finite", "NaN");
    check("density: 1000.0", "density: 0", "`density` must be finite and greater than 0", "0");
    check("viscosity: 1.0e-3", "viscosity: -1e-3", "`viscosity` must be finite and not negative", "-1e-3");
    check("sound_speed: 10.0", "sound_speed: inf", "`sound_speed` must be finite", "inf");
    check("dimensions: 2", "dimensions: 4", "`dimensions` must be 2 or 3", "4");
    check("smoothing_ratio: 1.5", "smoothing_ratio: 15", "`smoothing_ratio` is out of range", "15");
    check(
        "Fickian()",
        "Local(coefficient: -1)",
        "`coefficient` of the shifting is out of range",
        "Local(coefficient: -1)",
    );
    check(
        "Fickian()",
        "Fickian(drift_correction: Gone)",
        "`Gone` is not a choice for `drift_correction`",
        "Gone",
    );
    check("end: 1.0", "end: 0", "`end` must be finite and greater than 0", "0");
    check("cfl: 0.3", "cfl: 3", "`cfl` must be greater than 0 and at most `1`", "3");
    check("every: 0.1", "every: -1", "`every` must be finite and greater than 0", "-1");
}

#[test]
fn a_scheme_has_its_own_parameters_within_their_bounds() {
    let wcsph = "Wcsph(smoothing_ratio: 1.5, viscosity: Laminar(), shifting: Fickian())";
    for (field, value) in [
        ("shifting", "Fickian()"),
        ("viscosity", "Sps()"),
        ("tensile_control", "true"),
        ("integrator", "Verlet()"),
        ("noise_damping", "Off"),
    ] {
        let edac = format!("EdacTvf({field}: {value})");
        let report = check(wcsph, &edac, &format!("unknown field `{field}`"), field);
        assert!(report.contains("allowed: `kernel`, `smoothing_ratio`, `alpha`, `background`"), "{report}");
    }
    check(wcsph, "Wcsph(alpha: 0.5)", "unknown field `alpha`", "alpha");
    let never = "Verlet(corrective_step_every: 0)";
    let set = format!("Wcsph(integrator: {never})");
    check(wcsph, &set, "`corrective_step_every` must be at least 1", never);
    check(wcsph, "EdacTvf(alpha: -0.5)", "`alpha` of the scheme is out of range", "-0.5");
    check(wcsph, "EdacTvf(background: 11)", "`background` of the scheme is out of range", "11");
    check(wcsph, "EdacTvf(relaxation: 2)", "`relaxation` of the scheme is out of range", "2");
    check(wcsph, "EdacTvf(smoothing_ratio: 15)", "`smoothing_ratio` is out of range", "15");
    check(wcsph, "EdacTfv()", "`EdacTfv` is not a choice for `scheme`", "EdacTfv");
}

#[test]
fn speeds_of_the_sound_speed_are_faults() {
    check("\"v0 * y\"", "\"30 * y\"", "an inlet is as fast as sound", "Normal");
    let outlet = "an outlet is as fast as sound";
    check("WaveEquation()", "Characteristic(velocity: -10.0, pressure: 0.0)", outlet, "Characteristic");
    let pressure = "the pressure of an outlet is too large";
    check("WaveEquation()", "WaveEquation(pressure: Reference(-1e5))", pressure, "WaveEquation");
    check("WaveEquation()", "Hybrid(pressure: 1e12)", pressure, "Hybrid");
    let wcsph = "Wcsph(smoothing_ratio: 1.5, viscosity: Laminar(), shifting: Fickian())";
    let text = SOUND.replace(wcsph, "EdacTvf(background: 10)");
    let faults = faults_of(&text);
    assert_eq!(faults.faults()[0].title, "the time step is too long for the background pressure");
    if let Err(faults) = Scene::from_text("t", text.replace("cfl: 0.3", "cfl: 0.25")).load() {
        panic!("at the limit it is allowed: {faults:?}");
    }
}

#[test]
fn an_outlet_may_leave_its_condition_to_the_engine() {
    let text = SOUND.replace(", condition: WaveEquation()", "");
    assert_ne!(text, SOUND);
    let scene = Scene::from_text("test.ron", &text)
        .load()
        .unwrap_or_else(|faults| panic!("{:?}", miette::Report::new(faults)));
    let conditions: Vec<_> = scene.outlets.iter().map(|outlet| outlet.condition.clone()).collect();
    let usual = OutletCondition::WaveEquation(WaveEquation {
        frame: ReferenceFrame::Moving,
        transverse: TransverseOperator::Normalised,
        pressure: OutletPressure::NonReflecting { target: 0.0, time: None, waves: Waves::All },
    });
    assert_eq!(conditions, [usual]);
}

#[test]
fn a_wall_function_needs_a_viscosity() {
    let text = SOUND.replace("slip: NoSlip", "slip: WallFunction");
    let scene = Scene::from_text("test.ron", &text)
        .load()
        .unwrap_or_else(|faults| panic!("{:?}", miette::Report::new(faults)));
    assert!(scene.walls.parts.iter().all(|part| part.slip == Slip::WallFunction));
    let text = text.replace("viscosity: 1.0e-3", "viscosity: 0");
    let faults = faults_of(&text);
    let [fault] = faults.faults() else { panic!("{:?}", miette::Report::new(faults)) };
    assert_eq!(fault.title, "`WallFunction` needs a viscosity");
    assert_eq!(fault.span.and_then(|span| text.get(span.start..span.end)), Some("0"));
}

#[test]
fn mass_flow_inlet_takes_a_rate_in_time_and_a_profile_in_space() {
    let normal = "Normal(\"v0 * y\")";
    let report =
        check(normal, "MassFlow(rate: \"1 + y\")", "`rate` of an inlet must depend on t alone", "\"1 + y\"");
    assert!(report.contains("what varies over the plane goes into `profile`"), "{report}");
    let flux = "MassFlux(flux: 3, profile: \"y*t\")";
    let report = check(normal, flux, "`profile` of an inlet must depend on x, y and z alone", "\"y*t\"");
    assert!(report.contains("what varies in time goes into `flux`"), "{report}");
    let backwards = "MassFlow(rate: 1, profile: \"0.2 - y\")";
    check(normal, backwards, "`profile` of an inlet carries nothing into the domain", "\"0.2 - y\"");
    check(normal, "MassFlow(rate: \"1/(t - 0.5)\")", "a field is not finite", "\"1/(t - 0.5)\"");
    let report = check(normal, "MassFlow(rate: 1, mass: 1)", "unknown field `mass`", "mass");
    assert!(report.contains("allowed: `rate`, `profile`"), "{report}");
}

#[test]
fn body_must_be_a_wall_part_with_all_references() {
    let bodies = |body: &str| {
        format!(
            "walls: (slip: NoSlip, parts: [(name: \"lid\", region: Box(min: (0.0, 0.3), max: (1.0, 0.5)))]), bodies: [{body}]"
        )
    };
    let walls = "walls: (slip: NoSlip)";
    let report = check(walls, &bodies("(part: \"lit\")"), "the walls have no part `lit`", "\"lit\"");
    assert!(report.contains("did you mean `lid`?") && report.contains("`walls`"), "{report}");
    let lid = "\"lid\"";
    let report =
        check(walls, &bodies("(part: \"lid\", velocity: 1.0)"), "`area` of the body `lid` is missing", lid);
    assert!(report.contains("give `area`") && report.contains("or neither"), "{report}");
    check(walls, &bodies("(part: \"lid\", area: 1.0)"), "`velocity` of the body `lid` is missing", lid);
    check(walls, &bodies("(part: \"lid\", length: 1.0)"), "`velocity` of the body `lid` is missing", lid);
    check(
        walls,
        &bodies("(part: \"lid\", velocity: -2, area: 1.0)"),
        "`velocity` must be finite and greater",
        "-2",
    );
    let late = "(part: \"lid\", mean: (0.5, 2.5))";
    check(walls, &bodies(late), "the interval of a time mean is wrong", "(0.5, 2.5)");
    let far = bodies("(part: \"lid\")").replace("(0.0, 0.3), max: (1.0, 0.5)", "(5.0, 0.3), max: (6.0, 0.5)");
    check(walls, &far, "the body `lid` has no particles", lid);
    let ring = bodies("")
        .replace("max: (1.0, 0.5))", "max: (1.0, 0.5)), fill: Concentric(center: (0.5, 0.2), radius: 0.1)");
    check(walls, &ring, "the circle of `Concentric` is not the surface of the domain", "Concentric");
    // Filling a circle that is not part of the domain would take 100 TB.
    let huge = ring.replace("radius: 0.1", "radius: 1.0e11");
    check(walls, &huge, "the circle of `Concentric` is not the surface of the domain", "Concentric");
}

#[test]
fn output_of_nothing_is_a_fault() {
    let right = "output: (every: 0.1,";
    let fields = "output: (every: 0.1, fields: (volume: false),";
    check(right, fields, "the gridded fields have no grid", "(");
    let walls = "output: (every: 0.1, walls: (parts: []),";
    check(right, walls, "the quantities at the walls have no wall", "(");
}

#[test]
fn expression_faults_mark_their_token() {
    let report = check("\"v0 * y\"", "\"v0 * velo\"", "unknown name `velo`", "velo");
    assert!(report.contains("at Some((14, 88))"), "{report}");
    check("\"v0 * y\"", "\"v0 * * y\"", "a value is missing in the expression", "*");
    check("\"v0 * y\"", "\"min(v0)\"", "`min` has the wrong number of arguments", "min");
    check("\"y > 0.2\"", "\"(y > 0.2\"", "never closed", "(");
    check("\"H\")", "\"H + \")", "the expression ends too early", "");
    check("\"H\")", "\"x\")", "unknown name `x`", "x");
    check("\"H\": 0.4", "\"H\": \"G\"", "unknown name `G`", "G");
    check("\"H\": 0.4", "\"H\": \"0.4/0\"", "cannot be used", "0.4/0");
}

#[test]
fn fields_that_are_not_finite_are_faults() {
    let report = check("\"v0 * y\"", "\"v0 / (t - 0.5)\"", "a field is not finite", "\"v0 / (t - 0.5)\"");
    assert!(report.contains("t = 0.5 s"), "{report}");
    check(
        "velocity: (0.0, 0.0)",
        "velocity: (\"sqrt(x - 0.5)\", 0.0)",
        "a field is not finite",
        "\"sqrt(x - 0.5)\"",
    );
    check("pressure: 0.0", "pressure: \"1/0\"", "an expression is not finite", "\"1/0\"");
    check(
        "body_force: (0.0, 0.0)",
        "body_force: (\"ln(y - 0.1)\", 0.0)",
        "a field is not finite",
        "\"ln(y - 0.1)\"",
    );
    // A moment between any ten of the run.
    let narrow = "\"v0 * sqrt(abs(t - 0.653) - 0.004)\"";
    check("\"v0 * y\"", narrow, "a field is not finite", narrow);
    let parts = "walls: (parts: [(name: \"lid\", region: Box(min: (-1.0, 0.3), max: (2.0, 1.0)), \
                 velocity: (\"1e-5*sqrt(0.1 - t)\", 0.0))])";
    check("walls: (slip: NoSlip)", parts, "a field is not finite", "\"1e-5*sqrt(0.1 - t)\"");
    // The rest of the wall may be where the field of a part has no value.
    let lid = parts.replace("sqrt(0.1 - t)", "ln(y - 0.2)");
    let text = SOUND.replace("walls: (slip: NoSlip)", &lid);
    let scene = Scene::from_text("lid", text).load().expect("a scene");
    let [speed, ..] = &scene.walls.parts[1].velocity;
    assert!(speed.value(0.5, 0.1, 0.0, 0.0).is_nan(), "the rest of the wall has a value");
    assert!((speed.value(0.5, 0.4, 0.0, 0.0) - 1e-5 * 0.2_f64.ln()).abs() < 1e-15);
}

#[test]
fn vectors_have_as_many_components_as_the_scene_has_dimensions() {
    check(
        "max: (1.0, \"H\")",
        "max: (1.0, \"H\", 1.0)",
        "`max` has the wrong number of components",
        "(1.0, \"H\", 1.0)",
    );
    check("body_force: (0.0, 0.0)", "body_force: (0.0,)", "`body_force` has the wrong number", "(0.0,)");
}

#[test]
fn probes_have_unique_names_and_lie_in_the_domain() {
    let two = "probes: [(name: \"p\", kind: Point(at: (0.1, 0.2))), (name";
    check("probes: [(name", two, "two probes are called `p`", "\"p\"");
    check("Point(at: (0.5, 0.2))", "Point(at: (0.5, 2.0))", "probe `p` is outside the domain", "Point");
    check(
        "(0.5, 0.2)))",
        "(0.5, 0.2)), mean: (2.0, 1.0))",
        "the interval of a time mean is wrong",
        "(2.0, 1.0)",
    );
}

#[test]
fn names_are_apart_in_the_results() {
    let probes = |name: &str| format!("probes: [(name: \"{name}\", kind: Point(at: (0.1, 0.2))), (name");
    let same = "two probes have the same name in the results";
    // The name of the second is marked; letters beyond ASCII become `_`, case does not count.
    for (first, second) in [("a b", "a_b"), ("Gap", "gap"), ("ä", "ö")] {
        let between = format!(", (name: \"{second}\", kind: Point(at: (0.3, 0.2))), (name");
        let three = probes(first).replace(", (name", &between);
        let report = check("probes: [(name", &three, same, &format!("\"{second}\""));
        assert!(report.contains("case does not count"), "{report}");
    }
    let long = format!("\"{}\"", "n".repeat(250));
    check("\"p\"", &long, "a name among the probes is empty or too long", &long);
    check("\"p\"", "\"\"", "a name among the probes is empty or too long", "\"\"");
    // An opening without a name has a default one.
    let named = "outlets: [(name: \"outlet_1\", at: (0.5, 0.4), towards: (0.0, 1.0)), (at";
    check("outlets: [(at", named, "two outlets have the same name in the results", "\"outlet_1\"");
    let parts =
        "walls: (slip: NoSlip, parts: [(name: \"Walls\", region: Box(min: (0.0, 0.0), max: (0.1, 0.1)))])";
    check("walls: (slip: NoSlip)", parts, "two wall parts have the same name in the results", "\"Walls\"");
}

#[test]
fn faults_of_a_table_mark_the_text_of_the_table() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("speed.csv"), "# inflow\ntime,speed\n0.0,0.0\n0.5,fast\n0.4,1.0\n")
        .unwrap();
    std::fs::write(folder.path().join("profile.csv"), "0,-0.2,0.2\n0,1,1\n1,2\n").unwrap();
    let run = |velocity: &str| {
        let path = folder.path().join("scene.ron");
        std::fs::write(&path, SOUND.replace("Normal(\"v0 * y\")", velocity)).unwrap();
        match Scene::from_file(&path).load() {
            Ok(_) => panic!("{velocity} was taken"),
            Err(faults) => faults,
        }
    };
    let faults = run("TimeTable(file: \"speed.csv\")");
    let fault = &faults.faults()[0];
    assert_eq!(faults.position(fault), Some((4, 5)), "{fault:?}");
    assert!(fault.label.contains("is `fast`, must be a finite number"));
    let faults = run("ProfileTable(file: \"profile.csv\")");
    assert_eq!(faults.position(&faults.faults()[0]), Some((3, 1)), "{faults:?}");
    let faults = run("TimeTable(file: \"nowhere.csv\")");
    assert!(faults.faults()[0].title.contains("`nowhere.csv` cannot be read"));
    let faults = run("TimeTable(rows: [(0.0, 0.0), (0.0, 1.0)])");
    assert!(faults.faults()[0].title.contains("do not rise"));
}

#[test]
fn missing_file_is_a_fault() {
    let faults = Scene::from_file(std::path::Path::new("no/such/scene.ron")).load();
    assert!(faults.is_err_and(|f| f.faults()[0].title.contains("no/such/scene.ron")));
}

#[test]
fn the_exact_startup_needs_a_viscosity() {
    let text = SOUND.replace("Normal(\"v0 * y\")", "PoiseuilleStartup(body_force: 1.0)");
    let faults = faults_of(&text.replace("viscosity: 1.0e-3", "viscosity: 0"));
    assert!(faults.faults()[0].title.contains("needs a viscosity"), "{faults:?}");
}

#[test]
fn former_field_names_get_the_new_ones_as_advice() {
    let advice = |new: &str| {
        let faults = faults_of(&SOUND.replace("Fickian()", new));
        faults.faults().iter().filter_map(|fault| fault.help.clone()).collect::<Vec<_>>().join("; ")
    };
    assert!(advice("Fickian(drift: Removed)").contains("`drift_correction: On`"));
    assert!(advice("Local(drift: Kept)").contains("`drift_correction: Off`"));
    let laminar = faults_of(&SOUND.replace("Laminar()", "Laminar(printed: true)"));
    assert!(laminar.faults()[0].help.as_ref().is_some_and(|help| help.contains("`as_published`")));
}
