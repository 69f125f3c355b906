//! Bitwise identical continuation of a flow from its saved state in another world.

mod common;

use std::any::TypeId;
use std::path::Path;

use common::{in_parallel, shipped_scenes, simulation, smoke_scene, text_scene};
use rayon::{ThreadPool, ThreadPoolBuilder};
use sphecs::bevy_ecs::resource::Resource;
use sphecs::bevy_ecs::schedule::{IntoScheduleConfigs, Schedule, Schedules};
use sphecs::bevy_ecs::world::World;
use sphecs::glam::DVec3;
use sphecs::{Ledger, Scene, Simulation, StepSet};
use sphecs_core::math::column::Columns;
use sphecs_engine::arrays::Arrays;
use sphecs_engine::components::{
    Fluid, Inflow, Outflow, ParticleId, Position, Reservoir, SpsStress, Thermodynamics, Tracer, Velocity,
    Wall, WallSurface,
};
use sphecs_engine::plugins::{Plugin, PluginContext};
use sphecs_engine::resources::entity_index::{EntityIndex, FreeParticles};
use sphecs_engine::resources::grid::{Grid, SortBuffers};
use sphecs_engine::resources::inflow_particles::InflowParticles;
use sphecs_engine::resources::pair::Pair;
use sphecs_engine::resources::pair_sums::Sums;
use sphecs_engine::resources::scene::ActiveScene;
use sphecs_engine::resources::state_location::StateLocation;
use sphecs_engine::resources::stopwatch::Stopwatch;
use sphecs_engine::saved_state::SavedResources;
use sphecs_engine::systems::body_forces::Bodies;
use sphecs_engine::systems::boundaries::emitter_states::EmitterStates;
use sphecs_engine::systems::boundaries::movers::{MoverParticles, PresentPoses};
use sphecs_engine::systems::boundaries::opening_regions::OpeningRegions;
use sphecs_engine::systems::boundaries::outlet_registry::AddedOutlets;
use sphecs_engine::systems::boundaries::patch_rows::PatchRows;
use sphecs_engine::systems::divergence::{Failure, check_state};
use sphecs_engine::systems::forces::AddedForces;
use sphecs_engine::systems::transitions::TransitionLists;

/// Steps between two saved states, which include corrective steps and changes of zone.
const STEPS: usize = 52;

fn pool(threads: usize) -> ThreadPool {
    ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool of a few threads")
}

/// Returns the names of the columns in which two states differ.
fn differences(one: &Columns, other: &Columns) -> Vec<String> {
    let names: Vec<&str> = one.iter().map(|(name, _)| name).collect();
    assert!(other.iter().map(|(name, _)| name).eq(names), "two states have different columns");
    let both = one.iter().zip(other.iter());
    both.filter(|((_, a), (_, b))| a != b).map(|((name, _), _)| name.to_owned()).collect()
}

/// Returns the number of crossings of inlet and outlet planes.
fn crossings(run: &Simulation) -> u64 {
    let ledger = run.ledger();
    [&ledger.entered, &ledger.entered_back, &ledger.left, &ledger.left_back].into_iter().flatten().sum()
}

