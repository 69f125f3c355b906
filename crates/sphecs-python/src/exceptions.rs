//! Errors of the engine as Python exceptions, with the messages of the command line.
//!
//! The classes are those of `python/src/sphecs/_exceptions.py`.

use miette::{Diagnostic, GraphicalReportHandler, GraphicalTheme};
use pyo3::types::{PyAnyMethods, PyDict, PyDictMethods};
use pyo3::{Bound, PyAny, PyErr, PyResult, Python};

use sphecs::SceneErrors;
use sphecs_engine::simulation::{BuildError, Stop};
use sphecs_output::error::OutputError;
use sphecs_run::error::RunError;
use sphecs_run::report::status_and_cure;

/// Width of messages, characters: that of the command line without a terminal.
const WIDTH: usize = 160;

/// Returns the message of the command line, without colours.
fn rendered(error: &dyn Diagnostic) -> String {
    let handler = GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor())
        .with_width(WIDTH)
        .with_links(false);
    let mut text = String::new();
    match handler.render_report(&mut text, error) {
        Ok(()) => text.trim_matches('\n').to_owned(),
        Err(_) => error.to_string(),
    }
}

/// Returns an exception of a class of the package.
fn exception<'py>(
    py: Python<'py>,
    class: &str,
    message: String,
    attributes: &Bound<'py, PyDict>,
) -> PyResult<Bound<'py, PyAny>> {
    py.import("sphecs._exceptions")?.getattr(class)?.call((message,), Some(attributes))
}

fn raised(made: PyResult<Bound<'_, PyAny>>) -> PyErr {
    made.map_or_else(|error| error, PyErr::from_value)
}

/// Returns a `RunError` with a reason that programs can compare.
pub(crate) fn run_error(py: Python<'_>, reason: &str, message: String) -> PyErr {
    let attributes = PyDict::new(py);
    let made =
        attributes.set_item("reason", reason).and_then(|()| exception(py, "RunError", message, &attributes));
    raised(made)
}

/// Returns the faults of a scene as dictionaries.
pub(crate) fn faults<'py>(
    py: Python<'py>,
    file: &str,
    errors: &SceneErrors,
) -> PyResult<Vec<Bound<'py, PyDict>>> {
    let entry = |fault| {
        let position = errors.position(fault);
        let source = fault.source.as_deref().map_or(file, |source| source.name());
        let entry = PyDict::new(py);
        entry.set_item("message", &fault.title)?;
        entry.set_item("file", source)?;
        entry.set_item("line", position.map(|(line, _)| line))?;
        entry.set_item("column", position.map(|(_, column)| column))?;
        entry.set_item("found", &fault.label)?;
        entry.set_item("help", fault.help.as_deref())?;
        Ok(entry)
    };
    errors.faults().iter().map(entry).collect()
}

/// Returns the message and the faults of a scene as the command line prints them.
pub(crate) fn scene_message(errors: &SceneErrors) -> String {
    rendered(errors)
}

/// Returns the `SceneError` of a scene.
pub(crate) fn scene_error(py: Python<'_>, file: &str, errors: &SceneErrors) -> PyErr {
    let made = || {
        let attributes = PyDict::new(py);
        attributes.set_item("faults", faults(py, file, errors)?)?;
        exception(py, "SceneError", rendered(errors), &attributes)
    };
    raised(made())
}

/// Returns the exception of a flow that cannot be advanced further.
pub(crate) fn stop_error(py: Python<'_>, stop: Stop) -> PyErr {
    let (_, cure) = status_and_cure(&stop);
    flow_error(py, RunError::Flow { stop, cure, report: String::new() })
}

/// Returns the exception of a simulation that cannot be built.
pub(crate) fn build_error(py: Python<'_>, error: &BuildError) -> PyErr {
    run_error(py, "build", error.to_string())
}

/// Returns the exception of a file that cannot be read or written.
pub(crate) fn output_error(py: Python<'_>, error: &OutputError) -> PyErr {
    let reason = match error {
        OutputError::Exists { .. } => "exists",
        OutputError::Foreign { .. } => "foreign",
        OutputError::Busy { .. } => "busy",
        OutputError::NotARun { .. } => "not a run",
        OutputError::Request(_) => "request",
        OutputError::DiskFull { .. } => "disk",
        OutputError::Io { .. } | OutputError::NetCdf { .. } | OutputError::Damaged { .. } => "files",
    };
    run_error(py, reason, error.to_string())
}

/// Returns the exception of a run that an error stopped.
pub(crate) fn error_of_run(py: Python<'_>, file: &str, error: RunError) -> PyErr {
    match error {
        RunError::Scene(errors) => scene_error(py, file, &errors),
        RunError::Output(error) => output_error(py, &error),
        RunError::Build(error) => build_error(py, &error),
        RunError::Flow { .. } => flow_error(py, error),
        error @ (RunError::Threads(_) | RunError::Ranks(_) | RunError::Signals(_)) => {
            run_error(py, "threads", rendered(&error))
        }
    }
}

fn flow_error(py: Python<'_>, error: RunError) -> PyErr {
    let RunError::Flow { stop, .. } = &error else { return run_error(py, "flow", error.to_string()) };
    let (reason, step, time) = match stop {
        Stop::Diverged { step, time, .. } => ("diverged", *step, *time),
        Stop::Drained { step, time, .. } => ("drained", *step, *time),
        Stop::ReservoirEmpty { step, time } => ("reservoir empty", *step, *time),
        Stop::Requested { step, time, .. } => ("stopped", *step, *time),
    };
    let made = || {
        let attributes = PyDict::new(py);
        attributes.set_item("reason", reason)?;
        attributes.set_item("step", step)?;
        attributes.set_item("time", time)?;
        exception(py, "RunError", rendered(&error), &attributes)
    };
    raised(made())
}
