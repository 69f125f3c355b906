//! Scenes built in Rust: the same as their files, with the same checks.

use std::fmt::Debug;

use miette::NarratableReportHandler;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::gridded::{gridded_fields, wall_quantities};
use super::schema_fields::{self, Names};
use super::shipped::scene;
use crate::builder::{
    BendSection, Body, Concentric, EdacTvf, Emitter, Fields, Fluid, Formula, Initial, Inlet, InletVelocity,
    Lattice, MassFlow, MassFlux, Motion, Mover, Number, Outlet, Output, Packed, PoiseuilleStartup, Probe,
    Reference, Reservoir, Rotation, SceneBuilder, Shape, Time, Translation, Turning, Vector, WallFill,
    WallFitted, WallPart, Walls, Wcsph, ron_text,
};
use crate::expression::Constants;
use crate::faults::SceneErrors;
use crate::meshes::LengthUnit;
use crate::model::{ForcesEvery, Precision, ProbeSight, Scene, WhenEmpty};
use crate::notation::{reader, typed};
use crate::rings::FirstRing;
use crate::schema::SceneFile;
use crate::seeds;
use sphecs_core::boundary::inlet::{Feed, InletPressure};
use sphecs_core::boundary::outlet::OutletCondition;
use sphecs_core::boundary::patch::Extent;
use sphecs_core::math::kernel::Kernel;
use sphecs_core::physics::integrator::Integrator;
use sphecs_core::physics::shifting::Shifting;
use sphecs_core::physics::viscosity::reconstructed::NoiseDamping;
use sphecs_core::physics::viscosity::{Viscosity, laminar::Laminar};
use sphecs_core::physics::wall::{Slip, WallModel};

fn sound(scene: Result<Scene, SceneErrors>) -> Scene {
    scene.unwrap_or_else(|faults| panic!("{:?}", miette::Report::new(faults)))
}

/// The scene of `scenes/quickstart.ron`.
fn quickstart() -> SceneBuilder {
    let block = |bottom, top| Shape::cuboid((0.06, bottom), (0.10, top));
    let inflow = "v0 * 0.5*(1 - cos(pi*min(t/t0, 1))) * (1 - 4*y^2/D^2)";
    let section = |name, x| Probe::section(name, (x, 0.0), (1.0, 0.0)).mean((1.0, 2.0));
    let output = Output::at_interval(0.05).fields(Fields::default().mean((1.0, 2.0)));
    let axis = Probe::line("axis", (0.0, 0.0), ("L", 0.0), 81).mean((1.0, 2.0));
    Scene::builder(2)
        .name("quickstart")
        .title("Channel with a constriction")
        .spacing(1.25e-3)
        .smoke(2.5e-3)
        .constant("v0", 0.1)
        .constant("t0", 0.5)
        .constant("D", 0.04)
        .constant("d", 0.02)
        .constant("L", 0.2)
        .fluid(Fluid::new().density(1000.0).viscosity(1.0e-5).sound_speed(2.0))
        .domain(Shape::difference([
            Shape::cuboid((0.0, "-D/2"), ("L", "D/2")),
            block("d/2", "D"),
            block("-D", "-d/2"),
        ]))
        .initial(Initial::new().tag("y > 0"))
        .inlet(Inlet::new((0.0, 0.0), (1.0, 0.0), InletVelocity::normal(inflow)))
        .outlet(Outlet::new(("L", 0.0), (1.0, 0.0)).condition(OutletCondition::default()))
        .time(Time::until(2.0))
        .reference(Reference::new().velocity("2/3*v0*D/d").length("d"))
        .output(output.probe(section("inlet", 0.02)).probe(section("gap", 0.08)).probe(axis))
}

/// A closed box with what a scene requires and nothing more.
fn closed_box() -> SceneBuilder {
    Scene::builder(2)
        .spacing(0.05)
        .constant("H", 0.4)
        .fluid(Fluid::new().density(1000.0).viscosity(1e-3).sound_speed(10.0))
        .domain(Shape::cuboid((0.0, 0.0), (1.0, "H")))
        .time(Time::until(1.0))
        .output(Output::at_interval(0.1))
}

/// The box with an inlet and an outlet.
fn channel() -> SceneBuilder {
    closed_box()
        .inlet(Inlet::new((0.0, 0.2), (1.0, 0.0), InletVelocity::normal(1.0)))
        .outlet(Outlet::new((1.0, 0.2), (1.0, 0.0)))
}

/// Returns the report of faults, with the lines of the scene that they mark.
fn shown(faults: &SceneErrors) -> String {
    let mut text = String::new();
    NarratableReportHandler::new().render_report(&mut text, faults).unwrap();
    text
}

