//! Start of a run in its folder. A folder that exists is used in place and never renamed.
//!
//! It may be the working folder, a mount point, the target of a link, or have permissions of its
//! own. The initial files are written to a folder inside it, an earlier run is moved to another
//! one, and then they get their places. A start that is cut off leaves one of these folders; the
//! next one puts the earlier run back before it begins.

use std::ffi::{OsStr, OsString};
use std::fs::{self, File};
use std::path::{Path, PathBuf};

use rustix::fs::{Access, access};

use super::disk::{self, remove_folder};
use super::error::OutputError;
use super::header::Header;
use super::lock::Lock;
use super::meshes;
use super::paths::{JOURNAL, LOCK, MESHES, PLACED, REPLACED, SCENE, STAGED, SUMMARY, TABLES};
use super::results::is_run;
use super::summary::Summary;

/// Files and folders of a run before its first frame.
const INITIAL: [&str; 5] = [JOURNAL, TABLES, MESHES, SUMMARY, SCENE];

/// Entries that do not count as content: `lost+found` of a file system, the others by a start.
const NO_CONTENT: [&str; 4] = ["lost+found", STAGED, PLACED, REPLACED];

/// Content of a folder.
enum Content {
    Nothing,
    Run,
    Foreign,
}

/// Checks that a run may be written to a folder, before time is spent on the scene.
///
/// # Errors
/// [`OutputError::Exists`] when it holds an earlier run and `force` is not given,
/// [`OutputError::Foreign`] when it holds other files, [`OutputError::Busy`] when another process
/// writes it, [`OutputError::Request`] when the path has a link that leads nowhere,
/// [`OutputError::Io`] when nothing can be written there.
pub fn check_free(path: &Path, force: bool) -> Result<(), OutputError> {
    check_links(path)?;
    if !path.exists() {
        return disk::existing_ancestor(path).map_or(Ok(()), |ancestor| check_writable(&ancestor));
    }
    match content(path)? {
        Content::Foreign => return Err(OutputError::Foreign { path: path.to_path_buf() }),
        Content::Run if !force => return Err(OutputError::Exists { path: path.to_path_buf() }),
        Content::Run => drop(Lock::acquire(path)?),
        Content::Nothing => {}
    }
    check_writable(path)
}

/// Refuses a path through a link that leads nowhere, which would be replaced by a folder.
fn check_links(path: &Path) -> Result<(), OutputError> {
    let broken = path.ancestors().find(|place| disk::is_link(place) && !place.exists());
    let Some(link) = broken else { return Ok(()) };
    let target = fs::read_link(link).unwrap_or_default();
    Err(OutputError::Request(format!(
        "`{}`: is a link to `{}`, which does not exist: make that folder, or remove the link",
        link.display(),
        target.display()
    )))
}

/// Checks the permission to make files in a folder.
fn check_writable(folder: &Path) -> Result<(), OutputError> {
    match access(folder, Access::WRITE_OK | Access::EXEC_OK) {
        // A file in place of the folder has a message of its own.
        Err(error) if folder.is_dir() => Err(OutputError::io(folder, "write to the folder")(error.into())),
        _ => Ok(()),
    }
}

fn content(path: &Path) -> Result<Content, OutputError> {
    if !path.is_dir() {
        return Ok(Content::Foreign);
    }
    let mut names = entries(path)?;
    let [staged, placed] = [STAGED, PLACED].map(|name| path.join(name).exists());
    if staged || placed {
        // A start was cut off before the earlier run was complete in its place again.
        if path.join(REPLACED).exists() && !entries(&path.join(REPLACED))?.is_empty() {
            return Ok(Content::Run);
        }
        names.retain(|name| name != LOCK && !(placed && INITIAL.iter().any(|initial| name == initial)));
    }
    Ok(match names.is_empty() {
        true => Content::Nothing,
        false if is_run(path) => Content::Run,
        false => Content::Foreign,
    })
}

