//! How fast an outflow zone is carried away.
//!
//! ```text
//! v̄_n = ⟨v_n⟩_f + (⟨p⟩_f − p_o)/(ρ0 c0)        ⟨·⟩_f fitted to the fluid a layer inside the particle's foot on the plane
//! p_o  = p − ½ ρ0 v̄_n²   where v̄_n < 0
//! ```
//!
//! The convective velocity of the wave equation, Alvarado-Rodríguez et al. (2017), Eq. 30, is a kernel mean; of the fluid next to the plane, by a fit that keeps its profile
//! (`systems/boundaries/wave_zone.rs`), it is the same along the normal, as Negi et al. (2020), Eqs. 17 and 18, move their outflow particles. So
//! the zone moves as a bundle of rods: what crosses the plane is carried off at the speed with which it comes, nothing piles up
//! and no gap opens, whether the flow starts from rest or a vortex sends it back through the lower half of the outlet. With
//! each particle's own frozen velocity the zone at rest blocks the flow, and a vortex cannot leave.
//!
//! The second term is the outgoing characteristic J2 = p + ρ0 c0 v_n, which must be the same on both sides of
//! the plane: where the fluid stands under more pressure than the zone, the rods give way. Without it the
//! rods repeat whatever the fluid does and nothing holds its density.
//!
//! Fluid that comes back is drawn from a reservoir at rest, so the sum of static and dynamic pressure is the
//! outlet's: the directional condition of Braack & Mucha (2014). With the static pressure alone a backflow feeds itself. An outlet whose
//! pressure is frozen or relaxed has no such level, and takes p as it is.

/// Convective velocity v̄_n, m/s, from the mean normal velocity (m/s) and pressure (Pa) of the fluid at the foot, the
/// pressure of the zone (Pa) and the impedance ρ0 c0 (kg/(m² s)).
pub fn convective_velocity(
    fluid_velocity: f64,
    fluid_pressure: f64,
    zone_pressure: f64,
    impedance: f64,
) -> f64 {
    fluid_velocity + (fluid_pressure - zone_pressure) / impedance
}

/// Pressure of an outflow particle, Pa: the outlet's, less the dynamic pressure of fluid that comes back.
pub fn backflow_pressure(pressure: f64, convective_velocity: f64, density: f64) -> f64 {
    let back = convective_velocity.min(0.0);
    pressure - 0.5 * density * back * back
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_outgoing_characteristic_is_the_same_on_both_sides() {
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
