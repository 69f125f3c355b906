//! Connection between ranks: threads or processes.

use std::fmt;

/// Connection between the ranks of a flow.
pub trait Transport: fmt::Debug + Send + Sync {
    /// Returns the number of this rank, from 0.
    fn rank(&self) -> usize;

    /// Returns the number of ranks.
    fn size(&self) -> usize;

    /// Sends a message to all ranks, and puts the messages of all, this rank included, behind each
    /// other in the order of the ranks.
    ///
    /// All ranks call it together. `lengths` are the bytes of each rank's message, the same on all
    /// ranks.
    ///
    /// # Panics
    /// If another rank has ended.
    fn all_gather(&self, own: &[u8], lengths: &[usize], all: &mut Vec<u8>);

    /// Sends a message to each other rank that gets one and receives one from each that sends one,
    /// and calls `work` while they are under way.
    ///
    /// `incoming` has the length of each message already; a message without bytes is not sent.
    ///
    /// # Panics
    /// If another rank has ended.
    fn exchange_during(&self, outgoing: &[Vec<u8>], incoming: &mut [Vec<u8>], work: &mut dyn FnMut());

    /// Exchanges messages as [`Self::exchange_during`] does, without work.
    ///
    /// # Panics
    /// If another rank has ended.
    fn exchange(&self, outgoing: &[Vec<u8>], incoming: &mut [Vec<u8>]) {
        self.exchange_during(outgoing, incoming, &mut || ());
    }

    /// Sends a number to each other rank and returns that from each; `outgoing` has one for each
    /// rank.
    ///
    /// # Panics
    /// If another rank has ended.
    fn exchange_numbers(&self, outgoing: &[u64]) -> Vec<u64> {
        let own = self.rank();
        let message = |(rank, number): (usize, &u64)| match rank == own {
            true => Vec::new(),
            false => number.to_ne_bytes().to_vec(),
        };
        let outgoing: Vec<Vec<u8>> = outgoing.iter().enumerate().map(message).collect();
        let mut incoming = outgoing.clone();
        self.exchange(&outgoing, &mut incoming);
        let number = |message: &Vec<u8>| message.as_chunks().0.first().map_or(0, |&n| u64::from_ne_bytes(n));
        incoming.iter().map(number).collect()
    }

    /// Tells the other ranks that this one ends before its time, so that they do not wait for it.
    fn abandon(&self);
}
