//! Bitwise identical results for any number of ranks and threads, and with reads between the steps.

mod census;
mod common;

use std::path::{Path, PathBuf};

use census::{Particle, census};
use common::{in_parallel, shipped_scenes, smoke_scene, text_scene};
use rayon::ThreadPoolBuilder;
use sphecs::glam::{DMat3, DVec3};
use sphecs::{Simulation, SimulationBuilder};
use sphecs_core::pass::grid_rows::{NodeFields, NodeRow, RowSink};
use sphecs_core::pass::section::Section;
use sphecs_core::pass::surface_flow::{Friction, SurfacePoint};
use sphecs_output::frame::Frame;
use sphecs_run::ranks::in_process::Followers;
use sphecs_scene::model::ProbeSight;
use sphecs_scene::seeds;

/// Least and largest number of steps of each run, which include many changes of zone and corrective
/// steps.
const STEPS: [u64; 2] = [60, 240];

/// Particles times steps of a run between these numbers: a large scene has many changes in a step.
const PARTICLE_STEPS: u64 = 600_000;

/// Steps of the runs with reads between the steps.
const STEPS_WITH_READS: usize = 35;

/// Returns simulations of a scene file at its smoke spacing, from particles that are placed once.
fn simulations<const N: usize>(path: &Path) -> [Simulation; N] {
    let scene = smoke_scene(path, &[]);
    let particles = seeds(&scene);
    [(); N].map(|()| {
        let builder = Simulation::builder(scene.clone()).particles(particles.clone());
        builder.build().expect("a scene without plugins can be built")
    })
}

/// Returns every bit of a particle: `==` would equate −0 and 0.
fn bits(particle: &Particle) -> [u64; 17] {
    let vectors = [particle.position, particle.velocity, particle.previous_velocity];
    let vectors = vectors.map(|v| v.to_array().map(f64::to_bits));
    let [density, pressure] = [particle.density, particle.pressure].map(f64::to_bits);
    let [zone, patch] = [particle.zone as u64, u64::from(particle.patch)];
    let [passages, needs_restart] = [u64::from(particle.passages), u64::from(particle.needs_restart)];
    let tag = u64::from(particle.tag.to_bits());
    let scalars = [density, pressure, tag, zone, patch, passages, needs_restart, u64::from(particle.id)];
    let mut all = [0; 17];
    for (to, from) in all.iter_mut().zip(vectors.as_flattened().iter().chain(&scalars)) {
        *to = *from;
    }
    all
}

/// Returns the first particle that differs in a bit, with both of its states.
fn difference(one: &mut Simulation, other: &mut Simulation) -> Option<String> {
    let (a, b) = (one.clock(), other.clock());
    if (a.time.to_bits(), a.step) != (b.time.to_bits(), b.step) {
        return Some(format!("{a:?}, other {b:?}"));
    }
    let (a, b) = (census(one), census(other));
    if a.len() != b.len() {
        return Some(format!("{} particles, other {}", a.len(), b.len()));
    }
    a.iter().zip(&b).find(|(a, b)| bits(a) != bits(b)).map(|(a, b)| format!("{a:?}\nother {b:?}"))
}

/// Returns every bit of the frame that is written of a simulation.
fn frame_bits(run: &mut Simulation) -> Vec<u64> {
    let frame = Frame::of(run);
    let wide = frame.position.into_iter().flatten().map(f64::to_bits);
    let narrow = frame.velocity.into_iter().chain([frame.density, frame.pressure, frame.tag]).flatten();
    let zones = frame.zone.into_iter().map(u64::from).chain(frame.patch.into_iter().map(u64::from));
    let counts = frame.passage.into_iter().chain([frame.moving_walls.start, frame.moving_walls.end]);
    let head = [frame.time.to_bits(), frame.step, frame.time_step.to_bits()];
    let all = head.into_iter().chain(wide).chain(narrow.map(|x| u64::from(x.to_bits())));
    all.chain(zones).chain(counts.map(u64::from)).collect()
}

