//! Particles around the first invalid one of a flow that diverged: `divergence.nc` and
//! `divergence.png`.
//!
//! The variables of `divergence.nc` run over `particle`, in the order of the particle numbers. They
//! are position and velocity after the step that failed, the velocity one step earlier, and
//! density, pressure and acceleration within the step.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use glam::DVec3;

use super::error::OutputError;
use super::frame::Frame;
use super::header::Header;
use super::netcdf::dataset::{Dataset, Group, Variable};
use super::paths::{DIVERGENCE_NETCDF, DIVERGENCE_PICTURE};
use super::picture::{Field, RenderOptions, Slice, render_marked};
use super::results::Results;
use sphecs_core::particles::zone::Zone;
use sphecs_engine::resources::clock::Clock;
use sphecs_engine::systems::divergence::DivergedParticle;
use sphecs_engine::systems::divergence::{NearbyParticle, Neighbourhood};

/// Width of the picture, pixels.
const WIDTH: u32 = 1000;

/// Writes both files and returns their paths.
///
/// # Errors
/// [`OutputError`] with path and cause.
pub fn write(
    folder: &Path,
    header: &Header,
    clock: &Clock,
    diverged: &DivergedParticle,
) -> Result<[PathBuf; 2], OutputError> {
    let paths = [folder.join(DIVERGENCE_NETCDF), folder.join(DIVERGENCE_PICTURE)];
    dataset(header, &diverged.neighbourhood, diverged).write(&paths[0], header)?;
    draw(header, clock, diverged, &paths[1])?;
    Ok(paths)
}

/// Removes both files if they exist, since the run resumes from an earlier step.
///
/// # Errors
/// [`OutputError::Io`] when a file cannot be removed.
pub(super) fn remove(folder: &Path) -> Result<(), OutputError> {
    for name in [DIVERGENCE_NETCDF, DIVERGENCE_PICTURE] {
        let path = folder.join(name);
        match fs::remove_file(&path) {
            Err(cause) if cause.kind() != io::ErrorKind::NotFound => {
                return Err(OutputError::io(&path, "remove")(cause));
            }
            _ => {}
        }
    }
    Ok(())
}

/// Returns the time of the last frame, s, and the values of a particle in it; None if the particle
/// is absent.
///
/// # Errors
/// [`OutputError`] with path and cause.
pub fn in_last_frame(folder: &Path, id: u32) -> Result<Option<(f64, NearbyParticle)>, OutputError> {
    let results = Results::open(folder)?;
    let Some(last) = results.len().checked_sub(1) else { return Ok(None) };
    let frame = results.frame(last)?;
    let slot = id as usize;
    if slot >= frame.len() || !frame.position[0][slot].is_finite() {
        return Ok(None);
    }
    let vector = |columns: &[Vec<f32>; 3]| {
        let component = |axis: usize| f64::from(columns[axis].get(slot).copied().unwrap_or(0.0));
        DVec3::new(component(0), component(1), component(2))
    };
    let velocity = vector(&frame.velocity);
    let particle = NearbyParticle {
        id,
        zone: Zone::ALL.get(usize::from(frame.zone[slot])).copied().unwrap_or_default(),
        patch: frame.patch[slot],
        position: DVec3::from_array([0, 1, 2].map(|axis| frame.position[axis][slot])),
        velocity,
        previous_velocity: velocity,
        acceleration: DVec3::ZERO,
        density: f64::from(frame.density[slot]),
        pressure: f64::from(frame.pressure[slot]),
    };
    Ok(Some((frame.time, particle)))
}

fn dataset(header: &Header, around: &Neighbourhood, diverged: &DivergedParticle) -> Dataset {
    let mut dataset = Dataset {
        title: format!(
            "particles around particle {} when the flow diverged: {}",
            diverged.id, diverged.found
        ),
        root: Group { dimensions: vec![("particle".to_owned(), around.particles.len())], ..Group::default() },
    };
    let mut add = |name: String, units: &str, long_name: &str, value: &dyn Fn(&NearbyParticle) -> f64| {
        dataset.root.variables.push(Variable {
            name,
            dimensions: vec!["particle".to_owned()],
            values: around.particles.iter().map(value).collect(),
            attributes: vec![("units", units.to_owned()), ("long_name", long_name.to_owned())],
        });
    };
    add("particle_id".into(), "1", "number of the particle in the run", &|near| f64::from(near.id));
    let zones: Vec<String> =
        Zone::ALL.iter().map(|zone| format!("{} {}", *zone as u8, zone.name())).collect();
    let zones = format!("zone that the particle belongs to: {}", zones.join(", "));
    add("zone".into(), "1", &zones, &|near| f64::from(near.zone as u8));
    add("patch".into(), "1", "inlet, outlet or wall part", &|near| f64::from(near.patch));
    for (axis, name) in header.axes().iter().enumerate() {
        add((*name).to_owned(), "m", "position after the step", &move |near| near.position[axis]);
    }
    for (axis, name) in ["u", "v", "w"].into_iter().enumerate().take(header.dimensions) {
        add(name.to_owned(), "m s-1", "velocity after the step", &move |near| near.velocity[axis]);
        add(format!("{name}_before"), "m s-1", "velocity one step earlier", &move |near| {
            near.previous_velocity[axis]
        });
        add(format!("d{name}_dt"), "m s-2", "acceleration in the step", &move |near| near.acceleration[axis]);
    }
    add("density".into(), "kg m-3", "density in the step", &|near| near.density);
    add("pressure".into(), "Pa", "pressure in the step", &|near| near.pressure);
    dataset
}

/// Draws the speed around the particle, which is marked by a square.
fn draw(header: &Header, clock: &Clock, diverged: &DivergedParticle, path: &Path) -> Result<(), OutputError> {
    let around = &diverged.neighbourhood;
    let mut frame = Frame::absent(around.particles.len());
    (frame.time, frame.step, frame.time_step) = (clock.time, clock.step, clock.time_step);
    for (slot, near) in around.particles.iter().enumerate() {
        frame.zone[slot] = near.zone as u8;
        for axis in 0..3 {
            frame.position[axis][slot] = near.position[axis];
            frame.velocity[axis][slot] = near.velocity[axis] as f32;
        }
        (frame.density[slot], frame.pressure[slot]) = (near.density as f32, near.pressure as f32);
    }
    let reach = DVec3::splat(around.reach);
    let mut header = header.clone();
    header.title = format!("Speed around particle {}", diverged.id);
    header.bounds = [(around.centre - reach).to_array(), (around.centre + reach).to_array()];
    let options = RenderOptions {
        field: Field::Speed,
        width: WIDTH,
        slice: Slice { axis: 2, at: Some(around.centre.z) },
        ..RenderOptions::default()
    };
    let slot = around.particles.iter().position(|near| near.id == diverged.id).unwrap_or_default();
    render_marked(&header, &frame, slot, &options, path)
}