/// Returns the names of the entries of a folder that count as content.
fn entries(folder: &Path) -> Result<Vec<OsString>, OutputError> {
    let read = || -> std::io::Result<Vec<OsString>> {
        let names = fs::read_dir(folder)?.map(|entry| Ok(entry?.file_name()));
        names.collect()
    };
    let mut names = read().map_err(OutputError::io(folder, "read"))?;
    names.retain(|name| !NO_CONTENT.iter().any(|excluded| name == excluded));
    Ok(names)
}

/// Writes the initial files of a run into its folder and returns the lock of the run.
///
/// An earlier run is replaced once the initial files of the new one are complete.
///
/// # Errors
/// As [`check_free`]; an earlier run is then untouched.
pub fn start(path: &Path, force: bool, header: &Header) -> Result<Lock, OutputError> {
    check_free(path, force)?;
    if path.exists() {
        return start_in(path, force, header);
    }
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
    fs::create_dir_all(parent).map_err(OutputError::io(parent, "make the folder"))?;
    // Processes that make the same folder wait for each other, so the second finds the run of the
    // first. A file system without locks must not stop a run.
    let _parent_lock = File::open(parent).ok().filter(|folder| folder.lock().is_ok());
    if path.exists() {
        return start_in(path, force, header);
    }
    let made = make(path, parent, header);
    if made.is_err() {
        remove_folder(&sibling(path))?;
    }
    made
}

/// Makes the folder of a run, which appears with its initial files.
fn make(path: &Path, parent: &Path, header: &Header) -> Result<Lock, OutputError> {
    let new = sibling(path);
    remove_folder(&new)?;
    write_initial_files(&new, header)?;
    // The lock is renamed with its folder.
    let lock = Lock::acquire(&new)?;
    fs::rename(&new, path).map_err(OutputError::io(path, "make the folder"))?;
    disk::sync_folder(parent)?;
    Ok(lock)
}

fn sibling(path: &Path) -> PathBuf {
    let mut name = OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(".new");
    path.with_file_name(name)
}

/// Starts a run in a folder that exists.
fn start_in(path: &Path, force: bool, header: &Header) -> Result<Lock, OutputError> {
    // Processes that start in the same folder wait for each other, so the second finds the run of
    // the first.
    let folder = File::open(path).map_err(OutputError::io(path, "read"))?;
    // A file system without locks must not stop a run.
    let _folder_lock = Some(folder).filter(|folder| folder.lock().is_ok());
    check_free(path, force)?;
    let was_locked = path.join(LOCK).exists();
    if [STAGED, PLACED].iter().all(|mark| !path.join(mark).exists()) {
        // A start that was cut off while it removed an earlier run has left the rest of it.
        remove_folder(&path.join(REPLACED))?;
    }
    // Made first: it marks what is in the folder as belonging to a start.
    let staged = path.join(STAGED);
    fs::create_dir_all(&staged).map_err(OutputError::io(path, "write to the folder"))?;
    let lock = Lock::acquire(path).inspect_err(|_| {
        let _not_empty = fs::remove_dir(&staged);
    })?;
    let placed =
        put_back(path).and_then(|()| write_initial_files(&staged, header)).and_then(|()| replace(path));
    if let Err(error) = placed {
        put_back(path)?;
        if !was_locked {
            let _not_there = fs::remove_file(path.join(LOCK));
        }
        return Err(error);
    }
    Ok(lock)
}

/// Moves an earlier run away and the initial files to their places.
fn replace(path: &Path) -> Result<(), OutputError> {
    let [staged, placed, replaced] = [STAGED, PLACED, REPLACED].map(|name| path.join(name));
    let names = entries(path)?;
    if names.iter().any(|name| name != LOCK) {
        fs::create_dir(&replaced).map_err(OutputError::io(path, "write to the folder"))?;
        for name in names.iter().filter(|name| *name != LOCK) {
            move_entry(path, &replaced, name)?;
        }
    }
    fs::rename(&staged, &placed).map_err(OutputError::io(&staged, "rename"))?;
    for name in INITIAL.iter().filter(|name| placed.join(name).exists()) {
        move_entry(&placed, path, name.as_ref())?;
    }
    remove_folder(&placed)?;
    disk::sync_folder(path)?;
    remove_folder(&replaced)
}

