//! Particles that keep what they had when they crossed.
//!
//! ```text
//! x_o(n) = x_o(n−1) + v_n Δt n,   v_o(n) = v_o(n−1),   p_o(n) = p_o(n−1)
//! ```
//!
//! Negi et al. (2020), Eqs. 14–16: ∂u/∂t + u ∂u/∂x = 0 for what the particle carries, after Federico et al. (2012). It
//! moves along the normal n of the outlet only, with its own normal velocity.
//!
//! What follows: what the zone holds at the start stays as it is, so that a zone at rest blocks a flow that starts from rest until the
//! fluid pushes its own particles across; sound is thrown back, since neither pressure nor velocity of the zone takes part in it; what
//! has crossed never comes back, so that a vortex loses what it would draw in; nothing anchors the pressure. Particles of one
//! column cross within a few steps of each other, and what the sound of that moment gave them stays with the column.
//!
//! The code of the authors moves the zone with the transport velocity of the crossing; here it is v itself, as printed: the other part of
//! the transport velocity evens out the lattice and has no mean.

use glam::DVec3;

use super::Outflow;

/// The particle with the velocity (m/s) and the pressure (Pa) of its crossing, which it still has, at an outlet of unit normal `normal`.
pub fn kept(velocity: DVec3, pressure: f64, normal: DVec3) -> Outflow {
    Outflow::moving(velocity, pressure, normal)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_is_kept_and_the_normal_velocity_moves() {
        let normal = DVec3::new(0.6, 0.8, 0.0);
        let velocity = DVec3::new(1.0, -0.5, 0.25);
        let outflow = kept(velocity, -3.0, normal);
        assert_eq!((outflow.velocity, outflow.pressure), (velocity, -3.0));
        assert!((outflow.speed - 0.2).abs() < 1e-15);
        assert_eq!(kept(outflow.velocity, outflow.pressure, normal), outflow);
    }
}
