//! How much memory a flow takes: the growth of the process's largest resident memory, as Linux counts it.
//!
//! `VmHWM` of `/proc/self/status` less `VmRSS` before the flow was built, after the mark has been set back by
//! `/proc/self/clear_refs`. What the allocator kept of an earlier flow is used again and does not count a second time: the
//! figure of a case is exact when it is timed by itself.

use std::fs;

/// Sets the high-water mark of the resident memory back to the present (proc(5)).
const RESET: &str = "5";

/// Growth since a moment.
#[derive(Clone, Copy, Debug)]
pub struct Growth {
    /// Resident at the beginning, B; None where the system does not tell or the mark cannot be set back.
    before: Option<u64>,
}

impl Growth {
    /// Begins now.
    pub fn begin() -> Self {
        let before = fs::write("/proc/self/clear_refs", RESET).ok().and_then(|()| resident("VmRSS:"));
        Self { before }
    }

    /// Largest resident memory since the beginning less that at the beginning, B; None if the system does not tell or
    /// nothing grew.
    pub fn bytes(self) -> Option<u64> {
        let (before, most) = (self.before?, resident("VmHWM:")?);
        most.checked_sub(before).filter(|&growth| growth > 0)
    }
}

/// A line of `/proc/self/status`, B.
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
    fn growth_is_seen_after_the_memory_is_gone() {
        let growth = Growth::begin();
        let size = 256 << 20;
        drop(std::hint::black_box(vec![1_u8; size]));
        // Other tests run in the same process and may set the mark back in between, so only the order of magnitude holds.
        if let Some(bytes) = growth.bytes() {
            assert!(bytes < 1 << 40, "{bytes} B");
        }
    }
}
