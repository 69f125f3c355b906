//! Panics of the engine as exceptions: none may cross the border to Python.
//!
//! PyO3 turns a panic into `PanicException`, which `except Exception` does not catch.

use std::panic::{AssertUnwindSafe, catch_unwind};

use pyo3::{PyErr, PyResult, Python};

use crate::exceptions::run_error;

/// Runs `work` with the interpreter free for other threads, and returns its result or the message
/// of its panic.
pub(crate) fn detached<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    // What a panic leaves behind is not used again: the caller drops or locks it for ever.
    let done = py.detach(|| catch_unwind(AssertUnwindSafe(work)));
    done.map_err(|panic| internal_error(py, panic.as_ref()))
}

/// Returns the exception of a panic.
pub(crate) fn internal_error(py: Python<'_>, panic: &(dyn std::any::Any + Send)) -> PyErr {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    let what = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
    let message =
        format!("internal error in sphecs: {what}\nplease report it with the scene and the program");
    run_error(py, "internal", message)
}