/// Runs a scene with reads as for output, and restores its state twice into another world with
/// another number of threads: after a fixed number of steps and directly after a particle crossed a
/// plane. Returns the columns that differ.
fn check(name: &str, scene: &Scene) -> Option<String> {
    let pools = [1, 2, 3].map(pool);
    let mut whole = simulation(scene.clone());
    let mut pieces = None;
    for part in 0..3 {
        let mut steps = 0;
        while steps < STEPS {
            for run in std::iter::once(&mut whole).chain(pieces.as_mut()) {
                // At intervals that differ from those of the saved states.
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
            // The second state is saved in the step of an injection, if there is one.
            if part == 1 && crossings(&whole) > before {
                break;
            }
        }
        let state = whole.state();
        if let Some(pieces) = &mut pieces {
            let different = differences(&state, &pieces.state());
            if !different.is_empty() {
                let different = different.join(", ");
                return Some(format!("{name}: after {part} restored states these differ: {different}"));
            }
        }
        let mut next = Simulation::builder(scene.clone())
            .state(state.clone())
            .build()
            .unwrap_or_else(|mismatch| panic!("{name}: {mismatch}"));
        let different = differences(&state, &next.state());
        assert!(
            different.is_empty(),
            "{name}: the restored state differs from the saved one: {}",
            different.join(", ")
        );
        pieces = Some(next);
    }
    None
}

/// Checks scenes, several at once, and fails with all faults.
#[track_caller]
fn check_all<I: Sync>(scenes: &[I], scene: impl Fn(&I) -> (String, Scene) + Sync) {
    let faults = in_parallel(scenes, |item| {
        let (name, scene) = scene(item);
        check(&name, &scene)
    });
    let faults: Vec<String> = faults.into_iter().flatten().collect();
    assert!(faults.is_empty(), "\n{}\n", faults.join("\n"));
}

#[test]
fn every_shipped_scene_resumes_bitwise_identically() {
    check_all(&shipped_scenes(), |path| (path.display().to_string(), smoke_scene(path, &[])));
}

#[test]
fn other_precisions_stresses_and_outlets_resume_bitwise_identically() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let variants: [(&str, &[(&str, &str)]); 21] = [
        ("quickstart.ron", &[("precision", "F32")]),
        ("duct3d.ron", &[("precision", "F32")]),
        ("quickstart.ron", &[("scheme", "Wcsph(viscosity: Sps())")]),
        ("quickstart.ron", &[("scheme", "Wcsph(viscosity: Sps())"), ("walls", "(model: Dummy)")]),
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
        ("windkessel.ron", &[("scheme", "EdacTvf()"), ("precision", "F32")]),
        ("pressure_poiseuille.ron", &[("scheme", "EdacTvf()")]),
        ("intake.ron", &[("precision", "F32")]),
        ("quickstart.ron", &[("outlets.0.condition", "Resistance(resistance: 10.0)")]),
        (
            "orientation.ron",
            &[
                ("fill", "Lattice(angle: 0.0)"),
                ("walls", "(slip: FreeSlip, fill: Layers)"),
                ("precision", "F32"),
            ],
        ),
        ("duct3d.ron", &[("walls", "(slip: FreeSlip, fill: Layers)")]),
    ];
    check_all(&variants, |(name, sets)| (format!("{name} {sets:?}"), smoke_scene(&scenes.join(name), sets)));
}

/// Channel with particles that oscillate across the inlet plane, and a reservoir that is empty at
/// the start.
const OSCILLATING: &str = r#"Scene(
    title: "Oscillating channel", dimensions: 2, spacing: 0.01, smoke: 0.01,
    fluid: (density: 1000.0, viscosity: 1.0e-3, sound_speed: 4.0),
    domain: Box(min: (0.0, -0.05), max: (0.3, 0.05)),
    inlets: [(at: (0.0, 0.0), towards: (1.0, 0.0), velocity: Normal("0.3*sin(60*t)"))],
    outlets: [(at: (0.3, 0.0), towards: (1.0, 0.0), condition: WaveEquation())],
    reservoir: (particles: 0),
    initial: (tag: "x + 10*t"),
    time: (end: 1.0), output: (every: 1.0),
)"#;

/// Restores the oscillating channel from its state every 90 steps; returns the particle counts at
/// the end.
#[track_caller]
fn check_side_by_side(sets: &[(&str, &str)], steps: u32) -> Ledger {
    let scene = || text_scene("oscillating", OSCILLATING, sets);
    let mut run = simulation(scene());
    let mut resumed = simulation(scene());
    for step in 0..steps {
        if step % 90 == 13 {
            let state = run.state();
            resumed = Simulation::builder(scene())
                .state(state)
                .build()
                .unwrap_or_else(|mismatch| panic!("{mismatch}"));
        }
        run.step().expect("a step");
        resumed.step().expect("a step");
        let different = differences(&run.state(), &resumed.state());
        assert!(different.is_empty(), "step {step}: {}", different.join(", "));
    }
    run.ledger().clone()
}

#[test]
fn backflow_and_a_growing_reservoir_resume_bitwise_identically() {
    let ledger = check_side_by_side(&[], 900);
    assert!(ledger.grown > 0 && ledger.entered_back[0] > 0 && ledger.left_back[0] > 0, "{ledger:?}");
}

#[test]
fn deleted_particles_and_free_numbers_resume_bitwise_identically() {
    let ledger = check_side_by_side(&[("reservoir", "(recycle: false)")], 500);
    assert!(ledger.created > 0 && ledger.deleted > 0 && ledger.grown == 0, "{ledger:?}");
}

