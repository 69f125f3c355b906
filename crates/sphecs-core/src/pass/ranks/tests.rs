//! Every rank must have the sums of one rank alone, to the last bit.

use std::sync::{Arc, Barrier, Mutex};

use super::*;
use crate::math::kernel::Kernel;
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

    fn abandon(&self) {}
}

/// Runs `work` on each of some ranks and returns the results in their order.
fn on_ranks<T: Send>(size: usize, work: impl Fn(Ranks) -> T + Sync) -> Vec<T> {
    let shared = Arc::new((Barrier::new(size), (0..size).map(|_| Mutex::default()).collect()));
    std::thread::scope(|scope| {
        let run = |rank| {
            let transport = ThreadRank { rank, shared: Arc::clone(&shared) };
            let work = &work;
            scope.spawn(move || {
                // A pool of its own, as each rank has: a thread that waits would block the others.
                let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
                pool.install(|| work(Ranks::new(transport)))
            })
        };
        let ranks: Vec<_> = (0..size).map(run).collect();
        ranks.into_iter().map(|rank| rank.join().expect("no panic")).collect()
    })
}

#[test]
fn all_ranks_have_the_densities_of_one() {
    let density = |ranks: Ranks| {
        let mut sample = Sample::<f32, 2>::lattice(settings(Kernel::WendlandC2, 2, 1.3), [61, 43], false);
        sample.pair.ranks = ranks;
        for _ in 0..3 {
            sample.pair.ranks.begin_step();
            sum_density(&sample.pair, &sample.grid, &mut sample.particles, &mut sample.sums);
        }
        let bits = |column: &[f32]| column.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        (bits(&sample.particles.density), bits(&sample.particles.pressure), sample.pair.ranks.traffic())
    };
    let (densities, pressures, traffic) = density(Ranks::default());
    assert!(densities.len() > 2000 && traffic == Traffic::default());
    for size in [2, 3, 7] {
        for (found, found_pressures, traffic) in on_ranks(size, density) {
            assert!(found == densities && found_pressures == pressures, "{size} ranks");
            // Density and pressure of every row and the time, three times; the masks stay.
            assert_eq!(traffic.messages, 3);
            let rows = (traffic.sent + traffic.received - 3 * (BUSY * size) as u64) / (3 * 8);
            assert_eq!(rows as usize, densities.len());
        }
    }
}

#[test]
fn summaries_of_ranks_without_cells_are_joined() {
    // One cell has all rows, so that one rank has them all.
    let largest = |ranks: Ranks| {
        let grid = CellGrid::<2>::new([0.0; 2], [1.0; 2], [false; 2], 2.0, 2.0);
        let mut column = [0.0_f64; 0];
        let work = |_: Range<usize>, _: &mut &mut [f64]| 3.0_f64;
        ranks.for_each_block(&grid, &mut column[..], &work, &f64::max)
    };
    assert!(on_ranks(3, largest).into_iter().all(|found| found == 3.0));
}

#[test]
fn first_rank_is_heard_by_all() {
    let heard = |ranks: Ranks| ranks.from_first(&[7 + ranks.rank() as u8; 3], 3);
    assert!(on_ranks(4, heard).into_iter().all(|bytes| bytes == [7; 3]));
    assert_eq!(Ranks::default().from_first(&[1], 1), [1]);
}
