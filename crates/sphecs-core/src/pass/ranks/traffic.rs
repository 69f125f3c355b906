//! Messages and times of a rank.

/// Messages of a rank to the others, and the time that they took.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Traffic {
    /// Messages sent; one to all others counts once.
    pub messages: u64,
    /// Bytes sent.
    pub sent: u64,
    /// Bytes received.
    pub received: u64,
    /// Wall-clock time of own work in steps, s.
    pub busy: f64,
    /// Wall-clock time of messages, waiting for other ranks included, s.
    pub exchanging: f64,
    /// Particles that this rank owns since the sort of the last step.
    pub own_rows: u64,
    /// Particles that this rank holds since that sort, its own included.
    pub held_rows: u64,
}

impl Traffic {
    /// Returns the traffic since an earlier time.
    #[must_use]
    pub fn since(&self, before: &Self) -> Self {
        Self {
            messages: self.messages - before.messages,
            sent: self.sent - before.sent,
            received: self.received - before.received,
            busy: self.busy - before.busy,
            exchanging: self.exchanging - before.exchanging,
            ..*self
        }
    }

    /// Counts a message.
    pub(super) fn count(&mut self, sent: usize, received: usize) {
        self.messages += 1;
        self.sent += sent as u64;
        self.received += received as u64;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_since_a_time_are_those_counted_after_it() {
        let mut traffic = Traffic { own_rows: 5, busy: 1.0, ..Traffic::default() };
        traffic.count(10, 20);
        let before = traffic;
        traffic.count(1, 2);
        traffic.busy += 0.5;
        let since = traffic.since(&before);
        let expected =
            Traffic { messages: 1, sent: 1, received: 2, busy: 0.5, own_rows: 5, ..Traffic::default() };
        assert_eq!(since, expected);
    }
}
