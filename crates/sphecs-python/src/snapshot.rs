//! Arrays of the particles of a simulation, in the order of their numbers.
//!
//! The arrays are copies that own their memory, not views of the columns of the engine. A view
//! could be kept alive, but not kept right. The columns hold one axis each, in the precision of the
//! scene, are sorted again in every step, and are resized when particles enter. An array of the
//! shape `(n, dimensions)` in a lasting order therefore does not exist inside the engine. The copy
//! is made at the first use after a step, in a part of its time. Most of that is spent on density
//! and pressure at the present positions, which the files need as well.

use std::ops::Range;

use glam::DVec3;
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::types::{PyDict, PyDictMethods};
use pyo3::{Bound, PyResult, Python};

use sphecs_engine::particle_table::ParticleTable;

/// Returns the columns as arrays by their names.
pub(crate) fn arrays_of(
    py: Python<'_>,
    table: ParticleTable,
    dimensions: usize,
) -> PyResult<Bound<'_, PyDict>> {
    let zone = table.zone.iter().map(|&zone| zone as u8);
    let arrays = PyDict::new(py);
    arrays.set_item("zone", PyArray1::from_iter(py, zone))?;
    arrays.set_item("id", PyArray1::from_vec(py, table.id))?;
    arrays.set_item("patch", PyArray1::from_vec(py, table.patch))?;
    arrays.set_item("position", vectors(py, &table.position, 0..dimensions)?)?;
    arrays.set_item("velocity", vectors(py, &table.velocity, 0..dimensions)?)?;
    arrays.set_item("density", PyArray1::from_vec(py, table.density))?;
    arrays.set_item("pressure", PyArray1::from_vec(py, table.pressure))?;
    Ok(arrays)
}

/// Returns an array of shape `(n, axes)` from vectors.
pub(crate) fn vectors<'py>(
    py: Python<'py>,
    vectors: &[DVec3],
    axes: Range<usize>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let shape = [vectors.len(), axes.len()];
    let flat = vectors.iter().flat_map(|vector| axes.clone().map(|axis| vector[axis])).collect();
    PyArray1::from_vec(py, flat).reshape(shape)
}
