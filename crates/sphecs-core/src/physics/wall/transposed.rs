//! The part of a surface's shear that sums of ν ∇²v do not have: that of the transposed velocity gradient.
//!
//! ```text
//! σ·n = μ (∇v + (∇v)ᵀ)·n,   ((∇v)ᵀ·n)_i = ∂_i v_j n_j = Σ_τ τ_i (∂_τ v·n) − n_i Σ_τ ∂_τ v·τ
//! ```
//!
//! Inside the flow the divergence of (∇v)ᵀ is ∇(∇·v) and vanishes, so that the motion does not know it; on a surface its traction
//! is there. It needs the velocity along the surface alone, which is that of the wall: the derivative along n has no part n·∂_n v but what
//! ∇·v = 0 leaves it, the second sum. On a surface that turns with ω it is μ n × ω, whose torque is −2 μ ω V over a closed body of
//! volume V (in 2D its area), whose force is nought; on one at rest, or one that moves as a whole, it is nought. The stress is that
//! of Newton, e.g. Batchelor (1967), Eq. 3.3.11.

use glam::DVec3;

/// Its traction on a surface of unit normal n into the fluid, Pa, by the tangents (unit) and the derivative of the surface's velocity along
/// each, 1/s; `viscosity` is μ, Pa s.
pub fn transposed_traction(viscosity: f64, normal: DVec3, along: &[(DVec3, DVec3)]) -> DVec3 {
    let shear: DVec3 = along.iter().map(|(tangent, slope)| *tangent * slope.dot(normal)).sum();
    let widening: f64 = along.iter().map(|(tangent, slope)| slope.dot(*tangent)).sum();
    viscosity * (shear - normal * widening)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of a field of v = G·x with no divergence, whatever the plane: (∇v)ᵀ·n, with ∂_i v_j = G_ji.
    #[test]
    fn it_is_that_of_the_transposed_gradient() {
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
    fn what_turns_has_the_normal_across_its_rate() {
        let (rate, normal) = (DVec3::new(0.2, -0.5, 1.3), DVec3::new(0.0, 0.6, 0.8));
        let (first, second) = normal.any_orthonormal_pair();
        let found = transposed_traction(3.0, normal, &[first, second].map(|way| (way, rate.cross(way))));
        assert!((found - 3.0 * normal.cross(rate)).length() < 1e-12, "{found}");
    }
}
