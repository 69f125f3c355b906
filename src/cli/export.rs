//! Command `export`: the frames of a run in other forms.

use std::path::PathBuf;

use super::commands::{counter, make_parent};
use super::export_arguments::ExportArguments;
use super::failure::{DONE, Failure};
use sphecs_core::format::grouped;
use sphecs_output::error::OutputError;
use sphecs_output::fields::resampling::{self, GridOptions};
use sphecs_output::paths::{FIELDS, TRACKS, VTKHDF};
use sphecs_output::results::Results;
use sphecs_output::tracks::{self, TrackOptions};
use sphecs_output::{disk, vtk, vtkhdf};
use sphecs_run::console::Console;
use sphecs_run::memory;

/// Writes the frames of a run for ParaView, on a grid or as trajectories.
///
/// # Errors
/// [`Failure::Output`].
pub fn export(arguments: &ExportArguments) -> Result<u8, Failure> {
    let results = Results::open(&arguments.run)?;
    if let Some(fault) = arguments.fault_of_output() {
        return Err(OutputError::Request(fault).into());
    }
    let text = match arguments.form.grid {
        Some(spacing) => export_grid(arguments, &results, spacing)?,
        None if arguments.form.tracks => export_tracks(arguments, &results)?,
        None if arguments.form.vtkhdf => export_vtkhdf(arguments, &results)?,
        None => export_vtu(arguments, &results)?,
    };
    Console::Normal.print(&text);
    Ok(DONE)
}

fn export_vtu(arguments: &ExportArguments, results: &Results) -> Result<String, Failure> {
    let folder = arguments.output.clone().unwrap_or_else(|| arguments.run.join("vtu"));
    let export = vtk::export_vtu(results, &folder, counter("frames"))?;
    if export.removed > 0 {
        Console::Normal.print(&format!("{} frames of an earlier, longer export removed", export.removed));
    }
    Ok(format!("{} frames, open {}", results.len(), export.series.display()))
}

fn export_grid(arguments: &ExportArguments, results: &Results, spacing: f64) -> Result<String, Failure> {
    if results.header.fields.is_some() && arguments.output.is_none() {
        return Err(OutputError::Request(format!(
            "`{}`: has the `fields.nc` of its run, which is not replaced; give another file by `-o`",
            arguments.run.display()
        ))
        .into());
    }
    let target = arguments.output.clone().unwrap_or_else(|| arguments.run.join(FIELDS));
    let options = GridOptions { spacing, mean: arguments.mean, memory: memory::available() };
    resampling::export_grid(results, &target, &options, counter("frames"))?;
    Ok(format!("{} frames in {}", results.len(), target.display()))
}

fn export_tracks(arguments: &ExportArguments, results: &Results) -> Result<String, Failure> {
    let target = target_of(arguments, TRACKS)?;
    let options = TrackOptions {
        every: arguments.every.get(),
        zones: arguments.zones.clone(),
        ids: arguments.ids.clone(),
        within: arguments.r#box,
    };
    let export = tracks::export_tracks(results, &disk::target(&target), &options, counter("frames"))?;
    let [tracks, frames] = [export.trajectories, export.frames].map(|count| grouped(count as u64));
    Ok(format!("{tracks} trajectories over {frames} frames in {}", target.display()))
}

fn export_vtkhdf(arguments: &ExportArguments, results: &Results) -> Result<String, Failure> {
    let target = target_of(arguments, VTKHDF)?;
    let every = arguments.every.get();
    let export = vtkhdf::export_vtkhdf(results, &disk::target(&target), every, counter("frames"))?;
    let walls = export.walls.map(|path| format!(", and the walls at rest {}", path.display()));
    let frames = grouped(export.frames as u64);
    Ok(format!("{frames} frames, open {}{}", target.display(), walls.unwrap_or_default()))
}

/// Returns the file to write, whose folder is made.
fn target_of(arguments: &ExportArguments, name: &str) -> Result<PathBuf, OutputError> {
    let target = arguments.output.clone().unwrap_or_else(|| arguments.run.join(name));
    make_parent(&target)?;
    Ok(target)
}
