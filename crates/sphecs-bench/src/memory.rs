//! How much memory a flow takes: the growth of the process's largest resident memory, as Linux counts it.
//!
//! `VmHWM` of `/proc/self/status`, set back by `/proc/self/clear_refs` before the flow is built, less `VmRSS` before the first
//! flow of the process. What the allocator kept of an earlier flow is used again, so the flows come in the order of their
//! size; what it could not use is counted too. The nearest figure is that of a flow by itself.

use std::fs;

/// Sets the high-water mark of the resident memory back to the present (proc(5)).
const RESET: &str = "5";

/// Resident memory of the process, B; None where the system does not tell.
pub fn at_rest() -> Option<u64> {
    resident("VmRSS:")
}

/// Growth of the process by a flow.
#[derive(Clone, Copy, Debug)]
pub struct Growth {
    at_rest: u64,
    /// Resident at the beginning, B.
    before: u64,
}

impl Growth {
    /// Begins before the flow is built; `at_rest` is resident without any, B. None where the system does not tell or the
    /// mark cannot be set back.
    pub fn begin(at_rest: Option<u64>) -> Option<Self> {
        fs::write("/proc/self/clear_refs", RESET).ok()?;
        Some(Self { at_rest: at_rest?, before: resident("VmRSS:")? })
    }

    /// Largest resident memory since the beginning less that at rest, B; None if nothing had to grow.
    pub fn bytes(self) -> Option<u64> {
        let most = resident("VmHWM:").filter(|&most| most > self.before)?;
        most.checked_sub(self.at_rest)
    }
}

/// Returns a line of `/proc/self/status`, B.
fn resident(name: &str) -> Option<u64> {
    let text = fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find(|line| line.starts_with(name))?;
    let kilobytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn growth_is_no_less_than_what_is_held() {
        let size = 64 << 20;
        // Other tests run in the same process and may free as much meanwhile: no growth is an answer too.
        let growth = Growth::begin(Some(0));
        let held = std::hint::black_box(vec![1_u8; size]);
        if let Some(bytes) = growth.and_then(Growth::bytes) {
            assert!(bytes >= held.len() as u64, "{bytes} B");
        }
    }
}
