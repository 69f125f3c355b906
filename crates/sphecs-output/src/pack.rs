//! `sphecs pack`: the journal and the CSV files become `particles.nc`, `monitor.nc`, `probes.nc` and `forces.nc`.
//!
//! Nothing is removed before what replaces it is whole and durable, so that a kill during the packing costs
//! nothing either: packing again starts from the journal.

use std::fs;
use std::path::{Path, PathBuf};

use super::disk;
use super::error::OutputError;
use super::frame::Frame;
use super::header::Header;
use super::journal;
use super::lock::Lock;
use super::netcdf::particles::{self, ParticleFile, Slots};
use super::results::read_header;
use super::{forces, monitor, probes};

/// Name of the file of all frames in the run folder.
pub const PARTICLES: &str = "particles.nc";

/// The journal's name between the moment that `particles.nc` stands and its removal.
pub const PACKED_JOURNAL: &str = "journal.packed";

/// What packing made.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Packed {
    /// Frames that went from the journal into `particles.nc`; 0 when the run was packed already.
    pub frames: usize,
    /// Files written.
    pub files: Vec<PathBuf>,
}

/// Packs the run in a folder.
///
/// # Errors
/// [`OutputError::Busy`] while another process writes the run, or [`OutputError`] with path and cause; the journal stays.
pub fn pack(folder: &Path) -> Result<Packed, OutputError> {
    let header = read_header(folder)?;
    let _lock = Lock::take_plain(folder)?;
    pack_locked(folder, &header)
}

/// Packs a run whose lock is held.
pub fn pack_locked(folder: &Path, header: &Header) -> Result<Packed, OutputError> {
    let mut packed = Packed::default();
    let journal = folder.join(journal::FOLDER);
    if journal.exists() {
        packed.frames = pack_frames(folder, &journal, header)?;
        if packed.frames > 0 {
            packed.files.push(folder.join(PARTICLES));
        }
    }
    remove_folder(&folder.join(PACKED_JOURNAL))?;
    packed.files.extend(monitor::pack(folder, header)?);
    packed.files.extend(probes::results::pack(folder, header)?);
    packed.files.extend(forces::pack(folder, header)?);
    Ok(packed)
}

fn pack_frames(folder: &Path, journal: &Path, header: &Header) -> Result<usize, OutputError> {
    let paths = journal::frame_paths(journal)?;
    let target = folder.join(PARTICLES);
    if !paths.is_empty() {
        ensure_room(&target, &paths)?;
        let walls: Frame = ParticleFile::open(&journal::walls_path(journal))?.walls()?;
        let mut slots = Slots { particles: Vec::new(), walls: Slots::of(&walls).walls };
        for path in &paths {
            let file = ParticleFile::open(path)?;
            if file.slots.particles.len() > slots.particles.len() {
                slots.particles = file.slots.particles;
            }
        }
        particles::write_run(&target, header, &slots, &walls, paths.len(), |index| {
            ParticleFile::open(&paths[index])?.frame(0, &walls)
        })?;
    }
    let retired = folder.join(PACKED_JOURNAL);
    // Left over when an earlier removal was cut short.
    remove_folder(&retired)?;
    fs::rename(journal, &retired).map_err(OutputError::io(journal, "rename"))?;
    disk::sync_folder(folder)?;
    Ok(paths.len())
}

/// Whether there is room for all frames in one file, as large as they are one by one: asked before it is begun, since a journal is larger
/// than the file only by the heads of its files.
fn ensure_room(target: &Path, frames: &[PathBuf]) -> Result<(), OutputError> {
    let size = |path: &PathBuf| fs::metadata(path).map_or(0, |data| data.len());
    let needed: u64 = frames.iter().map(size).sum();
    match disk::free_space(target.parent().unwrap_or(Path::new("."))) {
        Some(free) if free < needed => Err(OutputError::NoRoom {
            path: target.to_path_buf(),
            what: format!("packing {} frames", frames.len()),
            needed,
            free,
            cure: "all frames are safe in the journal: make room, then `sphecs pack` or `sphecs resume` this run".to_owned(),
        }),
        _ => Ok(()),
    }
}

/// Removes a folder, if it is there.
///
/// # Errors
/// [`OutputError::Io`] when the system refuses.
pub fn remove_folder(path: &Path) -> Result<(), OutputError> {
    match fs::remove_dir_all(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(OutputError::io(path, "remove")(error))
        }
        _ => Ok(()),
    }
}
