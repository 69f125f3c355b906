//! Small linear systems, by elimination with row pivoting.

/// Solves `matrix · x = right`; None if the matrix is singular or not finite.
///
/// A pivot below 1e-10 of the largest entry counts as zero. In moment matrices of kernel sums it is
/// rounding error; dividing by it would move a particle across the domain. The unknowns must
/// therefore be of similar size, such as distances over h.
pub fn solve<const N: usize>(mut matrix: [[f64; N]; N], mut right: [f64; N]) -> Option<[f64; N]> {
    const SINGULAR: f64 = 1e-10;
    let largest = matrix.iter().flatten().fold(0.0, |largest: f64, entry| largest.max(entry.abs()));
    for column in 0..N {
        let pivot =
            (column..N).max_by(|&a, &b| matrix[a][column].abs().total_cmp(&matrix[b][column].abs()))?;
        let size = matrix[pivot][column].abs();
        if !size.is_finite() || size <= SINGULAR * largest {
            return None;
        }
        matrix.swap(column, pivot);
        right.swap(column, pivot);
        for row in column + 1..N {
            let factor = matrix[row][column] / matrix[column][column];
            for k in column..N {
                matrix[row][k] -= factor * matrix[column][k];
            }
            right[row] -= factor * right[column];
        }
    }
    for row in (0..N).rev() {
        for k in row + 1..N {
            right[row] -= matrix[row][k] * right[k];
        }
        right[row] /= matrix[row][row];
    }
    right.iter().all(|x| x.is_finite()).then_some(right)
}

/// Returns the inverse of a matrix; None if it is singular as defined for [`solve`].
pub fn invert<const N: usize>(matrix: [[f64; N]; N]) -> Option<[[f64; N]; N]> {
    let mut inverse = [[0.0; N]; N];
    for column in 0..N {
        let unit = std::array::from_fn(|row| f64::from(u8::from(row == column)));
        let solution = solve(matrix, unit)?;
        for row in 0..N {
            inverse[row][column] = solution[row];
        }
    }
    Some(inverse)
}

/// Returns the inverse of a symmetric matrix of two or three rows by cofactors, without branches
/// for hot loops.
///
/// Zero if its determinant is not finite or below 1e-10 of the square (3D: cube) of its largest
/// entry.
#[inline(always)]
pub fn invert_symmetric<const N: usize>(matrix: [[f64; N]; N]) -> [[f64; N]; N] {
    const SINGULAR: f64 = 1e-10;
    let largest = matrix.iter().flatten().fold(0.0, |largest: f64, entry| largest.max(entry.abs()));
    let mut cofactors = [[0.0; N]; N];
    if N == 2 {
        cofactors[0][0] = matrix[1][1];
        cofactors[0][1] = -matrix[0][1];
        cofactors[1][1] = matrix[0][0];
    } else {
        for i in 0..3 {
            for j in i..3 {
                let (k, l, m, n) = ((i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3);
                cofactors[i][j] = matrix[k][m] * matrix[l][n] - matrix[k][n] * matrix[l][m];
            }
        }
    }
    let determinant: f64 = (0..N).map(|j| matrix[0][j] * cofactors[0][j]).sum();
    let smallest = SINGULAR * largest.powi(N as i32);
    let regular = determinant.is_finite() && determinant.abs() > smallest;
    let scale = if regular { 1.0 / determinant } else { 0.0 };
    let mut inverse = [[0.0; N]; N];
    for i in 0..N {
        for j in i..N {
            inverse[i][j] = if regular { scale * cofactors[i][j] } else { 0.0 };
            inverse[j][i] = inverse[i][j];
        }
    }
    inverse
}

#[cfg(test)]
mod tests {
    use proptest::{prop_assert, proptest};

    use super::*;

    proptest! {
        #[test]
        fn solution_satisfies_the_system(
            matrix in proptest::array::uniform4(proptest::array::uniform4(-1.0..1.0)),
            right in proptest::array::uniform4(-1.0..1.0),
        ) {
            if let Some(x) = solve(matrix, right) {
                for row in 0..4 {
                    let left: f64 = (0..4).map(|k| matrix[row][k] * x[k]).sum();
                    let size = x.iter().fold(1.0, |a: f64, b| a.max(b.abs()));
                    prop_assert!((left - right[row]).abs() < 1e-12 * size);
                }
            }
        }
    }

    #[test]
    fn singular_systems_have_no_solution() {
        assert_eq!(solve([[1.0, 2.0], [2.0, 4.0]], [1.0, 2.0]), None);
        assert_eq!(solve([[0.0; 3]; 3], [0.0; 3]), None);
        assert_eq!(solve([[f64::NAN, 0.0], [0.0, 1.0]], [1.0, 1.0]), None);
        assert_eq!(solve([[f64::INFINITY, 0.0], [0.0, 1.0]], [1.0, 1.0]), None);
    }

    #[test]
    fn a_zero_on_the_diagonal_is_pivoted() {
        assert_eq!(solve([[0.0, 1.0], [1.0, 0.0]], [3.0, 5.0]), Some([5.0, 3.0]));
        assert_eq!(invert([[0.0, 2.0], [4.0, 0.0]]), Some([[0.0, 0.25], [0.5, 0.0]]));
    }

    #[test]
    fn cofactors_agree_with_elimination() {
        let flat = [[-2.0, 0.3], [0.3, -1.0]];
        let deep = [[-2.0, 0.3, 0.1], [0.3, -1.0, -0.4], [0.1, -0.4, -3.0]];
        let (Some(a), b) = (invert(flat), invert_symmetric(flat)) else { panic!("regular") };
        assert!(a.iter().flatten().zip(b.iter().flatten()).all(|(a, b)| (a - b).abs() < 1e-14));
        let (Some(a), b) = (invert(deep), invert_symmetric(deep)) else { panic!("regular") };
        assert!(a.iter().flatten().zip(b.iter().flatten()).all(|(a, b)| (a - b).abs() < 1e-14));
        assert_eq!(invert_symmetric([[1.0, 1.0], [1.0, 1.0]]), [[0.0; 2]; 2]);
        assert_eq!(invert_symmetric([[0.0; 3]; 3]), [[0.0; 3]; 3]);
        assert_eq!(invert_symmetric([[f64::NAN; 3]; 3]), [[0.0; 3]; 3]);
    }
}
