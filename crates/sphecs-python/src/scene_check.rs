//! Faults and notes of a scene, as `sphecs check` finds them.

use pyo3::types::{PyDict, PyDictMethods};
use pyo3::{Bound, PyResult, Python, pyfunction};

use crate::exceptions::{faults, run_error, scene_message};
use crate::guard::detached;
use crate::scene_input::SceneInput;
use sphecs_run::check::{self as scene_check, CheckOptions};
use sphecs_run::memory;
use sphecs_run::threads::on_threads;

/// Returns the report on a scene: `text`, `faults` and `notes`.
#[pyfunction]
pub(crate) fn check<'py>(
    py: Python<'py>,
    scene: SceneInput,
    until: Option<f64>,
    threads: Option<usize>,
    timed: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let report = PyDict::new(py);
    let loaded = detached(py, || scene.read(memory::available()))?;
    let scene = match loaded {
        Ok(scene) => scene,
        Err(errors) => {
            report.set_item("text", scene_message(&errors))?;
            report.set_item("faults", faults(py, &scene.shown(), &errors)?)?;
            report.set_item("notes", Vec::<String>::new())?;
            return Ok(report);
        }
    };
    let options = CheckOptions { until, timed, ranks: 1 };
    let work = || on_threads(threads, || scene_check::check(&scene, sphecs_scene::seeds(&scene), &options));
    let found = detached(py, work)?.map_err(|error| run_error(py, "threads", error.to_string()))?;
    report.set_item("text", &found.text)?;
    report.set_item("faults", Vec::<String>::new())?;
    report.set_item("notes", &found.notes)?;
    Ok(report)
}
