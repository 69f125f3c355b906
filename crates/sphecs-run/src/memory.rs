//! Memory that a run may take, and takes.

use std::fs;
use std::path::{Path, PathBuf};

/// Value that resets the high-water mark of the resident memory, see proc(5).
const RESET: &str = "5";

/// Returns the memory that is free for this process, B; None where the system does not say.
///
/// The limit of the process's control group counts where it is lower than the free memory of the
/// machine, as under a batch system.
pub fn available() -> Option<f64> {
    let text = fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("MemAvailable:"))?;
    let kilobytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    let free = kilobytes * 1024.0;
    Some(group_memory(Path::new("/sys/fs/cgroup")).map_or(free, |left| left.min(free)))
}

/// Resets [`peak`] and returns true where the system allows it.
pub fn reset_peak() -> bool {
    fs::write("/proc/self/clear_refs", RESET).is_ok()
}

/// Returns the largest resident memory of the process since [`reset_peak`], or since its start, B;
/// None if unknown.
pub fn peak() -> Option<u64> {
    status("VmHWM:")
}

/// Returns the resident memory of the process, B; None if unknown.
pub fn resident() -> Option<u64> {
    status("VmRSS:")
}

/// Returns the value of a line of `/proc/self/status`, B.
fn status(name: &str) -> Option<u64> {
    let text = fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find(|line| line.starts_with(name))?;
    let kilobytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kilobytes * 1024)
}

/// Returns the memory that the control group of this process and those above it leave, B; None
/// without a limit.
fn group_memory(root: &Path) -> Option<f64> {
    let text = fs::read_to_string("/proc/self/cgroup").ok()?;
    let own = text.lines().find_map(|line| line.strip_prefix("0::/"))?;
    let number = |path: PathBuf| fs::read_to_string(path).ok()?.trim().parse::<f64>().ok();
    let left =
        |folder: &Path| Some(number(folder.join("memory.max"))? - number(folder.join("memory.current"))?);
    let folder = root.join(own);
    folder.ancestors().take_while(|place| place.starts_with(root)).filter_map(left).min_by(f64::total_cmp)
}
