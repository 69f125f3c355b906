//! Faults of names, kinds and syntax.

use super::check;

#[test]
fn unknown_names_get_the_nearest_as_advice() {
    let report = check("viscosity: 1.0e-3", "viscosty: 1.0e-3", "unknown field `viscosty`", "viscosty");
    assert!(report.contains("did you mean `viscosity`?"), "{report}");
    let report = check("NoSlip", "NoSlipp", "`NoSlipp` is not a choice for `slip`", "NoSlipp");
    assert!(report.contains("did you mean `NoSlip`? allowed: `NoSlip`, `FreeSlip`"), "{report}");
    let report = check("WaveEquation()", "WaveEqation()", "is not a choice for `condition`", "WaveEqation");
    assert!(report.contains("did you mean `WaveEquation`?"), "{report}");
    let report = check("WaveEquation()", "Periodic", "is not a choice for `condition`", "Periodic");
    assert!(report.contains("leave them out and write `periodic:"), "{report}");
    let report = check("Fickian()", "Fickian(coeficient: 2.0)", "unknown field", "coeficient");
    assert!(report.contains("did you mean `coefficient`?"), "{report}");
    check("Scene(", "Szene(", "has the wrong name", "Szene");
}

#[test]
fn inlets_of_given_pressure_lead_to_outlets() {
    for pressure in ["4.0", "\"4*sin(t)\""] {
        let inlet = format!("inlets: [(pressure: {pressure}, at");
        let report = check("inlets: [(at", &inlet, "is not one of the choices `Extrapolated`", pressure);
        assert!(
            report.contains("write it under `outlets`") && report.contains("Pressure(value: "),
            "{report}"
        );
    }
    let report =
        check("velocity: Normal", "velocity: Windkessel", "is not a choice for `velocity`", "Windkessel");
    assert!(report.contains("write it under `outlets`") && report.contains("as `condition`"), "{report}");
}

#[test]
fn missing_and_repeated_fields_are_faults() {
    check("sound_speed: 10.0", "", "field `sound_speed` is missing", "(");
    check("title: \"t\",", "", "field `title` is missing", "Scene");
    check("smoke: 0.1,", "smoke: 0.1, smoke: 0.2,", "field `smoke` is given twice", "smoke");
}

#[test]
fn values_of_the_wrong_kind_are_faults() {
    check("spacing: 0.05", "spacing: [0.05]", "`spacing` is not a number", "[");
    check("spacing: 0.05", "spacing: true", "`spacing` is not a number", "true");
    check("title: \"t\"", "title: t", "`title` is not text in quotes", "t");
    check("dimensions: 2", "dimensions: 2.5", "is not a whole number", "2.5");
    check("slip: NoSlip", "slip: 3", "is not one of the choices `NoSlip`", "3");
    check("walls: (slip: NoSlip)", "walls: 7", "is not a bracket with named fields", "7");
    check("inlets: [(at", "inlets: [3, (at", "is not a bracket with named fields", "3");
    check("(0.5, 0.2)", "0.5", "`at` is not a list", "0.5");
    check("{\"v0\": 1.0, \"H\": 0.4}", "{\"v0\": [1.0], \"H\": 0.4}", "constant `v0` is not a number", "[");
    check("{\"v0\": 1.0", "{\"x\": 1.0, \"v0\": 1.0", "`x` cannot be the name of a constant", "\"x\"");
}

#[test]
fn syntax_faults_mark_their_position() {
    check("spacing: 0.05,", "spacing: ,", "a value is missing", ",");
    let report = check("spacing: 0.05,", "spacing: −0.05,", "a minus sign is not plain", "−");
    assert!(report.contains("U+2212") && report.contains("must be `-`"), "{report}");
    let report = check("name: \"p\"", "name: “p”", "a quote is not plain", "“");
    assert!(report.contains("must be `\"`"), "{report}");
    check("spacing: 0.05,", "spacing: 0.0.5,", "`0.0.5` is not a number", "0.0.5");
    check("spacing: 0.05,", "spacing: 2*0.05,", "an expression has no quotes", "2*0.05");
    check("spacing: 0.05,", "spacing: 0.05", "a comma is missing", "s");
    check("title: \"t\"", "title: \"\\q\"", "unknown escape", "\\q");
    check("(slip: NoSlip)", "(slip: NoSlip]", "brackets do not match", "]");
    check("periodic: [],", "/* periodic: [],", "a comment never ends", "/*");
}
