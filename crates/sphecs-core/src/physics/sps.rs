//! Sub-particle-scale stress.
//!
//! ```text
//! S_ij = ½ (∂v_i/∂x_j + ∂v_j/∂x_i),   |S| = √(2 S_ij S_ij),   ν_t = (C_s Δ)² |S|
//! T_ij = ρ (2 ν_t S_ij − ⅔ ν_t S_kk δ_ij) − ⅔ ρ C_I Δ² |S|² δ_ij
//! dv_a/dt = Σ_b m_b (T_a/ρ_a² + T_b/ρ_b²) · ∇W
//! ```
//!
//! Alvarado-Rodríguez et al. (2017), Eqs. 7, 8 and 10, with the misprints resolved: S_ij carries a minus sign there,
//! ν_t is missing in the second term of T and |S|² in the third (without them the units are wrong), and C_I is
//! 0.00066 for 0.0066. The third term only shifts the pressure.

use crate::math::lanes::Lanes;

/// Constants of the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sps {
    /// Smagorinsky constant C_s.
    pub smagorinsky: f64,
    /// Constant C_I of the isotropic part.
    pub isotropic: f64,
    /// Filter width Δ, m.
    pub spacing: f64,
}

/// Where the components of a symmetric tensor stand: xx, yy, xy in 2D, xx, yy, zz, xy, yz, zx in 3D.
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

impl Sps {
    /// T/ρ², m⁵/(kg s²), by component (the rest of the six is zero), and ν_t, m²/s, of a velocity gradient
    /// `gradient[i][j]` = ∂v_i/∂x_j (1/s) at a density (kg/m³).
    pub fn stress<const D: usize>(&self, gradient: [[f64; D]; D], density: f64) -> ([f64; 6], f64) {
        let strain = |i: usize, j: usize| 0.5 * (gradient[i][j] + gradient[j][i]);
        let mut square = 0.0;
        let mut trace = 0.0;
        for i in 0..D {
            trace += strain(i, i);
            for j in 0..D {
                square += strain(i, j) * strain(i, j);
            }
        }
        let square = 2.0 * square;
        let eddy = (self.smagorinsky * self.spacing).powi(2) * square.sqrt();
        let isotropic = 2.0 / 3.0 * (eddy * trace + self.isotropic * self.spacing.powi(2) * square);
        let mut stress = [0.0; 6];
        for i in 0..D {
            for j in 0..=i {
                let diagonal = if i == j { isotropic } else { 0.0 };
                stress[component::<D>(i, j)] = (2.0 * eddy * strain(i, j) - diagonal) / density;
            }
        }
        (stress, eddy)
    }
}

/// Product of a symmetric tensor, given by its components, with a vector.
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

    const MODEL: Sps = Sps { smagorinsky: 0.12, isotropic: 0.0066, spacing: 0.01 };

    #[test]
    fn plane_shear_has_the_smagorinsky_stress() {
        let shear = 30.0;
        let (stress, eddy) = MODEL.stress([[0.0, shear], [0.0, 0.0]], 1000.0);
        let expected = (0.12f64 * 0.01).powi(2) * shear;
        assert!((eddy - expected).abs() < 1e-15);
        assert!((stress[2] - expected * shear / 1000.0).abs() < 1e-15);
        let isotropic = -2.0 / 3.0 * 0.0066 * 1e-4 * shear * shear / 1000.0;
        assert!((stress[0] - isotropic).abs() < 1e-15 && (stress[1] - isotropic).abs() < 1e-15);
    }

    #[test]
    fn solid_rotation_has_no_stress() {
        let (stress, eddy) = MODEL.stress([[0.0, -2.0, 1.0], [2.0, 0.0, 3.0], [-1.0, -3.0, 0.0]], 998.0);
        assert_eq!((stress, eddy), ([0.0; 6], 0.0));
    }

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
