//! A state taken out of a flow and put into another world goes on to the same bits.

mod shipped;

use std::any::TypeId;
use std::path::Path;

use rayon::{ThreadPool, ThreadPoolBuilder};
use shipped::shipped;
use sphecs::arrays::Arrays;
use sphecs::bevy_ecs::resource::Resource;
use sphecs::bevy_ecs::schedule::{IntoScheduleConfigs, Schedule, Schedules};
use sphecs::bevy_ecs::world::World;
use sphecs::components::{
    Fluid, Inflow, Outflow, ParticleId, Position, Reservoir, Returned, SpsStress, Thermodynamics, Tracer,
    Velocity, Wall, WallSurface,
};
use sphecs::glam::DVec3;
use sphecs::math::column::Columns;
use sphecs::plugins::{Plugin, PluginContext};
use sphecs::resources::entity_index::{EntityIndex, FreeParticles};
use sphecs::resources::grid::{Grid, SortBuffers};
use sphecs::resources::ledger::Ledger;
use sphecs::resources::pair::Pair;
use sphecs::resources::pair_sums::Sums;
use sphecs::resources::scene::{ActiveScene, Resolution};
use sphecs::resources::state_location::StateLocation;
use sphecs::resources::stopwatch::Stopwatch;
use sphecs::saved_state::SavedResources;
use sphecs::scene::model::Scene;
use sphecs::scene::{load_smoke, load_str};
use sphecs::schedule::StepSet;
use sphecs::simulation::Simulation;
use sphecs::systems::body_forces::Bodies;
use sphecs::systems::boundaries::rows::PatchRows;
use sphecs::systems::divergence::{Failure, check_state};
use sphecs::systems::forces::AddedForces;
use sphecs::systems::transitions::TransitionLists;

/// Steps from one cut to the next: plain steps come round, particles change zone.
const STEPS: usize = 52;

fn smoke(path: &Path, sets: &[(&str, &str)]) -> Scene {
    let sets: Vec<(String, String)> =
        sets.iter().map(|(path, value)| ((*path).into(), (*value).into())).collect();
    load_smoke(path, &sets).unwrap_or_else(|faults| panic!("{}: {faults:?}", path.display()))
}

fn pool(threads: usize) -> ThreadPool {
    ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool of a few threads")
}

/// The columns in which two states differ.
fn differences(one: &Columns, other: &Columns) -> Vec<String> {
    let names: Vec<&str> = one.iter().map(|(name, _)| name).collect();
    assert!(other.iter().map(|(name, _)| name).eq(names), "two states have different columns");
    let both = one.iter().zip(other.iter());
    both.filter(|((_, a), (_, b))| a != b).map(|((name, _), _)| name.to_owned()).collect()
}

/// Crossings of inlet and outlet planes.
fn crossings(run: &Simulation) -> u64 {
    let ledger = run.ledger();
    [&ledger.entered, &ledger.entered_back, &ledger.left, &ledger.left_back].into_iter().flatten().sum()
}

/// Runs a scene, looks at it as outputs do, and cuts it where steps have been made and where a particle has just crossed
/// a plane. Every piece is carried on in a world of its own, with another number of threads.
fn check(name: &str, scene: impl Fn() -> Scene, faults: &mut Vec<String>) {
    let pools = [1, 2, 3].map(pool);
    let mut whole = Simulation::from_scene(scene());
    let mut pieces = None;
    for part in 0..3 {
        let mut steps = 0;
        while steps < STEPS {
            for run in std::iter::once(&mut whole).chain(pieces.as_mut()) {
                // Between outputs as well as at them.
                if run.clock().step.is_multiple_of(29) {
                    run.monitor_row();
                    run.sample(&[DVec3::ZERO]);
                }
                if run.clock().step.is_multiple_of(47) {
                    run.world_mut();
                }
            }
            let before = crossings(&whole);
            pools[0].install(|| whole.step().expect("a step"));
            if let Some(pieces) = &mut pieces {
                pools[(part + 1) % 3].install(|| pieces.step().expect("a step"));
            }
            steps += 1;
            // The second cut is made in the moment of an injection, if there is one.
            if part == 1 && crossings(&whole) > before {
                break;
            }
        }
        let state = whole.state();
        if let Some(pieces) = &mut pieces {
            let different = differences(&state, &pieces.state());
            if !different.is_empty() {
                faults.push(format!("{name}: after {part} cuts these differ: {}", different.join(", ")));
                return;
            }
        }
        let mut next = Simulation::from_state(scene(), state.clone(), &[])
            .unwrap_or_else(|misfit| panic!("{name}: {misfit}"));
        let different = differences(&state, &next.state());
        assert!(
            different.is_empty(),
            "{name}: a state is not what it was restored from: {}",
            different.join(", ")
        );
        pieces = Some(next);
    }
}

