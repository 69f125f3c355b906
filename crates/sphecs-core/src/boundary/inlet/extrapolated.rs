//! Pressure at an inlet, extrapolated from the fluid.
//!
//! ```text
//! p_o = p(x_k) + ρ0 (g − dv_in/dt + ν ∇²v_in)·(x_o − x_k),   x_k = x_o − 2 ((x_o − x_plane)·n) n
//! ```
//!
//! The first term is the pressure of the fluid at the mirror image of the particle in the plane. It
//! is a first-order corrected sum: Negi et al. (2020), Eq. 22. The second continues it to the
//! particle by the pressure gradient that the prescribed motion needs. Extrapolating the sampled
//! gradient instead would multiply its noise by the distance.
//!
//! The pressure of a particle follows p_o over the time in which sound travels two spacings. If it
//! followed at once, the inlet would reflect sound with a gain, because the sums extrapolate where
//! the first layer of fluid is away from the plane. Poiseuille flow at c0 = 2 m/s then diverged
//! when its first particles crossed the plane. An inlet whose pressure lags yields to the wave and
//! absorbs its energy. The flow then stays within 0.1 % of the series.

use super::InletMethod;
use super::inflow_zone::InflowZone;
use crate::pass::pair_real::PairReal;

/// Time over which an extrapolated pressure is followed, in travel times of sound over Δ.
const LAG: f64 = 2.0;

/// The condition; it has no parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extrapolated;

impl InletMethod for Extrapolated {
    fn apply<R: PairReal<D>, const D: usize>(&self, zone: &mut InflowZone<'_, R, D>) {
        let lag = LAG * zone.spacing / zone.sound_speed;
        let share = zone.time_step / (zone.time_step + lag);
        zone.fit_mirrored_pressure();
        let (density, motion) = (zone.density, zone.motion);
        zone.set(share, |fitted, particle, own| match fitted {
            Some(flow) => {
                // Rise of the pressure from the particle to its mirror image.
                let gradient = motion.pressure_force(particle) * density;
                flow.pressure - gradient.dot(motion.mirrored(particle) - particle.position)
            }
            None => own,
        });
    }
}
