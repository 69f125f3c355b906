//! Pair passes on one thread: ordered pairs inside the support per second.
//!
//! `cargo bench --bench passes`. 2D: 160 000 particles at h = 1.33 Δ (20 neighbours). 3D: 262 144
//! at h = 2.02 Δ (250 neighbours). Disordered periodic boxes of Wendland's kernel with laminar
//! viscosity and Fickian shifting. The scalar baseline is the same density and pressure sums,
//! neighbour by neighbour over the same cells; the peak of fused multiply-adds is measured in the
//! same run, since a shared machine is never as fast as its data sheet.

use divan::Bencher;
use divan::counter::ItemsCount;
use sphecs_bench::measure::ordered_pairs;
use sphecs_bench::peak::Chains;
use sphecs_bench::scalar::density_and_force;
use sphecs_core::discretisation::Discretisation;
use sphecs_core::math::grid::CellGrid;
use sphecs_core::math::kernel::Kernel;
use sphecs_core::math::lanes::InstructionSet;
use sphecs_core::math::real::Real;
use sphecs_core::particles::arrays::{ParticleArrays, SpareColumns};
use sphecs_core::particles::rows::ParticleRow;
use sphecs_core::pass::density::sum_density;
use sphecs_core::pass::rates::{TimeLevel, sum_rates};
use sphecs_core::pass::settings::PairSettings;
use sphecs_core::pass::sums::PairSums;
use sphecs_core::physics::eos::Tait;

const SPACING: f64 = 0.01;

fn main() {
    // Figures are per thread: the passes must not spread.
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global().expect("the first pool of the process");
    #[expect(clippy::print_stdout, reason = "the figures mean nothing without the lanes they were taken on")]
    {
        println!("lanes: {}", InstructionSet::best().name());
    }
    divan::main();
}

/// A periodic box of disordered particles.
struct Flow<R: Real, const D: usize> {
    pair: PairSettings,
    grid: CellGrid<D>,
    particles: ParticleArrays<R, D>,
    sums: PairSums<R, D>,
    spare: SpareColumns<R>,
    /// Ordered pairs inside the support.
    pairs: usize,
}

/// A number in −1..1 by a key.
fn noise(key: usize) -> f64 {
    let mut x = (key as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x ^= x >> 27;
    (x >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

impl<R: Real, const D: usize> Flow<R, D> {
    fn new() -> Self {
        let (count, ratio): (usize, f64) = if D == 2 { (400, 1.33) } else { (64, 2.02) };
        let tait = Tait { reference_density: 1000.0, sound_speed: 10.0 };
        let discretisation =
            Discretisation::new(Kernel::WendlandC2, D, SPACING, ratio, tait.reference_density);
        let pair = PairSettings { viscosity: 1e-6, ..PairSettings::new(&discretisation, tait) };
        let upper = [count as f64 * SPACING; D];
        let grid = CellGrid::new(
            [0.0; D],
            upper,
            [true; D],
            pair.discretisation.support,
            pair.discretisation.cell_size(),
        );
        let mut particles = ParticleArrays::default();
        for index in 0..count.pow(D as u32) {
            let mut rest = index;
            let mut row =
                ParticleRow { id: index as u32, wall_distance: f64::INFINITY, ..Default::default() };
            for d in 0..D {
                let along = (rest % count) as f64 + 0.5 + 0.2 * noise(8 * index + d);
                row.position[d] = along * SPACING;
                row.velocity[d] = noise(8 * index + 4 + d);
                rest /= count;
            }
            particles.push(&row);
        }
        let mut flow = Self {
            pair,
            grid,
            particles,
            sums: PairSums::default(),
            spare: SpareColumns::default(),
            pairs: 0,
        };
        flow.sort();
        flow.density();
        flow.pairs = ordered_pairs(&flow.grid, &flow.particles);
        flow
    }

    fn point(&self, row: usize) -> [f64; D] {
        std::array::from_fn(|d| self.particles.position[d][row])
    }

    fn sort(&mut self) {
        let order = self.grid.build(&self.particles.position, &self.particles.id, |_| true).expect("inside");
        self.particles.reorder(order, &mut self.spare);
    }

    /// Moves every particle by a few percent of the spacing, as a step does, so that the sort has
    /// work.
    fn drift(&mut self, sign: f64) {
        for d in 0..D {
            for row in 0..self.particles.len() {
                let step = sign * 0.02 * SPACING * noise(8 * self.particles.id[row] as usize + d);
                self.particles.position[d][row] += step;
            }
        }
        for row in 0..self.particles.len() {
            let point = self.grid.wrap(self.point(row));
            for d in 0..D {
                self.particles.position[d][row] = point[d];
            }
        }
    }

    fn density(&mut self) {
        sum_density(&self.pair, &self.grid, &mut self.particles, &mut self.sums);
    }

    fn rates(&mut self) {
        divan::black_box(sum_rates(
            &self.pair,
            &self.grid,
            &mut self.particles,
            TimeLevel::Present,
            &mut self.sums,
        ));
    }
}

#[divan::bench(types = [f32, f64], consts = [2, 3], sample_count = 15)]
fn density<R: Real, const D: usize>(bencher: Bencher) {
    let mut flow = Flow::<R, D>::new();
    bencher.counter(ItemsCount::new(flow.pairs)).bench_local(|| flow.density());
}

#[divan::bench(types = [f32, f64], consts = [2, 3], sample_count = 15)]
fn rates<R: Real, const D: usize>(bencher: Bencher) {
    let mut flow = Flow::<R, D>::new();
    bencher.counter(ItemsCount::new(flow.pairs)).bench_local(|| flow.rates());
}

#[divan::bench(types = [f32, f64], consts = [2, 3], sample_count = 15)]
fn both<R: Real, const D: usize>(bencher: Bencher) {
    let mut flow = Flow::<R, D>::new();
    bencher.counter(ItemsCount::new(flow.pairs)).bench_local(|| {
        flow.density();
        flow.rates();
    });
}

#[divan::bench(types = [f32, f64], consts = [2, 3], sample_count = 15)]
fn sort_and_both<R: Real, const D: usize>(bencher: Bencher) {
    let mut flow = Flow::<R, D>::new();
    let mut sign = 1.0;
    let pairs = flow.pairs;
    let flow = std::cell::RefCell::new(&mut flow);
    bencher
        .counter(ItemsCount::new(pairs))
        .with_inputs(|| {
            flow.borrow_mut().drift(sign);
            sign = -sign;
        })
        .bench_local_values(|()| {
            let mut flow = flow.borrow_mut();
            flow.sort();
            flow.density();
            flow.rates();
        });
}

/// Density and forces neighbour by neighbour, in plain f64.
#[divan::bench(consts = [2, 3], sample_count = 3)]
fn scalar_both<const D: usize>(bencher: Bencher) {
    let Flow { pair, grid, particles, pairs, .. } = Flow::<f64, D>::new();
    bencher.counter(ItemsCount::new(pairs)).bench_local(|| {
        (0..particles.len()).map(|row| density_and_force(&pair, &grid, &particles, row).1).sum::<f64>()
    });
}

/// Floating-point operations per second (an item is one operation): two per lane and multiply-add.
#[divan::bench(types = [f32, f64], sample_count = 15)]
fn multiply_add_peak<R: Real>(bencher: Bencher) {
    let chains = || R::dispatch(InstructionSet::best(), Chains);
    bencher.counter(ItemsCount::new(chains())).bench_local(chains);
}