#[test]
fn every_shipped_scene_goes_on_to_the_same_bits() {
    let mut faults = Vec::new();
    for path in shipped() {
        check(&path.display().to_string(), || smoke(&path, &[]), &mut faults);
    }
    assert!(faults.is_empty(), "\n{}\n", faults.join("\n"));
}

#[test]
fn other_precisions_stresses_and_outlets_go_on_to_the_same_bits() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let mut faults = Vec::new();
    let variants: [(&str, &[(&str, &str)]); 14] = [
        ("quickstart.ron", &[("precision", "F32")]),
        ("duct3d.ron", &[("precision", "F32")]),
        ("quickstart.ron", &[("scheme", "Wcsph(viscosity: Sps())")]),
        ("taylor_green.ron", &[("scheme", "Wcsph(viscosity: Sps())"), ("precision", "F32")]),
        ("quickstart.ron", &[("scheme", "Wcsph(shifting: Local(), integrator: Verlet())")]),
        ("quickstart.ron", &[("outlets.0.condition", "Orlanski(pressure: Frozen)")]),
        (
            "quickstart.ron",
            &[("outlets.0.condition", "WaveEquation(pressure: Relaxed(target: 0.0, time: 0.1))")],
        ),
        ("quickstart.ron", &[("outlets.0.condition", "Hybrid()")]),
        ("quickstart.ron", &[("outlets.0.condition", "Hybrid()"), ("scheme", "EdacTvf()")]),
        ("quickstart.ron", &[("outlets.0.condition", "DoNothing")]),
        ("quickstart.ron", &[("outlets.0.condition", "DoNothing"), ("scheme", "EdacTvf()")]),
        ("quickstart.ron", &[("outlets.0.condition", "ModifiedDoNothing()"), ("precision", "F32")]),
        ("quickstart.ron", &[("outlets.0.condition", "Mirror()"), ("scheme", "EdacTvf()")]),
        ("quickstart.ron", &[("outlets.0.condition", "Characteristic(velocity: 0.1, pressure: 0.0)")]),
    ];
    for (name, sets) in variants {
        check(&format!("{name} {sets:?}"), || smoke(&scenes.join(name), sets), &mut faults);
    }
    assert!(faults.is_empty(), "\n{}\n", faults.join("\n"));
}

/// Particles that tremble on the inlet plane, and a reservoir that is empty at the start and grows.
const BREATHING: &str = r#"Scene(
    title: "Breathing channel", dimensions: 2, spacing: 0.01, smoke: 0.01,
    fluid: (density: 1000.0, viscosity: 1.0e-3, sound_speed: 4.0),
    domain: Box(min: (0.0, -0.05), max: (0.3, 0.05)),
    inlets: [(at: (0.0, 0.0), towards: (1.0, 0.0), velocity: Normal("0.3*sin(60*t)"))],
    outlets: [(at: (0.3, 0.0), towards: (1.0, 0.0), condition: WaveEquation())],
    reservoir: (particles: 0),
    initial: (tag: "x + 10*t"),
    time: (end: 1.0), output: (every: 1.0),
)"#;

/// Takes the breathing channel up from its state every 90 steps; the ledger, when all steps were the same.
#[track_caller]
fn go_on_side_by_side(sets: &[(&str, &str)], steps: u32) -> Ledger {
    let sets: Vec<(String, String)> =
        sets.iter().map(|(path, value)| ((*path).into(), (*value).into())).collect();
    let scene = || load_str("breathing", BREATHING, &sets).unwrap_or_else(|faults| panic!("{faults:?}"));
    let mut run = Simulation::from_scene(scene());
    let mut resumed = Simulation::from_scene(scene());
    for step in 0..steps {
        if step % 90 == 13 {
            let state = run.state();
            resumed = Simulation::from_state(scene(), state, &[]).unwrap_or_else(|misfit| panic!("{misfit}"));
        }
        run.step().expect("a step");
        resumed.step().expect("a step");
        let different = differences(&run.state(), &resumed.state());
        assert!(different.is_empty(), "step {step}: {}", different.join(", "));
    }
    run.ledger().clone()
}

