//! Results at points that all members of a region need, such as those of inlets and outlets.
//!
//! The members of a [region](super::regions) hold all particles around its points. So each finds
//! the results of a part of the points, and they send each other what they found.

use std::ops::Range;

use super::{Group, Messages, Ranks};

/// Number of points below which a message takes longer than all of them.
const LEAST: usize = 256;

/// Result at a point.
pub(in crate::pass) trait PointResult: Send + Default {
    /// Form in a message.
    type Message: bytemuck::Pod;

    /// Returns the result as it is sent.
    fn to_message(&self) -> Self::Message;

    /// Returns a result that was sent.
    fn from_message(message: Self::Message) -> Self;
}

impl Ranks {
    /// Runs `work` over all points; each member of the [region](Ranks::of_region) runs it over a
    /// part of them, and all members have all results in the end.
    ///
    /// All members call it together with the same points.
    pub(in crate::pass) fn for_points<F: PointResult>(
        &self,
        found: &mut [F],
        work: &dyn Fn(Range<usize>, &mut [F]),
    ) {
        if let (Some(group), Some(region), true) = (&self.group, self.region, found.len() >= LEAST) {
            group.for_points(region, found, work);
        } else {
            work(0..found.len(), found);
        }
    }
}

impl Group {
    fn for_points<F: PointResult>(
        &self,
        region: usize,
        found: &mut [F],
        work: &dyn Fn(Range<usize>, &mut [F]),
    ) {
        let state = &mut *self.state();
        let count = found.len();
        let members = state.domains.as_ref().map_or(Vec::new(), |domains| domains.members[region].clone());
        let Some(place) = members.iter().position(|&member| member == self.transport.rank()) else { return };
        let part = |place: usize| count * place / members.len()..count * (place + 1) / members.len();
        work(part(place), &mut found[part(place)]);
        let width = size_of::<F::Message>();
        let Messages { outgoing, incoming, .. } = &mut state.messages;
        outgoing.iter_mut().chain(incoming.iter_mut()).for_each(Vec::clear);
        for (other, &member) in members.iter().enumerate().filter(|(other, _)| *other != place) {
            let results = found[part(place)].iter().map(F::to_message);
            results.for_each(|result| outgoing[member].extend_from_slice(bytemuck::bytes_of(&result)));
            incoming[member].resize(part(other).len() * width, 0);
        }
        self.exchange(state);
        for (other, &member) in members.iter().enumerate().filter(|(other, _)| *other != place) {
            let results = state.messages.incoming[member].chunks_exact(width);
            for (found, result) in found[part(other)].iter_mut().zip(results) {
                *found = F::from_message(bytemuck::pod_read_unaligned(result));
            }
        }
    }
}
