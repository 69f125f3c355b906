//! Particles of the inflow zones: how many, and which returned from the fluid.

use std::collections::BTreeSet;

use bevy_ecs::resource::Resource;

/// Particles of the inflow zones by where they came from.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct InflowParticles {
    /// Numbers of those that returned from the fluid. The particle that was injected behind one of
    /// them may still be there.
    returned: BTreeSet<u32>,
    /// Number of all others in the zone of each inlet, then of each emitter.
    others: Vec<u64>,
}

impl InflowParticles {
    /// Returns zones without particles of a number of inlets and emitters.
    pub fn none(sources: usize) -> Self {
        Self { returned: BTreeSet::new(), others: vec![0; sources] }
    }

    /// Returns zones with particles that returned, by their numbers, and a number of others in the
    /// zone of each inlet and emitter.
    pub(crate) fn new(returned: Vec<u32>, others: Vec<u32>) -> Self {
        Self { returned: returned.into_iter().collect(), others: others.into_iter().map(u64::from).collect() }
    }

    /// Adds an injected particle to the zone of an inlet or emitter.
    pub(crate) fn inject(&mut self, source: u16) {
        self.others[usize::from(source)] += 1;
    }

    /// Adds a particle that returned from the fluid.
    pub(crate) fn add_returned(&mut self, id: u32) {
        self.returned.insert(id);
    }

    /// Removes a particle from the zone of an inlet or emitter.
    pub(crate) fn remove(&mut self, id: u32, source: u16) {
        if !self.returned.remove(&id) {
            self.others[usize::from(source)] -= 1;
        }
    }

    /// Returns true if a particle returned from the fluid.
    pub fn has_returned(&self, id: u32) -> bool {
        self.returned.contains(&id)
    }

    /// Returns the numbers of the particles that returned from the fluid, in their order.
    pub fn returned(&self) -> impl Iterator<Item = u32> + '_ {
        self.returned.iter().copied()
    }

    /// Returns the number of particles in the zone of an inlet or emitter that did not return.
    pub fn others(&self, source: u16) -> u64 {
        self.others[usize::from(source)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn particles_that_returned_do_not_count_with_the_others() {
        let mut inflow = InflowParticles::none(2);
        (0..3).for_each(|_| inflow.inject(1));
        inflow.add_returned(7);
        assert!(inflow.has_returned(7) && !inflow.has_returned(1) && inflow.others(1) == 3);
        inflow.remove(7, 1);
        inflow.remove(1, 1);
        assert_eq!((inflow.others(0), inflow.others(1), inflow.returned().count()), (0, 2, 0));
    }
}
