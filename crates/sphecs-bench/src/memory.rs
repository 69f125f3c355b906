//! Memory of a flow: growth of the largest resident memory of the process, as Linux counts it.
//!
//! `VmHWM` of `/proc/self/status`, reset by `/proc/self/clear_refs` before the flow is built, minus
//! `VmRSS` before the first flow of the process. Memory that the allocator keeps from an earlier
//! flow is reused, so flows are ordered by size; memory that it cannot reuse is counted too. A flow
//! measured alone gives the most accurate value.

use sphecs_run::memory;

/// Returns the resident memory of the process, B; None if unknown.
pub fn at_rest() -> Option<u64> {
    memory::resident()
}

/// Growth of the process by a flow.
#[derive(Clone, Copy, Debug)]
pub struct Growth {
    at_rest: u64,
    /// Resident memory at the start, B.
    before: u64,
}

impl Growth {
    /// Starts before the flow is built; `at_rest` is the resident memory without a flow, B.
    ///
    /// None if it is unknown or the mark cannot be reset.
    pub fn begin(at_rest: Option<u64>) -> Option<Self> {
        memory::reset_peak().then_some(())?;
        Some(Self { at_rest: at_rest?, before: memory::resident()? })
    }

    /// Returns the largest resident memory since the start minus that at rest, B; None without
    /// growth.
    pub fn bytes(self) -> Option<u64> {
        let most = memory::peak().filter(|&most| most > self.before)?;
        most.checked_sub(self.at_rest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn growth_is_at_least_the_allocation() {
        let size = 64 << 20;
        // Other tests run in this process and may free as much memory, so there may be no growth.
        let growth = Growth::begin(Some(0));
        let held = std::hint::black_box(vec![1_u8; size]);
        if let Some(bytes) = growth.and_then(Growth::bytes) {
            assert!(bytes >= held.len() as u64, "{bytes} B");
        }
    }
}
