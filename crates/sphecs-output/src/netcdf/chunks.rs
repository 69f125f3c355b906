//! Compressed chunks of the variables of a file, read and written past the filters of HDF5.
//!
//! HDF5 lets one thread in at a time, and its filters run inside. So other threads compress the
//! chunks, and chunks are copied from file to file as they are. The files must be closed in
//! netCDF, which opens them in a way that excludes other access.

use std::ffi::CString;
use std::path::Path;

use ::hdf5_metno_sys::LOCK;
use ::hdf5_metno_sys::h5d::{
    H5Dclose, H5Dget_chunk_info_by_coord, H5Dget_create_plist, H5Dopen2, H5Dread_chunk1, H5Dset_extent,
    H5Dwrite_chunk,
};
use ::hdf5_metno_sys::h5f::{H5F_ACC_RDONLY, H5F_ACC_RDWR, H5F_scope_t, H5Fclose, H5Fflush, H5Fopen};
use ::hdf5_metno_sys::h5i::hid_t;
use ::hdf5_metno_sys::h5p::{H5P_DEFAULT, H5Pclose, H5Pget_chunk, H5Pget_filter2, H5Pget_nfilters};
use ::hdf5_metno_sys::h5z::{H5Z_FILTER_DEFLATE, H5Z_FILTER_SHUFFLE};

/// Failed operation of the library, for a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ChunkError(pub(super) &'static str);

/// Level of compression of all files, the fastest of zlib.
pub(super) const LEVEL: u8 = 1;

/// Returns bytes compressed by zlib, as the filters of HDF5 and the blocks of VTK files have them.
pub(crate) fn deflated(bytes: &[u8]) -> Vec<u8> {
    let mut length = bytes.len() as _;
    // SAFETY: the function computes a number.
    length = unsafe { ::libz_sys::compressBound(length) };
    let mut compressed = vec![0; length as usize];
    // SAFETY: both buffers have the lengths given.
    let status = unsafe {
        ::libz_sys::compress2(
            compressed.as_mut_ptr(),
            &mut length,
            bytes.as_ptr(),
            bytes.len() as _,
            LEVEL.into(),
        )
    };
    // With a buffer of this length only the memory can be short, for which Rust aborts too.
    assert_eq!(status, ::libz_sys::Z_OK, "zlib has no memory");
    compressed.truncate(length as usize);
    compressed
}

/// Chunk as a file stores it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Chunk {
    /// Bytes behind the filters.
    pub(super) bytes: Vec<u8>,
    /// Bits of the filters that were left out.
    pub(super) skipped_filters: u32,
}

impl Chunk {
    /// Compresses shuffled bytes as the filters of HDF5 do.
    pub(super) fn compressed(shuffled: &[u8]) -> Self {
        Self { bytes: deflated(shuffled), skipped_filters: 0 }
    }
}

/// Access to a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Access {
    Read,
    Write,
}

/// Open HDF5 file, closed on drop.
#[derive(Debug)]
pub(super) struct ChunkFile(hid_t);

impl ChunkFile {
    /// Opens a file that netCDF has closed.
    pub(super) fn open(path: &Path, access: Access) -> Result<Self, ChunkError> {
        super::file::prepare();
        let failed = ChunkError("HDF5 cannot open the file");
        let name = CString::new(path.as_os_str().as_encoded_bytes()).map_err(|_| failed)?;
        let flags = if access == Access::Read { H5F_ACC_RDONLY } else { H5F_ACC_RDWR };
        let _guard = LOCK.lock();
        // SAFETY: the name ends in 0, and the lock is the one of the netcdf crate, as everywhere
        // below.
        let file = unsafe { H5Fopen(name.as_ptr(), flags, H5P_DEFAULT) };
        if file < 0 { Err(failed) } else { Ok(Self(file)) }
    }

    /// Opens a variable of the root group.
    pub(super) fn variable(&self, name: &str) -> Result<ChunkedVariable, ChunkError> {
        let failed = ChunkError("HDF5 cannot open a variable");
        let name = CString::new(name).map_err(|_| failed)?;
        let _guard = LOCK.lock();
        // SAFETY: the file is open, and the name ends in 0.
        let variable = unsafe { H5Dopen2(self.0, name.as_ptr(), H5P_DEFAULT) };
        if variable < 0 { Err(failed) } else { Ok(ChunkedVariable(variable)) }
    }

    /// Hands everything written to the system, where a full disk is noticed.
    pub(super) fn flush(&self) -> Result<(), ChunkError> {
        let _guard = LOCK.lock();
        // SAFETY: the file is open.
        let status = unsafe { H5Fflush(self.0, H5F_scope_t::H5F_SCOPE_GLOBAL) };
        if status < 0 { Err(ChunkError("HDF5 cannot write the file")) } else { Ok(()) }
    }

