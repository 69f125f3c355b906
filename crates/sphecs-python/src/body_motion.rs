//! Force and torque of the fluid on a body, and the motion of the body.

use glam::DVec3;
use numpy::PyArray1;
use pyo3::types::{PyDict, PyDictMethods};
use pyo3::{Bound, PyResult, Python};

use sphecs_core::pass::body::BodySum;
use sphecs_engine::systems::body_forces::BodyMotion;

/// Returns force and torque at a time, s; position, velocity and spin of a body that moves.
pub(crate) fn body_entry<'py>(
    py: Python<'py>,
    time: f64,
    sum: &BodySum,
    motion: Option<&BodyMotion>,
    dimensions: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let vector = |vector: DVec3| PyArray1::from_slice(py, &vector.to_array()[..dimensions]);
    // In 2D a body turns about z alone.
    let turning = |vector: DVec3| match dimensions {
        2 => PyArray1::from_slice(py, &[vector.z]),
        _ => PyArray1::from_slice(py, &vector.to_array()),
    };
    let entry = PyDict::new(py);
    entry.set_item("time", time)?;
    entry.set_item("pressure_force", vector(sum.pressure_force))?;
    entry.set_item("viscous_force", vector(sum.viscous_force))?;
    entry.set_item("pressure_torque", turning(sum.pressure_torque))?;
    entry.set_item("viscous_torque", turning(sum.viscous_torque))?;
    if let Some(motion) = motion {
        entry.set_item("position", vector(motion.position))?;
        entry.set_item("velocity", vector(motion.velocity))?;
        entry.set_item("spin", turning(motion.spin))?;
    }
    Ok(entry)
}
