//! Layout of `particles.nc` and of the frames of the journal.
//!
//! ```text
//! dimensions  time (unlimited), particle (slots of all but walls at rest), wall
//! x y (z)     f64 (time, particle), m            NaN: in the reservoir, or absent
//! u v (w)     f32 (time, particle), m s-1
//! density pressure tag   f32 (time, particle)
//! zone        u8  (time, particle), CF flags     255: slot without a particle
//! passage     u32 (time, particle)
//! particle_id u32 (particle)                     number of the particle in the run
//! moving_part u16 (particle)                     if walls move: their wall part
//! wall_x wall_y (wall_z) wall_id wall_part       (wall), walls at rest, stored once
//! step time_step (time)
//! ```
//!
//! A slot takes 41 bytes in 2D and 53 in 3D before compression. CF has standard names for air and
//! sea water only, so the fields have long names and units. The file declares no `featureType`: a
//! slot is no trajectory, since its particle may leave, wait in the reservoir and enter again as
//! another piece of fluid (`passage`). Trajectories are in [`tracks.nc`](super::trajectories).

use ::netcdf::{AttributeValue, FileMut};

use super::file::add_variable;
use super::slots::{NO_PART, Slots, pick};
use crate::frame::{ABSENT, Frame};
use crate::header::Header;
use sphecs_core::particles::zone::Zone;
use sphecs_scene::result_name::result_name;

/// Largest number of slots in a chunk: 2 MiB of doubles.
pub(super) const CHUNK: usize = 1 << 18;

/// Scalars of a particle in single precision: name, unit and meaning.
pub(super) const SCALARS: [(&str, &str, &str); 3] = [
    ("density", "kg m-3", "density"),
    ("pressure", "Pa", "pressure above that of the reference density"),
    ("tag", "1", "passive scalar carried along"),
];

/// Long name of `passage`.
pub(super) const PASSAGE_MEANING: &str = "number of times the particle was injected again from the reservoir";

pub(super) const AXES: [&str; 3] = ["x", "y", "z"];
pub(super) const VELOCITIES: [&str; 3] = ["u", "v", "w"];

/// Attributes of the coordinate `time` in all files.
pub(super) const TIME_ATTRIBUTES: [(&str, &str); 3] =
    [("units", "s"), ("standard_name", "time"), ("axis", "T")];

/// Adds the attributes that every file of a run has.
pub(super) fn put_header(file: &mut FileMut, header: &Header, title: &str) -> Result<(), ::netcdf::Error> {
    let texts = [
        ("Conventions", "CF-1.11".to_owned()),
        ("title", format!("{}: {title}", header.title)),
        ("source", format!("sphecs {}, smoothed particle hydrodynamics", header.version)),
        ("history", format!("written by sphecs {} from the scene {}", header.version, header.scene)),
        ("sphecs_version", header.version.clone()),
        ("scene_name", header.scene.clone()),
        ("scene_sha256", header.sha256.clone()),
        ("kernel", header.kernel.clone()),
        ("precision", header.precision.clone()),
        // HDF5 limits an attribute to 64 KiB; `scene.ron` has the whole text.
        ("scene", header.text.chars().take(16_000).collect()),
    ];
    for (name, text) in texts {
        file.add_attribute(name, text)?;
    }
    let numbers = [
        ("smoothing_length", header.smoothing_length),
        ("spacing", header.spacing),
        ("sound_speed", header.sound_speed),
        ("reference_density", header.reference_density),
        ("kinematic_viscosity", header.viscosity),
    ];
    for (name, number) in numbers {
        file.add_attribute(name, number)?;
    }
    file.add_attribute("dimensions", header.dimensions as i32)?;
    file.add_attribute(
        "comment",
        "SI units; attributes: lengths in m, speed in m s-1, density in kg m-3, viscosity in m2 s-1",
    )?;
    Ok(())
}

fn text(name: &'static str, value: impl Into<String>) -> (&'static str, AttributeValue) {
    (name, AttributeValue::from(value.into()))
}

/// Returns the attributes of `zone`.
pub(super) fn zone_attributes() -> Vec<(&'static str, AttributeValue)> {
    let meanings = Zone::ALL.iter().map(|zone| zone.name()).chain(["absent"]);
    let values: Vec<u8> = Zone::ALL.iter().map(|&zone| zone as u8).chain([ABSENT]).collect();
    vec![
        text("units", "1"),
        text("long_name", "zone that the particle belongs to"),
        ("flag_values", AttributeValue::from(values)),
        text("flag_meanings", meanings.collect::<Vec<_>>().join(" ")),
    ]
}