/// Ranks of 2 threads each that share the steps of a scene, by its place in the list: each number
/// of ranks has scenes of its own, so that the test stays short.
const RANKS: [usize; 4] = [3, 2, 5, 4];

#[test]
fn shipped_scenes_are_bitwise_identical_for_any_number_of_ranks_and_threads() {
    let scenes: Vec<(usize, PathBuf)> = shipped_scenes().into_iter().enumerate().collect();
    in_parallel(&scenes, |(place, path)| {
        let pools = [1, 2].map(|threads| {
            ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool of a few threads")
        });
        let [mut one, mut other] = simulations(path);
        let steps = (PARTICLE_STEPS / one.ledger().total()).clamp(STEPS[0], STEPS[1]);
        pools[0].install(|| (0..steps).for_each(|_| one.step().expect("a step")));
        let ranks = RANKS[place % RANKS.len()];
        // New domains every seventh step.
        let followers = Followers::start_changing(&mut other, ranks, 2, Some(7)).expect("a few threads");
        // The simulation is dropped first, with which the other ranks end.
        let mut led = (other, followers);
        pools[1].install(|| {
            for step in 0..steps {
                led.0.step().expect("a step");
                match step % 13 {
                    2 => drop(led.0.state()),
                    // Rank 0 gets the particles of all for this.
                    4 => drop(led.0.particles()),
                    9 => drop(frame_bits(&mut led.0)),
                    5 => drop(led.0.sample(&[DVec3::ZERO])),
                    _ => {}
                }
            }
        });
        assert!(led.0.traffic().iter().all(|rank| rank.messages > steps), "the ranks share no pass");
        for (pool, simulation) in pools.iter().zip([&mut one, &mut led.0]) {
            pool.install(|| simulation.step().expect("a step"));
        }
        // What is written, before and after rank 0 gets the particles of all, and all that a
        // checkpoint has, in its order.
        assert!(one.state() == led.0.state(), "{}: the states differ on {ranks} ranks", path.display());
        assert!(frame_bits(&mut one) == frame_bits(&mut led.0), "{}: frames differ", path.display());
        let places = places_of(&mut one);
        let expected = readings(&mut one, &places);
        assert_eq!(readings(&mut led.0, &places), expected, "{}: 1 rank and {ranks} differ", path.display());
        assert!(one.state() == led.0.state(), "{}: the states differ on {ranks} ranks", path.display());
        let rows = [readings(&mut one, &places), readings(&mut led.0, &places)];
        assert_eq!(rows[0], rows[1], "{}: 1 rank and {ranks} differ", path.display());
        assert!(one.particles() == led.0.particles(), "{}: 1 rank and {ranks} differ", path.display());
        assert!(frame_bits(&mut one) == frame_bits(&mut led.0), "{}: frames differ", path.display());
    });
}

/// Returns places in and beside a flow, m: close to particles, far outside, and nowhere.
fn places_of(run: &mut Simulation) -> Vec<DVec3> {
    let aside = DVec3::new(0.3, 0.1, 0.0) * run.scene().spacing;
    let near = run.particles().position.into_iter().step_by(53).map(|place| place + aside);
    near.chain([DVec3::splat(1e9), DVec3::splat(-1e3), DVec3::NAN]).collect()
}

/// Returns everything that is written of a flow but frames, at places, m, with every bit of the
/// numbers.
fn readings(run: &mut Simulation, places: &[DVec3]) -> String {
    let row = run.monitor_row();
    let sight = |at: usize| if at.is_multiple_of(3) { ProbeSight::Flow } else { ProbeSight::Fluid };
    let probes: Vec<_> = places.iter().enumerate().map(|(at, &place)| (place, sight(at))).collect();
    let (samples, pressures) = (run.sample_seeing(&probes), run.sample_pressure(&probes));
    let on_surface = |&position: &DVec3| SurfacePoint {
        position,
        normal: DVec3::Y,
        velocity: DVec3::X,
        gradient: DMat3::IDENTITY,
        friction: Friction::NoSlip,
    };
    let surface = run.sample_surface(&places.iter().map(on_surface).collect::<Vec<_>>());
    let (spacing, dimensions) = (run.scene().spacing, run.scene().dimensions);
    let inside = &places[..places.len() - 3];
    let periods = run.scene().periodic.map(|ends| ends.map(|(lower, upper)| upper - lower));
    let section =
        |normal| Section::new(inside[inside.len() / 2], normal, inside, spacing, periods, dimensions);
    let flows = run.mass_flows(&[&section(DVec3::X), &section(DVec3::Y)]);
    assert!(samples.iter().any(Option::is_some) && pressures.len() == places.len());
    let fields = grid_fields(run, inside);
    format!("{row:?} {samples:?} {pressures:?} {surface:?} {flows:?} {:?} {fields:?}", run.body_forces())
}