/// After a frame the components are current, and their order in a world differs from that of the
/// rows.
#[test]
fn state_saved_after_a_frame_keeps_the_order_of_its_rows() {
    let scene = || text_scene("oscillating", OSCILLATING, &[]);
    let mut run = simulation(scene());
    for _ in 0..200 {
        run.step().expect("a step");
    }
    assert!(crossings(&run) > 0, "no zone has changed");
    let state = run.state();
    let mut resumed =
        Simulation::builder(scene()).state(state).build().unwrap_or_else(|mismatch| panic!("{mismatch}"));
    for step in 0..20 {
        for run in [&mut run, &mut resumed] {
            run.step().expect("a step");
            run.world_mut();
        }
        let different = differences(&run.state(), &resumed.state());
        assert!(different.is_empty(), "step {step}: {}", different.join(", "));
    }
}

/// A body that turns and moves through a periodic face, with a piston's outlet beside it.
const MOVING: &str = r#"Scene(
    title: "Moving", dimensions: 2, spacing: 0.05, smoke: 0.05,
    fluid: (density: 1000.0, viscosity: 0.05, sound_speed: 20.0),
    domain: Box(min: (-1.0, -0.8), max: (1.0, 0.8)),
    movers: [(
        name: "paddle", shape: Box(min: (-0.3, -0.1), max: (0.3, 0.1)), slip: FreeSlip,
        motion: Chain([
            Rotation(about: (0.0, 0.0), rate: "20*t"),
            Translation(displacement: ("3*t^2", "0.05*sin(20*t)")),
        ]),
    )],
    bodies: [(part: "paddle")], periodic: ["x"],
    reference: (velocity: 2.0, length: 1.0), time: (end: 1.0), output: (every: 1.0),
)"#;

/// In the resumed run the components are changed by a caller now and then.
#[test]
fn walls_that_move_resume_bitwise_identically_after_frames() {
    for sets in [&[][..], &[("scheme", "EdacTvf()"), ("precision", "F32")]] {
        let scene = || text_scene("moving", MOVING, sets);
        let mut run = simulation(scene());
        for _ in 0..300 {
            run.step().expect("a step");
        }
        let resumed = Simulation::builder(scene()).state(run.state()).build();
        let mut resumed = resumed.unwrap_or_else(|mismatch| panic!("{mismatch}"));
        for step in 0..100 {
            run.step().expect("a step");
            run.world();
            resumed.step().expect("a step");
            if step % 7 == 0 {
                resumed.world_mut();
            }
            assert_eq!(run.body_forces(), resumed.body_forces(), "step {step}");
        }
        // A state is in the order of the numbers if a caller may have changed components.
        run.world_mut();
        resumed.world_mut();
        let different = differences(&run.state(), &resumed.state());
        assert!(different.is_empty(), "{}", different.join(", "));
    }
}

#[test]
fn state_of_another_scene_is_refused_with_the_mismatch() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let quick = |sets: &[(&str, &str)]| smoke_scene(&scenes.join("quickstart.ron"), sets);
    let state = simulation(quick(&[])).state();
    let refused = |scene: Scene, state: Columns, word: &str| {
        let mismatch = Simulation::builder(scene).state(state).build().err().expect(word).to_string();
        assert!(mismatch.contains(word), "{mismatch}");
    };
    refused(quick(&[("precision", "F32")]), state.clone(), "f32");
    refused(smoke_scene(&scenes.join("duct3d.ron"), &[]), state.clone(), "grid");
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
        assert!(Simulation::builder(quick(&[])).state(wrong).build().is_err(), "a zone `{value}` was taken");
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

