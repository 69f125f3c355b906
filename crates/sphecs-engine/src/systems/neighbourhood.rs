//! What stood around a particle when the flow blew up.

use glam::DVec3;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use sphecs_core::math::real::Real;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::rows::real_vector;
use sphecs_core::particles::zone::Zone;

/// How far a neighbourhood reaches, in supports of the kernel: the particle's neighbours and theirs.
const REACH_IN_SUPPORTS: f64 = 2.5;

/// Rows before and behind in the cells' order among which a place is looked for when the particle's own is not finite.
const ROWS_AROUND: usize = 8;

/// A particle as the step that failed left it: position and velocity are new, density, pressure and acceleration those that moved it.
#[derive(Clone, Debug, PartialEq)]
pub struct Nearby {
    /// Number of the particle.
    pub id: u32,
    /// Its zone.
    pub zone: Zone,
    /// Index of its inlet, outlet or wall part; 0 for the others.
    pub patch: u16,
    /// Position, m.
    pub position: DVec3,
    /// Velocity, m/s.
    pub velocity: DVec3,
    /// Velocity one step earlier, m/s.
    pub velocity_before: DVec3,
    /// Acceleration, m/s².
    pub acceleration: DVec3,
    /// Density, kg/m³.
    pub density: f64,
    /// Pressure, Pa.
    pub pressure: f64,
}

/// Particles around one, in the order of their numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Neighbourhood {
    /// Its middle: the particle's position, or that of those beside it in the grid if its own is not finite, m.
    pub middle: DVec3,
    /// Half of the box's edge, m.
    pub reach: f64,
    /// Radius of the kernel's support, m.
    pub support: f64,
    /// The particles in the box, the one in the middle among them.
    pub particles: Vec<Nearby>,
}

impl Neighbourhood {
    /// The particles around a row.
    pub fn around<R: Real, const D: usize>(arrays: &ParticleArrays<R, D>, row: usize, support: f64) -> Self {
        let reach = REACH_IN_SUPPORTS * support;
        let middle = place(arrays, row);
        let within = |other: &usize| {
            let offset = (arrays.position_of(*other) - middle).abs();
            *other == row || arrays.zone[*other] != Zone::Reservoir && offset.max_element() <= reach
        };
        let mut particles: Vec<Nearby> =
            (0..arrays.len()).into_par_iter().filter(within).map(|other| nearby(arrays, other)).collect();
        particles.sort_by_key(|particle| particle.id);
        Self { middle, reach, support, particles }
    }

    /// The particle with a number.
    pub fn particle(&self, id: u32) -> Option<&Nearby> {
        self.particles.iter().find(|particle| particle.id == id)
    }

    /// Particles in the support of one, and the nearest of them with its distance, m.
    pub fn neighbours(&self, id: u32) -> (usize, Option<(&Nearby, f64)>) {
        let Some(own) = self.particle(id) else { return (0, None) };
        let others = self.particles.iter().filter(|other| other.id != id);
        let far = others.map(|other| (other, other.position.distance(own.position)));
        let near: Vec<(&Nearby, f64)> = far.filter(|(_, distance)| *distance < self.support).collect();
        (near.len(), near.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)))
    }
}

fn nearby<R: Real, const D: usize>(arrays: &ParticleArrays<R, D>, row: usize) -> Nearby {
    Nearby {
        id: arrays.id[row],
        zone: arrays.zone[row],
        patch: arrays.patch[row],
        position: arrays.position_of(row),
        velocity: arrays.velocity_of(row),
        velocity_before: real_vector(&arrays.velocity_before, row),
        acceleration: arrays.acceleration_of(row),
        density: arrays.density[row].to_f64(),
        pressure: arrays.pressure[row].to_f64(),
    }
}

/// The position of a row, or where the rows beside it in the cells' order are.
fn place<R: Real, const D: usize>(arrays: &ParticleArrays<R, D>, row: usize) -> DVec3 {
    let own = arrays.position_of(row);
    if own.is_finite() {
        return own;
    }
    let around = row.saturating_sub(ROWS_AROUND)..(row + ROWS_AROUND + 1).min(arrays.len());
    let places: Vec<DVec3> =
        around.map(|other| arrays.position_of(other)).filter(|place| place.is_finite()).collect();
    places.iter().sum::<DVec3>() / places.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use sphecs_core::particles::rows::Row;

    fn arrays() -> ParticleArrays<f64, 2> {
        let mut arrays = ParticleArrays::default();
        for id in 0..20_u32 {
            let x = f64::from(19 - id);
            arrays.push(&Row { id, position: DVec3::new(x, 0.0, 0.0), density: 1000.0, ..Row::default() });
        }
        arrays
    }

    #[test]
    fn a_box_around_the_particle_in_the_order_of_numbers() {
        let found = Neighbourhood::around(&arrays(), 9, 1.2);
        let ids: Vec<u32> = found.particles.iter().map(|particle| particle.id).collect();
        assert_eq!(ids, [6, 7, 8, 9, 10, 11, 12]);
        let (count, nearest) = found.neighbours(9);
        assert_eq!((count, nearest.map(|(_, distance)| distance)), (2, Some(1.0)));
    }

    #[test]
    fn a_particle_that_is_nowhere_has_the_place_of_those_beside_it() {
        let mut arrays = arrays();
        arrays.position[0][9] = f64::NAN;
        let found = Neighbourhood::around(&arrays, 9, 1.2);
        assert_eq!(found.middle, DVec3::new(10.0, 0.0, 0.0));
        assert!(found.particle(9).is_some_and(|own| own.position.x.is_nan()));
        assert_eq!(found.neighbours(9), (0, None));
    }
}
