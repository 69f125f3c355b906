//! Times of the gridded fields in the journal, and `fields.nc` made from them.
//!
//! Every time is a complete file of the layout of `fields.nc`, and so are the means, which are
//! written again whenever a time is. A kill loses neither.

use std::path::Path;

use super::averages::FieldMeans;
use super::snapshot::FieldSnapshot;
use crate::error::OutputError;
use crate::header::{FieldsHeader, Header};
use crate::mean_interval::sampled_note;
use crate::netcdf::grids::{self, FieldFile};
use crate::numbered_files::{count_up_to_gap, numbered_files};
use crate::pack::{Packed, check_free_space};
use crate::paths::{self, FIELDS};

/// Writes the fields at one time.
///
/// # Errors
/// [`OutputError`] with the path and the cause.
pub(crate) fn write_time(path: &Path, header: &Header, snapshot: FieldSnapshot) -> Result<(), OutputError> {
    let Some(fields) = &header.fields else { return Ok(()) };
    let mut snapshot = Some(snapshot);
    grids::write(path, (header, fields), 1, None, |_| Ok(snapshot.take().unwrap_or_default()))
}

/// Writes the means without a time.
///
/// # Errors
/// [`OutputError`] with the path and the cause.
pub(crate) fn write_means(path: &Path, header: &Header, means: &FieldMeans) -> Result<(), OutputError> {
    let Some(fields) = &header.fields else { return Ok(()) };
    grids::write(path, (header, fields), 0, Some(means), |_| Ok(FieldSnapshot::default()))
}

/// Writes `fields.nc` from the journal of a run that is not packed.
///
/// # Errors
/// [`OutputError`] with the path and the cause; the journal stays.
pub(crate) fn pack(
    folder: &Path,
    journal: &Path,
    header: &Header,
    packed: &mut Packed,
) -> Result<(), OutputError> {
    let Some(fields) = &header.fields else { return Ok(()) };
    let times = numbered_files(journal, paths::fields_index)?;
    let path = paths::fields_means(journal);
    let means = if path.exists() { FieldFile::open(&path, (header, fields))?.means()? } else { None };
    if times.is_empty() && means.is_none() {
        return Ok(());
    }
    let target = folder.join(FIELDS);
    check_free_space(&target, &times)?;
    grids::write(&target, (header, fields), times.len(), means.as_ref(), |index| {
        FieldFile::open(&times[index], (header, fields))?.snapshot(0)
    })?;
    packed.files.push(target);
    packed.notes.extend(note(fields, means.as_ref()));
    Ok(())
}

/// Returns a note on means whose interval the run did not complete.
fn note(fields: &FieldsHeader, means: Option<&FieldMeans>) -> Option<String> {
    sampled_note("means of the fields", fields.mean?, means.map(|means| means.covered))
}

/// Returns the number of times of a run, packed or not, counted from the first up to a gap.
///
/// # Errors
/// [`OutputError`] with the path and the cause.
pub(crate) fn times(run: &Path, header: &Header) -> Result<u64, OutputError> {
    let Some(fields) = &header.fields else { return Ok(0) };
    let (journal, packed) = (run.join(paths::JOURNAL), run.join(FIELDS));
    if journal.exists() {
        return count_up_to_gap(&journal, paths::fields_index);
    }
    if packed.exists() { Ok(FieldFile::open(&packed, (header, fields))?.times()? as u64) } else { Ok(0) }
}

/// Writes the first `count` times of `fields.nc` into a new journal.
///
/// # Errors
/// [`OutputError`] with the path and the cause.
pub(crate) fn unpack(run: &Path, journal: &Path, header: &Header, count: u64) -> Result<(), OutputError> {
    let Some(fields) = header.fields.as_ref().filter(|_| count > 0) else { return Ok(()) };
    let file = FieldFile::open(&run.join(FIELDS), (header, fields))?;
    (0..count).try_for_each(|index| {
        write_time(&paths::fields(journal, index), header, file.snapshot(index as usize)?)
    })
}

