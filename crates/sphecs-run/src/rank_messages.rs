//! Messages between the ranks of a run, in words.

use sphecs_core::format::{bytes, grouped, significant, with_digits};
use sphecs_core::pass::ranks::Traffic;

/// Messages between the ranks in some steps.
#[derive(Clone, Debug, PartialEq)]
pub struct RankMessages {
    /// Messages and times of each rank.
    pub traffic: Vec<Traffic>,
    /// Number of steps.
    pub steps: u64,
    /// Wall time of the steps and of what was between them, s.
    pub wall_time: f64,
}

impl RankMessages {
    /// Returns the longest time of own work over the mean of the ranks.
    pub fn imbalance(&self) -> f64 {
        let busy = || self.traffic.iter().map(|rank| rank.busy);
        let mean = busy().sum::<f64>() / self.traffic.len() as f64;
        if mean > 0.0 { busy().fold(0.0, f64::max) / mean } else { 1.0 }
    }

    /// Returns the shares of the ranks, and number, bytes and time of their messages.
    pub fn text(&self) -> String {
        let most = |of: fn(&Traffic) -> u64| self.traffic.iter().map(of).max().unwrap_or_default();
        let per_step = |count: u64| count as f64 / self.steps.max(1) as f64;
        let waiting: f64 = self.traffic.iter().map(|rank| rank.exchanging).sum();
        let share = waiting / self.traffic.len().max(1) as f64 / self.wall_time.max(f64::MIN_POSITIVE);
        format!(
            "{}, each owns at most {} particles and holds {}; the slowest takes {} times the mean time for its work; \
             in a step at most {} messages and {} from each, {} % of the time for them and for waiting",
            self.traffic.len(),
            grouped(most(|rank| rank.own_rows)),
            grouped(most(|rank| rank.held_rows)),
            with_digits(self.imbalance(), 3),
            significant(per_step(most(|rank| rank.messages))),
            bytes(per_step(most(|rank| rank.sent)) as u64),
            with_digits(100.0 * share, 2),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_has_the_largest_shares_and_the_mean_time() {
        let rank = |busy: f64, sent: u64| Traffic {
            messages: 70,
            sent,
            busy,
            exchanging: 0.5,
            own_rows: 900 + sent,
            held_rows: 2000,
            ..Traffic::default()
        };
        let messages =
            RankMessages { traffic: vec![rank(1.0, 20_000), rank(1.5, 10_000)], steps: 10, wall_time: 5.0 };
        assert!((messages.imbalance() - 1.2).abs() < 1e-12);
        let text = messages.text();
        for part in
            ["2, each owns at most 20 900", "holds 2 000", "1.2 times", "7 messages", "2000 B", "10 %"]
        {
            assert!(text.contains(part), "no `{part}` in {text}");
        }
    }
}
