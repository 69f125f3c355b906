//! Traction of the transposed velocity gradient, which sums of ν ∇²v do not contain.
//!
//! ```text
//! σ·n = μ (∇v + (∇v)ᵀ)·n,   ((∇v)ᵀ·n)_i = ∂_i v_j n_j = Σ_τ τ_i (∂_τ v·n) − n_i Σ_τ ∂_τ v·τ
//! ```
//!
//! Inside the flow the divergence of (∇v)ᵀ is ∇(∇·v) and vanishes, so that it does not affect the
//! motion; on a surface it has a traction. This needs only the velocity along the surface, which is
//! that of the wall. By ∇·v = 0 the second sum equals the part n·∂_n v of the derivative along n.
//! On a surface that turns with ω the traction is μ n × ω. Over a closed body of volume V (in 2D
//! its area) its torque is −2 μ ω V and its force 0. On a surface at rest, or in translation, it is
//! 0. The stress is that of Newton, e.g. Batchelor (1967), Eq. 3.3.11.

use glam::DVec3;

/// Returns the traction on a surface of unit normal n into the fluid, Pa. Each unit tangent comes
/// with the derivative of the velocity of the surface along it, 1/s; `viscosity` is μ, Pa s.
pub fn transposed_traction(viscosity: f64, normal: DVec3, along: &[(DVec3, DVec3)]) -> DVec3 {
    let shear: DVec3 = along.iter().map(|(tangent, slope)| *tangent * slope.dot(normal)).sum();
    let widening: f64 = along.iter().map(|(tangent, slope)| slope.dot(*tangent)).sum();
    viscosity * (shear - normal * widening)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// For a field v = G·x without divergence, on any plane: (∇v)ᵀ·n, with ∂_i v_j = G_ji.
    #[test]
    fn the_traction_is_that_of_the_transposed_gradient() {
        let gradient = [[0.3, -0.7, 0.2], [1.1, 0.4, -0.5], [0.6, 0.8, -0.7]];
        let slope = |way: DVec3| DVec3::from(gradient.map(|row| DVec3::from(row).dot(way)));
        for normal in [DVec3::X, DVec3::new(0.48, -0.6, 0.64)] {
            let (first, second) = normal.any_orthonormal_pair();
            let found = transposed_traction(2.0, normal, &[(first, slope(first)), (second, slope(second))]);
            let all: DVec3 = (0..3).map(|j| DVec3::from(gradient[j]) * normal[j]).sum();
            assert!((found - 2.0 * all).length() < 1e-12, "{found} Pa, not {all} twice");
        }
    }

    #[test]
    fn a_turning_surface_has_the_traction_of_normal_cross_rate() {
        let (rate, normal) = (DVec3::new(0.2, -0.5, 1.3), DVec3::new(0.0, 0.6, 0.8));
        let (first, second) = normal.any_orthonormal_pair();
        let found = transposed_traction(3.0, normal, &[first, second].map(|way| (way, rate.cross(way))));
        assert!((found - 3.0 * normal.cross(rate)).length() < 1e-12, "{found}");
    }
}
