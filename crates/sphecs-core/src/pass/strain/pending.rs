//! Velocity gradients from the moments of particles, many particles at a time so that the compiler
//! vectorises the loops.

use super::row::FlowSums;
use crate::math::linear::invert_symmetric;
use crate::math::real::Real;
use crate::math::symmetric::{component, components};
use crate::pass::blocks::GROUP;

/// One number per waiting particle.
type GroupColumn = [f64; GROUP];

/// Columns of a block for the symmetric parts of the gradients, by component, and for the
/// gradients; empty ones are left out.
pub(super) type Gradients<'a, R, const D: usize> = ([&'a mut [R]; 6], [[&'a mut [R]; D]; D]);

/// Moments of particles whose gradients are not computed yet.
pub(super) struct PendingGradients<const D: usize> {
    /// Number of waiting particles.
    waiting: usize,
    /// Their slots in the columns.
    slots: [usize; GROUP],
    weights: GroupColumn,
    along: [GroupColumn; D],
    across: [GroupColumn; D],
    moment: [GroupColumn; 6],
    sum: [[GroupColumn; D]; D],
    /// Weight w of the particle itself, which only the sum of the weights contains.
    own_weight: f64,
    /// 1/m, since distances are in units of h.
    inverse_h: f64,
}

impl<const D: usize> PendingGradients<D> {
    /// Returns an empty group.
    pub(super) fn new(own_weight: f64, inverse_h: f64) -> Self {
        let none = [0.0; GROUP];
        Self {
            waiting: 0,
            slots: [0; GROUP],
            weights: none,
            along: [none; D],
            across: [none; D],
            moment: [none; 6],
            sum: [[none; D]; D],
            own_weight,
            inverse_h,
        }
    }

    /// Adds the sums of the particle whose gradient goes to `slot`; writes all gradients once a
    /// group is complete.
    #[inline(always)]
    pub(super) fn push<R: Real>(&mut self, slot: usize, sums: &FlowSums<D>, to: &mut Gradients<R, D>) {
        let row = self.waiting % GROUP;
        self.slots[row] = slot;
        self.weights[row] = sums.weights;
        for i in 0..D {
            self.along[i][row] = sums.along[i];
            self.across[i][row] = sums.across[i];
            for j in 0..D {
                self.sum[i][j][row] = sums.sum[i][j];
            }
        }
        for component in 0..components(D) {
            self.moment[component][row] = sums.moment[component];
        }
        self.waiting += 1;
        if self.waiting == GROUP {
            self.write(to);
        }
    }

    /// Writes the gradients of all waiting particles.
    #[inline(always)]
    pub(super) fn write<R: Real>(&mut self, to: &mut Gradients<R, D>) {
        let gradient = self.gradients();
        let slots = &self.slots[..self.waiting.min(GROUP)];
        let (strain, whole) = to;
        for i in 0..D {
            for j in 0..=i {
                let mut mean = [0.0; GROUP];
                for row in 0..GROUP {
                    mean[row] = 0.5 * (gradient[i][j][row] + gradient[j][i][row]);
                }
                write_column(slots, &mean, strain[component::<D>(i, j)]);
            }
            for j in 0..D {
                write_column(slots, &gradient[i][j], whole[i][j]);
            }
        }
        self.waiting = 0;
    }

    /// Returns the gradient of each particle, 1/s; zero where the neighbours do not span all
    /// dimensions.
    ///
    /// It computes a whole group, in which entries behind the waiting ones have older sums and are
    /// not written.
    #[inline(always)]
    fn gradients(&self) -> [[GroupColumn; D]; D] {
        let mut gradient = [[[0.0; GROUP]; D]; D];
        for row in 0..GROUP {
            let weights = self.weights[row] - self.own_weight;
            let of_weights = if weights == 0.0 { 0.0 } else { 1.0 / weights };
            let mut moments = [[0.0; D]; D];
            let mut plain = [[0.0; D]; D];
            for i in 0..D {
                for j in 0..D {
                    // The moments are about the mean of the neighbours.
                    let (along, across) = (self.along[j][row], self.across[i][row]);
                    moments[i][j] =
                        self.moment[component::<D>(i, j)][row] - self.along[i][row] * along * of_weights;
                    plain[i][j] = self.inverse_h * (self.sum[i][j][row] - across * along * of_weights);
                }
            }
            let inverse = invert_symmetric(moments);
            for i in 0..D {
                for j in 0..D {
                    gradient[i][j][row] = (0..D).map(|k| plain[i][k] * inverse[k][j]).sum();
                }
            }
        }
        gradient
    }
}

/// Writes one number per particle to its slot.
#[inline(always)]
fn write_column<R: Real>(slots: &[usize], values: &GroupColumn, column: &mut [R]) {
    let (Some(first), Some(last)) = (slots.first(), slots.last()) else { return };
    if column.is_empty() {
        return;
    }
    if last - first < slots.len() {
        for (slot, value) in column[*first..=*last].iter_mut().zip(values) {
            *slot = R::from_f64(*value);
        }
    } else {
        for (slot, value) in slots.iter().zip(values) {
            column[*slot] = R::from_f64(*value);
        }
    }
}
