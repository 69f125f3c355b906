//! Outlet conditions that plugins add.

use std::any::Any;
use std::fmt;

use bevy_ecs::resource::Resource;

use super::outlets::{RunningCondition, WithMemory};
use sphecs_core::boundary::outlet::method::OutletMethod;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_core::physics::parameter_fault::ParameterFault;

/// Outlet conditions that plugins add, by the name that a scene gives to
/// [`OutletCondition::Custom`](sphecs_core::boundary::outlet::OutletCondition::Custom).
#[derive(Resource, Default)]
pub struct AddedOutlets(Vec<(String, Box<dyn AddedOutlet>)>);

/// Faults of the outlet conditions of a scene, each with the name of its outlet.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutletFaults(pub Vec<String>);

impl fmt::Display for OutletFaults {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.0.join("\n"))
    }
}

impl std::error::Error for OutletFaults {}

/// An added condition of any type.
trait AddedOutlet: Send + Sync {
    fn faults(&self) -> Vec<ParameterFault>;
    /// Returns the condition ready to run, boxed for every precision and dimension.
    fn start(&self) -> [Box<dyn Any>; 4];
}

impl<M: OutletMethod> AddedOutlet for M {
    fn faults(&self) -> Vec<ParameterFault> {
        // Qualified: the method of this trait has the same name.
        sphecs_core::boundary::outlet::method::OutletParameters::faults(self)
    }

    fn start(&self) -> [Box<dyn Any>; 4] {
        fn running<M: OutletMethod, R: PairReal<D>, const D: usize>(method: &M) -> Box<dyn Any> {
            let running: Box<dyn RunningCondition<R, D>> = Box::new(WithMemory::new(method));
            Box::new(running)
        }
        [
            running::<M, f64, 2>(self),
            running::<M, f64, 3>(self),
            running::<M, f32, 2>(self),
            running::<M, f32, 3>(self),
        ]
    }
}

impl AddedOutlets {
    /// Adds a condition under a name.
    ///
    /// # Panics
    /// If a condition of this name was added before.
    pub fn add<M: OutletMethod>(&mut self, name: &str, method: M) {
        assert!(self.find(name).is_none(), "an outlet condition `{name}` is added twice");
        self.0.push((name.to_owned(), Box::new(method)));
    }

    fn find(&self, name: &str) -> Option<&dyn AddedOutlet> {
        self.0.iter().find(|(other, _)| other == name).map(|(_, method)| &**method)
    }

    /// Returns the condition of a name, ready to run.
    pub(super) fn start<R: PairReal<D>, const D: usize>(
        &self,
        name: &str,
    ) -> Result<Box<dyn RunningCondition<R, D>>, Vec<String>> {
        let Some(method) = self.find(name) else { return Err(vec![self.unknown(name)]) };
        let faults = method.faults();
        if !faults.is_empty() {
            return Err(faults.iter().map(|fault| format!("`{name}`: {fault}")).collect());
        }
        let running = method.start().into_iter().find_map(|any| any.downcast().ok());
        running.map(|running| *running).ok_or_else(|| vec![self.unknown(name)])
    }

    fn unknown(&self, name: &str) -> String {
        let known: Vec<String> = self.0.iter().map(|(name, _)| format!("`{name}`")).collect();
        let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
        format!(
            "no plugin adds an outlet condition `{name}`, added are: {known}; \
             add it with `PluginContext::add_outlet` or take a condition of the engine"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sphecs_core::boundary::outlet::do_nothing::DoNothing;
    use sphecs_core::boundary::outlet::hybrid::Hybrid;

    #[test]
    fn a_condition_starts_in_every_precision_and_dimension() {
        let mut added = AddedOutlets::default();
        added.add("Frozen", DoNothing);
        assert_eq!(added.start::<f32, 2>("Frozen").err(), None);
        assert_eq!(added.start::<f32, 3>("Frozen").err(), None);
        assert_eq!(added.start::<f64, 2>("Frozen").err(), None);
        assert_eq!(added.start::<f64, 3>("Frozen").err(), None);
    }

    #[test]
    fn an_unknown_name_lists_those_that_are_added() {
        let mut added = AddedOutlets::default();
        assert!(added.unknown("Sponge").contains("added are: none"));
        added.add("Frozen", DoNothing);
        let Err(faults) = added.start::<f64, 2>("Sponge") else { panic!("it is not added") };
        assert!(faults[0].contains("`Sponge`, added are: `Frozen`"), "{faults:?}");
    }

    #[test]
    fn parameters_out_of_range_are_refused() {
        let mut added = AddedOutlets::default();
        added.add("Short", Hybrid { velocity: None, pressure: 0.0, steps: 0.5 });
        let Err(faults) = added.start::<f64, 2>("Short") else { panic!("its steps are out of range") };
        assert_eq!(faults, ["`Short`: `steps` is 0.5, must be finite and at least 1"]);
    }
}