#[test]
fn a_built_scene_equals_that_of_its_file() {
    let [built, read] = [sound(quickstart().build()), scene("quickstart.ron")];
    assert_eq!(seeds(&built), seeds(&read));
    // All other fields: the `Debug` text of a number is that of no other number.
    let [built, read] = [built, read].map(|scene| format!("{:#?}", Scene { text: String::new(), ..scene }));
    assert_eq!(built, read);
}

#[test]
fn the_text_of_a_built_scene_is_a_scene_file() {
    let built = sound(quickstart().build());
    assert_eq!(built.text, quickstart().to_ron());
    let read = sound(Scene::from_text("quickstart", &built.text).load());
    assert_eq!(format!("{built:?}"), format!("{read:?}"));
}

#[test]
fn all_faults_of_a_built_scene_are_reported_with_their_places() {
    let faults = channel()
        .spacing(-0.05)
        .domain(Shape::cuboid((0.0, 0.0), ("length", "H")))
        .scheme(Wcsph::new().smoothing_ratio(0.1))
        .time(Time::until(0.0))
        .build()
        .unwrap_err();
    let text = shown(&faults);
    let titles: Vec<&str> = faults.faults().iter().map(|fault| fault.title.as_str()).collect();
    assert_eq!(titles.len(), 4, "{text}");
    for (place, message) in [
        ("spacing: -0.05", "`spacing` must be finite and greater than 0"),
        ("\"length\"", "`length`"),
        ("smoothing_ratio: 0.1", "`smoothing_ratio`"),
        ("end: 0.0", "`end` must be finite and greater than 0"),
    ] {
        assert!(text.contains(place) && text.contains(message), "{place}: {message} in\n{text}");
    }
    assert!(faults.faults().iter().all(|fault| faults.position(fault).is_some()), "{text}");
}

#[test]
fn an_inlet_outside_the_domain_is_reported_beside_other_faults() {
    let outside = Inlet::new((0.0, 2.0), (1.0, 0.0), InletVelocity::normal("speed"));
    let faults = channel().inlet(outside).output(Output::at_interval("nothing")).build().unwrap_err();
    let text = shown(&faults);
    assert_eq!(faults.faults().len(), 3, "{text}");
    for place in ["at: (0.0, 2.0)", "Normal(\"speed\")", "every: \"nothing\""] {
        assert!(text.contains(place), "{place} in\n{text}");
    }
}

#[test]
fn missing_parts_are_the_faults_of_a_file_without_them() {
    let faults = Scene::builder(2).inlet(Inlet::default()).fluid(Fluid::new()).build().unwrap_err();
    let titles: Vec<String> = faults.faults().iter().map(|fault| fault.title.clone()).collect();
    let missing = |field: &&str| !titles.contains(&format!("field `{field}` is missing"));
    let required = ["spacing", "domain", "time", "output", "velocity", "density", "viscosity", "sound_speed"];
    assert_eq!(required.iter().copied().filter(missing).collect::<Vec<_>>(), [""; 0], "{titles:?}");
}

#[test]
fn tables_and_changed_values_reach_the_loader() {
    let table = ("speeds.csv", "0,0.1\n1,0.2\n");
    let inlet = Inlet::new((0.0, 0.2), (1.0, 0.0), InletVelocity::time_table_file(table.0));
    let scene = closed_box().inlet(inlet).table(table.0, table.1);
    let built = sound(scene.loader().set("fluid.viscosity", 2e-3).load());
    assert_eq!(built.fluid.viscosity, 2e-3);
    assert_eq!(built.tables, [(table.0.to_owned(), table.1.to_owned())]);
}

