//! Symmetric tensors, stored by component: xx, yy, xy in 2D and xx, yy, zz, xy, yz, zx in 3D.

use super::lanes::Lanes;

/// Index of the component of row `i` and column `j`.
#[inline(always)]
pub const fn component<const D: usize>(i: usize, j: usize) -> usize {
    if i == j {
        i
    } else if D == 2 {
        2
    } else {
        // xy, yz, zx: the indices sum to 1, 3 and 2.
        match i + j {
            1 => 3,
            3 => 4,
            _ => 5,
        }
    }
}

/// Number of components of a symmetric tensor.
#[inline(always)]
pub const fn components(dimensions: usize) -> usize {
    dimensions * (dimensions + 1) / 2
}

/// Sum of two symmetric tensors; components beyond those of `D` dimensions are those of `a`.
#[inline(always)]
pub fn sum<L: Lanes, const D: usize>(a: [L; 6], b: [L; 6]) -> [L; 6] {
    let mut sum = a;
    for (sum, b) in sum.iter_mut().zip(b).take(components(D)) {
        *sum = *sum + b;
    }
    sum
}

/// Product of a symmetric tensor with a vector.
#[inline(always)]
pub fn product<L: Lanes, const D: usize>(tensor: [L; 6], x: [L; D]) -> [L; D] {
    let mut product = [L::constant(0.0); D];
    for i in 0..D {
        for j in 0..D {
            product[i] = tensor[component::<D>(i, j)].mul_add(x[j], product[i]);
        }
    }
    product
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn components_of_a_tensor_are_all_different() {
        let mut seen = [false; 6];
        for (i, j) in [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)] {
            assert_eq!(component::<3>(i, j), component::<3>(j, i));
            seen[component::<3>(i, j)] = true;
        }
        assert_eq!(seen, [true; 6]);
        assert_eq!([component::<2>(0, 0), component::<2>(1, 1), component::<2>(0, 1)], [0, 1, 2]);
    }
}