/// Fields of a row of nodes.
#[derive(Clone, Default)]
struct RowFields(Vec<NodeFields>);

impl RowSink for RowFields {
    fn take(&mut self, fields: &[NodeFields]) {
        self.0.extend_from_slice(fields);
    }
}

/// Returns the fields in rows of nodes through the places of a flow, m, and beyond its ends: their
/// groups of nodes belong to several ranks.
fn grid_fields(run: &mut Simulation, inside: &[DVec3]) -> Vec<NodeFields> {
    let spacing = run.scene().spacing;
    let (low, high) =
        inside.iter().fold((inside[0], inside[0]), |(low, high), &place| (low.min(place), high.max(place)));
    let step = DVec3::new(0.9, 0.05, 0.0) * spacing;
    let nodes = ((high.x - low.x) / step.x) as usize + 8;
    let row = |place: usize| {
        let at = low + (high - low) * (place as f64 / 6.0);
        let start = DVec3::new(low.x - 3.5 * spacing, at.y, at.z);
        NodeRow { start, step, wanted: (0..nodes).map(|node| node % 11 != 3).collect() }
    };
    let rows: Vec<NodeRow> = (0..7).map(row).collect();
    let mut found = vec![RowFields::default(); rows.len()];
    let mut sinks: Vec<&mut dyn RowSink> = found.iter_mut().map(|row| row as &mut dyn RowSink).collect();
    let has_tags = run.scene().has_tags();
    run.sample_rows(&rows, &mut sinks, has_tags);
    let fields: Vec<NodeFields> = found.into_iter().flat_map(|row| row.0).collect();
    assert!(fields.len() == 7 * nodes && fields.iter().any(|node| node.pressure.is_finite()));
    fields
}

/// Channel with enough rows for several tasks per pass, with inlet, outlet, walls and a body force
/// by a formula.
const CHANNEL: &str = r#"Scene(
    title: "Channel", dimensions: 2, spacing: 0.005, smoke: 0.01,
    fluid: (density: 1000.0, viscosity: 1.0e-3, sound_speed: 10.0),
    scheme: Wcsph(smoothing_ratio: 1.5),
    domain: Box(min: (0.0, -0.15), max: (1.2, 0.15)),
    body_force: ("0.1*cos(y)", "0"),
    inlets: [(at: (0.0, 0.0), towards: (1.0, 0.0), velocity: Normal("min(20*t, 1)*(1 - 40*y^2)"))],
    outlets: [(at: (1.2, 0.0), towards: (1.0, 0.0), condition: WaveEquation())],
    time: (end: 1.0), output: (every: 1.0),
)"#;

/// At smoke spacing the shipped scenes have few rows per pass.
#[test]
fn many_rows_are_bitwise_identical_for_any_number_of_threads_and_ranks() {
    check_many_rows(&[]);
    check_many_rows(&[("outlets.0.condition", "Hybrid()"), ("scheme", "EdacTvf()")]);
    check_many_rows(&[("outlets.0.condition", "Mirror()")]);
    let windkessel = "Windkessel(proximal: 10.0, compliance: 1e-4, distal: 100.0)";
    check_many_rows(&[("outlets.0.condition", windkessel)]);
}

