//! The rates neighbour by neighbour, in plain scalars.

use crate::particles::zone::Zone;
use crate::pass::neighbours::Neighbours;
use crate::pass::samples::{Sample, WATER, dummy_velocity};
use crate::physics::shifting::Shifting;
use crate::physics::sps;
use crate::physics::viscosity::Viscosity;
use crate::physics::wall::{WallModel, WallPressure};

/// Rates of a row in SI units.
pub struct Reference<const D: usize> {
    pub acceleration: [f64; D],
    pub shift: [f64; D],
    pub divergence: f64,
    pub signal: f64,
    pub damping: f64,
}

/// The rates of a row by the formulas as they are printed, in SI units, neighbour by neighbour.
pub fn reference<const D: usize>(sample: &Sample<f64, D>, a: usize) -> Reference<D> {
    let pair = &sample.pair;
    let particles = &sample.particles;
    let h = pair.smoothing_length;
    let (rho_a, p_a) = (particles.density[a], particles.pressure[a]);
    let (mut acceleration, mut fickian, mut repulsion) = ([0.0; D], [0.0; D], [0.0; D]);
    let (mut divergence, mut signal, mut damping) = (0.0, 0.0f64, 0.0);
    let (mut count, mut distances) = (0.0, 0.0);
    let point = std::array::from_fn(|d| particles.position[d][a]);
    Neighbours::new(&sample.grid, particles).for_each(point, |b, x, r2| {
        if r2 < 1e-20 {
            return;
        }
        let r = r2.sqrt();
        let slope = pair.kernel.slope(D, h, r);
        let eta2 = 0.01 * h * h;
        let rho_b = particles.density[b];
        let volume = pair.mass / rho_b;
        let wall = particles.zone[b] == Zone::Wall;
        let free_slip = wall && pair.wall_part(particles.patch[b]).free_slip;
        let mut factor = 1.0;
        if wall {
            factor = match pair.wall_model {
                WallModel::Image { velocity_cap, .. } => {
                    let factor = 1.0 + particles.wall_distance[b] / particles.wall_distance[a];
                    factor.min(velocity_cap.unwrap_or(f64::INFINITY))
                }
                WallModel::Dummy => 1.0,
                WallModel::Ghost => 2.0,
            };
        }
        let mut v_b: [f64; D] = std::array::from_fn(|d| particles.velocity[d][b]);
        if pair.wall_model == WallModel::Dummy {
            v_b = dummy_velocity(sample, b);
        }
        let v: [f64; D] = std::array::from_fn(|d| particles.velocity[d][a] - v_b[d]);
        let dot = |a: [f64; D], b: [f64; D]| (0..D).map(|d| a[d] * b[d]).sum::<f64>();
        let mut xv = factor * dot(x, v);
        if free_slip {
            let normal = std::array::from_fn(|d| particles.wall_normal[d][b]);
            xv = factor * dot(x, normal) * dot(v, normal);
        }
        let mut p_b = particles.pressure[b];
        if wall && pair.wall_model.pressure() == WallPressure::Mirrored {
            p_b = p_a - rho_a * (0..D).map(|d| pair.body_force[d] * x[d]).sum::<f64>();
        }
        let tension = pair.tensile_control && p_a < 0.0 && rho_a >= 0.95 * WATER.reference_density;
        let pressure = if tension { p_b - p_a } else { p_a + p_b };
        signal = signal.max((h * dot(x, v) / (r2 + eta2)).abs());
        divergence -= volume * xv * slope;
        let mut along_x = -volume * pressure * slope / rho_a;
        let mut along_v = 0.0;
        match pair.viscous_term {
            _ if free_slip => {}
            Viscosity::Laminar { printed, .. } => {
                let slope = if printed { slope * r2 / (r2 + eta2) } else { slope };
                along_v = 4.0 * pair.pair_viscosity() * pair.mass * factor * slope / (rho_a + rho_b);
            }
            Viscosity::Artificial { alpha } => {
                let mu = (h * xv / (r2 + eta2)).min(0.0);
                let speed = 0.5 * (WATER.sound_speed_at(rho_a) + WATER.sound_speed_at(rho_b));
                along_x += pair.mass * alpha * speed * mu / (0.5 * (rho_a + rho_b)) * slope;
            }
            Viscosity::Sps { .. } => {
                along_v = 4.0 * pair.pair_viscosity() * pair.mass * factor * slope / (rho_a + rho_b);
            }
        }
        if matches!(pair.viscous_term, Viscosity::Sps { .. }) {
            for i in 0..D {
                for j in 0..D {
                    let column = &sample.sums.stress[sps::component::<D>(i, j)];
                    acceleration[i] += pair.mass * (column[a] + column[b]) * slope * x[j];
                }
            }
        }
        if pair.noise_damping != 0.0 && !wall {
            let strain = |row: usize, i, j| sample.sums.strain[sps::component::<D>(i, j)][row];
            let mut w = dot(x, v);
            for i in 0..D {
                for j in 0..D {
                    w -= 0.5 * x[i] * (strain(a, i, j) + strain(b, i, j)) * x[j];
                }
            }
            let speed = 0.5 * (WATER.sound_speed_at(rho_a) + WATER.sound_speed_at(rho_b));
            let pi = -pair.noise_damping * speed * h * w / (r2 + eta2) / (0.5 * (rho_a + rho_b));
            along_x -= pair.mass * pi * slope;
        }
        damping -= along_v;
        for d in 0..D {
            acceleration[d] += along_x * x[d] + along_v * v[d];
            fickian[d] += volume * slope * x[d];
            repulsion[d] += x[d] / r.powi(3);
        }
        count += 1.0;
        distances += r;
    });
    let mean = distances / count;
    let shift = match pair.shifting {
        Shifting::Vacondio { .. } => repulsion.map(|x| mean * mean * x / count),
        _ => fickian,
    };
    Reference { acceleration, shift, divergence, signal: WATER.sound_speed_at(rho_a) + signal, damping }
}