#[test]
fn backflow_through_planes_and_a_growing_reservoir_go_on_to_the_same_bits() {
    let ledger = go_on_side_by_side(&[], 900);
    assert!(ledger.grown > 0 && ledger.entered_back[0] > 0 && ledger.left_back[0] > 0, "{ledger:?}");
}

/// Numbers are free in between.
#[test]
fn deleted_particles_and_free_numbers_go_on_to_the_same_bits() {
    let ledger = go_on_side_by_side(&[("reservoir", "(recycle: false)")], 500);
    assert!(ledger.created > 0 && ledger.deleted > 0 && ledger.grown == 0, "{ledger:?}");
}

/// A frame leaves the state in the components, and a world hands these out in an order of its own.
#[test]
fn a_state_taken_behind_a_frame_has_its_rows_in_the_same_order() {
    let scene = || load_str("breathing", BREATHING, &[]).unwrap_or_else(|faults| panic!("{faults:?}"));
    let mut run = Simulation::from_scene(scene());
    for _ in 0..200 {
        run.step().expect("a step");
    }
    assert!(crossings(&run) > 0, "every zone has changed");
    let state = run.state();
    let mut resumed = Simulation::from_state(scene(), state, &[]).unwrap_or_else(|misfit| panic!("{misfit}"));
    for step in 0..20 {
        for run in [&mut run, &mut resumed] {
            run.step().expect("a step");
            run.world_mut();
        }
        let different = differences(&run.state(), &resumed.state());
        assert!(different.is_empty(), "step {step}: {}", different.join(", "));
    }
}

#[test]
fn a_state_of_another_scene_is_refused_with_what_does_not_fit() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let quick = |sets: &[(&str, &str)]| smoke(&scenes.join("quickstart.ron"), sets);
    let state = Simulation::from_scene(quick(&[])).state();
    let refused = |scene: Scene, state: Columns, word: &str| {
        let misfit = Simulation::from_state(scene, state, &[]).err().expect(word).to_string();
        assert!(misfit.contains(word), "{misfit}");
    };
    refused(quick(&[("precision", "F32")]), state.clone(), "f32");
    refused(smoke(&scenes.join("duct3d.ron"), &[]), state.clone(), "grid");
    refused(quick(&[("inlets", "[]")]), state.clone(), "inflow");
    for name in ["arrays.id", "particle.tag", "stored.id", "record.clock", "grid.lower"] {
        let mut incomplete = Columns::default();
        for (known, column) in state.iter().filter(|(known, _)| *known != name) {
            incomplete.put_column(known, column.clone());
        }
        refused(quick(&[]), incomplete, name);
    }
    let mut foreign = state.clone();
    foreign.put("record.weather", vec![0_u8]);
    refused(quick(&[]), foreign, "record.weather");
    for (name, value) in [("arrays.zone", 9_u8), ("arrays.zone", 4), ("arrays.zone", 3)] {
        let mut wrong = Columns::default();
        for (known, column) in state.iter().filter(|(known, _)| *known != name) {
            wrong.put_column(known, column.clone());
        }
        let mut zones = state.clone().take::<u8>(name).expect("zones");
        zones[0] = value;
        wrong.put(name, zones);
        assert!(Simulation::from_state(quick(&[]), wrong, &[]).is_err(), "a zone `{value}` was taken");
    }
    let mut ids = state.clone().take::<u32>("arrays.id").expect("ids");
    for (from, to) in [(ids[0], ids[1]), (ids[0], u32::MAX)] {
        let mut wrong = Columns::default();
        for (known, column) in state.iter().filter(|(known, _)| *known != "arrays.id") {
            wrong.put_column(known, column.clone());
        }
        ids[0] = to;
        wrong.put("arrays.id", ids.clone());
        ids[0] = from;
        refused(quick(&[]), wrong, "particle");
    }
}

