//! Writing so that a file is either whole or not there: temporary name, fsync, rename, fsync of the folder; and the room that is left.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use super::error::OutputError;

/// The name under which a file is written until it is whole.
pub fn partial_name(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(".partial");
    path.with_file_name(name)
}

/// The partial name with nothing under it that leads elsewhere: what is written there stays in its folder.
pub fn fresh_partial(path: &Path) -> PathBuf {
    let partial = partial_name(path);
    if is_link(&partial) {
        // One that cannot be removed cannot be renamed either, so that the write is refused.
        let _ = fs::remove_file(&partial);
    }
    partial
}

/// Whether a path is a symbolic link, wherever it leads.
pub fn is_link(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok_and(|data| data.is_symlink())
}

/// Makes a file written under its partial name durable and gives it its own name.
///
/// # Errors
/// [`OutputError::Io`] when the system refuses; the partial file is removed.
pub fn commit(path: &Path) -> Result<(), OutputError> {
    let partial = partial_name(path);
    let result = File::open(&partial)
        .and_then(|file| file.sync_all())
        .map_err(OutputError::io(path, "write"))
        .and_then(|()| fs::rename(&partial, path).map_err(OutputError::io(path, "rename")));
    match result {
        Ok(()) => sync_folder(path.parent().unwrap_or(Path::new("."))),
        Err(error) => {
            discard(path);
            Err(error)
        }
    }
}

/// Removes what a failed write left under the partial name.
pub fn discard(path: &Path) {
    // The write has failed already and its error is what the user needs: a second one would hide it.
    let _ = fs::remove_file(partial_name(path));
}

/// Makes renames in a folder durable.
///
/// # Errors
/// [`OutputError::Io`] when the system refuses.
pub fn sync_folder(folder: &Path) -> Result<(), OutputError> {
    // An empty parent of a relative path means the working folder.
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    File::open(folder).and_then(|file| file.sync_all()).map_err(OutputError::io(folder, "write"))
}

/// Writes a small file whole or not at all.
///
/// # Errors
/// [`OutputError::Io`] when the system refuses; an earlier file of that name is untouched.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    fs::write(fresh_partial(path), bytes).map_err(|cause| {
        discard(path);
        OutputError::io(path, "write")(cause)
    })?;
    commit(path)
}

/// Why nothing can be written to a folder, if that is so: the NetCDF library hides a full disk behind
/// "HDF error", so that the system is asked once more.
pub fn refusal(folder: &Path) -> Option<std::io::Error> {
    let probe = folder.join(format!(".probe-{}", std::process::id()));
    // A page of zeros may still fit where a frame did not: 1 MiB is about what the library buffers.
    let written = fs::write(&probe, vec![0x5a_u8; 1 << 20]).and_then(|()| File::open(&probe)?.sync_all());
    let _ = fs::remove_file(&probe);
    written.err()
}

/// Bytes that may still be written to the file system of a folder, or of the nearest one above it that is there; None where the system
/// does not tell.
pub fn free_space(folder: &Path) -> Option<u64> {
    let absolute = std::path::absolute(folder).ok()?;
    let place = absolute.ancestors().find(|place| place.exists())?;
    let figures = rustix::fs::statvfs(place).ok()?;
    Some(figures.f_bavail.saturating_mul(figures.f_frsize))
}

/// Bytes with a unit.
pub fn bytes(count: u64) -> String {
    let size = count as f64;
    match count {
        0..10_000 => format!("{count} B"),
        10_000..10_000_000 => format!("{:.0} kB", size / 1e3),
        10_000_000..10_000_000_000 => format!("{:.0} MB", size / 1e6),
        10_000_000_000..10_000_000_000_000 => format!("{:.1} GB", size / 1e9),
        u64::MAX => "more than 1.8e7 TB".to_owned(),
        _ => format!("{:.3e} TB", size / 1e12),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_a_unit() {
        for (count, text) in [
            (512, "512 B"),
            (25_000, "25 kB"),
            (42_000_000, "42 MB"),
            (12_300_000_000, "12.3 GB"),
            (2 << 50, "2.252e3 TB"),
            (u64::MAX, "more than 1.8e7 TB"),
        ] {
            assert_eq!(bytes(count), text);
        }
    }

    #[test]
    fn a_folder_that_is_not_there_has_the_room_of_the_one_above() {
        let folder = tempfile::tempdir().expect("a folder");
        assert!(free_space(&folder.path().join("deep/run")).is_some_and(|free| free > 0));
    }

    #[test]
    fn failed_write_leaves_the_earlier_file() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("summary.json");
        write_whole(&path, b"first").expect("written");
        // A folder in the way of the partial name makes the second write fail.
        fs::create_dir(partial_name(&path)).expect("a folder");
        let error = write_whole(&path, b"second").expect_err("refused").to_string();
        assert!(error.contains("summary.json"), "{error}");
        assert_eq!(fs::read(&path).expect("read"), b"first");
    }

    #[test]
    fn refusal_names_a_missing_folder() {
        let folder = tempfile::tempdir().expect("a folder");
        assert!(refusal(folder.path()).is_none());
        let missing = refusal(&folder.path().join("nowhere")).map(|error| error.kind());
        assert_eq!(missing, Some(std::io::ErrorKind::NotFound));
    }
}