/// Returns the resources and components that are not saved, each with the reason.
fn not_saved() -> Vec<(TypeId, &'static str)> {
    vec![
        (TypeId::of::<ActiveScene>(), "the scene"),
        (TypeId::of::<Pair>(), "from the scene"),
        (TypeId::of::<Grid<2>>(), "its box is saved, its cells are sorted in every step"),
        (TypeId::of::<Schedules>(), "the program"),
        (TypeId::of::<SavedResources>(), "the program"),
        (TypeId::of::<Registered>(), "of this test"),
        (TypeId::of::<AddedForces>(), "the program: a plugin adds them again"),
        (TypeId::of::<AddedOutlets>(), "the program: a plugin adds them again"),
        (TypeId::of::<Stopwatch>(), "wall-clock time"),
        (TypeId::of::<Arrays<f64, 2>>(), "saved as columns"),
        (TypeId::of::<FreeParticles>(), "saved as a column"),
        (TypeId::of::<EntityIndex>(), "a restored world has other entities"),
        (TypeId::of::<InflowParticles>(), "saved as zones and flags of the particles"),
        (TypeId::of::<StateLocation>(), "components and arrays agree in a restored world"),
        (TypeId::of::<Failure>(), "a diverged flow is not saved"),
        (TypeId::of::<PatchRows>(), "collected at each sort"),
        (TypeId::of::<OpeningRegions>(), "follows from the scene and the domains"),
        (TypeId::of::<PresentPoses>(), "from the scene and the time"),
        (TypeId::of::<MoverParticles>(), "saved in scenes with walls that move"),
        (TypeId::of::<EmitterStates>(), "saved in scenes with emitters"),
        (TypeId::of::<SortBuffers<f64>>(), "buffer"),
        (TypeId::of::<Sums<f64, 2>>(), "summed in every step"),
        (TypeId::of::<Bodies>(), "summed in every step with settings of the scene"),
        (TypeId::of::<TransitionLists>(), "buffer"),
        (TypeId::of::<ParticleId>(), "saved: number of a column"),
        (TypeId::of::<Position>(), "saved: arrays and reservoir"),
        (TypeId::of::<Velocity>(), "saved: arrays and reservoir"),
        (TypeId::of::<Thermodynamics>(), "saved: arrays and reservoir"),
        (TypeId::of::<Tracer>(), "saved: columns"),
        (TypeId::of::<Fluid>(), "saved: zone"),
        (TypeId::of::<Wall>(), "saved: zone and patch"),
        (TypeId::of::<WallSurface>(), "saved: columns"),
        (TypeId::of::<Inflow>(), "saved: zone and patch"),
        (TypeId::of::<Outflow>(), "saved: zone and patch"),
        (TypeId::of::<Reservoir>(), "saved: reservoir"),
        (TypeId::of::<SpsStress>(), "summed before it is read"),
    ]
}

/// Types of the components and resources of a world during a step.
#[derive(Resource, Default)]
struct Registered(Vec<(TypeId, String)>);

/// Lists the types from inside a step: from outside, bevy would register those of the reading
/// systems too.
struct Inspect;

fn types(world: &World) -> Vec<(TypeId, String)> {
    let infos = world.components().iter_registered();
    infos.filter_map(|(_, info)| Some((info.type_id()?, info.name().to_string()))).collect()
}

fn inspect(world: &mut World) {
    let seen = Registered(types(world));
    world.insert_resource(seen);
}

impl Plugin for Inspect {
    fn build(&self, context: &mut PluginContext<'_>) {
        context.world.init_resource::<Registered>();
        // After the check of the engine, relative to which its order would be ambiguous.
        context.step.add_systems(inspect.in_set(StepSet::Observe).after(check_state::<f64, 2>));
    }
}

#[test]
fn every_resource_that_persists_is_saved_or_listed() {
    let sets = [("scheme", "Wcsph(viscosity: Sps())")];
    let scene = text_scene("oscillating", OSCILLATING, &sets);
    let mut run = Simulation::builder(scene).plugin(Inspect).build().expect("a simulation");
    (0..300).for_each(|_| run.step().expect("a step"));
    assert!(run.ledger().entered_back[0] > 0, "no particle returned");
    let world = run.world();
    let saved: Vec<TypeId> = world.resource::<SavedResources>().types().collect();
    assert!(saved.len() >= 8, "only {} resources are saved", saved.len());
    let mut bare = World::new();
    // bevy does not build an empty schedule.
    let mut schedule = Schedule::default();
    schedule.add_systems(|| {});
    schedule.run(&mut bare);
    let of_bevy: Vec<TypeId> = types(&bare).into_iter().map(|(type_id, _)| type_id).collect();
    let not_saved: Vec<TypeId> = not_saved().into_iter().map(|(type_id, _)| type_id).collect();
    let known = [of_bevy, saved, not_saved].concat();
    let unsaved: Vec<&(TypeId, String)> =
        world.resource::<Registered>().0.iter().filter(|(type_id, _)| !known.contains(type_id)).collect();
    assert!(
        unsaved.is_empty(),
        "neither saved by `PluginContext::save_resource` nor listed in `not_saved` with a reason: {unsaved:?}; \
         `cargo test --features debug` shows the names"
    );
}
