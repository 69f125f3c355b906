//! Files of a run that Python reads: its summary, and the journal of a run that is under way.

use std::path::PathBuf;

use pyo3::{PyResult, Python, pyfunction};

use crate::exceptions::output_error;
use crate::guard::detached;
use sphecs_output::error::OutputError;
use sphecs_output::journal::frame_paths;
use sphecs_output::pack as packing;
use sphecs_output::paths::{JOURNAL, SUMMARY, walls};
use sphecs_output::summary::Summary;

/// Returns the files of the frames in a journal in the order of time, and that of the walls.
#[pyfunction]
pub(crate) fn journal_frames(py: Python<'_>, folder: PathBuf) -> PyResult<(Vec<PathBuf>, PathBuf)> {
    let journal = folder.join(JOURNAL);
    let found = detached(py, || frame_paths(&journal))?;
    found.map(|frames| (frames, walls(&journal))).map_err(|error: OutputError| output_error(py, &error))
}

/// Returns the text of `summary.json` of a run folder, or an error that says that it is none.
#[pyfunction]
pub(crate) fn run_summary(py: Python<'_>, folder: PathBuf) -> PyResult<String> {
    let read = detached(py, || {
        // Refuses what is no run, with the message of the command line.
        Summary::read(&folder)?;
        let path = folder.join(SUMMARY);
        std::fs::read_to_string(&path).map_err(OutputError::io(&path, "read"))
    })?;
    read.map_err(|error| output_error(py, &error))
}

/// Packs the run in a folder.
#[pyfunction]
pub(crate) fn pack(py: Python<'_>, folder: PathBuf) -> PyResult<()> {
    let packed = detached(py, || packing::pack(&folder))?;
    packed.map(|_| ()).map_err(|error| output_error(py, &error))
}