fn move_entry(from: &Path, to: &Path, name: &OsStr) -> Result<(), OutputError> {
    let source = from.join(name);
    fs::rename(&source, to.join(name)).map_err(OutputError::io(&source, "move"))
}

/// Undoes a start that failed or was cut off: an earlier run gets its places again.
fn put_back(path: &Path) -> Result<(), OutputError> {
    let [staged, placed, replaced] = [STAGED, PLACED, REPLACED].map(|name| path.join(name));
    if !staged.exists() && !placed.exists() {
        return Ok(());
    }
    if placed.exists() {
        for name in INITIAL.iter().filter(|name| path.join(name).exists()) {
            move_entry(path, &placed, name.as_ref())?;
        }
        // From here on the initial files in the folder are those of the earlier run.
        remove_folder(&staged)?;
        fs::rename(&placed, &staged).map_err(OutputError::io(&placed, "rename"))?;
    }
    if replaced.exists() {
        for name in entries(&replaced)? {
            move_entry(&replaced, path, &name)?;
        }
        remove_folder(&replaced)?;
    }
    remove_folder(&staged)
}

/// Writes the files that a run folder has before the first frame.
fn write_initial_files(folder: &Path, header: &Header) -> Result<(), OutputError> {
    let journal = folder.join(JOURNAL);
    fs::create_dir_all(&journal).map_err(OutputError::io(&journal, "make the folder"))?;
    disk::write_whole(&folder.join(SCENE), header.text.as_bytes())?;
    if !header.tables.is_empty() {
        let path = folder.join(TABLES);
        let tables = serde_json::to_vec_pretty(&header.tables)
            .map_err(|error| OutputError::Damaged { path: path.clone(), what: error.to_string() })?;
        disk::write_whole(&path, &tables)?;
    }
    meshes::write(folder, header)?;
    Summary { run: header.clone(), ..Summary::default() }.write(folder)
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};

    use super::*;
    use crate::folder::RunFolder;
    use crate::probes::ProbeSet;

    fn header(text: &str) -> Header {
        Header { text: text.to_owned(), dimensions: 2, ..Header::default() }
    }

    fn start(path: &Path, force: bool, text: &str) -> Result<RunFolder, OutputError> {
        RunFolder::create(path, force, &header(text), &ProbeSet::default())
    }

    /// Makes a folder with an ended run that has results.
    fn ended_run(path: &Path) {
        let run = start(path, false, "first").expect("created");
        run.finish(Summary::default()).expect("ended");
        fs::write(path.join("particles.nc"), "results").expect("written");
    }

    #[track_caller]
    fn holds(path: &Path, text: &str) {
        assert_eq!(fs::read_to_string(path.join(SCENE)).expect("read"), text);
        for name in [STAGED, PLACED, REPLACED] {
            assert!(!path.join(name).exists(), "{name} is left");
        }
    }

    #[test]
    fn earlier_run_is_replaced_only_by_force() {
        let parent = tempfile::tempdir().expect("a folder");
        let path = parent.path().join("deep/run");
        ended_run(&path);
        let error = start(&path, false, "second").expect_err("refused").to_string();
        assert!(error.contains("--force") && error.contains("--out"), "{error}");
        assert_eq!(fs::read(path.join("particles.nc")).expect("read"), b"results");

        let run = start(&path, true, "second").expect("replaced");
        holds(run.path(), "second");
        assert!(!path.join("particles.nc").exists());
        let siblings = fs::read_dir(parent.path().join("deep")).expect("read").count();
        assert_eq!(siblings, 1, "the replacement leaves no other folder");
    }

    #[test]
    fn folder_without_a_run_is_never_replaced() {
        let parent = tempfile::tempdir().expect("a folder");
        fs::write(parent.path().join("thesis.tex"), "years").expect("written");
        for force in [false, true] {
            let error = start(parent.path(), force, "scene").expect_err("refused");
            assert!(matches!(error, OutputError::Foreign { .. }), "{error}");
        }
        assert!(parent.path().join("thesis.tex").exists());
    }

    /// A folder that was renamed or made again would have another inode and the usual permissions.
    #[test]
    fn folder_that_exists_keeps_its_place_and_permissions() {
        let parent = tempfile::tempdir().expect("a folder");
        let path = parent.path().join("run");
        fs::create_dir(&path).expect("a folder");
        fs::create_dir(path.join("lost+found")).expect("a folder");
        fs::set_permissions(&path, fs::Permissions::from_mode(0o2750)).expect("set");
        let facts = || fs::metadata(&path).map(|data| (data.ino(), data.mode())).expect("read");
        let before = facts();
        ended_run(&path);
        assert_eq!(facts(), before);
        drop(start(&path, true, "second").expect("replaced"));
        holds(&path, "second");
        assert_eq!(facts(), before);
        assert!(path.join("lost+found").exists());
    }

    #[test]
    fn link_is_followed_and_a_broken_one_refused() {
        let parent = tempfile::tempdir().expect("a folder");
        let [disk, link, broken] = ["disk", "link", "broken"].map(|name| parent.path().join(name));
        fs::create_dir(&disk).expect("a folder");
        symlink(&disk, &link).expect("a link");
        symlink(parent.path().join("nowhere"), &broken).expect("a link");
        ended_run(&link);
        holds(&disk, "first");
        drop(start(&link, true, "second").expect("replaced"));
        holds(&disk, "second");
        assert!(disk::is_link(&link));
        for path in [broken.clone(), broken.join("run")] {
            let error = start(&path, true, "scene").expect_err("refused").to_string();
            assert!(error.contains("nowhere`, which does not exist"), "{error}");
        }
        assert!(disk::is_link(&broken));
    }

    /// Every state that a kill can leave: the earlier run is there again, or the folder is empty.
    #[test]
    fn start_that_was_cut_off_is_undone() {
        let parent = tempfile::tempdir().expect("a folder");
        // Initial files in their places, and whether the earlier run was moved away.
        let cuts = [(None, false), (None, true), (Some(0), true), (Some(2), true), (Some(4), true)];
        for (at, (placed, moved)) in cuts.into_iter().enumerate() {
            for has_run in [true, false] {
                let path = parent.path().join(format!("run{at}{has_run}"));
                fs::create_dir(&path).expect("a folder");
                if has_run {
                    ended_run(&path);
                }
                let staged = path.join(STAGED);
                write_initial_files(&staged, &header("cut off")).expect("written");
                if moved && has_run {
                    fs::create_dir(path.join(REPLACED)).expect("a folder");
                    let names = entries(&path).expect("read");
                    // The move of the earlier run is cut off, too, unless initial files are placed.
                    let count = if placed.is_some() { names.len() } else { 2 };
                    for name in names.iter().filter(|name| *name != LOCK).take(count) {
                        move_entry(&path, &path.join(REPLACED), name).expect("moved");
                    }
                }
                if let Some(count) = placed {
                    let from = path.join(PLACED);
                    fs::rename(&staged, &from).expect("renamed");
                    for name in INITIAL.iter().filter(|name| from.join(name).exists()).take(count) {
                        move_entry(&from, &path, name.as_ref()).expect("moved");
                    }
                }
                let refused = check_free(&path, false).is_err();
                assert_eq!(refused, has_run, "{at}");
                put_back(&path).expect("put back");
                if has_run {
                    holds(&path, "first");
                    assert_eq!(fs::read(path.join("particles.nc")).expect("read"), b"results");
                } else if placed.is_none() {
                    assert_eq!(fs::read_dir(&path).expect("read").count(), 0, "{at}");
                }
                drop(start(&path, true, "second").expect("started"));
                holds(&path, "second");
            }
        }
    }

    #[test]
    fn start_that_fails_leaves_what_was_there() {
        let parent = tempfile::tempdir().expect("a folder");
        let path = parent.path().join("run");
        ended_run(&path);
        // A file in place of the folder of the initial files makes the start fail.
        fs::write(path.join(STAGED), "in the way").expect("written");
        start(&path, true, "second").expect_err("failed");
        fs::remove_file(path.join(STAGED)).expect("removed");
        holds(&path, "first");
        assert_eq!(fs::read(path.join("particles.nc")).expect("read"), b"results");
    }
}
