//! The ends of rows: gradients of velocity from what the rows have summed up, many at a time, so that the loops are over vectors.

use super::row::FlowSums;
use crate::math::linear::invert_symmetric;
use crate::math::real::Real;
use crate::math::symmetric::{component, components};
use crate::pass::blocks::GROUP;

/// A number of each row.
type Column = [f64; GROUP];

/// The columns that gradients and their symmetric parts are written to, of a block's rows; one that is empty is left out.
pub(super) type Gradients<'a, R, const D: usize> = ([&'a mut [R]; 6], [[&'a mut [R]; D]; D]);

/// Sums of rows that wait for their ends.
pub(super) struct Ends<const D: usize> {
    /// How many wait.
    waiting: usize,
    /// Their places in the columns that are written to.
    places: [usize; GROUP],
    weights: Column,
    along: [Column; D],
    across: [Column; D],
    moment: [Column; 6],
    sum: [[Column; D]; D],
    /// w of a row itself, which is in no sum but that of the weights.
    own_weight: f64,
    /// 1/m, since distances are in units of h.
    inverse_h: f64,
}

impl<const D: usize> Ends<D> {
    pub(super) fn new(own_weight: f64, inverse_h: f64) -> Self {
        let none = [0.0; GROUP];
        Ends {
            waiting: 0,
            places: [0; GROUP],
            weights: none,
            along: [none; D],
            across: [none; D],
            moment: [none; 6],
            sum: [[none; D]; D],
            own_weight,
            inverse_h,
        }
    }

    /// Takes the sums of the row whose results go to `place`, and writes what waits as soon as there is no room for another.
    #[inline(always)]
    pub(super) fn take<R: Real>(&mut self, place: usize, sums: &FlowSums<D>, to: &mut Gradients<R, D>) {
        let row = self.waiting % GROUP;
        self.places[row] = place;
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

    /// Writes the gradients of all that waits.
    #[inline(always)]
    pub(super) fn write<R: Real>(&mut self, to: &mut Gradients<R, D>) {
        let gradient = self.gradients();
        let places = &self.places[..self.waiting.min(GROUP)];
        let (strain, whole) = to;
        for i in 0..D {
            for j in 0..=i {
                let mut mean = [0.0; GROUP];
                for row in 0..GROUP {
                    mean[row] = 0.5 * (gradient[i][j][row] + gradient[j][i][row]);
                }
                write_column(places, &mean, strain[component::<D>(i, j)]);
            }
            for j in 0..D {
                write_column(places, &gradient[i][j], whole[i][j]);
            }
        }
        self.waiting = 0;
    }

    /// The gradient of each row, 1/s; zero where fewer neighbours than dimensions, or those in a line, say nothing of it.
    ///
    /// Over all rows there is room for: those that do not wait have sums of earlier ones, and are not written.
    #[inline(always)]
    fn gradients(&self) -> [[Column; D]; D] {
        let mut gradient = [[[0.0; GROUP]; D]; D];
        for row in 0..GROUP {
            let weights = self.weights[row] - self.own_weight;
            let of_weights = if weights == 0.0 { 0.0 } else { 1.0 / weights };
            let mut moments = [[0.0; D]; D];
            let mut plain = [[0.0; D]; D];
            for i in 0..D {
                for j in 0..D {
                    // About the mean of the neighbours.
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

/// Writes a number of each row to its place.
#[inline(always)]
fn write_column<R: Real>(places: &[usize], values: &Column, column: &mut [R]) {
    let (Some(first), Some(last)) = (places.first(), places.last()) else { return };
    if column.is_empty() {
        return;
    }
    if last - first < places.len() {
        for (slot, value) in column[*first..=*last].iter_mut().zip(values) {
            *slot = R::from_f64(*value);
        }
    } else {
        for (place, value) in places.iter().zip(values) {
            column[*place] = R::from_f64(*value);
        }
    }
}
