//! Given pressure at an inlet.
//!
//! ```text
//! p_o = p_given
//! ```

use super::InletMethod;
use super::inflow_zone::InflowZone;
use crate::pass::pair_real::PairReal;
use crate::physics::parameter_fault::ParameterFault;

/// The given pressure, Pa.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prescribed(pub f64);

impl InletMethod for Prescribed {
    fn apply<R: PairReal<D>, const D: usize>(&self, zone: &mut InflowZone<'_, R, D>) {
        let pressure = self.0;
        zone.set(1.0, |_, _, _| pressure);
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
