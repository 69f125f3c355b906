//! Whether the disk has room for what a run will write: asked before anything is.

use super::RunOptions;
use super::words::{figure, grouped};
use sphecs_output::disk::free_space;
use sphecs_output::error::OutputError;
use sphecs_scene::disk_estimate::Demand;
use sphecs_scene::model::Scene;

/// Whether the results of a run find room.
///
/// # Errors
/// [`OutputError::NoRoom`] with what to change.
pub fn check(scene: &Scene, options: &RunOptions) -> Result<(), OutputError> {
    let demand = Demand::of(scene, options.until, options.steps);
    let Some(free) = free_space(&options.folder) else { return Ok(()) };
    if demand.bytes() <= free as f64 {
        return Ok(());
    }
    let every = demand.fitting_interval(scene.output.every, free as f64);
    let interval = match every {
        Some(every) => format!("raise `output.every` to at least {} s", figure(1.01 * every)),
        None => "raise `output.monitor_every` or give another folder by `--out`".to_owned(),
    };
    Err(OutputError::NoRoom {
        path: options.folder.clone(),
        what: format!("a run with {} frames", grouped(demand.frames as u64)),
        needed: demand.bytes() as u64,
        free,
        cure: format!("{interval}, or begin all the same by `--allow-oversize`"),
    })
}
