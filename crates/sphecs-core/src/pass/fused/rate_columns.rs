//! Columns that the fused passes write: acceleration, shifting vector and two scalars.
//!
//! They are taken out of particles and sums while a pass reads the other columns of both, and put
//! back when it ends.

use glam::DVec3;

use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::rows::set_real_vector;
use crate::pass::sums::PairSums;

/// Writer of the rates of either scheme.
#[derive(Debug)]
pub struct FusedRates(());

/// Scalars that a fused pass writes, in the order of its outputs.
#[derive(Clone, Copy, Debug)]
pub(in crate::pass) enum RateScalars {
    /// Divergence and damping, of `Wcsph`.
    DivergenceAndDamping {
        /// True if the damping is found for each row, not only its largest value.
        per_row: bool,
    },
    /// Rate of pressure and divergence, of `EdacTvf`.
    PressureRateAndDivergence,
}

/// Output columns of the rows of a block: acceleration, shifting vector (under `EdacTvf` the
/// acceleration by the background pressure) and two scalars of the scheme.
pub(in crate::pass) type FusedOutputs<'a, R, const D: usize> =
    ([&'a mut [R]; D], [&'a mut [R]; D], [&'a mut [R]; 2]);

/// The output columns of a block, from the row `first` on.
pub(in crate::pass) struct OutputColumns<'a, R, const D: usize> {
    pub first: usize,
    pub acceleration: [&'a mut [R]; D],
    pub shift: [&'a mut [R]; D],
    pub scalars: [&'a mut [R]; 2],
}

impl<'a, R, const D: usize> OutputColumns<'a, R, D> {
    /// Returns the columns of a block whose first row is `first`.
    #[inline(always)]
    pub(in crate::pass) fn from_row(
        first: usize,
        (acceleration, shift, scalars): &'a mut FusedOutputs<'_, R, D>,
    ) -> Self {
        Self {
            first,
            acceleration: acceleration.each_mut().map(|column| &mut **column),
            shift: shift.each_mut().map(|column| &mut **column),
            scalars: scalars.each_mut().map(|column| &mut **column),
        }
    }
}

/// The columns of a pass that runs.
pub(in crate::pass) struct RateColumns<R, const D: usize> {
    acceleration: [Vec<R>; D],
    shift: [Vec<R>; D],
    scalars: [Vec<R>; 2],
    kind: RateScalars,
}

impl<R: Real, const D: usize> RateColumns<R, D> {
    /// Takes the columns and gives each an entry per particle.
    pub(crate) fn take(
        kind: RateScalars,
        particles: &mut ParticleArrays<R, D>,
        sums: &mut PairSums<R, D>,
    ) -> Self {
        let rows = particles.len();
        let mut shift = std::mem::replace(sums.shift.write(FusedRates(())), [const { Vec::new() }; D]);
        let mut scalars = scalars_of(kind, sums).map(std::mem::take);
        let per_row = !matches!(kind, RateScalars::DivergenceAndDamping { per_row: false });
        scalars[1].resize(if per_row { rows } else { 0 }, R::default());
        for column in shift.iter_mut().chain(&mut scalars[..1]) {
            column.resize(rows, R::default());
        }
        let acceleration = std::mem::replace(&mut particles.acceleration, [const { Vec::new() }; D]);
        Self { acceleration, shift, scalars, kind }
    }

    /// Puts the columns back.
    pub(crate) fn put_back(self, particles: &mut ParticleArrays<R, D>, sums: &mut PairSums<R, D>) {
        particles.acceleration = self.acceleration;
        *sums.shift.write(FusedRates(())) = self.shift;
        for (column, found) in scalars_of(self.kind, sums).into_iter().zip(self.scalars) {
            *column = found;
        }
    }

    /// Returns the columns as outputs of all rows.
    pub(crate) fn as_outputs(&mut self) -> FusedOutputs<'_, R, D> {
        (
            self.acceleration.each_mut().map(Vec::as_mut_slice),
            self.shift.each_mut().map(Vec::as_mut_slice),
            self.scalars.each_mut().map(Vec::as_mut_slice),
        )
    }
}

/// Returns the scalars that a pass writes.
fn scalars_of<R, const D: usize>(kind: RateScalars, sums: &mut PairSums<R, D>) -> [&mut Vec<R>; 2] {
    let PairSums { divergence, damping, pressure_rate, .. } = sums;
    let divergence = divergence.write(FusedRates(()));
    match kind {
        RateScalars::DivergenceAndDamping { .. } => [divergence, damping.write(FusedRates(()))],
        RateScalars::PressureRateAndDivergence => [pressure_rate.write(FusedRates(())), divergence],
    }
}

impl<R: Real, const D: usize> PairSums<R, D> {
    /// Sets the shifting vector of an outflow particle, which the fused passes leave alone.
    pub fn set_outflow_shift(&mut self, row: usize, shift: DVec3) {
        set_real_vector(self.shift.write(FusedRates(())), row, shift);
    }
}
