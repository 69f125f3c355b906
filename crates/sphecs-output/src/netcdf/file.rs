//! NetCDF-4 files written completely or not at all, and opened for reading.

use std::cell::Cell;
use std::path::Path;
use std::sync::Once;

use ::hdf5_metno_sys::LOCK;
use ::hdf5_metno_sys::h5::H5dont_atexit;
use ::hdf5_metno_sys::h5e::{H5E_DEFAULT, H5Eset_auto2};
use ::netcdf::{AttributeValue, File, FileMut, GroupMut, NcTypeDescriptor, VariableMut};
use ::netcdf_sys::nc_set_chunk_cache;

use super::chunks::{Access, ChunkError, ChunkFile, LEVEL};
use crate::disk;
use crate::error::OutputError;

/// Converts an error of the library. Where it only reports "HDF error", a test write finds the
/// cause.
fn write_error(path: &Path) -> impl Fn(String) -> OutputError + '_ {
    move |error| {
        let folder = path.parent().unwrap_or(Path::new("."));
        let what = match disk::test_write(folder) {
            Some(cause) => format!("cannot write: {cause} (NetCDF says: {error})"),
            None => error,
        };
        OutputError::NetCdf { path: path.to_path_buf(), what }
    }
}

pub(super) fn read_error(path: &Path) -> impl Fn(::netcdf::Error) -> OutputError + '_ {
    move |error| OutputError::Damaged { path: path.to_path_buf(), what: format!("cannot be read: {error}") }
}

/// Error while a file is filled, of the library or of the source of the data.
pub(super) enum WriteError {
    Library(::netcdf::Error),
    Chunk(ChunkError),
    Source(OutputError),
}

impl From<ChunkError> for WriteError {
    fn from(error: ChunkError) -> Self {
        WriteError::Chunk(error)
    }
}

impl From<::netcdf::Error> for WriteError {
    fn from(error: ::netcdf::Error) -> Self {
        WriteError::Library(error)
    }
}

/// Size of the cache of each variable of an open file, B. No chunk is used twice: the default, 16
/// MB, would keep the last frames of each of a dozen variables until the file is closed.
const CHUNK_CACHE: usize = 1 << 18;

/// Slots of the cache's hash table, a prime number.
const CHUNK_CACHE_SLOTS: usize = 521;

/// Preemption of chunks that were read or written completely, from 0 to 1.
const CHUNK_CACHE_PREEMPTION: f32 = 1.0;

/// Bounds the memory of all files, and disables error printing and exit handlers of HDF5 for this
/// thread.
///
/// NetCDF handles errors of optional items but disables their printing only in the first thread
/// that uses it, and HDF5 stores this setting by thread. At exit HDF5 flushes files that could not
/// be closed on a full disk, which crashes; all other files are closed by then, so the exit handler
/// is not needed.
pub(super) fn prepare() {
    thread_local! {
        static DONE: Cell<bool> = const { Cell::new(false) };
    }
    static CACHED: Once = Once::new();
    CACHED.call_once(|| {
        let _guard = LOCK.lock();
        // SAFETY: the function sets three numbers, under the lock of the netcdf crate. It fails for
        // a preemption outside 0 to 1 only.
        unsafe {
            nc_set_chunk_cache(CHUNK_CACHE, CHUNK_CACHE_SLOTS, CHUNK_CACHE_PREEMPTION);
        }
    });
    if !DONE.replace(true) {
        let _guard = LOCK.lock();
        // SAFETY: the default error stack always exists, and without a function its data is not
        // used. The lock is the one under which the netcdf crate calls the library.
        unsafe {
            H5dont_atexit();
            H5Eset_auto2(H5E_DEFAULT, None, std::ptr::null_mut());
        }
    }
}

/// Writes a NetCDF-4 file completely or not at all.
///
/// On a full disk `nc_close` accesses open objects of a file that HDF5 has discarded, and crashes
/// (libnetcdf 4.9.0). So the file is flushed first, where a failure is only an error. After a
/// failure the file stays open, as the process is about to end.
pub(super) fn write_file(
    path: &Path,
    fill: impl FnOnce(&mut FileMut) -> Result<(), WriteError>,
) -> Result<(), OutputError> {
    finish(path, fill_file(path, fill))
}

