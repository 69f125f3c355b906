//! The outgoing characteristic about reference values; nothing comes in.
//!
//! ```text
//! J2 = ρ0 c0 (v_n − u_ref) + (p − p_ref)     carried out by the fluid: Σ V_b J2,b W_ob / Σ V_b W_ob
//! J3 = −ρ0 c0 (v_n − u_ref) + (p − p_ref)    would come in from outside: 0
//! v_n = u_ref + J2/(2 ρ0 c0),   p = p_ref + J2/2
//! ```
//!
//! Negi et al. (2020), Eqs. 25–27, after Lastiwka et al. (2009). The components along the plane stay as they were when the
//! particle crossed; it moves along the normal with v_n. Particles that see no fluid take the mean J2 of those that do, in the same
//! step; in print in the one before.
//!
//! * The impedance is ρ0 c0 throughout, where the print has the local density: they differ by the Mach number squared.
//! * J1 = −c0² (ρ − ρ0) + (p − p_ref), which gives the density, is not carried: here the density follows from the pressure (`Wcsph`, for
//!   which J1 is of second order) or from where the particles stand (`EdacTvf`).
//! * A stream of another velocity than u_ref is sound to the condition: it keeps a pressure of ρ0 c0 (v_n − u_ref). So the references
//!   have no default. A vortex is sound, too: its pressure at the outlet is wrong by ½ ρ0 c0 v'.
//! * A wave at the angle θ is reflected by (1 − cos θ)/(1 + cos θ).
//! * Backflow: J2 still comes from inside and drives the zone back through the plane with the v_n that it gives, without the loss of
//!   pressure of a real inflow; what comes in has the velocity along the plane that its predecessor had, since the entropy and vorticity
//!   that should come from outside are not known. A uniform stream inwards stays one if u_ref is its velocity (tests/outlets.rs).

use glam::DVec3;

use super::Outflow;

/// Reference values of the characteristics.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct References {
    /// Velocity along the normal, m/s.
    pub velocity: f64,
    /// Pressure, Pa.
    pub pressure: f64,
}

impl References {
    /// J2 of a flow with a normal velocity (m/s) and a pressure (Pa), impedance ρ0 c0 in kg/(m² s), Pa.
    pub fn outgoing(&self, velocity: f64, pressure: f64, impedance: f64) -> f64 {
        impedance * (velocity - self.velocity) + (pressure - self.pressure)
    }

    /// Normal velocity (m/s) and pressure (Pa) where J2 (Pa) goes out and nothing comes in.
    pub fn at(&self, outgoing: f64, impedance: f64) -> (f64, f64) {
        (self.velocity + 0.5 * outgoing / impedance, self.pressure + 0.5 * outgoing)
    }

    /// The particle with its velocity (m/s) along the plane where J2 (Pa) goes out.
    pub fn outflow(&self, velocity: DVec3, outgoing: f64, impedance: f64, normal: DVec3) -> Outflow {
        let (speed, pressure) = self.at(outgoing, impedance);
        Outflow { velocity, pressure, speed }.at_speed(speed, normal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REFERENCES: References = References { velocity: 0.2, pressure: 5.0 };

    #[test]
    fn an_outgoing_wave_goes_on_as_it_is() {
        // p' = ρ c v'.
        let outgoing = REFERENCES.outgoing(0.2 + 0.003, 5.0 + 30.0, 1e4);
        let (velocity, pressure) = REFERENCES.at(outgoing, 1e4);
        assert!((velocity - 0.203).abs() < 1e-15 && (pressure - 35.0).abs() < 1e-12, "{velocity} {pressure}");
    }

    #[test]
    fn what_comes_in_is_none() {
        // p' = −ρ c v' has no J2: the outlet is at its references.
        let outgoing = REFERENCES.outgoing(0.2 - 0.003, 5.0 + 30.0, 1e4);
        let (velocity, pressure) = REFERENCES.at(outgoing, 1e4);
        assert!((velocity - 0.2).abs() < 1e-14 && (pressure - 5.0).abs() < 1e-10, "{velocity} {pressure}");
    }

    #[test]
    fn only_the_normal_velocity_is_set() {
        let normal = DVec3::new(0.0, 0.6, -0.8);
        let outflow = REFERENCES.outflow(DVec3::new(1.0, 2.0, 3.0), 0.0, 1e4, normal);
        assert!((outflow.velocity.dot(normal) - 0.2).abs() < 1e-15 && outflow.speed == 0.2);
        let along = outflow.velocity - normal * outflow.velocity.dot(normal);
        let before = DVec3::new(1.0, 2.0, 3.0);
        assert!(along.distance(before - normal * before.dot(normal)) < 1e-15);
    }
}
