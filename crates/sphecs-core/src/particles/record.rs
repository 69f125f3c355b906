//! One particle as bytes, for messages between the ranks of a run.
//!
//! Vectors have three components and all numbers double precision, which holds those of the arrays
//! exactly. Few particles are sent in a step.

use glam::DVec3;

use super::rows::ParticleRow;
use super::zone::Zone;

/// Bytes of a particle in a message.
pub const BYTES: usize = size_of::<Record>();

/// Values of a particle without gaps between them.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Record {
    /// Position, velocities now and before, drift, wall normal, acceleration.
    vectors: [[f64; 3]; 6],
    /// Density, pressures now and before, wall distance and thickness.
    scalars: [f64; 5],
    id: u32,
    patch: u16,
    zone: u8,
    needs_restart: u8,
}

/// Appends a particle and its acceleration, m/s², to a message.
pub fn write(particle: &ParticleRow, acceleration: DVec3, message: &mut Vec<u8>) {
    let ParticleRow {
        id,
        zone,
        patch,
        needs_restart,
        position,
        velocity,
        previous_velocity,
        density,
        pressure,
        previous_pressure,
        drift,
        wall_distance,
        wall_normal,
        wall_thickness,
    } = *particle;
    let vectors = [position, velocity, previous_velocity, drift, wall_normal, acceleration];
    let record = Record {
        vectors: vectors.map(|vector| vector.to_array()),
        scalars: [density, pressure, previous_pressure, wall_distance, wall_thickness],
        id,
        patch,
        zone: zone as u8,
        needs_restart: u8::from(needs_restart),
    };
    message.extend_from_slice(bytemuck::bytes_of(&record));
}

/// Returns the particle and the acceleration, m/s², at the beginning of a message.
///
/// # Panics
/// If the message is too short or not from [`write()`].
pub fn read(message: &[u8]) -> (ParticleRow, DVec3) {
    let Record { vectors, scalars, id, patch, zone, needs_restart } =
        bytemuck::pod_read_unaligned(&message[..BYTES]);
    let [position, velocity, previous_velocity, drift, wall_normal, acceleration] =
        vectors.map(DVec3::from_array);
    let [density, pressure, previous_pressure, wall_distance, wall_thickness] = scalars;
    let particle = ParticleRow {
        id,
        zone: Zone::from_number(zone).expect("a zone from another rank"),
        patch,
        needs_restart: needs_restart != 0,
        position,
        velocity,
        previous_velocity,
        density,
        pressure,
        previous_pressure,
        drift,
        wall_distance,
        wall_normal,
        wall_thickness,
    };
    (particle, acceleration)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn particle_is_read_as_it_was_written() {
        let particle = ParticleRow {
            id: 77,
            zone: Zone::Outflow,
            patch: 3,
            needs_restart: true,
            position: DVec3::new(0.1, 0.2, 0.3),
            velocity: DVec3::new(-0.0, 1e-300, 5.0),
            previous_velocity: DVec3::new(1.0, 2.0, 3.0),
            density: 1000.0,
            pressure: -3.0,
            previous_pressure: f64::NEG_INFINITY,
            drift: DVec3::new(7.0, 8.0, 9.0),
            wall_distance: f64::INFINITY,
            wall_normal: DVec3::Y,
            wall_thickness: 0.25,
        };
        let mut message = Vec::new();
        write(&ParticleRow::default(), DVec3::ZERO, &mut message);
        write(&particle, DVec3::X, &mut message);
        assert_eq!(message.len(), 2 * BYTES);
        assert_eq!(read(&message), (ParticleRow::default(), DVec3::ZERO));
        assert_eq!(read(&message[BYTES..]), (particle, DVec3::X));
    }
}
