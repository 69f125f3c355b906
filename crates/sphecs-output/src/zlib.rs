//! Compression by zlib, as the filters of HDF5 and the blocks of VTK files have it.

/// Level of compression of all files, the fastest of zlib.
pub(crate) const LEVEL: u8 = 1;

/// Returns compressed bytes.
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