#[cfg(test)]
mod tests {
    use super::super::snapshot::GridValues;
    use super::*;
    use glam::DVec3;
    use sphecs_scene::field_grid::{FieldGrid, GridAxis};

    fn grid(name: &str, axes: [(&str, usize, DVec3); 2]) -> FieldGrid {
        let axis = |(name, count, direction): (&str, usize, DVec3)| GridAxis {
            name: name.to_owned(),
            first: 0.5,
            spacing: 1.0,
            count,
            direction,
        };
        FieldGrid { name: name.to_owned(), axes: axes.map(axis).to_vec(), origin: DVec3::Z }
    }

    /// Two planes of a scene in 3D, one of them oblique.
    fn header(has_moving_walls: bool) -> Header {
        let grids = vec![
            grid("mid plane", [("x", 3, DVec3::X), ("y", 2, DVec3::Y)]),
            grid("cut", [("a", 2, DVec3::new(0.6, 0.8, 0.0)), ("b", 2, DVec3::Z)]),
        ];
        let fields = FieldsHeader { grids, tagged: true, has_moving_walls, mean: Some((1.0, 3.0)) };
        Header { dimensions: 3, fields: Some(fields), ..Header::default() }
    }

    fn snapshot(index: usize) -> FieldSnapshot {
        let values = |nodes: usize| GridValues {
            // Nine quantities, the passive scalar among them, and the fluid fraction.
            columns: (0..10).map(|column| vec![(10 * index + column) as f32; nodes]).collect(),
            solid: (0..nodes).map(|node| u8::from(node == index)).collect(),
        };
        FieldSnapshot { time: 0.25 * index as f64, step: index as u64, grids: vec![values(6), values(4)] }
    }

    fn means(to: f64) -> FieldMeans {
        let columns = |nodes: usize| (0..19).map(|column| vec![f64::from(column); nodes]).collect();
        FieldMeans { covered: (1.0, to), grids: vec![columns(6), columns(4)] }
    }

    #[test]
    fn times_and_means_are_packed_and_unpacked_unchanged() {
        for has_moving_walls in [true, false] {
            let folder = tempfile::tempdir().expect("a folder");
            let (journal, header) = (folder.path().join("journal"), header(has_moving_walls));
            std::fs::create_dir(&journal).expect("a journal");
            let count = if has_moving_walls { 3 } else { 1 };
            for index in 0..count {
                write_time(&paths::fields(&journal, index as u64), &header, snapshot(index))
                    .expect("written");
            }
            write_means(&paths::fields_means(&journal), &header, &means(2.5)).expect("written");
            assert_eq!(times(folder.path(), &header).expect("counted"), count as u64);
            let mut packed = Packed::default();
            pack(folder.path(), &journal, &header, &mut packed).expect("packed");
            assert!(packed.notes[0].contains("cover 1 to 2.5 s of 1 to 3 s"), "{:?}", packed.notes);
            std::fs::remove_dir_all(&journal).expect("removed");
            assert_eq!(times(folder.path(), &header).expect("counted"), count as u64);
            let fields = header.fields.as_ref().expect("fields");
            let file = FieldFile::open(&folder.path().join(FIELDS), (&header, fields)).expect("open");
            assert_eq!(file.means().expect("read"), Some(means(2.5)));
            std::fs::create_dir(&journal).expect("a journal");
            unpack(folder.path(), &journal, &header, count as u64).expect("unpacked");
            for index in 0..count {
                let path = paths::fields(&journal, index as u64);
                let read = FieldFile::open(&path, (&header, fields)).expect("open").snapshot(0);
                assert_eq!(read.expect("read"), snapshot(index));
            }
        }
    }

    #[test]
    fn means_that_did_not_begin_are_noted() {
        let fields = header(false).fields.expect("fields");
        assert!(note(&fields, None).expect("a note").contains("begin, at 1 s: they are left out"));
        assert_eq!(note(&fields, Some(&means(3.0))), None);
    }
}
