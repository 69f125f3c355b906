//! Times of the quantities at the walls in the journal, and `walls.nc` made from them.
//!
//! As for the gridded fields, every time is a complete file of the layout of `walls.nc`, and so are
//! the means: a kill loses neither.

use std::path::Path;

use super::at_time::WallSnapshot;
use super::over_time::WallMeans;
use crate::error::OutputError;
use crate::header::{Header, WallsHeader};
use crate::mean_interval::sampled_note;
use crate::netcdf::wall_points::{self, WallFile};
use crate::numbered_files::{count_up_to_gap, numbered_files};
use crate::pack::{Packed, check_free_space};
use crate::paths::{self, WALLS};

/// Writes the quantities at one time.
///
/// # Errors
/// [`OutputError`] with the path and the cause.
pub(crate) fn write_time(path: &Path, header: &Header, snapshot: WallSnapshot) -> Result<(), OutputError> {
    let Some(walls) = &header.wall_quantities else { return Ok(()) };
    let points = snapshot.points.clone();
    let mut snapshot = Some(snapshot);
    wall_points::write(path, (header, walls, &points), 1, None, |_| Ok(snapshot.take().unwrap_or_default()))
}

/// Writes the means without a time.
///
/// # Errors
/// [`OutputError`] with the path and the cause.
pub(crate) fn write_means(path: &Path, header: &Header, means: &WallMeans) -> Result<(), OutputError> {
    let Some(walls) = &header.wall_quantities else { return Ok(()) };
    let absent = |_| Ok(WallSnapshot::default());
    wall_points::write(path, (header, walls, &means.points), 0, Some(means), absent)
}

/// Writes `walls.nc` from the journal of a run that is not packed.
///
/// # Errors
/// [`OutputError`] with the path and the cause; the journal stays.
pub(crate) fn pack(
    folder: &Path,
    journal: &Path,
    header: &Header,
    packed: &mut Packed,
) -> Result<(), OutputError> {
    let Some(walls) = &header.wall_quantities else { return Ok(()) };
    let times = numbered_files(journal, paths::surface_index)?;
    let path = paths::surface_means(journal);
    let means = if path.exists() { WallFile::open(&path, (header, walls))?.means()? } else { None };
    let points = match (times.first(), &means) {
        (Some(first), _) => WallFile::open(first, (header, walls))?.points()?,
        (None, Some(means)) => means.points.clone(),
        (None, None) => return Ok(()),
    };
    let target = folder.join(WALLS);
    check_free_space(&target, &times)?;
    wall_points::write(&target, (header, walls, &points), times.len(), means.as_ref(), |index| {
        WallFile::open(&times[index], (header, walls))?.snapshot(0)
    })?;
    packed.files.push(target);
    packed.notes.extend(note(walls, means.as_ref()));
    Ok(())
}

/// Returns a note on means whose interval the run did not complete.
fn note(walls: &WallsHeader, means: Option<&WallMeans>) -> Option<String> {
    sampled_note("means at the walls", walls.mean?, means.map(|means| means.covered))
}

/// Returns the number of times of a run, packed or not, counted from the first up to a gap.
///
/// # Errors
/// [`OutputError`] with the path and the cause.
pub(crate) fn times(run: &Path, header: &Header) -> Result<u64, OutputError> {
    let Some(walls) = &header.wall_quantities else { return Ok(0) };
    let (journal, packed) = (run.join(paths::JOURNAL), run.join(WALLS));
    if journal.exists() {
        return count_up_to_gap(&journal, paths::surface_index);
    }
    if packed.exists() { Ok(WallFile::open(&packed, (header, walls))?.times() as u64) } else { Ok(0) }
}

/// Writes the first `count` times of `walls.nc` into a new journal.
///
/// # Errors
/// [`OutputError`] with the path and the cause.
pub(crate) fn unpack(run: &Path, journal: &Path, header: &Header, count: u64) -> Result<(), OutputError> {
    let Some(walls) = header.wall_quantities.as_ref().filter(|_| count > 0) else { return Ok(()) };
    let file = WallFile::open(&run.join(WALLS), (header, walls))?;
    (0..count).try_for_each(|index| {
        write_time(&paths::surface(journal, index), header, file.snapshot(index as usize)?)
    })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use glam::DVec3;
    use sphecs_scene::wall_points::WallPoint;

    fn points() -> Arc<Vec<WallPoint>> {
        let point = |index: u32| WallPoint {
            position: DVec3::new(f64::from(index), 0.5, 0.0),
            normal: DVec3::Y,
            area: 0.25,
            part: u16::from(index > 1),
            curve: index / 2,
            arc_length: 0.125 * f64::from(index),
        };
        Arc::new((0..3).map(point).collect())
    }

    fn snapshot(index: usize, columns: usize) -> WallSnapshot {
        let columns = (0..columns).map(|column| vec![(10 * index + column) as f32; 3]).collect();
        WallSnapshot { time: 0.25 * index as f64, step: index as u64, points: points(), columns }
    }

    #[test]
    fn times_and_means_are_packed_and_unpacked_unchanged() {
        for (moves, columns) in [(false, 4), (true, 8)] {
            let folder = tempfile::tempdir().expect("a folder");
            let journal = folder.path().join("journal");
            std::fs::create_dir(&journal).expect("a journal");
            let walls = WallsHeader { moves, mean: Some((1.0, 3.0)) };
            let names = vec!["walls".to_owned(), "lid".to_owned()];
            let header = Header {
                dimensions: 2,
                wall_parts: names,
                wall_quantities: Some(walls),
                ..Header::default()
            };
            for index in 0..3 {
                write_time(&paths::surface(&journal, index), &header, snapshot(index as usize, columns))
                    .expect("written");
            }
            let means = WallMeans {
                covered: (1.0, 2.5),
                points: points(),
                columns: (0..8).map(|column| vec![f64::from(column); 3]).collect(),
            };
            write_means(&paths::surface_means(&journal), &header, &means).expect("written");
            assert_eq!(times(folder.path(), &header).expect("counted"), 3);
            let mut packed = Packed::default();
            pack(folder.path(), &journal, &header, &mut packed).expect("packed");
            assert!(packed.notes[0].contains("cover 1 to 2.5 s of 1 to 3 s"), "{:?}", packed.notes);
            std::fs::remove_dir_all(&journal).expect("removed");
            assert_eq!(times(folder.path(), &header).expect("counted"), 3);
            let walls = header.wall_quantities.as_ref().expect("walls");
            let file = WallFile::open(&folder.path().join(WALLS), (&header, walls)).expect("open");
            assert_eq!(file.means().expect("read"), Some(means));
            std::fs::create_dir(&journal).expect("a journal");
            unpack(folder.path(), &journal, &header, 3).expect("unpacked");
            for index in 0..3 {
                let path = paths::surface(&journal, index);
                let read = WallFile::open(&path, (&header, walls)).expect("open").snapshot(0);
                assert_eq!(read.expect("read"), snapshot(index as usize, columns));
            }
        }
    }

    #[test]
    fn means_that_did_not_begin_are_noted() {
        let walls = WallsHeader { moves: false, mean: Some((1.0, 3.0)) };
        assert!(note(&walls, None).expect("a note").contains("begin, at 1 s: they are left out"));
        let whole = WallMeans { covered: (1.0, 3.0), ..WallMeans::default() };
        assert_eq!(note(&walls, Some(&whole)), None);
    }
}
