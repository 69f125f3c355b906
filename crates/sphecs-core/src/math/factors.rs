//! LDLᵀ factors of small symmetric matrices, one matrix per lane.
//!
//! ```text
//! M = L D Lᵀ,   L_ii = 1,   d_j = M_jj − Σ_{k<j} L_jk² d_k
//! ```
//!
//! The factors of a leading block are the leading block of the factors, so that fits by the first
//! functions of a basis and by all of them share one factorisation. There are no branches: a lane
//! whose matrix is singular has a pivot of no meaning, which the caller must check.

use super::lanes::Lanes;

/// Factors of a matrix of `N` rows in each lane.
#[derive(Clone, Copy, Debug)]
pub struct Factors<L, const N: usize> {
    /// L below the diagonal.
    lower: [[L; N]; N],
    /// The diagonal D.
    pub pivots: [L; N],
    /// Its inverses.
    inverse: [L; N],
}

impl<L: Lanes, const N: usize> Factors<L, N> {
    /// Factorises matrices of which the upper triangles are given. Pivots below `least` count as
    /// `least`, so that nothing overflows.
    #[inline(always)]
    pub fn of(matrix: &[[L; N]; N], least: L) -> Self {
        let zero = L::constant(0.0);
        let mut factors = Self { lower: [[zero; N]; N], pivots: [zero; N], inverse: [zero; N] };
        for j in 0..N {
            // L_jk d_k, used by all rows below.
            let mut scaled = [zero; N];
            let mut pivot = matrix[j][j];
            for k in 0..j {
                scaled[k] = factors.lower[j][k] * factors.pivots[k];
                pivot = pivot - factors.lower[j][k] * scaled[k];
            }
            factors.pivots[j] = pivot;
            factors.inverse[j] = L::constant(1.0) / pivot.max(least);
            for i in j + 1..N {
                let mut entry = matrix[j][i];
                for k in 0..j {
                    entry = entry - factors.lower[i][k] * scaled[k];
                }
                factors.lower[i][j] = entry * factors.inverse[j];
            }
        }
        factors
    }

    /// Returns L⁻¹ `right`, from which [`Self::solution`] follows for every leading block.
    #[inline(always)]
    pub fn forward(&self, right: &[L; N]) -> [L; N] {
        let mut result = *right;
        for i in 0..N {
            for k in 0..i {
                result[i] = result[i] - self.lower[i][k] * result[k];
            }
        }
        result
    }

    /// Returns the solution for the leading block of `size` rows; the other entries are 0.
    #[inline(always)]
    pub fn solution(&self, forward: &[L; N], size: usize) -> [L; N] {
        let mut result = [L::constant(0.0); N];
        for i in (0..size).rev() {
            result[i] = forward[i] * self.inverse[i];
            for k in i + 1..size {
                result[i] = result[i] - self.lower[k][i] * result[k];
            }
        }
        result
    }

    /// Returns (M⁻¹)_00.
    #[inline(always)]
    pub fn first_of_inverse(&self) -> L {
        let mut unit = [L::constant(0.0); N];
        unit[0] = L::constant(1.0);
        let forward = self.forward(&unit);
        let mut sum = L::constant(0.0);
        for i in 0..N {
            sum = (forward[i] * forward[i]).mul_add(self.inverse[i], sum);
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::Array;
    use crate::math::linear::{invert, solve};

    #[test]
    fn solutions_of_all_leading_blocks_agree_with_elimination() {
        let matrix = [[4.0, 1.0, -0.5], [1.0, 3.0, 0.7], [-0.5, 0.7, 2.0]];
        let right = [1.0, -2.0, 0.5];
        let lanes = |x: f64| Array([x; 2]);
        let factors = Factors::of(&matrix.map(|row| row.map(lanes)), lanes(1e-12));
        let forward = factors.forward(&right.map(lanes));
        let whole = solve(matrix, right).expect("regular");
        let [a, b, _] = right;
        let block = solve([[4.0, 1.0], [1.0, 3.0]], [a, b]).expect("regular");
        for (found, expected) in factors.solution(&forward, 3).iter().zip(whole) {
            assert!((found.0[1] - expected).abs() < 1e-14);
        }
        let found = factors.solution(&forward, 2);
        assert!((found[0].0[0] - block[0]).abs() < 1e-14 && (found[1].0[0] - block[1]).abs() < 1e-14);
        let inverse = invert(matrix).expect("regular");
        assert!((factors.first_of_inverse().0[0] - inverse[0][0]).abs() < 1e-14);
    }
}
