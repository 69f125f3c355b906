//! Given pressure at an inlet.
//!
//! ```text
//! p_o = p_given + ρ0 f·(x_f − x_c)
//! ```
//!
//! f is the body force and x_f the foot of the particle on the plane: the pressure is given at the
//! centre x_c of the section.

use glam::DVec3;

use super::InletMethod;
use super::inflow_zone::InflowZone;
use crate::pass::pair_real::PairReal;
use crate::physics::parameter_fault::ParameterFault;

/// The given pressure, Pa.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prescribed(pub f64);

impl InletMethod for Prescribed {
    fn apply<R: PairReal<D>, const D: usize>(&self, zone: &mut InflowZone<'_, R, D>) {
        let (pressure, density, motion) = (self.0, zone.density, zone.motion);
        let centre = motion.centre();
        let weight = |foot: DVec3| {
            // The force at the middle is exact for a linear one.
            motion.body_force(0.5 * (centre + foot)).dot(foot - centre) * density
        };
        zone.set(1.0, |_, particle, _| pressure + weight(motion.foot(particle)));
    }

    fn faults(&self) -> Vec<ParameterFault> {
        ParameterFault::unless_finite("pressure", self.0, "Pa").into_iter().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_finite_pressure_is_taken() {
        assert_eq!(Prescribed(-5.0).faults(), []);
        assert_eq!(Prescribed(f64::INFINITY).faults().len(), 1);
    }
}
