//! Every rank must have what one rank alone has, to the last bit.

use std::sync::{Arc, Barrier, Mutex};

use glam::DVec3;

use super::division::Division;
use super::regions::Region;
use super::*;
use crate::math::kernel::Kernel;
use crate::math::real::Real;
use crate::particles::arrays::{ParticleArrays, SpareColumns};
use crate::particles::rows::ParticleRow;
use crate::particles::zone::Zone;
use crate::pass::density::sum_density;
use crate::pass::samples::{Sample, settings};

/// Ranks that are threads of the test.
#[derive(Debug)]
struct ThreadRank {
    rank: usize,
    shared: Arc<(Barrier, Vec<Mutex<Vec<u8>>>)>,
}

impl Transport for ThreadRank {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.shared.1.len()
    }

    fn all_gather(&self, own: &[u8], lengths: &[usize], all: &mut Vec<u8>) {
        let (barrier, messages) = &*self.shared;
        *messages[self.rank].lock().expect("a message") = own.to_vec();
        barrier.wait();
        all.clear();
        for (message, &length) in messages.iter().zip(lengths) {
            let message = message.lock().expect("a message");
            assert_eq!(message.len(), length);
            all.extend_from_slice(&message);
        }
        barrier.wait();
    }

    fn exchange_during(&self, outgoing: &[Vec<u8>], incoming: &mut [Vec<u8>], work: &mut dyn FnMut()) {
        let (barrier, messages) = &*self.shared;
        let size = self.size();
        // The message for a rank is found by its length, which is in front of it.
        let mut all = Vec::new();
        for message in outgoing {
            all.extend((message.len() as u64).to_ne_bytes());
            all.extend(message);
        }
        *messages[self.rank].lock().expect("a message") = all;
        work();
        barrier.wait();
        for (rank, message) in incoming.iter_mut().enumerate() {
            let theirs = messages[rank].lock().expect("a message");
            let mut rest = &theirs[..];
            for to in 0..size {
                let (length, after) = rest.split_at(size_of::<u64>());
                let length = bytemuck::pod_read_unaligned::<u64>(length) as usize;
                if to == self.rank {
                    assert_eq!(message.len(), length, "from {rank} to {to}");
                    message.copy_from_slice(&after[..length]);
                }
                rest = &after[length..];
            }
        }
        barrier.wait();
    }

    fn abandon(&self) {}
}

/// Runs `work` on each of some ranks and returns the results in their order.
fn on_ranks<T: Send>(size: usize, work: impl Fn(Ranks) -> T + Sync) -> Vec<T> {
    on_ranks_changing(size, None, work)
}

/// Runs `work` on ranks whose domains change every few steps.
fn on_ranks_changing<T: Send>(size: usize, every: Option<u32>, work: impl Fn(Ranks) -> T + Sync) -> Vec<T> {
    let shared = Arc::new((Barrier::new(size), (0..size).map(|_| Mutex::default()).collect()));
    std::thread::scope(|scope| {
        let run = |rank| {
            let transport = ThreadRank { rank, shared: Arc::clone(&shared) };
            let work = &work;
            scope.spawn(move || {
                // A pool of its own, as each rank has: a thread that waits would block the others.
                let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
                pool.install(|| work(Ranks::changing_domains(transport, every)))
            })
        };
        let ranks: Vec<_> = (0..size).map(run).collect();
        ranks.into_iter().map(|rank| rank.join().expect("no panic")).collect()
    })
}

/// Bits of the densities and pressures of particles by their numbers.
type Densities = Vec<(u32, [u32; 2])>;

/// Sums densities on a rank, after a sort; returns those that it holds and the own numbers.
fn densities(ranks: Ranks) -> (Densities, Vec<u32>, Traffic) {
    let mut sample = Sample::<f32, 2>::lattice(settings(Kernel::WendlandC2, 2, 1.3), [61, 43], false);
    sample.pair.ranks = ranks;
    sort(&sample.pair.ranks, &mut sample.grid, &mut sample.particles, &[]);
    sum_density(&sample.pair, &sample.grid, &mut sample.particles, &mut sample.sums);
    let particles = &sample.particles;
    let bits = |row: usize| [&particles.density, &particles.pressure].map(|column| column[row].to_bits());
    let found = (0..particles.len()).map(|row| (particles.id[row], bits(row))).collect();
    let own = sample.pair.ranks.own_cells();
    let rows = (0..particles.len()).filter(|&row| own.has_row(&sample.grid, row));
    (found, rows.map(|row| particles.id[row]).collect(), own_traffic(&sample.pair.ranks))
}

