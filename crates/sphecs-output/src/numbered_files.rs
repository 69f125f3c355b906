//! Files of a folder that are numbered, such as the frames and times in a journal.

use std::path::{Path, PathBuf};

use super::error::OutputError;

/// Number of a file by its name; None for other files.
pub(crate) type IndexOf = fn(&Path) -> Option<u64>;

/// Returns the numbered files of a folder in their order.
///
/// # Errors
/// [`OutputError::Io`] when the folder cannot be read.
pub(crate) fn numbered_files(folder: &Path, index_of: IndexOf) -> Result<Vec<PathBuf>, OutputError> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(OutputError::io(folder, "read"))? {
        let path = entry.map_err(OutputError::io(folder, "read"))?.path();
        found.extend(index_of(&path).is_some().then_some(path));
    }
    found.sort();
    Ok(found)
}

/// Returns the number of files from 0 up to a gap.
///
/// # Errors
/// [`OutputError::Io`] when the folder cannot be read.
pub(crate) fn count_up_to_gap(folder: &Path, index_of: IndexOf) -> Result<u64, OutputError> {
    let files = numbered_files(folder, index_of)?;
    let indices = files.iter().map(|path| index_of(path));
    Ok(indices.zip(0_u64..).take_while(|(found, index)| *found == Some(*index)).count() as u64)
}

#[cfg(test)]
mod tests {
    use super::super::paths;
    use super::*;

    #[test]
    fn numbered_files_are_found_in_order_and_counted_up_to_a_gap() {
        let folder = tempfile::tempdir().expect("a folder");
        for name in ["frame-00000001.nc", "frame-00000000.nc", "frame-00000003.nc", "walls.nc", "frame-x.nc"]
        {
            std::fs::write(folder.path().join(name), "").expect("written");
        }
        let found = numbered_files(folder.path(), paths::frame_index).expect("read");
        assert_eq!(found, [0, 1, 3].map(|index| paths::frame(folder.path(), index)));
        assert_eq!(count_up_to_gap(folder.path(), paths::frame_index).expect("read"), 2);
        assert_eq!(count_up_to_gap(folder.path(), paths::fields_index).expect("read"), 0);
    }
}
