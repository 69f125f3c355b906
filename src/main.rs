//! The program `sphecs`: see [`sphecs::cli`].

use std::process::ExitCode;

fn main() -> ExitCode {
    // HDF5 locks files that it opens and fails where a file system has no locks or another program
    // holds one. A run folder has a lock of its own, and complete files are never written again.
    if std::env::var_os(HDF5_LOCKS).is_none() {
        // SAFETY: no other thread exists yet.
        unsafe { std::env::set_var(HDF5_LOCKS, "FALSE") };
    }
    sphecs::cli::main()
}

/// Variable that HDF5 reads when it is first used.
const HDF5_LOCKS: &str = "HDF5_USE_FILE_LOCKING";
