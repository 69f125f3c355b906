//! Outlet conditions.
//!
//! - [`characteristic`]: outgoing characteristic about reference values
//! - [`convection`]: convective velocity of an outflow zone and pressure of backflow
//! - [`do_nothing`]: the state of the crossing
//! - [`hybrid`]: frozen base flow with acoustic waves transmitted by their characteristic
//! - [`method`]: interface of a condition
//! - [`mirror`]: mirror image of the fluid
//! - [`modified_do_nothing`]: the state of the crossing, advected by the fluid
//! - [`non_reflecting`]: acoustic waves at an outlet of nonreflecting pressure
//! - [`orlanski`]: outgoing wave equation without diffusion
//! - [`pressure`]: pressure under a wave equation
//! - [`pressure_driven`]: openings that a pressure drives, through which fluid enters and leaves
//! - [`wave_equation`]: outgoing wave equation with transverse diffusion
//! - [`outflow_zone`]: the zone of outflow particles that a condition works on
//!
//! To add a condition: write a file with a parameter type that implements [`OutletParameters`] and
//! [`OutletMethod`]. Add a variant of [`OutletCondition`], an arm of its dispatch and a line of
//! [`parameters`] below, and the source in docs/REFERENCES.md. A plugin adds a condition without
//! any of these, under a name for [`OutletCondition::Custom`].

pub mod characteristic;
pub mod convection;
pub mod do_nothing;
pub mod hybrid;
pub mod method;
pub mod mirror;
pub mod modified_do_nothing;
pub mod non_reflecting;
pub mod orlanski;
pub mod outflow_zone;
pub mod pressure;
pub mod pressure_driven;
pub mod wave_equation;

use serde::{Deserialize, Serialize};

use characteristic::Characteristic;
use do_nothing::DoNothing;
use hybrid::Hybrid;
use method::{OutletMethod, OutletParameters};
use mirror::Mirror;
use modified_do_nothing::ModifiedDoNothing;
use orlanski::Orlanski;
use pressure_driven::flow_share::FlowShare;
use pressure_driven::prescribed_pressure::Pressure;
use pressure_driven::resistance::Resistance;
use pressure_driven::total_pressure::TotalPressure;
use pressure_driven::windkessel::Windkessel;
use wave_equation::WaveEquation;

/// Parameters of the conditions, for scenes that are described in Rust.
pub mod parameters {
    pub use super::characteristic::Characteristic;
    pub use super::hybrid::Hybrid;
    pub use super::mirror::{Mirror, MirrorVariant};
    pub use super::modified_do_nothing::{ModifiedDoNothing, ShownVelocity};
    pub use super::orlanski::Orlanski;
    pub use super::pressure::{OutletPressure, Waves};
    pub use super::pressure_driven::Acoustics;
    pub use super::pressure_driven::flow_share::FlowShare;
    pub use super::pressure_driven::given_pressure::GivenPressure;
    pub use super::pressure_driven::prescribed_pressure::Pressure;
    pub use super::pressure_driven::resistance::Resistance;
    pub use super::pressure_driven::time_function::TimeFunction;
    pub use super::pressure_driven::total_pressure::TotalPressure;
    pub use super::pressure_driven::windkessel::Windkessel;
    pub use super::wave_equation::WaveEquation;
    pub use crate::physics::wave_sums::{ReferenceFrame, TransverseOperator};
}

/// Condition at an outlet.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub enum OutletCondition {
    /// Outgoing wave equation with transverse diffusion: Alvarado-Rodríguez et al. (2017), Eqs. 27,
    /// 29 and 30. Take it unless a case below applies.
    WaveEquation(WaveEquation),
    /// Outgoing wave equation without diffusion: Alvarado-Rodríguez et al. (2017), Eq. 28. Take it
    /// to compare with them.
    Orlanski(Orlanski),
    /// Velocity and pressure of the crossing: Negi et al. (2020), Eqs. 14–16. Take it to compare
    /// with them.
    DoNothing,
    /// Velocity and pressure of the crossing, moved with the velocity of the fluid next to the
    /// plane: Negi et al. (2020), Eqs. 17 and 18. Take it to compare with them.
    ModifiedDoNothing(ModifiedDoNothing),
    /// Velocity and pressure of the fluid's mirror image: Negi et al. (2020), Eqs. 22–24. Take it
    /// to compare with them.
    Mirror(Mirror),
    /// Outgoing characteristic about reference values, no wave enters: Negi et al. (2020), Eqs.
    /// 25–27. Take it for plane sound on a uniform stream of known velocity.
    Characteristic(Characteristic),
    /// Frozen base flow, with acoustic waves transmitted by their outgoing characteristic: Negi et
    /// al. (2020), Eqs. 28–31. Take it if the flow must be right during the start and never
    /// reverses.
    Hybrid(Hybrid),
    /// Given static pressure; fluid may enter and leave. Take it at both ends of a flow that a
    /// pressure difference drives.
    Pressure(Pressure),
    /// Given total pressure; fluid may enter and leave. Take it for an intake from a reservoir at
    /// rest.
    TotalPressure(TotalPressure),
    /// Pressure in proportion to the flow: Vignon-Clementel et al. (2006). Take it for conduits
    /// beyond the outlet without elasticity.
    Resistance(Resistance),
    /// Pressure of elastic vessels beyond the outlet, of three elements: Westerhof et al. (2009).
    /// Take it for a pulsating flow into arteries.
    Windkessel(Windkessel),
    /// Given share of the prescribed inflow. Take it at all but one of several outlets whose flows
    /// are known.
    FlowShare(FlowShare),
    /// A condition that a plugin adds under this name. Take it for a condition of your own.
    Custom(String),
}

