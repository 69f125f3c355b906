//! Atomic and durable file writes (temporary name, fsync, rename, fsync of the folder) and the free
//! disk space.

use std::fs::{self, File};
use std::path::{Path, PathBuf};

use super::error::OutputError;

/// Returns the name under which a file is written until it is complete.
pub fn partial_name(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(".partial");
    path.with_file_name(name)
}

/// Returns the partial name after removing a symbolic link there, so that writes stay in the
/// folder.
pub fn fresh_partial(path: &Path) -> PathBuf {
    let partial = partial_name(path);
    if is_link(&partial) {
        // A link that cannot be removed cannot be renamed either, so the write fails later.
        let _ = fs::remove_file(&partial);
    }
    partial
}

/// Returns true if a path is a symbolic link.
pub fn is_link(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok_and(|data| data.is_symlink())
}

/// Returns the file that a path names, behind a symbolic link.
///
/// A file written under a partial name would replace the link.
pub fn target(path: &Path) -> PathBuf {
    match fs::read_link(path) {
        Ok(link) => fs::canonicalize(path).unwrap_or_else(|_| path.with_file_name(link)),
        Err(_) => path.to_path_buf(),
    }
}

/// Makes a file written under its partial name durable and gives it its own name.
///
/// # Errors
/// [`OutputError::Io`] when the write fails; the partial file is removed.
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

/// Removes the partial file of a failed write.
pub fn discard(path: &Path) {
    // The write has failed already, and a second error would hide its cause.
    let _ = fs::remove_file(partial_name(path));
}

/// Makes renames in a folder durable.
///
/// # Errors
/// [`OutputError::Io`] when the system call fails.
pub fn sync_folder(folder: &Path) -> Result<(), OutputError> {
    // An empty parent of a relative path means the working folder.
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    File::open(folder).and_then(|file| file.sync_all()).map_err(OutputError::io(folder, "write"))
}

/// Writes a small file completely or not at all.
///
/// # Errors
/// [`OutputError::Io`] when the write fails; an earlier file of that name is untouched.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    fs::write(fresh_partial(path), bytes).map_err(|cause| {
        discard(path);
        OutputError::io(path, "write")(cause)
    })?;
    commit(path)
}

/// Returns the system error of a test write into a folder, None if it succeeds.
///
/// The NetCDF library reports a full disk as "HDF error" only; this finds the cause.
pub fn test_write(folder: &Path) -> Option<std::io::Error> {
    let probe = folder.join(format!(".probe-{}", std::process::id()));
    // A small file may fit where a frame did not: the library buffers about 1 MiB.
    let written = fs::write(&probe, vec![0x5a_u8; 1 << 20]).and_then(|()| File::open(&probe)?.sync_all());
    let _ = fs::remove_file(&probe);
    written.err()
}

/// Returns the free bytes on the file system of a folder, or of its nearest existing ancestor.
///
/// None if the system cannot tell.
pub fn free_space(folder: &Path) -> Option<u64> {
    let figures = rustix::fs::statvfs(existing_ancestor(folder)?).ok()?;
    Some(figures.f_bavail.saturating_mul(figures.f_frsize))
}

/// Returns a path or its nearest ancestor that exists; links are followed.
pub fn existing_ancestor(path: &Path) -> Option<PathBuf> {
    let absolute = std::path::absolute(path).ok()?;
    absolute.ancestors().find(|place| place.exists()).map(Path::to_path_buf)
}

/// Removes a folder if it exists.
///
/// # Errors
/// [`OutputError::Io`] when the system call fails.
pub fn remove_folder(path: &Path) -> Result<(), OutputError> {
    match fs::remove_dir_all(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(OutputError::io(path, "remove")(error))
        }
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_folder_has_the_free_space_of_its_ancestor() {
        let folder = tempfile::tempdir().expect("a folder");
        assert!(free_space(&folder.path().join("deep/run")).is_some_and(|free| free > 0));
    }

    /// The file system of /proc has no free space, the one of the link has some.
    #[test]
    #[cfg(target_os = "linux")]
    fn space_is_that_of_the_target_of_a_link() {
        let folder = tempfile::tempdir().expect("a folder");
        let link = folder.path().join("link");
        std::os::unix::fs::symlink("/proc", &link).expect("a link");
        assert_eq!([free_space(&link), free_space(&link.join("deep/run"))], [Some(0); 2]);
    }

    #[test]
    #[cfg(unix)]
    fn link_leads_to_the_file_that_is_written() {
        let folder = tempfile::tempdir().expect("a folder");
        let [file, link, new] = ["file", "link", "new"].map(|name| folder.path().join(name));
        std::os::unix::fs::symlink(&file, &link).expect("a link");
        std::os::unix::fs::symlink("file", &new).expect("a link");
        assert_eq!([target(&link), target(&new), target(&file)], [file.clone(), file.clone(), file.clone()]);
        fs::write(&file, "mine").expect("written");
        assert_eq!(target(&link), fs::canonicalize(&file).expect("a path"));
    }

    #[test]
    fn failed_write_keeps_the_earlier_file() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("summary.json");
        write_whole(&path, b"first").expect("written");
        // A folder with the partial name makes the second write fail.
        fs::create_dir(partial_name(&path)).expect("a folder");
        let error = write_whole(&path, b"second").expect_err("refused").to_string();
        assert!(error.contains("summary.json"), "{error}");
        assert_eq!(fs::read(&path).expect("read"), b"first");
    }

    #[test]
    fn test_write_fails_in_a_missing_folder() {
        let folder = tempfile::tempdir().expect("a folder");
        assert!(test_write(folder.path()).is_none());
        let missing = test_write(&folder.path().join("nowhere")).map(|error| error.kind());
        assert_eq!(missing, Some(std::io::ErrorKind::NotFound));
    }
}
