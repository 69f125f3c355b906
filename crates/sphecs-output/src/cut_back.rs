//! Output of a run cut back to a checkpoint, so that a resumed run repeats and omits no time.
//!
//! The journal keeps the frames that the checkpoint counts, the CSV files keep their bytes, and
//! packed files are removed. A packed run gets its journal back first. Every step can be
//! interrupted and repeated, because nothing is removed before its replacement is complete.

use std::fs;
use std::path::Path;

use crate::checkpoint::Facts;
use crate::disk::{self, remove_folder};
use crate::error::OutputError;
use crate::fields::packing;
use crate::frame::{ABSENT, Frame};
use crate::header::Header;
use crate::journal;
use crate::netcdf::particles::{self, ParticleFile};
use crate::numbered_files::numbered_files;
use crate::paths::{self, JOURNAL, PACKED_JOURNAL, PARTICLES};
use crate::walls::files;

/// Checks that the output counted by a checkpoint exists.
///
/// # Errors
/// The missing output.
pub fn has_output(run: &Path, header: &Header, facts: &Facts) -> Result<(), String> {
    let frames = frames(run).map_err(|error| error.to_string())?;
    if frames < facts.frames {
        return Err(format!("counts {} frames, the run has {frames}", facts.frames));
    }
    let fields = packing::times(run, header).map_err(|error| error.to_string())?;
    if fields < facts.fields {
        return Err(format!("counts {} times of gridded fields, the run has {fields}", facts.fields));
    }
    let walls = files::times(run, header).map_err(|error| error.to_string())?;
    if walls < facts.walls {
        return Err(format!("counts {} times at the walls, the run has {walls}", facts.walls));
    }
    let tables = [(paths::MONITOR_CSV, facts.monitor_bytes), (paths::FORCES_CSV, facts.forces_bytes)];
    let tables = tables.map(|(name, bytes)| (run.join(name), bytes));
    let probes = header.probes.iter().map(|probe| paths::probe(run, &probe.name));
    for (path, bytes) in tables.into_iter().chain(probes.zip(facts.probes_bytes.iter().copied())) {
        let found = fs::metadata(&path).map_or(0, |data| data.len());
        if found < bytes {
            let name = path.strip_prefix(run).unwrap_or(&path);
            return Err(format!("counts {bytes} bytes of `{}`, it has {found}", name.display()));
        }
    }
    Ok(())
}

/// Returns the number of frames of a run, packed or not, counted from the first up to a gap.
fn frames(run: &Path) -> Result<u64, OutputError> {
    let journal = run.join(JOURNAL);
    if journal.exists() {
        let paths = journal::frame_paths(&journal)?;
        let indices = paths.iter().map(|path| paths::frame_index(path));
        return Ok(indices.zip(0_u64..).take_while(|(found, index)| *found == Some(*index)).count() as u64);
    }
    let packed = run.join(PARTICLES);
    if packed.exists() { Ok(ParticleFile::open(&packed)?.times.len() as u64) } else { Ok(0) }
}

/// Cuts the output of a run back to a checkpoint; the default `facts` remove all of it.
///
/// # Errors
/// [`OutputError`] with path and cause; cutting back can be tried again.
pub fn cut_back(run: &Path, header: &Header, facts: &Facts) -> Result<(), OutputError> {
    let journal = run.join(JOURNAL);
    if !journal.exists() {
        unpack(run, &journal, header, facts)?;
    }
    for path in journal::frame_paths(&journal)? {
        if paths::frame_index(&path).is_none_or(|index| index >= facts.frames) {
            remove(&path)?;
        }
    }
    for path in numbered_files(&journal, paths::fields_index)? {
        if paths::fields_index(&path).is_none_or(|index| index >= facts.fields) {
            remove(&path)?;
        }
    }
    for path in numbered_files(&journal, paths::surface_index)? {
        if paths::surface_index(&path).is_none_or(|index| index >= facts.walls) {
            remove(&path)?;
        }
    }
    // The sums of the checkpoint replace them.
    remove(&paths::fields_means(&journal))?;
    remove(&paths::surface_means(&journal))?;
    if facts.frames == 0 {
        remove(&paths::walls(&journal))?;
    }
    remove_partial(&journal)?;
    disk::sync_folder(&journal)?;
    remove_folder(&run.join(PACKED_JOURNAL))?;
    let packed = [PARTICLES, paths::FIELDS, paths::WALLS, paths::MONITOR_NETCDF, paths::PROBES_NETCDF];
    let others = [paths::PROBES_MEAN_CSV, paths::FORCES_NETCDF, paths::FORCES_MEAN_CSV];
    for name in packed.into_iter().chain(others) {
        remove(&run.join(name))?;
    }
    remove_partial(run)?;
    disk::sync_folder(run)
}

/// Writes the frames, gridded fields and quantities at the walls that a checkpoint counts into a
/// new journal.
fn unpack(run: &Path, journal: &Path, header: &Header, facts: &Facts) -> Result<(), OutputError> {
    let count = facts.frames;
    let partial = disk::partial_name(journal);
    remove_folder(&partial)?;
    fs::create_dir(&partial).map_err(OutputError::io(&partial, "make the folder"))?;
    let packed = run.join(PARTICLES);
    if count > 0 {
        let walls = ParticleFile::open(&packed)?.walls()?;
        particles::write_walls(&paths::walls(&partial), header, &walls)?;
        for index in 0..count {
            unpack_frame(&packed, &paths::frame(&partial, index), header, index as usize, &walls)?;
        }
    }
    packing::unpack(run, &partial, header, facts.fields)?;
    files::unpack(run, &partial, header, facts.walls)?;
    fs::rename(&partial, journal).map_err(OutputError::io(journal, "make the folder"))?;
    disk::sync_folder(run)
}

/// Writes a frame of `particles.nc` into a file of its own.
fn unpack_frame(
    packed: &Path,
    target: &Path,
    header: &Header,
    index: usize,
    walls: &Frame,
) -> Result<(), OutputError> {
    let file = ParticleFile::open(packed)?;
    if file.has_last_slot(index)? {
        let (slots, time) = (file.slots.clone(), file.frame_time(index)?);
        drop(file);
        if let Some(chunks) = particles::read_chunks(packed, header, index, slots.particles.len())? {
            return particles::write_chunks(target, header, &slots, &time, &chunks);
        }
    }
    let mut frame = ParticleFile::open(packed)?.frame(index, walls)?;
    trim(&mut frame);
    particles::write_frame(target, header, &frame, rayon::current_num_threads())
}

/// Removes slots at the end that had no particle at the time, since the packed file has the slots
/// of its last frame.
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

/// Removes the files that a kill left incomplete.
fn remove_partial(folder: &Path) -> Result<(), OutputError> {
    for entry in fs::read_dir(folder).map_err(OutputError::io(folder, "read"))? {
        let path = entry.map_err(OutputError::io(folder, "read"))?.path();
        if path.extension().is_some_and(|extension| extension == "partial") {
            if path.is_dir() { remove_folder(&path)? } else { remove(&path)? }
        }
    }
    Ok(())
}
