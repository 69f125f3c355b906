//! Shares of the ranks in the rows, so that all need the same time for their sums.
//!
//! ```text
//! rows of rank r: from N s_r to N s_(r+1),   0 = s_0 ≤ s_1 ≤ … = 1
//! c(s) = t_r/(s_(r+1) − s_r) in the share of rank r,   ∫ c ds over a new share = Σ t/ranks
//! ```
//!
//! t_r is the time that rank r needed since the last change, and c the cost of a row, taken as
//! uniform within a share. All ranks know the times of all, so they find the same shares, and no
//! result depends on them.

/// Steps between two changes of the shares.
const STEPS: u32 = 50;

/// Part of the way to the new shares that a change goes: the times of a busy machine vary.
const STEP_LENGTH: f64 = 0.7;

/// Shares of the ranks, and the times since they changed.
#[derive(Debug)]
pub(super) struct Balance {
    /// First share of each rank, followed by 1.
    shares: Vec<f64>,
    /// Time of the sums of each rank, s.
    busy: Vec<f64>,
    steps: u32,
}

impl Balance {
    /// Returns equal shares.
    pub(super) fn even(ranks: usize) -> Self {
        let shares = (0..=ranks).map(|rank| rank as f64 / ranks as f64).collect();
        Self { shares, busy: vec![0.0; ranks], steps: 0 }
    }

    /// Adds the time, s, that a rank needed for a pass.
    pub(super) fn add(&mut self, rank: usize, seconds: f64) {
        self.busy[rank] += seconds;
    }

    /// Counts a step, and changes the shares when it is time.
    pub(super) fn begin_step(&mut self) {
        self.steps += 1;
        if self.steps.is_multiple_of(STEPS) {
            self.change();
        }
    }

    fn change(&mut self) {
        let ranks = self.busy.len();
        let total: f64 = self.busy.iter().sum();
        let is_measured = self.busy.iter().all(|&seconds| seconds.is_finite() && seconds > 0.0);
        if is_measured {
            let mut shares = self.shares.clone();
            let (mut old, mut done) = (0, 0.0);
            for (rank, share) in shares.iter_mut().enumerate().take(ranks).skip(1) {
                let wanted = total * rank as f64 / ranks as f64;
                while old + 1 < ranks && done + self.busy[old] < wanted {
                    done += self.busy[old];
                    old += 1;
                }
                let part = ((wanted - done) / self.busy[old]).clamp(0.0, 1.0);
                let found = self.shares[old] + part * (self.shares[old + 1] - self.shares[old]);
                *share += STEP_LENGTH * (found - *share);
            }
            self.shares = shares;
        }
        self.busy.fill(0.0);
    }

    /// Finds the first cell of each rank, followed by the number of cells, from the first rows of
    /// all cells.
    pub(super) fn cells(&self, starts: &[u32], cells: &mut Vec<usize>) {
        let count = starts.len() - 1;
        let rows = f64::from(starts[count]);
        cells.clear();
        cells.extend(self.shares.iter().map(|share| {
            let row = (share * rows).round() as u32;
            starts.partition_point(|&start| start < row).min(count)
        }));
        // Cells behind the last particle belong to the last rank, as those before the first one do
        // to the first.
        cells[0] = 0;
        cells[self.shares.len() - 1] = count;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_follow_the_times() {
        let mut balance = Balance::even(3);
        // A row of the middle third costs twice as much as one of the others.
        let cost = |from: f64, to: f64| {
            let part = |low: f64, high: f64| (to.min(high) - from.max(low)).max(0.0);
            part(0.0, 1.0 / 3.0) + 2.0 * part(1.0 / 3.0, 2.0 / 3.0) + part(2.0 / 3.0, 1.0)
        };
        for _ in 0..20 * STEPS {
            for rank in 0..3 {
                let (from, to) = (balance.shares[rank], balance.shares[rank + 1]);
                balance.add(rank, cost(from, to));
            }
            balance.begin_step();
        }
        for rank in 0..3 {
            let time = cost(balance.shares[rank], balance.shares[rank + 1]);
            assert!((time - 4.0 / 9.0).abs() < 1e-3, "{:?}", balance.shares);
        }
    }

    #[test]
    fn cells_cover_the_grid_with_few_particles_too() {
        let mut cells = Vec::new();
        for starts in [vec![0, 0, 0], vec![0, 1, 1, 1, 1], vec![0, 0, 2, 9, 9], vec![0, 5]] {
            Balance::even(4).cells(&starts, &mut cells);
            assert_eq!((cells[0], cells[4]), (0, starts.len() - 1));
            assert!(cells.is_sorted(), "{cells:?}");
        }
    }

    #[test]
    fn rank_without_a_time_keeps_the_shares() {
        let mut balance = Balance::even(2);
        balance.add(0, 1.0);
        (0..STEPS).for_each(|_| balance.begin_step());
        assert_eq!(balance.shares, [0.0, 0.5, 1.0]);
    }
}
