//! Arrays of the particles of a simulation, in the order of their numbers.
//!
//! The arrays are copies that own their memory, not views of the columns of the engine. A view
//! could be kept alive, but not kept right. The columns hold one axis each, in the precision of the
//! scene, are sorted again in every step, and are resized when particles enter. An array of the
//! shape `(n, dimensions)` in a lasting order therefore does not exist inside the engine. The copy
//! is made at the first use after a step. In 2D it takes about half the time of a step, most of it
//! for density and pressure at the present positions, which the files need as well.

use std::ops::Range;

use glam::DVec3;
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::types::{PyDict, PyDictMethods};
use pyo3::{Bound, PyResult, Python};

use sphecs::Zone;
use sphecs::bevy_ecs::world::World;
use sphecs_engine::components::{ParticleId, Position, Roles, Thermodynamics, Velocity, zone_and_patch};

/// Columns of all particles but those in the reservoir, sorted by number.
#[derive(Debug, Default)]
pub(crate) struct Snapshot {
    id: Vec<u32>,
    position: Vec<DVec3>,
    velocity: Vec<DVec3>,
    density: Vec<f64>,
    pressure: Vec<f64>,
    zone: Vec<u8>,
    patch: Vec<u16>,
}

/// Components of one particle.
type Particle = (&'static ParticleId, &'static Position, &'static Velocity, &'static Thermodynamics, Roles);

impl Snapshot {
    /// Returns the state of a world with up-to-date components.
    pub(crate) fn of(world: &World) -> Self {
        let Some(mut query) = world.try_query::<Particle>() else { return Self::default() };
        let mut particles: Vec<_> = query
            .iter(world)
            .map(|(id, position, velocity, thermodynamics, roles)| {
                let (zone, patch) = zone_and_patch(roles);
                (id.0, position.0, velocity.0, *thermodynamics, zone, patch)
            })
            .filter(|&(.., zone, _)| zone != Zone::Reservoir)
            .collect();
        particles.sort_unstable_by_key(|&(id, ..)| id);
        let mut snapshot = Self::default();
        for (id, position, velocity, thermodynamics, zone, patch) in particles {
            snapshot.id.push(id);
            snapshot.position.push(position);
            snapshot.velocity.push(velocity);
            snapshot.density.push(thermodynamics.density);
            snapshot.pressure.push(thermodynamics.pressure);
            snapshot.zone.push(zone as u8);
            snapshot.patch.push(patch);
        }
        snapshot
    }

    /// Returns the columns as arrays by their names.
    pub(crate) fn into_arrays(self, py: Python<'_>, dimensions: usize) -> PyResult<Bound<'_, PyDict>> {
        let arrays = PyDict::new(py);
        arrays.set_item("id", PyArray1::from_vec(py, self.id))?;
        arrays.set_item("position", vectors(py, &self.position, 0..dimensions)?)?;
        arrays.set_item("velocity", vectors(py, &self.velocity, 0..dimensions)?)?;
        arrays.set_item("density", PyArray1::from_vec(py, self.density))?;
        arrays.set_item("pressure", PyArray1::from_vec(py, self.pressure))?;
        arrays.set_item("zone", PyArray1::from_vec(py, self.zone))?;
        arrays.set_item("patch", PyArray1::from_vec(py, self.patch))?;
        Ok(arrays)
    }
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
