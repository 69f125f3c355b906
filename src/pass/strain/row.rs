//! The sums of one row: what every neighbour contributes to them.

use crate::math::kernel::KernelShape;
use crate::math::lanes::{self, Lanes};
use crate::math::linear::invert_symmetric;
use crate::math::real::Real;
use crate::pass::density::LEAST_Q2;
use crate::pass::pack::{Near, NearNotes, Pack, STRETCH, Source};
use crate::physics::sps::component;

/// What a row has summed up.
pub(super) struct RowSums<R, const D: usize> {
    /// Σ w(q) over all.
    pub kernel_sum: R,
    /// Gradient of the velocity over the flow, the row itself left out, 1/s.
    pub gradient: [[f64; D]; D],
    /// Σ V_b slope · x_ab/h over all, or 0.
    pub slopes: [f64; D],
    /// Which vectors of the pack have something in the support.
    pub near: Near,
}

/// Sums over a pack for a row; `CROWDED`: the slopes, too. `all_slopes` is room for f(q) of a stretch.
///
/// In two walks: what all need, without a branch, and then the many sums over what is near, which in one would find no registers, and
/// wait for a wrong guess once or twice a row.
#[inline(always)]
pub(super) fn sum<K: KernelShape, L: Lanes, const D: usize, const CROWDED: bool>(
    pack: &Pack<L::Real>,
    source: &Source<L::Real, D>,
    row: usize,
    all_slopes: &mut [L; STRETCH],
) -> RowSums<L::Real, D> {
    let zero = L::constant(0.0);
    let point = pack.relative(source, row);
    let mut x_a = [zero; D];
    let mut v_a = [zero; D];
    for d in 0..D {
        x_a[d] = L::splat(point[d]);
        v_a[d] = L::splat(source.columns[d][row]);
    }
    let mut kernel_sum = zero;
    let mut weight_sum = zero;
    let mut along_sum = [zero; D];
    let mut across_sum = [zero; D];
    let mut slopes = [zero; D];
    let mut sum = [[zero; D]; D];
    // By component: M is symmetric.
    let mut moment = [zero; 6];
    let limit = L::constant(K::SUPPORT * K::SUPPORT);
    let mut near = Near::ALL;
    for stretch in pack.stretches::<L>(if CROWDED { 2 * D + 2 } else { 2 * D + 1 }) {
        let mut notes = NearNotes::default();
        for vector in 0..stretch.len() {
            let entry = stretch.at(vector);
            let mut q2 = L::constant(LEAST_Q2);
            for d in 0..D {
                let x = x_a[d] - entry.column(d);
                q2 = x.mul_add(x, q2);
            }
            notes.take::<L, D>(q2, limit);
            let (q, inverse_q) = q2.roots();
            kernel_sum = kernel_sum + K::value(q);
            all_slopes[vector % STRETCH] = K::slope(q, inverse_q);
        }
        let of_stretch = notes.done::<D>();
        near = stretch.of_pack(of_stretch);
        for vector in stretch.near(of_stretch) {
            let entry = stretch.at(vector);
            let mut x = [zero; D];
            for d in 0..D {
                x[d] = x_a[d] - entry.column(d);
            }
            let of_all = all_slopes[vector % STRETCH];
            let slope = of_all * entry.column(2 * D);
            weight_sum = weight_sum + slope;
            if CROWDED {
                let of_volume = of_all * entry.column(2 * D + 1);
                for d in 0..D {
                    slopes[d] = of_volume.mul_add(x[d], slopes[d]);
                }
            }
            for i in 0..D {
                let across = slope * (v_a[i] - entry.column(D + i));
                let along = slope * x[i];
                across_sum[i] = across_sum[i] + across;
                along_sum[i] = along_sum[i] + along;
                for j in 0..D {
                    sum[i][j] = across.mul_add(x[j], sum[i][j]);
                    if j <= i {
                        let at = component::<D>(i, j);
                        moment[at] = along.mul_add(x[j], moment[at]);
                    }
                }
            }
        }
    }
    // The sums lack the same factor, but for one h: ∇W = scale · slope · x_ab/h. The row itself is in none but the first.
    let nearest = L::constant(LEAST_Q2);
    let (q, inverse_q) = nearest.roots();
    let own_weight = K::slope(q, inverse_q).largest().to_f64();
    let weights = weight_sum.sum().to_f64() - own_weight;
    let of_weights = if weights == 0.0 { 0.0 } else { 1.0 / weights };
    let along = lanes::sums(along_sum);
    let across = lanes::sums(across_sum);
    let mut moments = [[0.0; D]; D];
    let mut plain = [[0.0; D]; D];
    for i in 0..D {
        for j in 0..D {
            // About the mean of the neighbours.
            moments[i][j] = moment[component::<D>(i, j)].sum().to_f64() - along[i] * along[j] * of_weights;
            plain[i][j] = source.inverse_h * (sum[i][j].sum().to_f64() - across[i] * along[j] * of_weights);
        }
    }
    let mut gradient = [[0.0; D]; D];
    // Fewer neighbours than dimensions say nothing of a gradient.
    if let Some(inverse) = invert_symmetric(moments) {
        for i in 0..D {
            for j in 0..D {
                gradient[i][j] = (0..D).map(|k| plain[i][k] * inverse[k][j]).sum();
            }
        }
    }
    RowSums { kernel_sum: kernel_sum.sum(), gradient, slopes: lanes::sums(slopes), near }
}
