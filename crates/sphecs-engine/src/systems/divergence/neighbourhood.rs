//! Particles around a particle that diverged.

use glam::DVec3;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::rows::real_vector;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::pair_real::PairReal;

/// Reach of a neighbourhood, in supports of the kernel: it contains the neighbours and their
/// neighbours.
const REACH_IN_SUPPORTS: f64 = 2.5;

/// Rows before and after a particle, in the order of the cells, whose mean position replaces its
/// own if that is not finite.
const ROWS_AROUND: usize = 8;

/// Particle near a diverged particle: position and velocity after the failed step, density,
/// pressure and acceleration at its beginning.
#[derive(Clone, Debug, PartialEq)]
pub struct NearbyParticle {
    /// Number of the particle.
    pub id: u32,
    /// Zone.
    pub zone: Zone,
    /// Index of its inlet, outlet or wall part; 0 for other particles.
    pub patch: u16,
    /// Position, m.
    pub position: DVec3,
    /// Velocity, m/s.
    pub velocity: DVec3,
    /// Velocity one step earlier, m/s.
    pub previous_velocity: DVec3,
    /// Acceleration, m/s².
    pub acceleration: DVec3,
    /// Density, kg/m³.
    pub density: f64,
    /// Pressure, Pa.
    pub pressure: f64,
}

/// Particles in a box around a particle, in the order of their numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Neighbourhood {
    /// Centre of the box, m: the position of the particle, or of the rows next to it if that is not
    /// finite.
    pub centre: DVec3,
    /// Half the edge length of the box, m.
    pub reach: f64,
    /// Radius of the kernel's support, m.
    pub support: f64,
    /// Particles in the box, the one at its centre included.
    pub particles: Vec<NearbyParticle>,
}

impl Neighbourhood {
    /// Collects the particles around a row.
    pub(super) fn around<R: PairReal<D>, const D: usize>(
        arrays: &ParticleArrays<R, D>,
        row: usize,
        support: f64,
    ) -> Self {
        let reach = REACH_IN_SUPPORTS * support;
        let centre = centre(arrays, row);
        let within = |other: &usize| {
            let offset = (arrays.position_of(*other) - centre).abs();
            *other == row || arrays.zone[*other] != Zone::Reservoir && offset.max_element() <= reach
        };
        let mut particles: Vec<NearbyParticle> =
            (0..arrays.len()).into_par_iter().filter(within).map(|other| nearby(arrays, other)).collect();
        particles.sort_by_key(|particle| particle.id);
        Self { centre, reach, support, particles }
    }

    /// Returns the particle with a number.
    pub fn particle(&self, id: u32) -> Option<&NearbyParticle> {
        self.particles.iter().find(|particle| particle.id == id)
    }

    /// Returns the number of particles in the support of a particle, and the nearest of them with
    /// its distance, m.
    pub fn neighbours(&self, id: u32) -> (usize, Option<(&NearbyParticle, f64)>) {
        let Some(own) = self.particle(id) else { return (0, None) };
        let others = self.particles.iter().filter(|other| other.id != id);
        let far = others.map(|other| (other, other.position.distance(own.position)));
        let near: Vec<(&NearbyParticle, f64)> =
            far.filter(|(_, distance)| *distance < self.support).collect();
        (near.len(), near.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)))
    }
}

fn nearby<R: PairReal<D>, const D: usize>(arrays: &ParticleArrays<R, D>, row: usize) -> NearbyParticle {
    NearbyParticle {
        id: arrays.id[row],
        zone: arrays.zone[row],
        patch: arrays.patch[row],
        position: arrays.position_of(row),
        velocity: arrays.velocity_of(row),
        previous_velocity: real_vector(&arrays.previous_velocity, row),
        acceleration: arrays.acceleration_of(row),
        density: arrays.density[row].to_f64(),
        pressure: arrays.pressure[row].to_f64(),
    }
}

/// Returns the position of a row, or the mean position of the rows next to it if that is not
/// finite.
fn centre<R: PairReal<D>, const D: usize>(arrays: &ParticleArrays<R, D>, row: usize) -> DVec3 {
    let own = arrays.position_of(row);
    if own.is_finite() {
        return own;
    }
    let around = row.saturating_sub(ROWS_AROUND)..(row + ROWS_AROUND + 1).min(arrays.len());
    let positions: Vec<DVec3> =
        around.map(|other| arrays.position_of(other)).filter(|position| position.is_finite()).collect();
    positions.iter().sum::<DVec3>() / positions.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use sphecs_core::particles::rows::ParticleRow;

    fn arrays() -> ParticleArrays<f64, 2> {
        let mut arrays = ParticleArrays::default();
        for id in 0..20_u32 {
            let x = f64::from(19 - id);
            arrays.push(&ParticleRow {
                id,
                position: DVec3::new(x, 0.0, 0.0),
                density: 1000.0,
                ..ParticleRow::default()
            });
        }
        arrays
    }

    #[test]
    fn neighbourhood_is_a_box_in_the_order_of_numbers() {
        let found = Neighbourhood::around(&arrays(), 9, 1.2);
        let ids: Vec<u32> = found.particles.iter().map(|particle| particle.id).collect();
        assert_eq!(ids, [6, 7, 8, 9, 10, 11, 12]);
        let (count, nearest) = found.neighbours(9);
        assert_eq!((count, nearest.map(|(_, distance)| distance)), (2, Some(1.0)));
    }

    #[test]
    fn particle_without_finite_position_is_located_by_its_neighbouring_rows() {
        let mut arrays = arrays();
        arrays.position[0][9] = f64::NAN;
        let found = Neighbourhood::around(&arrays, 9, 1.2);
        assert_eq!(found.centre, DVec3::new(10.0, 0.0, 0.0));
        assert!(found.particle(9).is_some_and(|own| own.position.x.is_nan()));
        assert_eq!(found.neighbours(9), (0, None));
    }
}