/// Writes a NetCDF-4 file as [`write_file`] does, then adds chunks to its variables.
pub(super) fn write_file_with_chunks(
    path: &Path,
    fill: impl FnOnce(&mut FileMut) -> Result<(), WriteError>,
    add: impl FnOnce(&ChunkFile) -> Result<(), WriteError>,
) -> Result<(), OutputError> {
    let add_chunks = || {
        let file = ChunkFile::open(&disk::partial_name(path), Access::Write)?;
        match add(&file).and_then(|()| Ok(file.flush()?)) {
            Ok(()) => Ok(file.close()?),
            Err(error) => {
                std::mem::forget(file);
                Err(error)
            }
        }
    };
    finish(path, fill_file(path, fill).and_then(|()| add_chunks()))
}

fn fill_file(
    path: &Path,
    fill: impl FnOnce(&mut FileMut) -> Result<(), WriteError>,
) -> Result<(), WriteError> {
    prepare();
    let mut file = ::netcdf::create(disk::fresh_partial(path))?;
    match fill(&mut file).and_then(|()| Ok(file.sync()?)) {
        // Without an explicit close, data lost to a full disk would go unnoticed.
        Ok(()) => Ok(file.close()?),
        Err(error) => {
            std::mem::forget(file);
            Err(error)
        }
    }
}

/// Makes a written file durable, or removes what there is of it.
fn finish(path: &Path, written: Result<(), WriteError>) -> Result<(), OutputError> {
    let error = match written {
        Ok(()) => return disk::commit(path),
        Err(WriteError::Library(error)) => write_error(path)(error.to_string()),
        Err(WriteError::Chunk(ChunkError(what))) => write_error(path)(what.to_owned()),
        Err(WriteError::Source(error)) => error,
    };
    disk::discard(path);
    Err(error)
}

pub(super) fn open_file(path: &Path) -> Result<File, OutputError> {
    prepare();
    ::netcdf::open(path).map_err(read_error(path))
}

/// Adds a compressed variable with its attributes; missing values of floating-point types are NaN.
pub(super) fn add_variable<'f, T: Stored>(
    file: &'f mut FileMut,
    name: &str,
    dimensions: &[&str],
    chunks: &[usize],
    attributes: &[(&str, AttributeValue)],
) -> Result<VariableMut<'f>, ::netcdf::Error> {
    let mut variable = file.add_variable::<T>(name, dimensions)?;
    set_up::<T>(&mut variable, dimensions, chunks, attributes)?;
    Ok(variable)
}

/// Adds a variable to a group as [`add_variable`] does to the root of a file.
pub(super) fn add_to_group<'g, T: Stored>(
    group: &'g mut GroupMut<'_>,
    name: &str,
    dimensions: &[&str],
    chunks: &[usize],
    attributes: &[(&str, AttributeValue)],
) -> Result<VariableMut<'g>, ::netcdf::Error> {
    let mut variable = group.add_variable::<T>(name, dimensions)?;
    set_up::<T>(&mut variable, dimensions, chunks, attributes)?;
    Ok(variable)
}

fn set_up<T: Stored>(
    variable: &mut VariableMut<'_>,
    dimensions: &[&str],
    chunks: &[usize],
    attributes: &[(&str, AttributeValue)],
) -> Result<(), ::netcdf::Error> {
    if !dimensions.is_empty() {
        variable.set_chunking(chunks)?;
        // This is the only compression that xarray, ParaView and netCDF-Java all read.
        variable.set_compression(LEVEL.into(), true)?;
    }
    // CF allows no missing values in a coordinate variable.
    let is_coordinate = dimensions == [variable.name()];
    if let Some(missing) = T::MISSING.filter(|_| !is_coordinate) {
        variable.set_fill_value(missing)?;
    }
    for (name, value) in attributes {
        variable.put_attribute(name, value.clone())?;
    }
    Ok(())
}

/// Element type of a variable.
pub(super) trait Stored: NcTypeDescriptor + Copy {
    /// Value of `_FillValue`; None for integers, which readers such as xarray would turn into
    /// floats.
    const MISSING: Option<Self>;
}

impl Stored for f32 {
    const MISSING: Option<Self> = Some(f32::NAN);
}
impl Stored for f64 {
    const MISSING: Option<Self> = Some(f64::NAN);
}
impl Stored for u8 {
    const MISSING: Option<Self> = None;
}
impl Stored for u16 {
    const MISSING: Option<Self> = None;
}
impl Stored for u32 {
    const MISSING: Option<Self> = None;
}
impl Stored for i64 {
    const MISSING: Option<Self> = None;
}