/// Returns what this rank has sent, before it tells the others.
fn own_traffic(ranks: &Ranks) -> Traffic {
    ranks.traffic().get(ranks.rank()).copied().unwrap_or_default()
}

/// Takes newcomers and sorts, as a step does.
fn sort<R: Real, const D: usize>(
    ranks: &Ranks,
    grid: &mut CellGrid<D>,
    particles: &mut ParticleArrays<R, D>,
    regions: &[Region],
) {
    if ranks.changes() == 0 {
        ranks.divide(Division::new(grid, particles, ranks.size()));
    }
    assert!(ranks.move_rows(grid, particles, regions));
    let order = grid.build(&particles.position, &particles.id, |_| true).expect("all inside");
    particles.reorder(order, &mut SpareColumns::default());
    ranks.count_rows(grid);
}

#[test]
fn held_particles_have_the_densities_of_one_rank() {
    let (mut of_one, all, traffic) = densities(Ranks::default());
    of_one.sort_unstable();
    assert!(of_one.len() > 2000 && all.len() == of_one.len() && traffic == Traffic::default());
    for size in [2, 3, 7] {
        let mut owned = Vec::new();
        for (found, own, traffic) in on_ranks(size, densities) {
            assert_eq!(traffic.own_rows as usize, own.len());
            assert_eq!(traffic.held_rows as usize, found.len());
            assert!(found.len() < of_one.len() && own.len() < found.len(), "{size} ranks");
            for particle in &found {
                assert!(of_one.binary_search(particle).is_ok(), "{particle:?} on {size} ranks");
            }
            // Density and pressure of what is held besides the own rows; the masks stay.
            assert_eq!(traffic.received as usize, 8 * (found.len() - own.len()));
            owned.extend(own);
        }
        owned.sort_unstable();
        assert!(owned.into_iter().eq(0..of_one.len() as u32), "{size} ranks");
    }
}

/// Particles at random that move to and fro for some steps, with walls in a corner; returns the
/// assembled ones of rank 0, or the numbers held by others.
fn moved(ranks: &Ranks, regions: &[Region]) -> Vec<ParticleRow> {
    let mut grid = CellGrid::<2>::new([0.0; 2], [12.0, 8.0], [true, false], 1.0, 1.0);
    let mut particles = ParticleArrays::<f32, 2>::default();
    let mut random = 7_u64;
    let mut next = || {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (random >> 40) as f64 / f64::from(1 << 24)
    };
    for id in 0..600 {
        let position = DVec3::new(12.0 * next(), 8.0 * next(), 0.0);
        let zone = if position.length() < 2.0 { Zone::Wall } else { Zone::Fluid };
        let wall_normal = if zone == Zone::Wall { DVec3::X } else { DVec3::ZERO };
        let velocity = DVec3::new(next() - 0.5, next() - 0.5, 0.0);
        particles.push(&ParticleRow { id, zone, position, velocity, wall_normal, ..ParticleRow::default() });
    }
    sort(ranks, &mut grid, &mut particles, regions);
    for step in 0..40 {
        for row in 0..particles.len() {
            let sign = if step % 9 < 5 { 1.0 } else { -1.0 };
            for axis in 0..2 {
                particles.position[axis][row] += sign * f64::from(particles.velocity[axis][row]);
            }
            let [x, y] = std::array::from_fn(|axis| particles.position[axis][row]);
            particles.position[0][row] = x.rem_euclid(12.0).min(12.0_f64.next_down());
            particles.position[1][row] = y.clamp(0.0, 8.0);
        }
        ranks.begin_step();
        sort(ranks, &mut grid, &mut particles, regions);
        if step % 11 == 3 {
            ranks.assemble(&mut grid, &mut particles);
        }
    }
    ranks.assemble(&mut grid, &mut particles);
    (0..particles.len()).map(|row| particles.row(row)).collect()
}

