//! The only rooms that name the netcdf crate: `layout` and `particles` (frames), `dataset` (tables and probes).

pub(crate) mod dataset;
mod layout;
pub(crate) mod particles;

use std::cell::Cell;
use std::path::Path;

use ::hdf5_metno_sys::LOCK;
use ::hdf5_metno_sys::h5::H5dont_atexit;
use ::hdf5_metno_sys::h5e::{H5E_DEFAULT, H5Eset_auto2};
use ::netcdf::{AttributeValue, File, FileMut, NcTypeDescriptor, VariableMut};

use super::disk;
use super::error::OutputError;

/// Turns an error of the library into ours; where the library only says "HDF error" the system is asked why.
fn refused(path: &Path) -> impl Fn(::netcdf::Error) -> OutputError + '_ {
    move |error| {
        let folder = path.parent().unwrap_or(Path::new("."));
        let what = match disk::refusal(folder) {
            Some(cause) => format!("cannot write: {cause} (NetCDF says: {error})"),
            None => error.to_string(),
        };
        OutputError::NetCdf { path: path.to_path_buf(), what }
    }
}

fn damaged(path: &Path) -> impl Fn(::netcdf::Error) -> OutputError + '_ {
    move |error| OutputError::Damaged { path: path.to_path_buf(), what: format!("cannot be read: {error}") }
}

/// Why a file was not filled: the library, or what was to be written.
enum Fault {
    Library(::netcdf::Error),
    Other(OutputError),
}

impl From<::netcdf::Error> for Fault {
    fn from(error: ::netcdf::Error) -> Self {
        Fault::Library(error)
    }
}

/// Sets HDF5 up for this thread: no printing, no work at the end of the process.
///
/// NetCDF probes for things that may be missing and handles the errors, but switches their printing off in the first
/// thread that uses it only, and HDF5 keeps this setting by thread. A file that could not be closed on a full disk is
/// flushed again by HDF5 when the process ends, which crashes; all files are closed by then, so that nothing is lost
/// without it.
fn prepare() {
    thread_local! {
        static DONE: Cell<bool> = const { Cell::new(false) };
    }
    if !DONE.replace(true) {
        let _alone = LOCK.lock();
        // SAFETY: the default error stack always exists, no function means no data for it either, and the lock is
        // the one under which the netcdf crate calls the library.
        unsafe {
            H5dont_atexit();
            H5Eset_auto2(H5E_DEFAULT, None, std::ptr::null_mut());
        }
    }
}

/// Writes a NetCDF-4 file whole or not at all.
///
/// On a full disk `nc_close` looks for what is still open in a file that HDF5 has given up, and crashes (libnetcdf 4.9.0). So everything is
/// flushed before, where a refusal is only an error, and a file that was refused is left open: the process is about to end.
fn write_file(path: &Path, fill: impl FnOnce(&mut FileMut) -> Result<(), Fault>) -> Result<(), OutputError> {
    prepare();
    let written = ::netcdf::create(disk::fresh_partial(path)).map_err(Fault::from).and_then(|mut file| {
        match fill(&mut file).and_then(|()| Ok(file.sync()?)) {
            // Without an explicit close the data of a full disk would be lost in silence.
            Ok(()) => Ok(file.close()?),
            Err(fault) => {
                std::mem::forget(file);
                Err(fault)
            }
        }
    });
    if let Err(fault) = written {
        let error = match fault {
            Fault::Library(error) => refused(path)(error),
            Fault::Other(error) => error,
        };
        disk::discard(path);
        return Err(error);
    }
    disk::commit(path)
}

fn open_file(path: &Path) -> Result<File, OutputError> {
    prepare();
    ::netcdf::open(path).map_err(damaged(path))
}

/// Adds a compressed variable with its attributes; NaN marks missing values of the floating-point types.
fn add_variable<'f, T: Stored>(
    file: &'f mut FileMut,
    name: &str,
    dimensions: &[&str],
    chunks: &[usize],
    attributes: &[(&str, AttributeValue)],
) -> Result<VariableMut<'f>, ::netcdf::Error> {
    let mut variable = file.add_variable::<T>(name, dimensions)?;
    if !dimensions.is_empty() {
        variable.set_chunking(chunks)?;
        // The only compression that every reader has: xarray, ParaView and netCDF-Java.
        variable.set_compression(1, true)?;
    }
    if let Some(missing) = T::MISSING {
        variable.set_fill_value(missing)?;
    }
    for (name, value) in attributes {
        variable.put_attribute(name, value.clone())?;
    }
    Ok(variable)
}

/// A type that variables are stored in.
trait Stored: NcTypeDescriptor + Copy {
    /// Value of `_FillValue`; None for integers, which readers such as xarray would turn into floats.
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
