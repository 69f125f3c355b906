//! Rate of strain of the flow's rows, for the damping of noise.

use std::ops::Range;

use super::blocks::for_each_part;
use super::sums::PairSums;
use crate::math::real::Real;
use crate::physics::sps::{component, components};

/// Sets the symmetric part of the velocity gradient in `sums`, for all rows that have one.
pub fn find_strain<R: Real, const D: usize>(sums: &mut PairSums<R, D>) {
    let rows = sums.gradient[0][0].len();
    for column in sums.strain.iter_mut().take(components(D)) {
        column.resize(rows, R::default());
    }
    let gradient = &sums.gradient;
    let half = R::from_f64(0.5);
    let work = |rows: Range<usize>, strain: [&mut [R]; 6]| {
        for i in 0..D {
            for j in 0..=i {
                let sides = gradient[i][j][rows.clone()].iter().zip(&gradient[j][i][rows.clone()]);
                for (strain, (&one, &other)) in strain[component::<D>(i, j)].iter_mut().zip(sides) {
                    *strain = half * (one + other);
                }
            }
        }
    };
    for_each_part(0..rows, sums.strain.each_mut().map(Vec::as_mut_slice), &work);
}