#[test]
fn moving_particles_are_found_by_those_that_hold_their_cells() {
    let grid = CellGrid::<2>::new([0.0; 2], [12.0, 8.0], [true, false], 1.0, 1.0);
    let of_one = moved(&Ranks::default(), &[]);
    let around = Region::divide(&grid, &[1..2, 92..94], &[0..5, 90..96]);
    assert_eq!(around.len(), 2);
    for regions in [vec![], around] {
        for (size, every) in [(2, None), (3, Some(1)), (5, Some(7)), (8, Some(3))] {
            let work = |ranks: Ranks| (moved(&ranks, &regions), ranks);
            for (rank, (found, ranks)) in on_ranks_changing(size, every, work).into_iter().enumerate() {
                if rank == 0 {
                    assert!(found == of_one, "{size} ranks, domains change every {every:?} steps");
                    continue;
                }
                assert_eq!(ranks.changes() > 1, every.is_some());
                let held = ranks
                    .group
                    .as_ref()
                    .expect("ranks")
                    .state()
                    .domains
                    .as_ref()
                    .expect("domains")
                    .held
                    .clone();
                let cell = |particle: &ParticleRow| {
                    let place = [particle.position.x, particle.position.y];
                    grid.cell_of(place).expect("inside")
                };
                let expected = of_one.iter().filter(|particle| held.contains(cell(particle)));
                assert!(found.iter().eq(expected), "rank {rank} of {size}, {every:?}");
            }
        }
    }
}

#[test]
fn particle_outside_the_grid_stops_all_ranks() {
    let leave = |ranks: Ranks| {
        let mut sample = Sample::<f64, 2>::lattice(settings(Kernel::WendlandC2, 2, 1.3), [31, 21], false);
        sort(&ranks, &mut sample.grid, &mut sample.particles, &[]);
        for row in 0..sample.particles.len() {
            if sample.particles.id[row] == 17 {
                sample.particles.position[1][row] = f64::NAN;
            }
        }
        ranks.begin_step();
        let continues = ranks.move_rows(&mut sample.grid, &mut sample.particles, &[]);
        (continues, sample.particles.len())
    };
    let found = on_ranks(3, leave);
    assert!(found.iter().all(|(continues, _)| !continues));
    assert_eq!(found[0].1, 31 * 21, "rank 0 has all particles");
}

#[test]
fn values_of_all_ranks_are_joined() {
    let join = |ranks: Ranks| {
        let rank = ranks.rank() as f64;
        let mut sums = vec![ExactSum::default(); 2];
        sums[0] += 1e100 * (rank - 1.0);
        sums[0] += rank;
        sums[1] += f64::EPSILON;
        ranks.sum_exactly(&mut sums);
        (ranks.joined(rank, f64::max), sums.iter().map(ExactSum::value).collect::<Vec<_>>())
    };
    for (largest, sums) in on_ranks(3, join) {
        assert_eq!((largest, sums), (2.0, vec![3.0, 3.0 * f64::EPSILON]));
    }
    assert_eq!(Ranks::default().joined(5, |a, _| a), 5);
}

#[test]
fn first_rank_is_heard_by_all() {
    let heard = |ranks: Ranks| ranks.from_first(&[7 + ranks.rank() as u8; 3], 3);
    assert!(on_ranks(4, heard).into_iter().all(|bytes| bytes == [7; 3]));
    assert_eq!(Ranks::default().from_first(&[1], 1), [1]);
}

#[test]
fn the_first_rank_answers_all() {
    let ask = |ranks: Ranks| {
        let keys: Vec<u32> = (0..ranks.rank() as u32 * 2).map(|key| key + 5).collect();
        // Rank 0 finds all.
        ranks.answers_of_first(&keys, |keys| keys.iter().map(|&key| f64::from(key) * 0.5).collect::<Vec<_>>())
    };
    assert_eq!(on_ranks(3, ask), [vec![], vec![2.5, 3.0], vec![2.5, 3.0, 3.5, 4.0]]);
    assert_eq!(Ranks::default().answers_of_first(&[7_u8], |keys| keys.to_vec()), [7]);
}

#[test]
fn messages_of_all_ranks_reach_the_first() {
    let send = |ranks: Ranks| ranks.to_first(vec![ranks.rank() as u8; ranks.rank()]);
    assert_eq!(on_ranks(3, send), [vec![vec![], vec![1], vec![2, 2]], vec![], vec![]]);
    assert_eq!(Ranks::default().to_first(vec![5]), [[5]]);
}
