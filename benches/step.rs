//! Whole steps on one thread: particle-steps per second, ordered pairs per second, and where the time goes.
//!
//! `cargo bench --bench step`. Stirred periodic boxes of Wendland's kernel with laminar viscosity and Fickian shifting (2D:
//! h = 1.33 Δ; 3D: h = 2.02 Δ, with a quarter of a million and a million particles), and the shipped constricted channel
//! with walls, inlet and outlet. Divan's items are particle-steps, reservoir excluded. The table below divan's is made of the
//! fastest run of each set of systems, because a shared machine is slow for reasons of its own; `pairs` are ordered pairs
//! of fluid particles with anything in their support, density and force together counted as one.

use std::path::Path;
use std::sync::{Mutex, PoisonError};

use divan::Bencher;
use divan::counter::ItemsCount;
use sphecs::math::lanes::InstructionSet;
use sphecs::math::real::Real;
use sphecs::particles::arrays::ParticleArrays;
use sphecs::particles::zone::Zone;
use sphecs::pass::neighbours::Neighbours;
use sphecs::scene;
use sphecs::simulation::Simulation;
use sphecs::systems::neighbours::Grid;

/// What a bench found, for the table at the end.
struct Report {
    name: String,
    particles: usize,
    pairs: usize,
    /// Fastest run of each set, s.
    stages: Vec<(&'static str, f64)>,
}

static REPORTS: Mutex<Vec<Report>> = Mutex::new(Vec::new());

fn main() {
    // Figures are per thread: a step must not spread.
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("the first pool of the process");
    divan::main();
    #[expect(clippy::print_stdout, reason = "a bench reports to whoever started it")]
    {
        println!("\nlanes: {}", InstructionSet::best().name());
        for report in REPORTS.lock().unwrap_or_else(PoisonError::into_inner).iter() {
            println!("{}", report.line());
        }
    }
}

impl Report {
    fn line(&self) -> String {
        let step: f64 = self.stages.iter().map(|(_, seconds)| seconds).sum();
        let millions = |count: usize| count as f64 / step / 1e6;
        let shares: Vec<String> = self
            .stages
            .iter()
            .filter(|(_, seconds)| *seconds > 0.0005 * step)
            .map(|(name, seconds)| format!("{name} {:.1} %", 100.0 * seconds / step))
            .collect();
        format!(
            "{}: {} particles, {:.2} ms a step, {:.2} M particle-steps/s, {:.0} M pairs/s: {}",
            self.name,
            self.particles,
            1e3 * step,
            millions(self.particles),
            millions(self.pairs),
            shares.join(", ")
        )
    }
}

/// A periodic box with `count` particles along each axis.
fn periodic_box<R: Real>(dimensions: usize, count: usize, ratio: f64) -> Simulation {
    let edge = count as f64 * 0.01;
    let precision = if size_of::<R>() == 4 { "F32" } else { "F64" };
    let (zeros, edges, axes, velocity) = if dimensions == 2 {
        ("0.0, 0.0", format!("{edge}, {edge}"), r#""x", "y""#, r#""sin(k*y)", "cos(k*x)""#)
    } else {
        (
            "0.0, 0.0, 0.0",
            format!("{edge}, {edge}, {edge}"),
            r#""x", "y", "z""#,
            r#""sin(k*y)", "cos(k*z)", "sin(k*x)""#,
        )
    };
    let text = format!(
        r#"Scene(
            title: "Stirred box", dimensions: {dimensions}, precision: {precision}, spacing: 0.01, smoke: 0.02,
            constants: {{ "k": "4*pi/{edge}" }},
            fluid: (density: 1000.0, viscosity: 1.0e-6, sound_speed: 10.0),
            scheme: Wcsph(smoothing_ratio: {ratio}),
            domain: Box(min: ({zeros}), max: ({edges})), periodic: [{axes}], walls: None,
            initial: (velocity: ({velocity})),
            time: (end: 1.0), output: (every: 1.0),
        )"#
    );
    match scene::load_str("stirred_box", &text, &[]) {
        Ok(scene) => Simulation::from_scene(scene),
        Err(faults) => panic!("{faults}"),
    }
}

/// Times steps of a simulation after `spin_up` of them.
fn time<R: Real, const D: usize>(bencher: Bencher, name: String, spin_up: usize, mut simulation: Simulation) {
    for _ in 0..spin_up {
        simulation.step().expect("the flow is tame");
    }
    let (particles, pairs) = count::<R, D>(&mut simulation);
    // The first step after looking at the components carries them to the arrays.
    simulation.step().expect("the flow is tame");
    let mut before = simulation.stage_times();
    let mut fastest: Vec<(&'static str, f64)> =
        before.iter().map(|(name, _)| (*name, f64::INFINITY)).collect();
    bencher.counter(ItemsCount::new(particles)).bench_local(|| {
        simulation.step().expect("the flow is tame");
        let after = simulation.stage_times();
        for ((fastest, before), after) in fastest.iter_mut().zip(&before).zip(&after) {
            fastest.1 = fastest.1.min(after.1 - before.1);
        }
        before = after;
    });
    if fastest.iter().all(|(_, seconds)| seconds.is_finite()) {
        let report = Report { name, particles, pairs, stages: fastest };
        REPORTS.lock().unwrap_or_else(PoisonError::into_inner).push(report);
    }
}

/// Particles outside the reservoir, and ordered pairs of fluid particles with anything in their support.
fn count<R: Real, const D: usize>(simulation: &mut Simulation) -> (usize, usize) {
    let world = simulation.world();
    let arrays = world.resource::<ParticleArrays<R, D>>();
    let neighbours = Neighbours::new(&world.resource::<Grid<D>>().0, arrays);
    let mut pairs = 0;
    for row in (0..arrays.len()).filter(|&row| arrays.zone[row] == Zone::Fluid) {
        let point = std::array::from_fn(|d| arrays.position[d][row]);
        neighbours.for_each(point, |other, _, _| pairs += usize::from(other != row));
    }
    (arrays.len(), pairs)
}

fn precision<R: Real>() -> &'static str {
    if size_of::<R>() == 4 { "f32" } else { "f64" }
}

#[divan::bench(types = [f32, f64], sample_count = 30, sample_size = 1)]
fn box_2d<R: Real>(bencher: Bencher) {
    let name = format!("2D box, {}", precision::<R>());
    time::<R, 2>(bencher, name, 20, periodic_box::<R>(2, 400, 1.33));
}

#[divan::bench(types = [f32, f64], sample_count = 8, sample_size = 1)]
fn box_3d<R: Real>(bencher: Bencher) {
    let name = format!("3D box, {}", precision::<R>());
    time::<R, 3>(bencher, name, 3, periodic_box::<R>(3, 64, 2.02));
}

#[divan::bench(types = [f32, f64], sample_count = 3, sample_size = 1)]
fn million_3d<R: Real>(bencher: Bencher) {
    let name = format!("3D box of a million, {}", precision::<R>());
    time::<R, 3>(bencher, name, 1, periodic_box::<R>(3, 100, 2.02));
}

#[divan::bench(sample_count = 60, sample_size = 1)]
fn constricted_channel(bencher: Bencher) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/constricted_r2.ron");
    match scene::load(&path, &[]) {
        Ok(scene) => {
            time::<f64, 2>(bencher, "constricted_r2, f64".into(), 300, Simulation::from_scene(scene))
        }
        Err(faults) => panic!("{faults}"),
    }
}
