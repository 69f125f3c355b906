//! Shares of ranks in a run, the speed-up that they allow and the memory that they need.
//!
//! ```text
//! S = N/max_r (p N_r + (1 − p) H_r)
//! ```
//!
//! N are all particles, N_r those that rank r owns, H_r those that it holds, and p the part of a
//! step that the pair sums take. Messages come on top; they depend on the network.

use sphecs_core::format::{bytes, grouped, significant};
use sphecs_core::pass::ranks::shares::Share;
use sphecs_engine::simulation::Simulation;
use sphecs_scene::model::Precision;

/// Part of a step that the pair sums take in 2D and 3D: measured by `sphecs bench`, cases `2d-f64`
/// and `3d-f32`.
const PAIR_SUMS: [f64; 2] = [0.92, 0.98];

/// Memory of the first rank for each particle of the flow, B, in single and double precision: the
/// largest of runs in 2D and 3D (docs/notebook/2026-11-29-ranks.md).
const MEMORY_OF_ALL: [f64; 2] = [235.0, 300.0];

/// Memory of any other rank for each particle that it holds, B, in the same runs.
const MEMORY_OF_HELD: [f64; 2] = [145.0, 200.0];

/// Returns the rows of a report on the shares of a number of ranks; none for one rank.
pub(crate) fn rank_rows(simulation: &mut Simulation, ranks: usize) -> Vec<(&'static str, String)> {
    if ranks < 2 {
        return Vec::new();
    }
    let pair_sums = if simulation.scene().dimensions == 2 { PAIR_SUMS[0] } else { PAIR_SUMS[1] };
    let is_double = simulation.scene().precision == Precision::F64;
    vec![("ranks", text(&simulation.shares(ranks), pair_sums, is_double))]
}

fn text(shares: &[Share], pair_sums: f64, is_double: bool) -> String {
    let all: u64 = shares.iter().map(|share| share.own).sum();
    let largest = |of: fn(&Share) -> u64| shares.iter().map(of).max().unwrap_or_default();
    let memory = |particles: u64, each: [f64; 2]| (particles as f64 * each[usize::from(is_double)]) as u64;
    format!(
        "{}: each owns at most {} of {} particles and holds at most {}; at most {} times as fast as one, \
         without messages; some {} of memory for the particles on the first, at most {} on each other",
        shares.len(),
        grouped(largest(|share| share.own)),
        grouped(all),
        grouped(largest(|share| share.held)),
        significant(speed_up(shares, pair_sums)),
        bytes(memory(all, MEMORY_OF_ALL)),
        bytes(memory(
            shares.iter().skip(1).map(|share| share.held).max().unwrap_or_default(),
            MEMORY_OF_HELD
        )),
    )
}

/// Returns the speed-up without messages.
fn speed_up(shares: &[Share], pair_sums: f64) -> f64 {
    let all: u64 = shares.iter().map(|share| share.own).sum();
    let cost = |share: &Share| pair_sums * share.own as f64 + (1.0 - pair_sums) * share.held as f64;
    all as f64 / shares.iter().map(cost).fold(f64::MIN_POSITIVE, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speed_up_is_that_of_the_slowest_rank() {
        let shares = [Share { own: 1000, held: 1500 }, Share { own: 1200, held: 1400 }];
        // Rank 0 does 0.9·1000 + 0.1·1500 = 1050, rank 1 0.9·1200 + 0.1·1400 = 1220.
        assert!((speed_up(&shares, 0.9) - 2200.0 / 1220.0).abs() < 1e-12);
        let text = text(&shares, 0.9, true);
        assert!(
            text.starts_with("2: each owns at most 1 200 of 2 200 particles and holds at most 1 500;"),
            "{text}"
        );
        assert!(text.contains("at most 1.803 times"), "{text}");
        assert!(
            text.ends_with(
                "some 660 kB of memory for the particles on the first, at most 280 kB on each other"
            ),
            "{text}"
        );
    }
}