/// Evaluates an expression with the parameters of a condition: the only match on the conditions.
macro_rules! with_condition {
    ($condition:expr, $method:ident => $result:expr, custom $name:ident => $custom:expr) => {
        match $condition {
            OutletCondition::WaveEquation($method) => $result,
            OutletCondition::Orlanski($method) => $result,
            OutletCondition::DoNothing => {
                let $method = &DoNothing;
                $result
            }
            OutletCondition::ModifiedDoNothing($method) => $result,
            OutletCondition::Mirror($method) => $result,
            OutletCondition::Characteristic($method) => $result,
            OutletCondition::Hybrid($method) => $result,
            OutletCondition::Pressure($method) => $result,
            OutletCondition::TotalPressure($method) => $result,
            OutletCondition::Resistance($method) => $result,
            OutletCondition::Windkessel($method) => $result,
            OutletCondition::FlowShare($method) => $result,
            OutletCondition::Custom($name) => $custom,
        }
    };
}

/// A function of an outlet condition, generic over its type.
pub trait OutletVisitor {
    /// Result of the function.
    type Output;

    /// Evaluates the function for a condition.
    fn visit<M: OutletMethod>(self, method: &M) -> Self::Output;
}

impl OutletCondition {
    /// Evaluates a function of the condition.
    ///
    /// # Errors
    /// The name of a [`Custom`](Self::Custom) condition, which only the plugin that adds it knows.
    pub fn visit<V: OutletVisitor>(&self, visitor: V) -> Result<V::Output, &str> {
        with_condition!(self, method => Ok(visitor.visit(method)), custom name => Err(name))
    }

    /// Returns the parameters of the condition.
    pub fn parameters(&self) -> &dyn OutletParameters {
        with_condition!(self, parameters => parameters, custom name => name)
    }
}

impl Default for OutletCondition {
    /// Returns the condition that docs/book/src/guides/choosing_an_outlet.md recommends for both
    /// schemes.
    fn default() -> Self {
        OutletCondition::WaveEquation(WaveEquation::default())
    }
}

/// The name of a condition that a plugin adds, in place of its parameters.
impl OutletParameters for String {
    fn name(&self) -> &str {
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_the_scene_notation() {
        let characteristic = Characteristic { velocity: 0.1, pressure: 0.0 };
        let windkessel =
            Windkessel { proximal: 1.0, compliance: 1.0, distal: 1.0, distal_pressure: 0.0, initial: None };
        let hybrid = Hybrid { velocity: None, pressure: 0.0, steps: 6.0 };
        for condition in [
            OutletCondition::default(),
            OutletCondition::Orlanski(Orlanski::default()),
            OutletCondition::DoNothing,
            OutletCondition::ModifiedDoNothing(ModifiedDoNothing::default()),
            OutletCondition::Mirror(Mirror::default()),
            OutletCondition::Characteristic(characteristic),
            OutletCondition::Hybrid(hybrid),
            OutletCondition::Pressure(Pressure::new(4.0)),
            OutletCondition::TotalPressure(TotalPressure::new("4*t")),
            OutletCondition::Resistance(Resistance { resistance: 0.0, distal_pressure: 0.0 }),
            OutletCondition::Windkessel(windkessel),
            OutletCondition::FlowShare(FlowShare { share: 0.5 }),
        ] {
            // The derived form begins with the variant, which is the name in a scene.
            let derived = format!("{condition:?}");
            let variant = derived.split('(').next().expect("a first part");
            assert_eq!(condition.parameters().name(), variant);
            assert_eq!(condition.parameters().faults(), [], "{derived}");
        }
        let custom = OutletCondition::Custom("Sponge".to_owned());
        assert_eq!(custom.parameters().name(), "Sponge");
    }
}
