//! Packing of the journal and the CSV files into `particles.nc`, `fields.nc`, `walls.nc`,
//! `monitor.nc`, `probes.nc` and `forces.nc`.
//!
//! A file is removed only after its replacement is complete and durable. A kill during packing
//! loses nothing: packing again starts from the journal.

use std::fs;
use std::path::{Path, PathBuf};

use super::disk::{self, remove_folder};
use super::error::OutputError;
use super::frame::Frame;
use super::header::Header;
use super::journal::frame_paths;
use super::lock::Lock;
use super::netcdf::particles::{self, ParticleFile};
use super::netcdf::slots::Slots;
use super::paths::{self, JOURNAL, PACKED_JOURNAL, PARTICLES};
use super::results::read_header;
use super::{fields, forces, monitor, probes, walls};

/// Files and frames that packing produced.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Packed {
    /// Number of frames moved from the journal into `particles.nc`; 0 when the run was packed
    /// already.
    pub frames: usize,
    /// Files written.
    pub files: Vec<PathBuf>,
    /// Remarks for the user: means whose interval the run did not complete.
    pub notes: Vec<String>,
    /// Name and lines of text on the force coefficients of each body.
    pub forces: Vec<(String, Vec<String>)>,
}

/// Packs the run in a folder.
///
/// # Errors
/// [`OutputError::Busy`] while another process writes the run, or [`OutputError`] with path and
/// cause; the journal stays.
pub fn pack(folder: &Path) -> Result<Packed, OutputError> {
    let header = read_header(folder)?;
    let _lock = Lock::acquire_without_links(folder)?;
    pack_locked(folder, &header)
}

/// Packs a run whose lock is held.
///
/// # Errors
/// [`OutputError`] with path and cause; the journal stays.
pub fn pack_locked(folder: &Path, header: &Header) -> Result<Packed, OutputError> {
    let mut packed = Packed::default();
    let journal = folder.join(JOURNAL);
    if journal.exists() {
        packed.frames = pack_frames(folder, &journal, header)?;
        if packed.frames > 0 {
            packed.files.push(folder.join(PARTICLES));
        }
        fields::packing::pack(folder, &journal, header, &mut packed)?;
        walls::files::pack(folder, &journal, header, &mut packed)?;
        retire(folder, &journal)?;
    }
    remove_folder(&folder.join(PACKED_JOURNAL))?;
    packed.files.extend(monitor::pack(folder, header)?);
    probes::results::pack(folder, header, &mut packed)?;
    forces::pack(folder, header, &mut packed)?;
    Ok(packed)
}

fn pack_frames(folder: &Path, journal: &Path, header: &Header) -> Result<usize, OutputError> {
    let paths = frame_paths(journal)?;
    let target = folder.join(PARTICLES);
    if !paths.is_empty() {
        check_free_space(&target, &paths)?;
        let walls: Frame = ParticleFile::open(&paths::walls(journal))?.walls()?;
        let mut slots = Slots { walls: Slots::of(&walls).walls, ..Slots::default() };
        let (mut times, mut counts) = (Vec::new(), Vec::new());
        for path in &paths {
            let file = ParticleFile::open(path)?;
            times.push(file.frame_time(0)?);
            counts.push(file.slots.particles.len());
            if file.slots.particles.len() > slots.particles.len() {
                (slots.particles, slots.moving_parts) = (file.slots.particles, file.slots.moving_parts);
            }
        }
        particles::write_run(&target, header, &slots, &walls, &times, |index| {
            // A frame from before the last growth of the reservoir has fewer slots than the file.
            if counts[index] == slots.particles.len()
                && let Some(chunks) = particles::read_chunks(&paths[index], header, 0, counts[index])?
            {
                return Ok(chunks);
            }
            let frame = ParticleFile::open(&paths[index])?.frame(0, &walls)?;
            Ok(particles::compress(&frame, header, &slots))
        })?;
    }
    Ok(paths.len())
}

/// Renames a journal whose files are complete elsewhere, before it is removed.
fn retire(folder: &Path, journal: &Path) -> Result<(), OutputError> {
    let packed_journal = folder.join(PACKED_JOURNAL);
    // An earlier, interrupted removal may have left it.
    remove_folder(&packed_journal)?;
    fs::rename(journal, &packed_journal).map_err(OutputError::io(journal, "rename"))?;
    disk::sync_folder(folder)
}

/// Checks that the disk has space for a packed file, which is about as large as its files of the
/// journal together.
pub(crate) fn check_free_space(target: &Path, frames: &[PathBuf]) -> Result<(), OutputError> {
    let size = |path: &PathBuf| fs::metadata(path).map_or(0, |data| data.len());
    let needed: u64 = frames.iter().map(size).sum();
    match disk::free_space(target.parent().unwrap_or(Path::new("."))) {
        Some(free) if free < needed => Err(OutputError::DiskFull {
            path: target.to_path_buf(),
            what: format!("packing {} frames", frames.len()),
            needed,
            free,
            cure: "the frames stay in the journal; free disk space, then `sphecs pack` or `sphecs resume` this run".to_owned(),
        }),
        _ => Ok(()),
    }
}
