//! Rates by the formulas, neighbour by neighbour in plain scalars, and the pass compared with them.

use std::sync::Arc;

use super::super::RatesSummary;
use super::viscous;
use crate::math::kernel::Kernel;
use crate::math::symmetric::{component, components};
use crate::particles::zone::Zone;
use crate::pass::column_access::AfterPasses;
use crate::pass::neighbours::Neighbours;
use crate::pass::samples::{SPACING, Sample, WATER, assert_close, dummy_velocity, in_space, noise};
use crate::pass::settings::{PairSettings, WallPartSettings};
use crate::physics::shifting::{DriftCorrection, Local, Shifting, Vacondio};
use crate::physics::viscosity::{Artificial, Laminar, Sps, Viscosity};
use crate::physics::wall::{WallModel, WallPressure};

/// Rates of a row in SI units.
struct Reference<const D: usize> {
    acceleration: [f64; D],
    shift: [f64; D],
    divergence: f64,
    signal: f64,
    damping: f64,
}

/// The rates of a row by the formulas as they are printed, in SI units, neighbour by neighbour.
fn reference<const D: usize>(sample: &Sample<f64, D>, a: usize) -> Reference<D> {
    let pair = &sample.pair;
    let particles = &sample.particles;
    let h = pair.discretisation.smoothing_length;
    let (rho_a, p_a) = (particles.density[a], particles.pressure[a]);
    let (mut acceleration, mut fickian, mut repulsion) = ([0.0; D], [0.0; D], [0.0; D]);
    let (mut divergence, mut signal, mut damping) = (0.0, 0.0f64, 0.0);
    let (mut count, mut distances) = (0.0, 0.0);
    let (mut concentration_gradient, mut weights) = ([0.0; D], 0.0);
    let point = std::array::from_fn(|d| particles.position[d][a]);
    Neighbours::new(&sample.grid, particles).for_each(point, |b, x, r2| {
        if !pair.shifting.keeps_drift() && particles.zone[b] == Zone::Fluid {
            let weight = pair.discretisation.mass / particles.density[b] * pair.discretisation.w(r2.sqrt());
            weights += weight;
            for d in 0..D {
                concentration_gradient[d] +=
                    weight * sample.sums.concentration_gradient.read(AfterPasses)[d][b];
            }
        }
        if r2 < 1e-20 {
            return;
        }
        let r = r2.sqrt();
        let slope = pair.discretisation.kernel.slope(D, h, r);
        let eta2 = 0.01 * h * h;
        let rho_b = particles.density[b];
        let volume = pair.discretisation.mass / rho_b;
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
            Viscosity::Laminar(Laminar { as_published, .. }) => {
                let slope = if as_published { slope * r2 / (r2 + eta2) } else { slope };
                along_v =
                    4.0 * pair.pair_viscosity() * pair.discretisation.mass * factor * slope / (rho_a + rho_b);
            }
            Viscosity::Artificial(Artificial { alpha }) => {
                let mu = (h * xv / (r2 + eta2)).min(0.0);
                let speed = 0.5 * (WATER.sound_speed_at(rho_a) + WATER.sound_speed_at(rho_b));
                along_x += pair.discretisation.mass * alpha * speed * mu / (0.5 * (rho_a + rho_b)) * slope;
            }
            Viscosity::Sps(_) => {
                along_v =
                    4.0 * pair.pair_viscosity() * pair.discretisation.mass * factor * slope / (rho_a + rho_b);
            }
        }
        if pair.viscous_term.needs().stress {
            for i in 0..D {
                for j in 0..D {
                    let column = &sample.sums.stress.read(AfterPasses)[component::<D>(i, j)];
                    acceleration[i] += pair.discretisation.mass * (column[a] + column[b]) * slope * x[j];
                }
            }
        }
        if pair.noise_damping != 0.0 && !wall {
            let strain = |row: usize, i, j| sample.sums.strain.read(AfterPasses)[component::<D>(i, j)][row];
            let mut w = dot(x, v);
            for i in 0..D {
                for j in 0..D {
                    w -= 0.5 * x[i] * (strain(a, i, j) + strain(b, i, j)) * x[j];
                }
            }
            let speed = 0.5 * (WATER.sound_speed_at(rho_a) + WATER.sound_speed_at(rho_b));
            let pi = -pair.noise_damping * speed * h * w / (r2 + eta2) / (0.5 * (rho_a + rho_b));
            along_x -= pair.discretisation.mass * pi * slope;
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
        Shifting::Vacondio(_) => repulsion.map(|x| mean * mean * x / count),
        shifting if !shifting.keeps_drift() => std::array::from_fn(|d| {
            sample.sums.concentration_gradient.read(AfterPasses)[d][a] - concentration_gradient[d] / weights
        }),
        _ => fickian,
    };
    Reference { acceleration, shift, divergence, signal: WATER.sound_speed_at(rho_a) + signal, damping }
}

/// A disordered block of fluid on a wall, with a moving lid, checked row by row against the
/// reference.
fn check<const D: usize>(pair: PairSettings, counts: [usize; D]) {
    let mut sample = Sample::<f64, D>::lattice(pair, counts, false);
    sample.stir(0.3, 1.0);
    for row in 0..sample.particles.len() {
        let key = 8 * sample.particles.id[row];
        sample.particles.density[row] = 1000.0 + 30.0 * noise(key + 7);
        sample.particles.pressure[row] = WATER.pressure(sample.particles.density[row]);
        let height = (sample.particles.position[1][row] + 0.3) / SPACING;
        let distance = (height - 2.9).abs().max(0.1) * SPACING;
        let sees_wall = distance
            < sample.pair.discretisation.smoothing_length * sample.pair.discretisation.kernel.support_ratio();
        sample.particles.wall_distance[row] =
            if height < 2.9 || sees_wall { distance } else { f64::INFINITY };
        if height < 2.9 {
            sample.particles.zone[row] = Zone::Wall;
            sample.particles.patch[row] = u16::from(noise(key) > 0.0);
            sample.particles.wall_normal[0][row] = 0.6;
            sample.particles.wall_normal[1][row] = 0.8;
        }
    }
    if sample.pair.viscous_term.needs().stress {
        for (component, column) in sample.sums.stress.choose().iter_mut().enumerate().take(components(D)) {
            let ids = sample.particles.id.iter();
            *column = ids.map(|id| 0.1 * noise(id * 64 + 32 + component as u32)).collect();
        }
    }
    if sample.pair.noise_damping != 0.0 {
        for (component, column) in sample.sums.strain.choose().iter_mut().enumerate().take(components(D)) {
            let ids = sample.particles.id.iter();
            *column = ids.map(|id| 5.0 * noise(id * 64 + 48 + component as u32)).collect();
        }
    }
    if !sample.pair.shifting.keeps_drift() {
        for (d, column) in sample.sums.concentration_gradient.choose().iter_mut().enumerate() {
            *column = sample.particles.id.iter().map(|id| 7.0 * noise(id * 64 + 56 + d as u32)).collect();
        }
    }
    let summary = sample.rates();
    let mut largest = RatesSummary::default();
    let mut found = vec![Vec::new(); 2 * D + 2];
    let mut expected = found.clone();
    for row in (0..sample.particles.len()).filter(|&row| sample.particles.zone[row] == Zone::Fluid) {
        let Reference { acceleration, shift, divergence, signal, damping } = reference(&sample, row);
        for d in 0..D {
            found[d].push(sample.particles.acceleration[d][row]);
            expected[d].push(acceleration[d]);
            found[D + d].push(sample.sums.shift.read(AfterPasses)[d][row]);
            expected[D + d].push(shift[d]);
        }
        found[2 * D].push(sample.sums.divergence.read(AfterPasses)[row]);
        expected[2 * D].push(divergence);
        found[2 * D + 1].push(sample.sums.damping.read(AfterPasses)[row]);
        expected[2 * D + 1].push(damping);
        if sample.particles.wall_distance[row].is_finite() {
            largest.damping_at_walls = largest.damping_at_walls.max(damping);
        } else {
            largest.damping = largest.damping.max(damping);
        }
        largest.signal_speed = largest.signal_speed.max(signal);
        largest.divergence = largest.divergence.max(divergence.abs());
        let size = acceleration.iter().map(|x| x * x).sum::<f64>().sqrt();
        largest.acceleration = largest.acceleration.max(size);
    }
    assert_close(&found, &expected, 1e-12, &format!("{:?}", sample.pair));
    assert!((summary.signal_speed / largest.signal_speed - 1.0).abs() < 1e-12);
    assert!((summary.divergence / largest.divergence - 1.0).abs() < 1e-12);
    assert!((summary.acceleration / largest.acceleration - 1.0).abs() < 1e-12);
    assert!((summary.damping - largest.damping).abs() <= 1e-12 * largest.damping);
    assert!((summary.damping_at_walls - largest.damping_at_walls).abs() <= 1e-12 * largest.damping_at_walls);
}

#[test]
fn rates_are_the_published_sums() {
    for kernel in Kernel::ALL {
        check(viscous(kernel, 2, 1.3), [13, 9]);
        check(viscous(kernel, 3, 1.2), [7, 8, 5]);
        for (lattice_normalised, as_published) in [(true, true), (false, true), (false, false)] {
            let viscous_term = Viscosity::Laminar(Laminar { lattice_normalised, as_published });
            let wall_model =
                WallModel::Image { velocity_cap: Some(1.5), pressure: WallPressure::Extrapolated };
            check(PairSettings { viscous_term, wall_model, ..viscous(kernel, 2, 1.5) }, [12, 9]);
        }
        check(
            PairSettings {
                viscous_term: Viscosity::Artificial(Artificial { alpha: 0.1 }),
                shifting: Shifting::Vacondio(Vacondio { beta: 0.04 }),
                tensile_control: false,
                ..viscous(kernel, 3, 1.3)
            },
            [6, 9, 5],
        );
        let viscous_term = Viscosity::Sps(Sps::default());
        let turbulent = PairSettings { viscous_term, ..viscous(kernel, 2, 1.3) };
        check(turbulent.clone(), [12, 9]);
        check(in_space(&turbulent), [6, 9, 5]);
        check(PairSettings { noise_damping: 0.2, ..turbulent }, [12, 9]);
        check(PairSettings { noise_damping: 0.2, ..viscous(kernel, 2, 1.3) }, [12, 9]);
        check(PairSettings { noise_damping: 0.2, ..viscous(kernel, 3, 1.3) }, [6, 9, 5]);
        // Compiled for it with damping and walls, else one of the branches.
        let shifting = Shifting::Local(Local { coefficient: 32.0, drift_correction: DriftCorrection::On });
        for noise_damping in [0.0, 0.2] {
            let net = PairSettings { shifting, noise_damping, ..viscous(kernel, 2, 1.3) };
            check(net.clone(), [12, 9]);
            check(in_space(&net), [6, 9, 5]);
            check(PairSettings { viscous_term, ..net }, [12, 9]);
        }
        let free_slip = WallPartSettings { free_slip: true, ..Default::default() };
        check(
            PairSettings {
                wall_parts: [WallPartSettings::default(), free_slip].into(),
                wall_model: WallModel::Image { velocity_cap: None, pressure: WallPressure::Mirrored },
                body_force: [0.5, -9.81, 0.0],
                ..viscous(kernel, 2, 1.3)
            },
            [12, 9],
        );
        for wall_model in [WallModel::Dummy, WallModel::Ghost] {
            let body_force = [0.5, -9.81, 0.0];
            let plain = PairSettings { wall_model, body_force, ..viscous(kernel, 2, 1.3) };
            let slippery: Arc<[_]> = [WallPartSettings::default(), free_slip].into();
            check(plain.clone(), [13, 9]);
            check(PairSettings { wall_parts: slippery.clone(), ..plain.clone() }, [12, 9]);
            check(PairSettings { wall_parts: slippery, ..in_space(&plain) }, [7, 8, 5]);
            check(PairSettings { noise_damping: 0.2, ..plain.clone() }, [12, 9]);
            check(
                PairSettings { viscous_term: Viscosity::Artificial(Artificial { alpha: 0.1 }), ..plain },
                [12, 9],
            );
        }
    }
}