    /// Closes the file.
    pub(super) fn close(self) -> Result<(), ChunkError> {
        let file = std::mem::ManuallyDrop::new(self);
        let _guard = LOCK.lock();
        // SAFETY: the file is open, and it is not closed again.
        let status = unsafe { H5Fclose(file.0) };
        if status < 0 { Err(ChunkError("HDF5 cannot close the file")) } else { Ok(()) }
    }
}

impl Drop for ChunkFile {
    fn drop(&mut self) {
        let _guard = LOCK.lock();
        // SAFETY: the file is open. Of a file that was only read nothing can be lost.
        unsafe { H5Fclose(self.0) };
    }
}

/// Open variable over (time, slot), closed on drop.
#[derive(Debug)]
pub(super) struct ChunkedVariable(hid_t);

impl ChunkedVariable {
    /// Returns the number of slots in a chunk; None if the chunks are not those that
    /// [`Chunk::compressed`] makes.
    pub(super) fn slots_in_chunk(&self) -> Option<usize> {
        let _guard = LOCK.lock();
        // SAFETY: the variable is open. The properties are closed before they go out of scope, and
        // the functions write at most two numbers to `shape` and nothing elsewhere.
        unsafe {
            let properties = H5Dget_create_plist(self.0);
            if properties < 0 {
                return None;
            }
            let mut shape = [0; 2];
            let rank = H5Pget_chunk(properties, 2, shape.as_mut_ptr());
            let filter = |index: i32| {
                let (mut values, none) = (0, std::ptr::null_mut());
                let (mut flags, mut config) = (0, 0);
                H5Pget_filter2(
                    properties,
                    index as u32,
                    &mut flags,
                    &mut values,
                    std::ptr::null_mut(),
                    0,
                    none,
                    &mut config,
                )
            };
            let filters: Vec<_> = (0..H5Pget_nfilters(properties)).map(filter).collect();
            H5Pclose(properties);
            let is_usual = rank == 2 && shape[0] == 1 && filters == [H5Z_FILTER_SHUFFLE, H5Z_FILTER_DEFLATE];
            is_usual.then_some(shape[1] as usize)
        }
    }

    /// Reads the chunk of a time that begins at a slot.
    pub(super) fn read(&self, time: usize, slot: usize) -> Result<Chunk, ChunkError> {
        let (failed, at) = (ChunkError("HDF5 cannot read a chunk"), [time as u64, slot as u64]);
        let (mut chunk, mut length, mut address) = (Chunk::default(), 0, 0);
        let _guard = LOCK.lock();
        // SAFETY: the variable is open and has two dimensions, as `at` has.
        let status = unsafe {
            let filters = &mut chunk.skipped_filters;
            H5Dget_chunk_info_by_coord(self.0, at.as_ptr(), filters, &mut address, &mut length)
        };
        if status < 0 || length == 0 {
            return Err(failed);
        }
        chunk.bytes.resize(length as usize, 0);
        let to = chunk.bytes.as_mut_ptr().cast();
        // SAFETY: as above, and the buffer has the length that the library has just given.
        let status =
            unsafe { H5Dread_chunk1(self.0, H5P_DEFAULT, at.as_ptr(), &mut chunk.skipped_filters, to) };
        if status < 0 { Err(failed) } else { Ok(chunk) }
    }

    /// Sets the number of times and slots.
    pub(super) fn resize(&self, times: usize, slots: usize) -> Result<(), ChunkError> {
        let shape = [times as u64, slots as u64];
        let _guard = LOCK.lock();
        // SAFETY: the variable is open and has two dimensions.
        let status = unsafe { H5Dset_extent(self.0, shape.as_ptr()) };
        if status < 0 { Err(ChunkError("HDF5 cannot extend a variable")) } else { Ok(()) }
    }

    /// Writes the chunk of a time that begins at a slot.
    pub(super) fn write(&self, time: usize, slot: usize, chunk: &Chunk) -> Result<(), ChunkError> {
        let at = [time as u64, slot as u64];
        let (length, bytes) = (chunk.bytes.len(), chunk.bytes.as_ptr().cast());
        let _guard = LOCK.lock();
        // SAFETY: the variable is open and has two dimensions, and the buffer has the length given.
        let status =
            unsafe { H5Dwrite_chunk(self.0, H5P_DEFAULT, chunk.skipped_filters, at.as_ptr(), length, bytes) };
        if status < 0 { Err(ChunkError("HDF5 cannot write a chunk")) } else { Ok(()) }
    }
}

impl Drop for ChunkedVariable {
    fn drop(&mut self) {
        let _guard = LOCK.lock();
        // SAFETY: the variable is open.
        unsafe { H5Dclose(self.0) };
    }
}
