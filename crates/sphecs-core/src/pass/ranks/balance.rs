//! Balance of the ranks: what a row costs in each domain, by the times of its rank.
//!
//! ```text
//! c_r = 1 + θ ((t_r/N_r)/(Σ t/Σ N) − 1)
//! ```
//!
//! t_r is the time that rank r worked in the steps since the domains changed, with N_r rows in its
//! domain. All ranks know the times of all, so they find the same domains, and no result depends on
//! them.

/// Steps between two comparisons of the times.
const STEPS: u32 = 50;

/// Steps before the first comparisons: what the particles of a flow cost is not known before them.
const FIRST: [u32; 2] = [5, 15];

/// Longest time of a rank, over the mean of all, that is balanced.
const TOLERANCE: f64 = 1.02;

/// Tolerance of the first comparisons: times of few steps vary more.
const FIRST_TOLERANCE: f64 = 1.05;

/// Part θ of the measured differences that counts: the times of a busy machine vary.
const PART: f64 = 0.7;

/// Times of the ranks since their domains changed.
#[derive(Debug)]
pub(super) struct Balance {
    /// Time of the sums of each rank, s.
    busy: Vec<f64>,
    steps: u32,
    /// Steps after which the domains change in any case; None: when the times differ.
    change_every: Option<u32>,
}

impl Balance {
    /// Returns the balance of a number of ranks whose domains change when their times differ, or
    /// every few steps.
    pub(super) fn new(ranks: usize, change_every: Option<u32>) -> Self {
        Self { busy: vec![0.0; ranks], steps: 0, change_every }
    }

    /// Adds the time, s, that a rank needed.
    pub(super) fn add(&mut self, rank: usize, seconds: f64) {
        self.busy[rank] += seconds;
    }

    /// Counts a step; returns true if the domains have to change before it.
    pub(super) fn begin_step(&mut self) -> bool {
        self.steps += 1;
        if let Some(steps) = self.change_every {
            return self.steps.is_multiple_of(steps);
        }
        let tolerance = match self.steps {
            steps if steps.is_multiple_of(STEPS) => TOLERANCE,
            steps if FIRST.contains(&steps) => FIRST_TOLERANCE,
            _ => return false,
        };
        let mean = self.busy.iter().sum::<f64>() / self.busy.len() as f64;
        let largest = self.busy.iter().copied().fold(0.0, f64::max);
        let is_unequal = largest > tolerance * mean;
        if !is_unequal {
            self.busy.fill(0.0);
        }
        is_unequal
    }

    /// Returns the cost of a row in the domain of each rank, where the mean is 1, and forgets the
    /// times; `rows` are their numbers.
    pub(super) fn take_costs(&mut self, rows: &[f64]) -> Vec<f64> {
        let mean = self.busy.iter().sum::<f64>() / rows.iter().sum::<f64>();
        let cost = |(busy, rows): (&f64, &f64)| {
            let measured = busy / rows / mean;
            if measured.is_finite() && measured > 0.0 { 1.0 + PART * (measured - 1.0) } else { 1.0 }
        };
        let costs = self.busy.iter().zip(rows).map(cost).collect();
        self.busy.fill(0.0);
        costs
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_ranks_have_costly_rows() {
        let mut balance = Balance::new(3, None);
        [2.0, 1.0, 1.0].into_iter().enumerate().for_each(|(rank, busy)| balance.add(rank, busy));
        let due: Vec<u32> = (1..FIRST[1]).filter(|_| balance.begin_step()).collect();
        assert_eq!(due, [FIRST[0]]);
        let costs = balance.take_costs(&[100.0, 100.0, 50.0]);
        // The mean row takes 4/250, those of the ranks 2/100, 1/100 and 1/50.
        let expected = [1.25, 0.625, 1.25].map(|cost| 1.0 + PART * (cost - 1.0));
        for (cost, expected) in costs.iter().zip(expected) {
            assert!((cost - expected).abs() < 1e-12, "{costs:?}");
        }
        assert!((0..2 * STEPS).all(|_| !balance.begin_step()), "no times");
    }

    #[test]
    fn equal_times_change_nothing() {
        let mut balance = Balance::new(2, None);
        for _ in 0..4 * STEPS {
            balance.add(0, 1.0);
            balance.add(1, 1.03);
            assert!(!balance.begin_step());
        }
    }

    #[test]
    fn domains_change_as_often_as_wanted() {
        let mut balance = Balance::new(2, Some(7));
        assert_eq!((1..=21).filter(|_| balance.begin_step()).count(), 3);
        assert_eq!(balance.take_costs(&[5.0, 0.0]), [1.0, 1.0]);
    }
}
