//! Convective velocity of an outflow zone and pressure of backflow.
//!
//! ```text
//! v̄_n = ⟨v_n⟩_f + (⟨p⟩_f − p_o)/(ρ0 c0)
//! p_o  = p − ½ ρ0 v̄_n²   where v̄_n < 0
//! ```
//!
//! ⟨·⟩_f is fitted to the fluid a layer inside the foot of the particle on the plane.
//!
//! The convective velocity of the wave equation, Alvarado-Rodríguez et al. (2017), Eq. 30, is a
//! kernel mean. Here it is the velocity of the fluid next to the plane, by a fit that preserves its
//! profile. It is constant along the normal, as in Negi et al. (2020), Eqs. 17 and 18. So the zone
//! moves as a bundle of rods: the fluid that crosses the plane is carried off at the speed with
//! which it arrives. Nothing accumulates and no gap opens, whether the flow starts from rest or a
//! vortex sends it back through the lower half of the outlet. With the frozen velocity of each
//! particle the zone at rest blocks the flow, and a vortex cannot leave.
//!
//! The second term makes the outgoing characteristic J2 = p + ρ0 c0 v_n equal on both sides of the
//! plane. Where the pressure of the fluid exceeds that of the zone, the rods yield. Without it the
//! rods repeat the motion of the fluid, and nothing controls its density.
//!
//! Backflow is drawn from a reservoir at rest, so the sum of static and dynamic pressure equals the
//! outlet pressure. This is the directional condition of Braack & Mucha (2014). With the static
//! pressure alone a backflow amplifies itself. An outlet whose pressure is frozen or relaxed has no
//! such level and uses p unchanged.

/// Returns the convective velocity v̄_n, m/s. Arguments: normal velocity (m/s) and pressure (Pa) of
/// the fluid at the foot, pressure of the zone (Pa), impedance ρ0 c0 (kg/(m² s)).
pub fn convective_velocity(
    fluid_velocity: f64,
    fluid_pressure: f64,
    zone_pressure: f64,
    impedance: f64,
) -> f64 {
    fluid_velocity + (fluid_pressure - zone_pressure) / impedance
}

/// Returns the pressure of an outflow particle, Pa: the outlet pressure minus the dynamic pressure
/// of backflow.
pub fn backflow_pressure(pressure: f64, convective_velocity: f64, density: f64) -> f64 {
    let back = convective_velocity.min(0.0);
    pressure - 0.5 * density * back * back
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_outgoing_characteristic_is_equal_on_both_sides() {
        let (v, p, p_o, z) = (0.03, 12.0, 4.0, 4000.0);
        let v_o = convective_velocity(v, p, p_o, z);
        assert!((p_o + z * v_o - (p + z * v)).abs() < 1e-12);
    }

    #[test]
    fn backflow_keeps_the_total_pressure() {
        let p = backflow_pressure(5.0, -0.1, 1000.0);
        assert!((p + 0.5 * 1000.0 * 0.01 - 5.0).abs() < 1e-12);
        assert_eq!(backflow_pressure(5.0, 0.1, 1000.0), 5.0);
    }
}