/// Regions of every kind.
fn regions() -> [Shape; 15] {
    let unit = || Shape::cuboid((0.0, 0.0), (1.0, 1.0));
    let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    let bend = |section| Shape::bend((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 2.0, 0.0), 90, section);
    [
        Shape::circle((0.0, "R"), "R"),
        Shape::sphere((0.0, 0.0, 0.0), 1.0),
        Shape::cylinder((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 0.5),
        Shape::polygon(corners),
        Shape::extruded(corners, 0.0, "R"),
        bend(BendSection::circular(0.1)),
        bend(BendSection::rectangular(0.1, "R")),
        Shape::union([unit(), unit()]),
        Shape::intersection([unit(), unit()]),
        unit().translated((1.0, "R")),
        unit().rotated(Rotation::new(30.0).axis((0.0, 0.0, 1.0)).about((1.0, 0.0))).rotated("R"),
        unit().scaled(2.0),
        Shape::mesh("pipe.stl", LengthUnit::Millimetre),
        Shape::mesh_of(["wall.stl", "ends.stl"], LengthUnit::Inch),
        Shape::outline("naca0012.csv", LengthUnit::Metre),
    ]
}

/// Velocities of every kind.
fn velocities() -> [InletVelocity; 7] {
    [
        InletVelocity::components(("1 - y^2", 0.0)),
        InletVelocity::time_table([(0.0, "R"), (1.0, "2*R")]),
        InletVelocity::time_table_file("speeds.csv"),
        InletVelocity::profile_table("profile.csv"),
        MassFlow::new("2*t").profile("1 - y^2").into(),
        MassFlux::new(3.0).profile("1 - y^2").into(),
        PoiseuilleStartup::new(0.1).half_width("R").into(),
    ]
}

/// Motions of every kind.
fn motions() -> Motion {
    Motion::chain([
        Translation::by(("t", 0.0)).into(),
        Translation::with_velocity(("t", 0.0)).into(),
        Translation::default().file("path.csv").into(),
        Turning::at_rate((0.0, 0.0), "t").into(),
        Turning::default().about((0.0, 0.0)).file("angle.csv").into(),
    ])
}

/// A scene in which every field of the schema occurs, though no flow has all of them.
fn complete() -> SceneBuilder {
    let rings = Concentric::new((0.0, 0.0), "R").first(FirstRing::Circumference);
    let part = WallPart::new("drum", Shape::difference([Shape::circle((0.0, 0.0), "R")]))
        .slip(Slip::FreeSlip)
        .velocity(("-y", "x"))
        .fill(rings);
    let body = Body::new("drum").about((0.0, 0.0)).velocity(1.0).area("2*R").length(0.1);
    let walls = Walls::new().model(WallModel::default()).slip(Slip::NoSlip).velocity((0.0, 0.0));
    let walls = walls.fill(WallFill::Layers).motion(Turning::by((0.0, 0.0), "t").axis((0.0, 0.0, 1.0)));
    let walls = walls.one_sided(true).part(part);
    let opening = Inlet::default()
        .name("left")
        .depth("5*R")
        .pressure(InletPressure::default())
        .feed(Feed::Once)
        .extent(Extent::Whole)
        .on("in")
        .closed(true);
    let jet = Emitter::on_surface("piston", MassFlow::new(1.0)).name("jet").depth("5*R");
    let outlet = Outlet::new((0.0, 0.0), (1.0, 0.0)).name("right").depth(1.0).on("out").closed(false);
    let scene = quickstart()
        .precision(Precision::F32)
        .constant("R", 0.1)
        .scheme(
            Wcsph::new()
                .kernel(Kernel::QuinticSpline)
                .smoothing_ratio(1.5)
                .viscosity(Viscosity::Laminar(Laminar::default()))
                .noise_damping(NoiseDamping::Off)
                .shifting(Shifting::Off)
                .tensile_control(false)
                .integrator(Integrator::KickDrift),
        )
        .fill(Lattice::new().angle(0.0).axis((0.0, 0.0, 1.0)).anchor((0.0, "R")).jitter(0.1))
        .walls(walls)
        .mover(
            Mover::new("piston", Shape::circle((0.0, 0.0), "R"), motions())
                .slip(Slip::NoSlip)
                .fill(WallFill::Layers),
        )
        .body(body.mean((0.5, "10*R")).five_point_mean(true))
        .initial(Initial::new().velocity(("y", 0.0)).pressure("1000*y").tag(1.0))
        .outlet(outlet.extent(Extent::Connected))
        .emitter(jet.region(Shape::circle((0.0, 0.0), "R")))
        .periodic("y")
        .body_force((0.0, "-9.81"))
        .reservoir(Reservoir::new().particles(100).when_empty(WhenEmpty::Stop).recycle(false))
        .time(Time::until(1.0).cfl(0.3).viscous(0.1))
        .output(
            Output::at_interval(0.1)
                .monitor_every(0.01)
                .forces(ForcesEvery::Row)
                .checkpoint_every(60)
                .fields(gridded_fields())
                .walls(wall_quantities())
                .probe(Probe::point("point", (0.0, "R")).sees(ProbeSight::Flow))
                .probe(Probe::line("line", (0.0, 0.0), (1.0, 0.0), 11).every("R/10").mean((0.0, "R")))
                .probe(Probe::section("section", (0.0, 0.0), (1.0, 0.0))),
        );
    let at = |velocity| opening.clone().at((0.0, 0.0)).towards((1.0, 0.0)).velocity(velocity);
    velocities().into_iter().fold(scene, |scene, velocity| scene.inlet(at(velocity)))
}

/// Scenes that together have every field and variant of the schema.
fn complete_scenes() -> Vec<SceneBuilder> {
    let edac = EdacTvf::new()
        .kernel(Kernel::WendlandC2)
        .smoothing_ratio("1 + R")
        .alpha(0.5)
        .background(1.0)
        .average_pressure(true)
        .lattice_normalised(true)
        .relaxation(0.1)
        .as_published(false);
    let other = complete().without_walls().scheme(edac).fill(WallFitted::new("-1 - x", "1 + x"));
    let packed = complete().fill(Packed::new().angle(10.0).axis((0.0, 0.0, 1.0)).anchor((0.0, 0.0)));
    let mut scenes = vec![complete(), other, packed];
    scenes.extend(regions().map(|region| complete().domain(region)));
    scenes
}

/// Reads a type from a text; panics on a fault.
fn read_back<T: DeserializeOwned>(text: &str) -> T {
    let reading = reader::read(text);
    let mut constants = Constants::default();
    for name in ["R", "v0", "t0", "D", "d", "L"] {
        constants.define(name, 1.0);
    }
    let (value, faults) = typed::read(&reading.root, &constants);
    let all: Vec<_> =
        reading.faults.iter().chain(&faults).map(|fault| (&fault.title, &fault.label)).collect();
    assert!(all.is_empty(), "{all:?} in\n{text}");
    value.unwrap()
}

/// Checks that all values of a type that the builder takes as it is are read back from their text;
/// returns their names.
fn shared<T: DeserializeOwned + Serialize + PartialEq + Debug>() -> Names {
    let (values, names) = schema_fields::all::<T>();
    for value in values {
        let text = ron_text(&value);
        assert_eq!(read_back::<T>(&text), value, "{text}");
    }
    names
}

#[test]
fn every_field_of_a_scene_file_can_be_built() {
    let mut shared_names = Names::new();
    for names in [
        shared::<Precision>(),
        shared::<WhenEmpty>(),
        shared::<ForcesEvery>(),
        shared::<ProbeSight>(),
        shared::<FirstRing>(),
        shared::<Feed>(),
        shared::<Extent>(),
        shared::<InletPressure>(),
        shared::<OutletCondition>(),
        shared::<Kernel>(),
        shared::<Integrator>(),
        shared::<Shifting>(),
        shared::<Viscosity>(),
        shared::<NoiseDamping>(),
        shared::<Slip>(),
        shared::<LengthUnit>(),
        shared::<WallModel>(),
    ] {
        shared_names.extend(names);
    }
    let mut built = Names::new();
    for scene in complete_scenes() {
        let text = scene.to_ron();
        let _: SceneFile = read_back(&text);
        built.extend(schema_fields::given::<SceneFile>(&reader::read(&text).root));
    }
    let (_, schema) = schema_fields::all::<SceneFile>();
    assert!(schema.contains("Scene.domain") && schema.contains("ShapeFile::Bend.section"), "{schema:?}");
    let own: Names = schema.difference(&shared_names).cloned().collect();
    let missing: Vec<_> = own.difference(&built).collect();
    assert!(missing.is_empty(), "the builder writes none of {missing:#?}");
}

#[test]
fn numbers_are_read_back_bit_by_bit() {
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut random = || {
        // Marsaglia (2003), xorshift64.
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        f64::from_bits(state)
    };
    let mut numbers: Vec<f64> = (0..500).map(|_| random()).filter(|number| number.is_finite()).collect();
    numbers.extend([0.0, -0.0, 0.1, 1.0, 1e16, f64::MIN_POSITIVE, f64::MAX, f64::EPSILON, 5e-324]);
    assert!(numbers.len() > 400);
    let text = ron_text(&numbers.iter().map(|number| Number::from(*number)).collect::<Vec<_>>());
    let read: Vec<f64> = read_back(&text);
    let bits = |numbers: &[f64]| numbers.iter().map(|number| number.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&read), bits(&numbers));
}

#[test]
fn numbers_that_are_not_finite_are_faults_of_the_scene() {
    for number in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let faults = closed_box().spacing(number).build().unwrap_err();
        assert!(faults.faults()[0].title.contains("`spacing` must be finite"), "{:?}", faults.faults());
    }
}

#[test]
fn texts_with_quotes_and_signs_are_read_back() {
    let title = "Re = 270, \"Δ\" \\ it's\n\t½";
    assert_eq!(sound(closed_box().title(title).build()).title, title);
}

#[test]
fn vectors_are_made_of_tuples_arrays_and_glam() {
    let text = |vector: Vector| ron_text(&vector);
    assert_eq!(text(("L", 0.5).into()), "(\"L\", 0.5)");
    assert_eq!(text((1, "-L", 0.25).into()), "(1.0, \"-L\", 0.25)");
    assert_eq!(text([0.5, 1.0].into()), text(glam::DVec2::new(0.5, 1.0).into()));
    assert_eq!(text([0.5, 1.0, 2.0].into()), text(glam::DVec3::new(0.5, 1.0, 2.0).into()));
    assert_eq!(ron_text(&Formula::from("x + t")), "\"x + t\"");
}