/// What a world has that no state keeps, and why it need not.
fn not_kept() -> Vec<(TypeId, &'static str)> {
    vec![
        (TypeId::of::<ActiveScene>(), "the scene"),
        (TypeId::of::<Resolution>(), "from the scene"),
        (TypeId::of::<Pair>(), "from the scene"),
        (TypeId::of::<Grid<2>>(), "its box is kept, its cells are sorted anew in every step"),
        (TypeId::of::<Schedules>(), "the program"),
        (TypeId::of::<SavedResources>(), "the program"),
        (TypeId::of::<Seen>(), "of this test"),
        (TypeId::of::<AddedForces>(), "the program: a plugin adds them again"),
        (TypeId::of::<Stopwatch>(), "wall time"),
        (TypeId::of::<Arrays<f64, 2>>(), "kept as columns"),
        (TypeId::of::<FreeParticles>(), "kept as a column"),
        (TypeId::of::<EntityIndex>(), "entities are seats"),
        (TypeId::of::<StateLocation>(), "both homes are fresh in a restored world"),
        (TypeId::of::<Failure>(), "a flow that failed is not kept"),
        (TypeId::of::<PatchRows>(), "collected anew at each sort"),
        (TypeId::of::<SortBuffers<f64>>(), "buffer"),
        (TypeId::of::<Sums<f64, 2>>(), "summed anew in every step"),
        (TypeId::of::<Bodies>(), "summed anew in every step, from what the scene says"),
        (TypeId::of::<TransitionLists>(), "buffer"),
        (TypeId::of::<ParticleId>(), "kept: number of a column"),
        (TypeId::of::<Position>(), "kept: arrays and reservoir"),
        (TypeId::of::<Velocity>(), "kept: arrays and reservoir"),
        (TypeId::of::<Thermodynamics>(), "kept: arrays and reservoir"),
        (TypeId::of::<Tracer>(), "kept: columns"),
        (TypeId::of::<Fluid>(), "kept: zone"),
        (TypeId::of::<Wall>(), "kept: zone and patch"),
        (TypeId::of::<WallSurface>(), "kept: columns"),
        (TypeId::of::<Inflow>(), "kept: zone and patch"),
        (TypeId::of::<Returned>(), "kept: a flag"),
        (TypeId::of::<Outflow>(), "kept: zone and patch"),
        (TypeId::of::<Reservoir>(), "kept: reservoir"),
        (TypeId::of::<SpsStress>(), "summed anew before anybody reads it"),
    ]
}

/// Types of components and resources that a world knew in a step.
#[derive(Resource, Default)]
struct Seen(Vec<(TypeId, String)>);

/// Looks at the world from inside the step: reading from outside would add bevy's own notes of the systems that do it.
struct Look;

fn types(world: &World) -> Vec<(TypeId, String)> {
    let infos = world.components().iter_registered();
    infos.filter_map(|(_, info)| Some((info.type_id()?, info.name().to_string()))).collect()
}

fn look(world: &mut World) {
    let seen = Seen(types(world));
    world.insert_resource(seen);
}

impl Plugin for Look {
    fn build(&self, parts: &mut PluginContext<'_>) {
        parts.world.init_resource::<Seen>();
        // Behind the engine's own check, with which it would be ambiguous.
        parts.step.add_systems(look.in_set(StepSet::Observe).after(check_state::<f64, 2>));
    }
}

#[test]
fn nothing_that_lives_across_steps_is_forgotten() {
    let sets = [("scheme".to_owned(), "Wcsph(viscosity: Sps())".to_owned())];
    let scene = load_str("breathing", BREATHING, &sets).unwrap_or_else(|faults| panic!("{faults:?}"));
    let mut run = Simulation::with_plugins(scene, &[&Look]);
    (0..300).for_each(|_| run.step().expect("a step"));
    assert!(run.ledger().entered_back[0] > 0, "no particle came back");
    let world = run.world();
    let kept: Vec<TypeId> = world.resource::<SavedResources>().types().collect();
    assert!(kept.len() >= 8, "only {} resources are kept", kept.len());
    let mut bare = World::new();
    // An empty schedule would not be built.
    let mut schedule = Schedule::default();
    schedule.add_systems(|| {});
    schedule.run(&mut bare);
    let of_bevy: Vec<TypeId> = types(&bare).into_iter().map(|(type_id, _)| type_id).collect();
    let not_kept: Vec<TypeId> = not_kept().into_iter().map(|(type_id, _)| type_id).collect();
    let known = [of_bevy, kept, not_kept].concat();
    let forgotten: Vec<&(TypeId, String)> =
        world.resource::<Seen>().0.iter().filter(|(type_id, _)| !known.contains(type_id)).collect();
    assert!(
        forgotten.is_empty(),
        "neither kept by `PluginContext::keep` nor named in `not_kept` with a reason: {forgotten:?}; \
         `cargo test --features debug` shows the names"
    );
}
