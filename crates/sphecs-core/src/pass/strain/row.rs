//! Sums of one particle over its neighbours: kernel sum, moments of the flow, and slopes.

use crate::math::kernel::KernelShape;
use crate::math::lanes::{self, Lanes};
use crate::math::real::Real;
use crate::math::symmetric::component;
use crate::pass::density::squared_distance;
use crate::pass::pack::{CoveredLanes, NeighbourMask, Pack, Source, TILE_VECTORS};
use crate::pass::row_pass::splat;

/// Sums of one particle.
pub(super) struct RowSums<R, const D: usize> {
    /// Σ w(q) over all neighbours.
    pub kernel_sum: R,
    /// Moments of which the velocity gradient is made.
    pub of_flow: FlowSums<D>,
    /// Σ V_b slope · x_ab/h over all neighbours; 0 if it is not summed.
    pub slopes: [f64; D],
    /// Vectors of the pack with a neighbour in the support.
    pub near: NeighbourMask,
}

/// Sums over the flow with the weights of the slope, x = x_ab and v = v_ab.
pub(super) struct FlowSums<const D: usize> {
    /// Σ w, the particle itself included.
    pub weights: f64,
    /// Σ w x.
    pub along: [f64; D],
    /// Σ w v.
    pub across: [f64; D],
    /// Σ w x_i x_j, by component of a symmetric tensor.
    pub moment: [f64; 6],
    /// Σ w v_i x_j.
    pub sum: [[f64; D]; D],
}

/// Sums over a pack for the particle of a row, with the slopes if `SLOPES`. `all_slopes` is a
/// buffer for f(q) of a tile.
///
/// There are three loops. The first finds the neighbours in the support without a branch, the
/// second computes their roots and kernel, the third adds to the sums. In one loop the sums and the
/// kernel would need too many registers.
#[inline(always)]
pub(super) fn sum<K: KernelShape, L: Lanes, const D: usize, const SLOPES: bool>(
    pack: &Pack<L::Real>,
    source: &Source<L::Real, D>,
    row: usize,
    all_slopes: &mut [L; TILE_VECTORS],
) -> RowSums<L::Real, D> {
    let zero = L::constant(0.0);
    let x_a = splat::<L, D>(pack.relative(source, row));
    let mut v_a = [zero; D];
    for d in 0..D {
        v_a[d] = L::splat(source.columns[d][row]);
    }
    let mut kernel_sum = zero;
    let mut weight_sum = zero;
    let mut along_sum = [zero; D];
    let mut across_sum = [zero; D];
    let mut slopes = [zero; D];
    let mut sum = [[zero; D]; D];
    let mut moment = [zero; 6];
    let limit = L::constant(K::SUPPORT * K::SUPPORT);
    let mut near = NeighbourMask::ALL;
    let mut covered = CoveredLanes::default();
    for tile in pack.tiles::<L, D>(if SLOPES { 2 * D + 2 } else { 2 * D + 1 }) {
        let builder = tile.find_neighbours(x_a, limit);
        tile.store_mask(builder, &mut near);
        let lanes = tile.start_lanes(builder, &mut covered);
        for (slope, lane) in all_slopes.iter_mut().zip(lanes.clone()) {
            let (q, inverse_q) = squared_distance(x_a, tile.at_lane(lane)).roots();
            kernel_sum = K::add_value(q, kernel_sum);
            *slope = K::slope(q, inverse_q);
        }
        for (&of_all, lane) in all_slopes.iter().zip(lanes) {
            let entry = tile.at_lane(lane);
            let x = entry.seen_from(x_a);
            let slope = of_all * entry.column(2 * D);
            weight_sum = weight_sum + slope;
            if SLOPES {
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
    RowSums {
        kernel_sum: kernel_sum.sum(),
        of_flow: FlowSums {
            weights: weight_sum.sum().to_f64(),
            along: lanes::sums(along_sum),
            across: lanes::sums(across_sum),
            moment: lanes::sums(moment),
            sum: sum.map(lanes::sums),
        },
        slopes: lanes::sums(slopes),
        near,
    }
}
