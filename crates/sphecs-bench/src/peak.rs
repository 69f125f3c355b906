//! Measured peak rate of multiply-adds of a core, with which the pair loops are compared.
//!
//! A shared machine is slower than its data sheet, so the peak is measured in the run of the bench.

use std::hint::black_box;
use std::time::Instant;

use sphecs_core::math::lanes::{InstructionSet, Lanes, Vectorised};
use sphecs_core::math::real::Real;
use sphecs_scene::model::Precision;

/// Number of independent chains: they fill two pipes of four cycles and fit into the sixteen
/// registers of AVX2.
const CHAINS: usize = 12;

/// Rounds of a repetition: some milliseconds, far above the resolution of the clock.
const ROUNDS: usize = 1 << 20;

/// Repetitions, of which the fastest counts.
const REPETITIONS: usize = 15;

/// Independent chains of dependent multiply-adds.
///
/// Returns the number of floating-point operations, two per lane and multiply-add.
#[derive(Clone, Copy, Debug, Default)]
pub struct Chains;

impl<R: Real> Vectorised<R> for Chains {
    type Output = usize;
    type Module = Self;

    #[inline(always)]
    fn run<L: Lanes<Real = R>>(self) -> usize {
        let mut chains = [L::constant(0.5); CHAINS];
        let (factor, term) = (L::constant(black_box(0.999)), L::constant(black_box(0.001)));
        for _ in 0..ROUNDS {
            for chain in &mut chains {
                *chain = chain.mul_add(factor, term);
            }
        }
        black_box(chains.into_iter().fold(L::constant(0.0), |sum, chain| sum + chain).sum());
        2 * L::COUNT * CHAINS * ROUNDS
    }
}

/// Floating-point operations per second of a core, two per multiply-add.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peaks {
    /// In f32, 1/s.
    pub single: f64,
    /// In f64, 1/s.
    pub double: f64,
}

impl Peaks {
    /// Measures both rates on the current thread.
    pub fn measure() -> Self {
        Self { single: fastest::<f32>(), double: fastest::<f64>() }
    }

    /// Returns the rate of a precision, 1/s.
    pub fn of(&self, precision: Precision) -> f64 {
        match precision {
            Precision::F32 => self.single,
            Precision::F64 => self.double,
        }
    }
}

/// Returns the floating-point operations per second of the fastest repetition.
fn fastest<R: Real>() -> f64 {
    let mut best: f64 = 0.0;
    for _ in 0..REPETITIONS {
        let started = Instant::now();
        let operations = R::dispatch(InstructionSet::best(), Chains);
        best = best.max(operations as f64 / started.elapsed().as_secs_f64());
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peak_is_positive_and_counts_the_lanes() {
        let peaks = Peaks::measure();
        for peak in [peaks.single, peaks.double] {
            assert!(peak > 0.0 && peak.is_finite(), "{peak} operations/s");
        }
        assert_eq!(peaks.of(Precision::F32), peaks.single);
        for set in InstructionSet::available() {
            assert_eq!(f32::dispatch(set, Chains), 2 * f64::dispatch(set, Chains), "{}", set.name());
        }
    }
}
