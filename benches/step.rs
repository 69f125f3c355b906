//! Whole steps on one thread: particle-steps per second, ordered pairs per second, and where the
//! time goes.
//!
//! `cargo bench --bench step`. The cases of `sphecs bench`: periodic boxes of disordered particles
//! (2D: h = 1.33 Δ; 3D: h = 2.02 Δ, with a quarter of a million and a million particles), and
//! channels and a duct with walls, inlet and outlet; and `scenes/step.ron` with each outlet
//! condition under both schemes. Divan's items are particle-steps, reservoir excluded. The table
//! below divan's is made of the fastest run of each set of systems, because a shared machine is
//! slow for reasons of its own; `pairs` are ordered pairs of fluid particles with anything in their
//! support, all passes of a step together counted as one.

use std::path::Path;
use std::sync::{Mutex, OnceLock, PoisonError};

use divan::Bencher;
use divan::counter::ItemsCount;
use sphecs::{Scene, SceneErrors};
use sphecs_bench::cases::BenchCase;
use sphecs_bench::measure::{FastestSets, count, filled_with_tiles, scalar_rate};
use sphecs_bench::operations::per_pair;
use sphecs_bench::peak::Peaks;
use sphecs_bench::tile::Tile;
use sphecs_bench::timing_table::shares;
use sphecs_core::math::lanes::InstructionSet;

/// What a bench found, for the table at the end.
struct Report {
    name: String,
    particles: usize,
    pairs: usize,
    /// Floating-point operations of a pair.
    operations: usize,
    /// Multiply-adds of the core, operations a second.
    peak: f64,
    /// Pairs a second of the scalar baseline.
    scalar_rate: f64,
    /// Fastest run of each set, s.
    sets: Vec<(&'static str, f64)>,
}

const OUTLETS: [&str; 8] = [
    "WaveEquation()",
    "WaveEquation(pressure: NonReflecting(waves: Plane))",
    "Orlanski()",
    "DoNothing",
    "ModifiedDoNothing()",
    "Mirror()",
    "Characteristic(velocity: 1.0, pressure: 0.0)",
    "Hybrid()",
];

/// Measured once.
static PEAKS: OnceLock<Peaks> = OnceLock::new();

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
        let step: f64 = self.sets.iter().map(|(_, seconds)| seconds).sum();
        let millions = |count: usize| count as f64 / step / 1e6;
        format!(
            "{}: {} particles, {:.2} ms a step, {:.2} M particle-steps/s, {:.0} M pairs/s, \
             {:.1} % of the peak of multiply-adds, {:.1} x scalar: {} %",
            self.name,
            self.particles,
            1e3 * step,
            millions(self.particles),
            millions(self.pairs),
            100.0 * (self.pairs * self.operations) as f64 / step / self.peak,
            self.pairs as f64 / step / self.scalar_rate,
            shares(&self.sets),
        )
    }
}

/// Times steps of a case after its warm-up.
fn time(bencher: Bencher, name: &str) {
    let case = BenchCase::named(name).expect("a case of the engine");
    let tile = case.periodic_box().map(|periodic_box| Tile::of(periodic_box).expect("a stable flow"));
    time_flow(bencher, name.to_owned(), case.scene(), tile, case.plan().warm_up);
}

/// Times steps of a scene after a number of warm-up steps; the scene is filled with the tile, if
/// there is one.
fn time_flow(
    bencher: Bencher,
    name: String,
    scene: Result<Scene, SceneErrors>,
    tile: Option<Tile>,
    warm_up: usize,
) {
    let mut simulation = match scene {
        Ok(scene) => filled_with_tiles(scene, tile.as_ref()),
        Err(faults) => panic!("{faults}"),
    };
    for _ in 0..warm_up {
        simulation.step().expect("the flow is tame");
    }
    let (particles, pairs) = count(&mut simulation);
    // The first step after looking at the components carries them to the arrays.
    simulation.step().expect("the flow is tame");
    let mut sets = FastestSets::begin(&simulation);
    bencher.counter(ItemsCount::new(particles)).bench_local(|| {
        simulation.step().expect("the flow is tame");
        sets.record(&simulation, 1);
    });
    let sets = sets.seconds();
    if sets.iter().all(|(_, seconds)| seconds.is_finite()) {
        let scene = simulation.scene();
        let (operations, precision) = (per_pair(scene), scene.precision);
        let scalar_rate = scalar_rate(&mut simulation);
        let peak = PEAKS.get_or_init(Peaks::measure).of(precision);
        let report = Report { name, particles, pairs, operations, peak, scalar_rate, sets };
        REPORTS.lock().unwrap_or_else(PoisonError::into_inner).push(report);
    }
}

#[divan::bench(args = ["2d-f32", "2d-f64"], sample_count = 30, sample_size = 1)]
fn box_2d(bencher: Bencher, name: &str) {
    time(bencher, name);
}

#[divan::bench(args = ["3d-f32", "3d-f64", "3d-sps-f32", "3d-sps-f64"], sample_count = 8, sample_size = 1)]
fn box_3d(bencher: Bencher, name: &str) {
    time(bencher, name);
}

#[divan::bench(args = ["3d-large-f32", "3d-large-f64"], sample_count = 3, sample_size = 1)]
fn million_3d(bencher: Bencher, name: &str) {
    time(bencher, name);
}

#[divan::bench(args = ["channel", "channel_cylinder", "channel_mover"], sample_count = 60, sample_size = 1)]
fn open_channels(bencher: Bencher, name: &str) {
    time(bencher, name);
}

#[divan::bench(args = ["duct"], sample_count = 8, sample_size = 1)]
fn square_duct(bencher: Bencher, name: &str) {
    time(bencher, name);
}

/// The backward-facing step with another outlet.
fn time_outlet(bencher: Bencher, scheme: &str, condition: &str) {
    let sets = [("scheme", scheme), ("outlets.0.condition", condition)];
    time_flow(
        bencher,
        format!("{scheme} {condition}"),
        Scene::from_file(Path::new("scenes/step.ron")).sets(sets).load(),
        None,
        20,
    );
}

#[divan::bench(args = OUTLETS, sample_count = 100, sample_size = 1)]
fn outlets_wcsph(bencher: Bencher, condition: &str) {
    time_outlet(bencher, "Wcsph()", condition);
}

#[divan::bench(args = OUTLETS, sample_count = 100, sample_size = 1)]
fn outlets_edac_tvf(bencher: Bencher, condition: &str) {
    time_outlet(bencher, "EdacTvf()", condition);
}
