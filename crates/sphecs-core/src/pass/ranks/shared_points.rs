//! Results at points that all ranks need, such as those of inlets and outlets.
//!
//! All ranks hold the particles around them. So each finds the results of a part of the points, and
//! they send each other what they found.

use std::ops::Range;
use std::time::Instant;

use super::{Group, Ranks};

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
    /// Runs `work` over all points; each rank runs it over a part of them, and all have all results
    /// in the end.
    ///
    /// All ranks call it together with the same points.
    pub(in crate::pass) fn for_points<F: PointResult>(
        &self,
        found: &mut [F],
        work: &dyn Fn(Range<usize>, &mut [F]),
    ) {
        let points = 0..found.len();
        match &self.0 {
            Some(group) if found.len() >= LEAST => group.for_points(found, work),
            _ => work(points, found),
        }
    }
}

impl Group {
    fn for_points<F: PointResult>(&self, found: &mut [F], work: &dyn Fn(Range<usize>, &mut [F])) {
        let state = &mut *self.state();
        let (rank, ranks, count) = (self.transport.rank(), self.transport.size(), found.len());
        let part = |rank: usize| count * rank / ranks..count * (rank + 1) / ranks;
        let started = Instant::now();
        work(part(rank), &mut found[part(rank)]);
        let busy = started.elapsed().as_secs_f64();
        state.busy += busy;
        state.traffic.busy += busy;
        let mut own = std::mem::take(&mut state.messages.outgoing[rank]);
        own.clear();
        let message = found[part(rank)].iter().map(F::to_message);
        message.for_each(|message| own.extend_from_slice(bytemuck::bytes_of(&message)));
        let width = size_of::<F::Message>();
        state.messages.lengths.clear();
        state.messages.lengths.extend((0..ranks).map(|rank| part(rank).len() * width));
        self.gather_lengths(state, &own);
        for (found, message) in found.iter_mut().zip(state.messages.gathered.chunks_exact(width)) {
            *found = F::from_message(bytemuck::pod_read_unaligned(message));
        }
        // A rank sends nothing to itself.
        own.clear();
        state.messages.outgoing[rank] = own;
    }
}