#[track_caller]
fn check_many_rows(sets: &[(&str, &str)]) {
    let mut runs = [(1, 1), (3, 1), (1, 4)].map(|(threads, ranks)| {
        let mut run = common::simulation(text_scene("channel", CHANNEL, sets));
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool of a few threads");
        let followers = Followers::start(&mut run, ranks, threads).expect("a few threads");
        pool.install(|| (0..160).for_each(|_| run.step().expect("a step")));
        assert!(run.ledger().entered[0] > 0, "no particle crossed the inlet");
        assert!(run.ledger().total() > 12_000, "too few rows for several tasks");
        // The simulation is dropped first, with which the other ranks end.
        (run, followers)
    });
    let [one, threads, ranks] = &mut runs;
    let (rows, total) = (ranks.0.traffic(), ranks.0.ledger().total());
    // Far more if it held the openings that it does not touch.
    assert!(rows.iter().all(|rank| 3 * rank.held_rows < total), "{rows:?}");
    // A rank begins with the particles that it holds, not with all.
    let division = one.0.divide(4);
    for rank in 1..4 {
        let part = one.0.part(&division, rank);
        let (_, ids) = part.iter().find(|(name, _)| *name == "arrays.id").expect("numbers of particles");
        assert!(3 * (ids.len() as u64) < total, "{} of {total} on rank {rank}", ids.len());
        // A record is one value as bytes.
        let columns = part.iter().filter(|(name, _)| !name.starts_with("record."));
        let largest = columns.map(|(_, column)| column.len()).max().expect("columns");
        assert_eq!(largest, ids.len(), "a column has more particles than rank {rank} holds");
    }
    assert_eq!(difference(&mut one.0, &mut threads.0), None, "threads");
    assert!(frame_bits(&mut one.0) == frame_bits(&mut ranks.0), "ranks: the frames differ");
    assert!(one.0.state() == ranks.0.state(), "ranks: the states differ");
}

/// Reads between the steps, a borrowed world and particles without components leave each shipped
/// scene as it is.
#[test]
fn reads_and_missing_components_leave_the_flow_bitwise_identical() {
    let faults: Vec<Vec<String>> = in_parallel(&shipped_scenes(), |path| {
        let scene = smoke_scene(path, &[]);
        let particles = seeds(&scene);
        let build =
            |builder: SimulationBuilder| builder.build().expect("a scene without plugins can be built");
        let builder = || Simulation::builder(scene.clone()).particles(particles.clone());
        let [mut alone, mut read, mut borrowed] = [(); 3].map(|()| build(builder()));
        // As for the first of several ranks.
        let mut without = build(builder().without_components());
        assert!(alone.has_components() && !without.has_components());
        let mut faults = Vec::new();
        let mut expect = |is_equal: bool, what: &str| {
            if !is_equal {
                faults.push(format!("{}: {what}", path.display()));
            }
        };
        expect(is_equal(&mut borrowed, &mut without), "without components, at first");
        for step in 0..STEPS_WITH_READS {
            match step % 11 {
                0 => drop(read.monitor_row()),
                3 => drop(read.sample(&[DVec3::ZERO, DVec3::splat(1e-4)])),
                5 => drop(census(&mut read)),
                _ => {}
            }
            if step % 7 == 0 {
                borrowed.world_mut();
            }
            for run in [&mut alone, &mut read, &mut borrowed, &mut without] {
                run.step().expect("a step");
            }
            // There is nothing that a caller could change.
            without.world_mut();
        }
        for (other, what) in [(&mut read, "reads"), (&mut borrowed, "borrowing the world")] {
            if let Some(found) = difference(&mut alone, other) {
                expect(false, &format!("{what}: {found}"));
            }
        }
        expect(is_equal(&mut alone, &mut without), "without components");
        let mut restored =
            build(Simulation::builder(scene.clone()).state(alone.state()).without_components());
        expect(is_equal(&mut alone, &mut restored), "without components, from a checkpoint");
        faults
    });
    let faults = faults.concat();
    assert!(faults.is_empty(), "\n{}\n", faults.join("\n"));
}

/// Returns true if all that is written of two simulations is equal.
fn is_equal(one: &mut Simulation, other: &mut Simulation) -> bool {
    frame_bits(one) == frame_bits(other) && one.state() == other.state()
}
