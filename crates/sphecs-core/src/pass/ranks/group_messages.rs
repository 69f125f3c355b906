//! Messages of a rank, and the time that they take.

use std::time::Instant;

use super::{Group, Messages, State};

impl Group {
    /// Puts messages of equal length of all ranks behind each other.
    pub(super) fn gather(&self, state: &mut State, own: &[u8]) {
        let lengths = &mut state.messages.lengths;
        lengths.clear();
        lengths.resize(self.transport.size(), own.len());
        self.gather_lengths(state, own);
    }

    /// Puts messages of all ranks, whose lengths are set, behind each other.
    pub(super) fn gather_lengths(&self, state: &mut State, own: &[u8]) {
        let Messages { lengths, gathered, .. } = &mut state.messages;
        let started = Instant::now();
        self.transport.all_gather(own, lengths, gathered);
        state.traffic.exchanging += started.elapsed().as_secs_f64();
        state.traffic.count(own.len(), gathered.len() - own.len());
    }

    pub(super) fn joined<T: bytemuck::Pod>(&self, state: &mut State, own: T, join: impl Fn(T, T) -> T) -> T {
        self.gather(state, bytemuck::bytes_of(&own));
        let values = state.messages.gathered.chunks_exact(size_of::<T>().max(1));
        values.map(bytemuck::pod_read_unaligned).reduce(join).unwrap_or(own)
    }

    /// Sends a number to each other rank and returns that from each.
    pub(super) fn exchange_numbers(&self, state: &mut State, outgoing: &[u64]) -> Vec<u64> {
        let started = Instant::now();
        let incoming = self.transport.exchange_numbers(outgoing);
        state.traffic.exchanging += started.elapsed().as_secs_f64();
        let others = size_of_val(outgoing) - size_of::<u64>();
        state.traffic.count(others, others);
        incoming
    }

    /// Sends the outgoing messages and receives the incoming ones, whose lengths are set.
    pub(super) fn exchange(&self, state: &mut State) {
        self.exchange_during(state, &mut || ());
    }

    /// Exchanges messages as [`Self::exchange`] does while `work` is done.
    pub(super) fn exchange_during(&self, state: &mut State, work: &mut dyn FnMut()) {
        let State { messages: Messages { outgoing, incoming, .. }, traffic, .. } = state;
        let (started, mut working) = (Instant::now(), 0.0);
        self.transport.exchange_during(outgoing, incoming, &mut || {
            let started = Instant::now();
            work();
            working = started.elapsed().as_secs_f64();
        });
        traffic.exchanging += started.elapsed().as_secs_f64() - working;
        traffic.messages += outgoing.iter().filter(|message| !message.is_empty()).count() as u64;
        traffic.sent += outgoing.iter().map(|message| message.len() as u64).sum::<u64>();
        traffic.received += incoming.iter().map(|message| message.len() as u64).sum::<u64>();
    }
}
