//! Check of the free disk space before a run writes its results.

use super::RunOptions;
use sphecs_core::format::{grouped, significant};
use sphecs_output::disk::free_space;
use sphecs_output::error::OutputError;
use sphecs_scene::disk_estimate::DiskEstimate;
use sphecs_scene::model::Scene;

/// Compares the size of the results with the free disk space.
///
/// # Errors
/// [`OutputError::DiskFull`] with the options that would make the results fit.
pub fn check(scene: &Scene, options: &RunOptions) -> Result<(), OutputError> {
    let estimate = DiskEstimate::new(scene, options.until, options.max_steps);
    let Some(free) = free_space(&options.folder) else { return Ok(()) };
    if estimate.bytes() <= free as f64 {
        return Ok(());
    }
    let every = estimate.fitting_interval(scene.output.every, free as f64);
    let interval = match every {
        Some(every) => format!("raise `output.every` to at least {} s", significant(1.01 * every)),
        None => "raise `output.monitor_every` or give another folder by `--out`".to_owned(),
    };
    Err(OutputError::DiskFull {
        path: options.folder.clone(),
        what: format!("a run with {} frames", grouped(estimate.frames as u64)),
        needed: estimate.bytes() as u64,
        free,
        cure: format!("{interval}, or start anyway by `--allow-oversize`"),
    })
}
