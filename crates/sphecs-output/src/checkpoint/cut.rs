//! Output cut back to a checkpoint, so that a resumed run writes no time twice and leaves none out.
//!
//! The journal keeps the frames that the checkpoint counts, the CSV files their bytes; what was made of them when the run was packed
//! goes. A packed run gets its journal back first. Every step can be broken off and done again: nothing is removed before what
//! replaces it is whole.

use std::fs;
use std::path::Path;

use super::Facts;
use crate::error::OutputError;
use crate::frame::{ABSENT, Frame};
use crate::header::Header;
use crate::netcdf::particles::ParticleFile;
use crate::pack::{PACKED_JOURNAL, PARTICLES, remove_folder};
use crate::probes::{results as probe_results, writer as probes};
use crate::{disk, forces, journal, monitor};

/// Whether the output that a checkpoint counts is there.
///
/// # Errors
/// What is missing.
pub fn has_output(run: &Path, facts: &Facts) -> Result<(), String> {
    let frames = frames(run).map_err(|error| error.to_string())?;
    if frames < facts.frames {
        return Err(format!("counts {} frames, the run has {frames}", facts.frames));
    }
    let tables = [
        (monitor::CSV, facts.monitor_bytes),
        (probes::CSV, facts.probes_bytes),
        (forces::CSV, facts.forces_bytes),
    ];
    for (name, bytes) in tables {
        let found = fs::metadata(run.join(name)).map_or(0, |data| data.len());
        if found < bytes {
            return Err(format!("counts {bytes} bytes of `{name}`, it has {found}"));
        }
    }
    Ok(())
}

/// Frames of a run, packed or not, without a gap from the first on.
fn frames(run: &Path) -> Result<u64, OutputError> {
    let journal = run.join(journal::FOLDER);
    if journal.exists() {
        let paths = journal::frame_paths(&journal)?;
        let indices = paths.iter().map(|path| journal::frame_index(path));
        return Ok(indices.zip(0_u64..).take_while(|(found, index)| *found == Some(*index)).count() as u64);
    }
    let packed = run.join(PARTICLES);
    if packed.exists() { Ok(ParticleFile::open(&packed)?.times.len() as u64) } else { Ok(0) }
}

/// Cuts the output of a run back to what a checkpoint counts, or to nothing.
///
/// # Errors
/// [`OutputError`] with path and cause; it can be tried again.
pub fn cut_back(run: &Path, header: &Header, facts: &Facts) -> Result<(), OutputError> {
    let journal = run.join(journal::FOLDER);
    if !journal.exists() {
        unpack(run, &journal, header, facts.frames)?;
    }
    for path in journal::frame_paths(&journal)? {
        if journal::frame_index(&path).is_none_or(|index| index >= facts.frames) {
            remove(&path)?;
        }
    }
    if facts.frames == 0 {
        remove(&journal::walls_path(&journal))?;
    }
    remove_partial(&journal)?;
    disk::sync_folder(&journal)?;
    remove_folder(&run.join(PACKED_JOURNAL))?;
    let packed = [PARTICLES, monitor::NETCDF, probe_results::NETCDF, probes::MEAN_CSV];
    for name in packed.into_iter().chain([forces::NETCDF, forces::means::CSV]) {
        remove(&run.join(name))?;
    }
    remove_partial(run)?;
    disk::sync_folder(run)
}

/// Makes a journal of the first frames of `particles.nc`, or an empty one.
fn unpack(run: &Path, journal: &Path, header: &Header, count: u64) -> Result<(), OutputError> {
    let fresh = disk::partial_name(journal);
    remove_folder(&fresh)?;
    fs::create_dir(&fresh).map_err(OutputError::io(&fresh, "make the folder"))?;
    let packed = run.join(PARTICLES);
    if count > 0 {
        let file = ParticleFile::open(&packed)?;
        let walls = file.walls()?;
        journal::write_all(&fresh, header, count as usize, |index| {
            let mut frame = file.frame(index, &walls)?;
            trim(&mut frame);
            Ok(frame)
        })?;
    }
    fs::rename(&fresh, journal).map_err(OutputError::io(journal, "make the folder"))?;
    disk::sync_folder(run)
}

/// Drops the slots at the end that no particle had at the time: the packed file has those of its last frame.
fn trim(frame: &mut Frame) {
    let present = frame.zone.iter().rposition(|&zone| zone != ABSENT).map_or(0, |last| last + 1);
    frame.resize(present);
}

fn remove(path: &Path) -> Result<(), OutputError> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(OutputError::io(path, "remove")(error))
        }
        _ => Ok(()),
    }
}

/// Removes the files that a kill left half written.
fn remove_partial(folder: &Path) -> Result<(), OutputError> {
    for entry in fs::read_dir(folder).map_err(OutputError::io(folder, "read"))? {
        let path = entry.map_err(OutputError::io(folder, "read"))?.path();
        if path.extension().is_some_and(|extension| extension == "partial") {
            if path.is_dir() { remove_folder(&path)? } else { remove(&path)? }
        }
    }
    Ok(())
}
