//! Names of the files and folders inside a run folder.

use std::path::{Path, PathBuf};

use sphecs_scene::result_name::result_name;

/// Scene as run, RON.
pub const SCENE: &str = "scene.ron";
/// Tables that the scene names, JSON.
pub const TABLES: &str = "tables.json";
/// Folder of the files of meshes and outlines that it names, by their numbers.
pub const MESHES: &str = "meshes";
/// State of the run and how it ended, JSON.
pub const SUMMARY: &str = "summary.json";
/// File that a process locks while it writes the run.
pub const LOCK: &str = ".lock";
/// Initial files of a run that is about to start.
pub const STAGED: &str = ".sphecs-start";
/// Initial files while they get their places.
pub const PLACED: &str = ".sphecs-placed";
/// Earlier run until the new one has its initial files.
pub const REPLACED: &str = ".sphecs-replaced";

/// Folder of one file per frame while the run is not packed.
pub const JOURNAL: &str = "journal";
/// Journal after `particles.nc` is complete and before the journal is removed.
pub const PACKED_JOURNAL: &str = "journal.packed";
/// Folder of the checkpoints.
pub const CHECKPOINTS: &str = "checkpoints";

/// All frames of a packed run.
pub const PARTICLES: &str = "particles.nc";
/// Integral quantities over time.
pub const MONITOR_CSV: &str = "monitor.csv";
/// Integral quantities over time, made from the CSV file when the run is packed.
pub const MONITOR_NETCDF: &str = "monitor.nc";
/// Folder of one CSV file per probe with its samples over time.
pub const PROBES: &str = "probes";
/// Points of all probes.
pub const PROBES_POINTS_CSV: &str = "probes_points.csv";
/// Probe samples and means, made from the CSV files when the run is packed.
pub const PROBES_NETCDF: &str = "probes.nc";
/// Time means of the probes, made when the run is packed.
pub const PROBES_MEAN_CSV: &str = "probes_mean.csv";
/// Fields on grids, made from the journal when the run is packed.
pub const FIELDS: &str = "fields.nc";
/// Pressure and shear stress at the walls, made from the journal when the run is packed.
pub const WALLS: &str = "walls.nc";
/// Particles as trajectories, by `sphecs export`.
pub const TRACKS: &str = "tracks.nc";
/// Particles for ParaView, by `sphecs export`.
pub const VTKHDF: &str = "particles.vtkhdf";
/// Forces and torques on the bodies over time.
pub const FORCES_CSV: &str = "forces.csv";
/// Forces, torques and means, made from the CSV file when the run is packed.
pub const FORCES_NETCDF: &str = "forces.nc";
/// Means of the force coefficients, made when the run is packed.
pub const FORCES_MEAN_CSV: &str = "forces_mean.csv";

/// Particles around the one that diverged.
pub const DIVERGENCE_NETCDF: &str = "divergence.nc";
/// Picture of the particles around the one that diverged.
pub const DIVERGENCE_PICTURE: &str = "divergence.png";

/// Returns the path of the samples of the probe `name` in a run folder.
pub fn probe(run: &Path, name: &str) -> PathBuf {
    run.join(PROBES).join(format!("{}.csv", result_name(name)))
}

/// Returns the path of the wall particles in a journal.
pub fn walls(journal: &Path) -> PathBuf {
    journal.join("walls.nc")
}

/// Returns the path of a frame in a journal.
pub fn frame(journal: &Path, index: u64) -> PathBuf {
    journal.join(format!("frame-{index:08}.nc"))
}

/// Returns the index of a frame by the name of its file; None for any other file.
pub fn frame_index(path: &Path) -> Option<u64> {
    let name = path.file_name()?.to_str()?;
    name.strip_prefix("frame-")?.strip_suffix(".nc")?.parse().ok()
}

/// Returns the path of the gridded fields at one time in a journal.
pub fn fields(journal: &Path, index: u64) -> PathBuf {
    journal.join(format!("fields-{index:08}.nc"))
}

/// Returns the path of the means of the gridded fields in a journal.
pub fn fields_means(journal: &Path) -> PathBuf {
    journal.join("means.nc")
}

/// Returns the index of a time of the gridded fields by the name of its file; None for any other
/// file.
pub fn fields_index(path: &Path) -> Option<u64> {
    let name = path.file_name()?.to_str()?;
    name.strip_prefix("fields-")?.strip_suffix(".nc")?.parse().ok()
}

/// Returns the path of the quantities at the walls at one time in a journal.
pub fn surface(journal: &Path, index: u64) -> PathBuf {
    journal.join(format!("surface-{index:08}.nc"))
}

/// Returns the path of the means at the walls in a journal.
pub fn surface_means(journal: &Path) -> PathBuf {
    journal.join("surface_means.nc")
}

/// Returns the index of a time of the quantities at the walls by the name of its file; None for any
/// other file.
pub fn surface_index(path: &Path) -> Option<u64> {
    let name = path.file_name()?.to_str()?;
    name.strip_prefix("surface-")?.strip_suffix(".nc")?.parse().ok()
}

/// Returns the file name of the checkpoint of a step.
pub fn checkpoint(step: u64) -> String {
    format!("step-{step:012}.checkpoint")
}

/// Returns true for the path of a complete checkpoint.
pub fn is_checkpoint(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.starts_with("step-") && name.ends_with(".checkpoint")
}