/// Defines the variables of the slots and writes the particle numbers.
pub(super) fn define(file: &mut FileMut, header: &Header, slots: &Slots) -> Result<(), ::netcdf::Error> {
    put_header(file, header, "particles")?;
    file.add_unlimited_dimension("time")?;
    // Length 0 would make the dimension unlimited.
    file.add_dimension("particle", slots.particles.len().max(1))?;
    let units =
        |units: &'static str, long_name: String| vec![text("units", units), text("long_name", long_name)];
    let mut attributes = TIME_ATTRIBUTES.map(|(name, value)| text(name, value)).to_vec();
    attributes.push(text("long_name", "time since the start of the run"));
    add_variable::<f64>(file, "time", &["time"], &[512], &attributes)?;
    add_variable::<i64>(file, "step", &["time"], &[512], &units("1", "steps done".into()))?;
    add_variable::<f64>(file, "time_step", &["time"], &[512], &units("s", "size of the last step".into()))?;

    let particle_chunk = slots.particles.len().clamp(1, CHUNK);
    let shape = ["time", "particle"];
    let chunks = [1, particle_chunk];
    for axis in 0..header.dimensions {
        let attributes = units("m", format!("{} coordinate", AXES[axis]));
        add_variable::<f64>(file, AXES[axis], &shape, &chunks, &attributes)?;
    }
    let coordinates = || text("coordinates", header.axes().join(" "));
    for axis in 0..header.dimensions {
        let mut attributes = units("m s-1", format!("velocity along {}", AXES[axis]));
        attributes.push(coordinates());
        add_variable::<f32>(file, VELOCITIES[axis], &shape, &chunks, &attributes)?;
    }
    for (name, unit, long_name) in SCALARS {
        let mut attributes = units(unit, long_name.into());
        attributes.push(coordinates());
        add_variable::<f32>(file, name, &shape, &chunks, &attributes)?;
    }
    let mut attributes = zone_attributes();
    attributes.push(coordinates());
    add_variable::<u8>(file, "zone", &shape, &chunks, &attributes)?;
    let mut attributes = units("1", PASSAGE_MEANING.into());
    attributes.push(coordinates());
    add_variable::<u32>(file, "passage", &shape, &chunks, &attributes)?;
    let mut attributes = units("1", "number of the particle in the run".into());
    attributes.push(text(
        "comment",
        "one slot per particle; each passage through the flow is another piece of fluid",
    ));
    let mut ids = add_variable::<u32>(file, "particle_id", &["particle"], &[particle_chunk], &attributes)?;
    if !slots.particles.is_empty() {
        ids.put_values(&slots.particles, ..)?;
    }
    if slots.moving_parts.is_empty() {
        return Ok(());
    }
    let mut attributes =
        vec![text("units", "1"), text("long_name", "wall part of a particle of a wall that moves")];
    let names = header.wall_parts.iter().map(|name| result_name(name)).chain(["none".to_owned()]);
    let values: Vec<u16> = (0..header.wall_parts.len() as u16).chain([NO_PART]).collect();
    attributes.extend([
        ("flag_values", AttributeValue::from(values)),
        text("flag_meanings", names.collect::<Vec<_>>().join(" ")),
    ]);
    add_variable::<u16>(file, "moving_part", &["particle"], &[particle_chunk], &attributes)?
        .put_values(&slots.moving_parts, ..)
}

/// Defines and writes the variables of the walls.
pub(super) fn put_walls(
    file: &mut FileMut,
    header: &Header,
    slots: &Slots,
    frame: &Frame,
) -> Result<(), ::netcdf::Error> {
    if slots.walls.is_empty() {
        return Ok(());
    }
    file.add_dimension("wall", slots.walls.len())?;
    let chunks = [slots.walls.len().min(CHUNK)];
    for axis in 0..header.dimensions {
        let attributes = [
            text("units", "m"),
            text("long_name", format!("{} coordinate of the wall particle", AXES[axis])),
        ];
        let values: Vec<f64> = pick(&frame.position[axis], &slots.walls);
        let name = format!("wall_{}", AXES[axis]);
        add_variable::<f64>(file, &name, &["wall"], &chunks, &attributes)?.put_values(&values, ..)?;
    }
    let attributes = [text("units", "1"), text("long_name", "number of the wall particle in the run")];
    add_variable::<u32>(file, "wall_id", &["wall"], &chunks, &attributes)?.put_values(&slots.walls, ..)?;
    let names: Vec<String> = header.wall_parts.iter().map(|name| result_name(name)).collect();
    let mut attributes = vec![text("units", "1"), text("long_name", "wall part of the scene")];
    if !names.is_empty() {
        let values: Vec<u16> = (0..names.len() as u16).collect();
        attributes
            .extend([("flag_values", AttributeValue::from(values)), text("flag_meanings", names.join(" "))]);
    }
    let values: Vec<u16> = pick(&frame.patch, &slots.walls);
    add_variable::<u16>(file, "wall_part", &["wall"], &chunks, &attributes)?.put_values(&values, ..)
}
