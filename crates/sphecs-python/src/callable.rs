//! Forces that a Python function computes for all fluid particles at once.
//!
//! The engine calls the function in every stage of a step from a thread of the flow, which takes
//! the interpreter for the call. The thread that began the step has left it. An exception ends the
//! step; later stages of it are not evaluated.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use glam::DVec3;
use numpy::{PyArray2, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::types::PyAnyMethods;
use pyo3::{Bound, Py, PyAny, PyErr, PyResult, PyTraverseError, PyVisit, Python};

use crate::snapshot::vectors;
use sphecs::{AddedForces, FluidState, Plugin, PluginContext, StopRequest};

/// First exception of a function in a simulation.
#[derive(Clone, Debug, Default)]
pub(crate) struct Failure(Arc<Mutex<Option<PyErr>>>);

impl Failure {
    /// Returns true if a function has raised an exception that nobody has taken.
    pub(crate) fn is_set(&self) -> bool {
        self.lock().is_some()
    }

    /// Takes the exception.
    pub(crate) fn take(&self) -> Option<PyErr> {
        self.lock().take()
    }

    fn set(&self, error: PyErr) {
        self.lock().get_or_insert(error);
    }

    fn lock(&self) -> MutexGuard<'_, Option<PyErr>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Functions of a simulation, which the garbage collector of Python may visit and clear.
///
/// A function is often a method of the object that holds the simulation: such a circle is freed by
/// the collector alone.
#[derive(Clone, Debug)]
pub(crate) struct Functions(Arc<Mutex<Vec<Py<PyAny>>>>);

impl Functions {
    pub(crate) fn new(functions: Vec<Py<PyAny>>) -> Self {
        Self(Arc::new(Mutex::new(functions)))
    }

    /// Visits the functions; those in use by a step are left out, and so stay alive.
    pub(crate) fn traverse(&self, visit: &PyVisit<'_>) -> Result<(), PyTraverseError> {
        let functions = self.0.try_lock();
        functions.iter().flat_map(|functions| functions.iter()).try_for_each(|function| visit.call(function))
    }

    /// Drops the functions.
    pub(crate) fn clear(&self) {
        let functions = std::mem::take(&mut *self.lock());
        drop(functions);
    }

    fn is_empty(&self) -> bool {
        self.lock().is_empty()
    }

    fn all(&self, py: Python<'_>) -> Vec<Py<PyAny>> {
        self.lock().iter().map(|function| function.clone_ref(py)).collect()
    }

    fn lock(&self) -> MutexGuard<'_, Vec<Py<PyAny>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Plugin that adds the functions to the forces.
pub(crate) struct CallableForces {
    pub(crate) functions: Functions,
    pub(crate) dimensions: usize,
    pub(crate) failure: Failure,
}

impl Plugin for CallableForces {
    fn build(&self, context: &mut PluginContext<'_>) {
        if self.functions.is_empty() {
            return;
        }
        let (functions, dimensions, failure) =
            (self.functions.clone(), self.dimensions, self.failure.clone());
        let stop = context.world.get_resource_or_init::<StopRequest>().clone();
        let add_all = move |fluid: &FluidState<'_>, force: &mut [DVec3]| {
            if failure.is_set() {
                return;
            }
            let called = Python::try_attach(|py| {
                let functions = functions.all(py);
                functions.iter().try_for_each(|function| add(function.bind(py), dimensions, fluid, force))
            });
            let ends = || PyRuntimeError::new_err("the interpreter is about to end");
            if let Err(error) = called.unwrap_or_else(|| Err(ends())) {
                stop.set(format!("a force raised {error}"));
                failure.set(error);
            }
        };
        context.world.get_resource_or_init::<AddedForces>().add_field(add_all);
    }
}

/// Calls a function and adds its result to the forces.
fn add(
    function: &Bound<'_, PyAny>,
    dimensions: usize,
    fluid: &FluidState<'_>,
    force: &mut [DVec3],
) -> PyResult<()> {
    let py = function.py();
    let position = vectors(py, fluid.position, 0..dimensions)?;
    let velocity = vectors(py, fluid.velocity, 0..dimensions)?;
    let returned = function.call1((fluid.time, position, velocity))?;
    let shape = [force.len(), dimensions];
    let array = as_array(&returned, function, shape)?;
    let array = array.readonly();
    let array = array.as_array();
    for (index, (force, row)) in force.iter_mut().zip(array.rows()).enumerate() {
        for (axis, &value) in row.iter().enumerate() {
            force[axis] += value;
        }
        if row.iter().any(|value| !value.is_finite()) {
            let at = &fluid.position[index].to_array()[..dimensions];
            return Err(PyValueError::new_err(format!(
                "the force {}: is {row} m/s² for particle {} at {at:?} m, t = {} s; must be finite",
                name_of(function),
                fluid.id[index],
                fluid.time,
            )));
        }
    }
    Ok(())
}

/// Returns the result as an array of the shape; a vector holds for all particles.
fn as_array<'py>(
    returned: &Bound<'py, PyAny>,
    function: &Bound<'py, PyAny>,
    shape: [usize; 2],
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let numpy = returned.py().import("numpy")?;
    let array = numpy.call_method1("asarray", (returned, "float64"))?;
    let shaped = numpy.call_method1("broadcast_to", (&array, (shape[0], shape[1])));
    let array = shaped.ok().and_then(|array| array.cast_into::<PyArray2<f64>>().ok());
    array.filter(|array| array.shape() == shape).ok_or_else(|| {
        let given = array_shape(returned, &numpy);
        PyValueError::new_err(format!(
            "the force {}: returned an array of shape {given}, must be ({}, {}): one acceleration per particle, m/s²",
            name_of(function),
            shape[0],
            shape[1],
        ))
    })
}

fn array_shape(returned: &Bound<'_, PyAny>, numpy: &Bound<'_, PyAny>) -> String {
    numpy.call_method1("shape", (returned,)).map_or_else(|_| "none".to_owned(), |shape| shape.to_string())
}

/// Returns the name of a function for messages.
fn name_of(function: &Bound<'_, PyAny>) -> String {
    let name = function.getattr("__name__").or_else(|_| function.get_type().getattr("__name__"));
    name.map_or_else(|_| "of the program".to_owned(), |name| format!("`{name}`"))
}
