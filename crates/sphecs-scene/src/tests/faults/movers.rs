//! Faults of walls that move.

use crate::Scene;

/// Returns the faults of a scene with these fields, as text.
fn faults(fields: &str) -> String {
    let text = format!(
        r#"Scene(
    title: "Movers", dimensions: 2, spacing: 0.05,
    fluid: (density: 1000.0, viscosity: 1e-3, sound_speed: 20.0),
    {fields}
    reference: (velocity: 1.0),
    time: (end: 1.0), output: (every: 0.5),
)"#
    );
    let errors = Scene::from_text("movers", text).load().err();
    let faults = errors.iter().flat_map(|errors| errors.faults());
    let texts = faults.map(|fault| format!("{} | {} | {:?}", fault.title, fault.label, fault.help));
    texts.collect::<Vec<_>>().join("\n")
}

const CLOSED: &str = "domain: Box(min: (0.0, 0.0), max: (4.0, 2.0)),";

const OPEN: &str = "domain: Box(min: (0.0, 0.0), max: (4.0, 2.0)),
    outlets: [(name: \"end\", at: (4.0, 1.0), towards: (1.0, 0.0))],";

fn body(shape: &str, motion: &str) -> String {
    format!("movers: [(name: \"body\", shape: {shape}, motion: {motion})],")
}

const DISC: &str = "Circle(center: (2.0, 1.0), radius: 0.4)";

#[test]
fn motions_are_given_in_one_way_and_depend_on_time() {
    let cases = [
        ("Translation()", "has 0 of `displacement`, `velocity` or `file`"),
        ("Translation(displacement: (\"t\", 0.0), velocity: (0.0, 0.0))", "has 2 of"),
        ("Translation(displacement: (\"t\"))", "has 1, must have 2"),
        ("Translation(displacement: (\"x*t\", 0.0))", "`x` cannot be in a motion"),
        ("Translation(displacement: (\"sqrt(t)\", 0.0))", "no finite place, velocity or acceleration"),
        ("Translation(velocity: (\"1/(t - 0.5)\", 0.0))", "not finite"),
        ("Translation(file: \"missing.csv\")", "cannot be read"),
        ("Rotation(about: (2.0, 1.0))", "has 0 of `radians`, `rate` or `file`"),
        ("Rotation(about: (2.0, 1.0), axis: (0.0, 1.0), radians: \"t\")", "`axis` has no meaning in 2D"),
        ("Chain([])", "a chain has no motions"),
    ];
    for (motion, expected) in cases {
        let found = faults(&format!("{CLOSED} {}", body(DISC, motion)));
        assert!(found.contains(expected), "{motion}: {found}");
        assert_eq!(found.lines().count(), 1, "{motion}: {found}");
    }
    let sound = body(
        DISC,
        "Chain([Rotation(about: (2.0, 1.0), rate: \"t\"), Translation(velocity: (\"0.2*t\", 0.0))])",
    );
    assert_eq!(faults(&format!("{CLOSED} {sound}")), "");
}

#[test]
fn paths_that_a_body_cannot_take_are_refused() {
    let path = |shape: &str, motion: &str| format!("{OPEN} {}", body(shape, motion));
    let cases = [
        (path(DISC, "Translation(displacement: (\"30*t\", 0.0))"), "a wall is as fast as sound"),
        (path(DISC, "Translation(displacement: (\"3*t\", 0.0))"), "enters the zone of `end`"),
        (path(DISC, "Translation(displacement: (0.0, \"t\"))"), "the mover `body` enters a wall"),
        (
            format!(
                "{CLOSED} {}",
                body("Box(min: (-2.0, 0.0), max: (0.5, 2.0))", "Translation(displacement: (\"0.3*t\", 0.0))")
            ),
            "movers change the volume of a closed domain",
        ),
    ];
    for (fields, expected) in cases {
        let found = faults(&fields);
        assert!(found.contains(expected), "{fields}: {found}");
    }
    // A plate as thin as a spacing holds no particle of the wall that it enters; a path whose
    // period is a 32nd of the run is seen, too.
    let plate = path("Box(min: (1.5, 0.975), max: (2.5, 1.025))", "Translation(velocity: (0.0, 1.5))");
    assert!(faults(&plate).contains("the mover `body` enters a wall"), "{}", faults(&plate));
    let quick = path(DISC, "Translation(displacement: (0.0, \"0.09*sin(64*pi*t)\"))");
    assert_eq!(faults(&quick), "");
    let quick = path(
        "Box(min: (1.9, 1.79), max: (2.1, 1.99))",
        "Translation(displacement: (0.0, \"0.09*sin(64*pi*t)\"))",
    );
    assert!(faults(&quick).contains("the mover `body` enters a wall"), "{}", faults(&quick));
    // A blade about a spacing thick that turns leaves the fluid its volume.
    let blade = format!(
        "domain: Circle(center: (0.0, 0.0), radius: 0.5), walls: (one_sided: true), {}",
        body(
            "Box(min: (-0.45, -0.025), max: (0.45, 0.025))",
            "Rotation(about: (0.0, 0.0), rate: \"2*tanh(2*t)\")"
        )
    );
    assert_eq!(faults(&blade), "");
    // A piston slides along the walls and out of the end of the domain; a rod turns in a wall.
    let piston =
        path("Box(min: (-2.0, 0.0), max: (0.5, 2.0))", "Translation(displacement: (\"0.3*t\", 0.0))");
    assert_eq!(faults(&piston), "");
    let rod = path("Circle(center: (2.0, 0.0), radius: 0.4)", "Rotation(about: (2.0, 0.0), rate: 1.0)");
    assert_eq!(faults(&rod), "");
}

#[test]
fn settings_that_walls_that_move_do_not_have_are_refused() {
    let still = body(DISC, "Translation(displacement: (0.0, 0.0))");
    let turning = "motion: Rotation(about: (2.0, 1.0), rate: 1.0)";
    let cases = [
        (
            format!("{CLOSED} {still} walls: (model: Image(pressure: Mirrored)),"),
            "cannot mirror the pressure",
        ),
        (format!("{CLOSED} {still} fill: WallFitted(lower: 0.0, upper: 2.0),"), "cannot go around movers"),
        (
            format!("{CLOSED} {still} walls: None, periodic: [\"x\", \"y\"],"),
            "a scene without walls has movers",
        ),
        (format!("{CLOSED} walls: ({turning}), periodic: [\"x\"],"), "all walls move, but openings do not"),
        (format!("{OPEN} walls: ({turning}),"), "all walls move, but openings do not"),
        (format!("{CLOSED} walls: ({turning}, velocity: (1.0, 0.0)),"), "has a motion and a velocity"),
        (
            format!(
                "{CLOSED} movers: [(name: \"walls\", shape: {DISC}, motion: Translation(velocity: (0.0, 0.0)))],"
            ),
            "two wall parts are called `walls`",
        ),
        (
            format!(
                "{CLOSED} movers: [(name: \"body\", shape: {DISC}, motion: Translation(velocity: (0.0, 0.0)), \
                 fill: Concentric(center: (2.0, 1.0), radius: 0.3))],"
            ),
            "the circle of `Concentric` is not the surface",
        ),
    ];
    for (fields, expected) in cases {
        let found = faults(&fields);
        assert!(found.contains(expected), "{fields}: {found}");
    }
}

#[test]
fn movers_must_not_run_into_each_other() {
    let two = |motion: &str, other: &str| {
        faults(&format!(
            "{OPEN} movers: [
                (name: \"left\", shape: Circle(center: (1.0, 1.0), radius: 0.4), motion: {motion}),
                (name: \"right\", shape: Circle(center: (2.0, 1.0), radius: 0.4), motion: {other}),
            ],"
        ))
    };
    let (rest, right) = ("Translation(displacement: (0.0, 0.0))", "Translation(displacement: (\"t\", 0.0))");
    let found = two(right, rest);
    assert!(found.contains("the mover `left` runs into `right`") && found.contains("t = 0.25"), "{found}");
    assert!(!two(rest, rest).contains("runs into") && !two(rest, right).contains("runs into"));
    // Parts of one body overlap from the start.
    let parts = faults(&format!(
        "{OPEN} movers: [
            (name: \"hub\", shape: Circle(center: (1.5, 1.0), radius: 0.3), motion: {right}),
            (name: \"arm\", shape: Box(min: (1.4, 0.5), max: (1.6, 1.5)), motion: {right}),
        ],"
    ));
    assert!(!parts.contains("runs into"), "{parts}");
}
