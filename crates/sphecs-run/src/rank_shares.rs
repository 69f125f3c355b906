//! Shares of ranks in a run, and the speed-up that they allow.
//!
//! ```text
//! S = N/max_r (p N_r + (1 − p) H_r)
//! ```
//!
//! N are all particles, N_r those that rank r owns, H_r those that it holds, and p the part of a
//! step that the pair sums take. Messages come on top; they depend on the network.

use sphecs_core::format::{grouped, significant};
use sphecs_core::pass::ranks::shares::Share;
use sphecs_engine::simulation::Simulation;

/// Part of a step that the pair sums take in 2D and 3D: measured by `sphecs bench`, cases `2d-f64`
/// and `3d-f32`.
const PAIR_SUMS: [f64; 2] = [0.92, 0.98];

/// Returns the rows of a report on the shares of a number of ranks; none for one rank.
pub(crate) fn rank_rows(simulation: &mut Simulation, ranks: usize) -> Vec<(&'static str, String)> {
    if ranks < 2 {
        return Vec::new();
    }
    let pair_sums = if simulation.scene().dimensions == 2 { PAIR_SUMS[0] } else { PAIR_SUMS[1] };
    vec![("ranks", text(&simulation.shares(ranks), pair_sums))]
}

fn text(shares: &[Share], pair_sums: f64) -> String {
    let all: u64 = shares.iter().map(|share| share.own).sum();
    let largest = |of: fn(&Share) -> u64| shares.iter().map(of).max().unwrap_or_default();
    format!(
        "{}: each owns at most {} of {} particles and holds at most {}; at most {} times as fast as one, \
         without messages",
        shares.len(),
        grouped(largest(|share| share.own)),
        grouped(all),
        grouped(largest(|share| share.held)),
        significant(speed_up(shares, pair_sums)),
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
        let text = text(&shares, 0.9);
        assert!(
            text.starts_with("2: each owns at most 1 200 of 2 200 particles and holds at most 1 500;"),
            "{text}"
        );
        assert!(text.contains("at most 1.803 times"), "{text}");
    }
}
