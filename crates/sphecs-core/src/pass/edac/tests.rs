//! Rates of an evolved pressure compared with their formulas, conservation and rest.

use glam::DVec3;

use super::*;
use crate::math::kernel::Kernel;
use crate::math::lanes::InstructionSet;
use crate::math::lattice::ETA_SQUARED;
use crate::particles::zone::Zone;
use crate::pass::column_access::AfterPasses;
use crate::pass::density::sum_density;
use crate::pass::neighbours::Neighbours;
use crate::pass::samples::{SPACING, Sample, WATER, assert_close, dummy_velocity, in_space, noise, settings};
use crate::pass::settings::{PressureLaw, WallPartSettings};
use crate::physics::wall::{WallModel, WallPressure};

const NU: f64 = 1e-3;

fn evolved(kernel: Kernel, dimensions: usize, ratio: f64, edac: Edac) -> PairSettings {
    PairSettings {
        viscosity: NU,
        pressure: PressureLaw::Evolved(edac),
        ..settings(kernel, dimensions, ratio)
    }
}

fn edac_of(pair: &PairSettings) -> Edac {
    match pair.pressure {
        PressureLaw::Evolved(edac) => edac,
        PressureLaw::Tait => panic!("the pressure must evolve"),
    }
}

/// A box of fluid whose particles have a drift and a pressure by their number.
fn sample<R: Real, const D: usize>(pair: PairSettings, counts: [usize; D], periodic: bool) -> Sample<R, D> {
    let mut sample = Sample::<R, D>::lattice(pair, counts, periodic);
    sample.particles.evolves_pressure = true;
    sample.particles.drifts = true;
    let rows = sample.particles.len();
    sample.particles.previous_pressure.resize(rows, R::default());
    for column in &mut sample.particles.drift {
        column.resize(rows, R::default());
    }
    sample
}

fn stir<R: Real, const D: usize>(sample: &mut Sample<R, D>) {
    sample.stir(0.3, 1.0);
    for row in 0..sample.particles.len() {
        let key = 8 * sample.particles.id[row];
        sample.particles.pressure[row] = R::from_f64(500.0 * noise(key + 7));
        for d in 0..D {
            sample.particles.drift[d][row] = R::from_f64(0.1 * noise(100_000 + key + d as u32));
        }
    }
}

fn density<R: Real, const D: usize>(sample: &mut Sample<R, D>) {
    sum_density(&sample.pair, &sample.grid, &mut sample.particles, &mut sample.sums);
}

fn rates<R: Real, const D: usize>(sample: &mut Sample<R, D>) -> EdacSummary {
    let edac = edac_of(&sample.pair);
    sample.velocity_seen();
    sum_rates(&sample.pair, &edac, &sample.grid, &mut sample.particles, &mut sample.sums)
}

/// Rates of a row in SI units.
struct Reference<const D: usize> {
    acceleration: [f64; D],
    background: [f64; D],
    pressure_rate: f64,
    divergence: f64,
    damping: f64,
}

/// Rates of a row, term by term as published.
fn reference<const D: usize>(sample: &Sample<f64, D>, a: usize) -> Reference<D> {
    let (pair, particles) = (&sample.pair, &sample.particles);
    let edac = edac_of(pair);
    let (h, m, c) = (pair.discretisation.smoothing_length, pair.discretisation.mass, WATER.sound_speed);
    let nu_edac = edac.pressure_viscosity(h, c) / pair.edac_coefficient(&edac);
    let point: [f64; D] = std::array::from_fn(|d| particles.position[d][a]);
    let neighbours = Neighbours::new(&sample.grid, particles);
    let (mut mean, mut count) = (0.0, 0.0);
    let pressure_of = |b: usize, x: [f64; D]| {
        if particles.zone[b] == Zone::Wall && pair.wall_model.pressure() == WallPressure::Mirrored {
            let lift: f64 = (0..D).map(|d| pair.body_force[d] * x[d]).sum();
            particles.pressure[a] - particles.density[a] * lift
        } else {
            particles.pressure[b]
        }
    };
    neighbours.for_each(point, |b, x, _| {
        mean += pressure_of(b, x);
        count += 1.0;
    });
    let mean = if edac.average_pressure { mean / count } else { 0.0 };
    let (mut acceleration, mut background) = ([0.0; D], [0.0; D]);
    let (mut pressure_rate, mut divergence, mut damping) = (0.0, 0.0, 0.0);
    neighbours.for_each(point, |b, x, r2| {
        if a == b {
            return;
        }
        let slope = pair.discretisation.f(r2.sqrt());
        let (rho_a, rho_b) = (particles.density[a], particles.density[b]);
        let (p_a, p_b) = (particles.pressure[a], pressure_of(b, x));
        let [v_a, v_b]: [[f64; D]; 2] = [a, b].map(|row| std::array::from_fn(|d| particles.velocity[d][row]));
        let along = |row: usize| (0..D).map(|d| particles.drift[d][row] * x[d]).sum::<f64>();
        let squares = (m / rho_a).powi(2) + (m / rho_b).powi(2);
        let p_ab = (rho_b * (p_a - mean) + rho_a * (p_b - mean)) / (rho_a + rho_b);
        let harmonic = |nu: f64| 2.0 * nu * rho_a * rho_b / (rho_a + rho_b);
        let softened = if edac.as_published { r2 / (r2 + ETA_SQUARED * h * h) } else { 1.0 };
        let wall = particles.zone[b] == Zone::Wall;
        let slips = wall && pair.wall_part(particles.patch[b]).free_slip;
        let mut factor = 1.0;
        if wall {
            let image = particles.wall_distance[b] / particles.wall_distance[a].max(0.1 * SPACING);
            factor = match pair.wall_model {
                WallModel::Image { velocity_cap, .. } => {
                    (1.0 + image).min(velocity_cap.unwrap_or(f64::INFINITY))
                }
                WallModel::Dummy => 1.0,
                WallModel::Ghost => 2.0,
            };
        }
        let per_viscosity = if slips { 0.0 } else { harmonic(1.0) * softened * factor };
        let drag = pair.pair_viscosity() * per_viscosity;
        let of_divergence = if wall && pair.wall_model == WallModel::Ghost { 2.0 } else { 1.0 };
        let seen = if pair.wall_model == WallModel::Dummy { dummy_velocity(sample, b) } else { v_b };
        let mut xv: f64 = (0..D).map(|d| x[d] * of_divergence * (v_a[d] - v_b[d])).sum();
        if slips {
            let normal =
                |values: [f64; D]| -> f64 { (0..D).map(|d| particles.wall_normal[d][b] * values[d]).sum() };
            xv = of_divergence * normal(x) * normal(std::array::from_fn(|d| v_a[d] - v_b[d]));
        }
        for d in 0..D {
            let stress = 0.5 * (rho_a * v_a[d] * along(a) + rho_b * v_b[d] * along(b));
            let force = -p_ab * x[d] + stress + drag * (v_a[d] - seen[d]);
            acceleration[d] += squares / m * force * slope;
            background[d] -= edac.background * WATER.reference_density * c * c / m * squares * x[d] * slope;
        }
        pressure_rate += m * rho_a / rho_b * c * c * xv * slope;
        pressure_rate += squares / m * harmonic(nu_edac) * softened * (p_a - p_b) * slope;
        divergence -= m / rho_b * xv * slope;
        damping -= squares / m * pair.pair_viscosity().max(nu_edac) * per_viscosity * slope;
    });
    damping += edac.relaxation * c / h;
    let excess = particles.density[a] - WATER.reference_density;
    pressure_rate += edac.relaxation * c / h * (c * c * excess - particles.pressure[a]);
    Reference { acceleration, background, pressure_rate, divergence, damping }
}

/// A disordered block of fluid on a wall, checked row by row against the reference.
fn check<const D: usize>(pair: PairSettings, counts: [usize; D]) {
    let mut sample = sample::<f64, D>(pair, counts, false);
    stir(&mut sample);
    for row in 0..sample.particles.len() {
        let key = 8 * sample.particles.id[row];
        sample.particles.density[row] = 1000.0 + 30.0 * noise(key + 6);
        let height = (sample.particles.position[1][row] + 0.3) / SPACING;
        sample.particles.wall_distance[row] = (height - 2.9).abs().max(0.1) * SPACING;
        if height < 2.9 {
            sample.particles.zone[row] = Zone::Wall;
            sample.particles.patch[row] = u16::from(noise(key) > 0.0);
            sample.particles.wall_normal[0][row] = 0.6;
            sample.particles.wall_normal[1][row] = 0.8;
            for d in 0..D {
                sample.particles.drift[d][row] = 0.0;
            }
        }
    }
    let summary = rates(&mut sample);
    let (mut largest, mut fastest) = (0.0_f64, 0.0_f64);
    let mut found = vec![Vec::new(); 2 * D + 2];
    let mut expected = found.clone();
    for row in (0..sample.particles.len()).filter(|&row| sample.particles.zone[row] == Zone::Fluid) {
        let Reference { acceleration, background, pressure_rate, divergence, damping } =
            reference(&sample, row);
        for d in 0..D {
            found[d].push(sample.particles.acceleration[d][row]);
            expected[d].push(acceleration[d]);
            found[D + d].push(sample.sums.shift.read(AfterPasses)[d][row]);
            expected[D + d].push(background[d]);
        }
        found[2 * D].push(sample.sums.pressure_rate.read(AfterPasses)[row]);
        expected[2 * D].push(pressure_rate);
        found[2 * D + 1].push(sample.sums.divergence.read(AfterPasses)[row]);
        expected[2 * D + 1].push(divergence);
        largest = largest.max(divergence.abs());
        fastest = fastest.max(damping);
    }
    assert_close(&found, &expected, 1e-12, &format!("{:?}", sample.pair));
    assert!((summary.divergence / largest - 1.0).abs() < 1e-12);
    assert!((summary.damping / fastest - 1.0).abs() < 1e-12);
}

#[test]
fn rates_are_the_published_sums() {
    let usual = Edac::default();
    for kernel in Kernel::ALL {
        check(evolved(kernel, 2, 1.3, usual), [13, 9]);
        check(evolved(kernel, 3, 1.2, usual), [7, 8, 5]);
        let edac = Edac { as_published: true, average_pressure: false, background: 0.3, alpha: 1.5, ..usual };
        let wall_model = WallModel::Image { velocity_cap: Some(1.5), pressure: WallPressure::Extrapolated };
        check(PairSettings { wall_model, ..evolved(kernel, 2, 1.5, edac) }, [12, 9]);
        let edac = Edac { lattice_normalised: false, relaxation: 0.3, ..usual };
        let free_slip = WallPartSettings { free_slip: true, ..Default::default() };
        let walled = PairSettings {
            wall_parts: [WallPartSettings::default(), free_slip].into(),
            wall_model: WallModel::Image { velocity_cap: None, pressure: WallPressure::Mirrored },
            body_force: [0.5, -9.81, 0.0],
            ..evolved(kernel, 2, 1.3, edac)
        };
        check(walled.clone(), [12, 9]);
        check(in_space(&walled), [6, 9, 5]);
        for wall_model in [WallModel::Dummy, WallModel::Ghost] {
            let walled = PairSettings { wall_model, ..walled.clone() };
            check(PairSettings { wall_parts: [].into(), ..walled.clone() }, [13, 9]);
            check(walled.clone(), [12, 9]);
            check(in_space(&walled), [6, 9, 5]);
        }
    }
}

#[test]
fn two_particles_push_and_drag_each_other_and_share_their_pressure() {
    let edac = Edac { average_pressure: false, lattice_normalised: false, ..Edac::default() };
    let mut sample = sample::<f64, 2>(evolved(Kernel::QuinticSpline, 2, 1.2, edac), [2, 1], false);
    let (first, second) = (sample.row(0), sample.row(1));
    let (rho_a, rho_b, p_a, p_b) = (1000.0, 1010.0, 30.0, 170.0);
    [sample.particles.density[first], sample.particles.density[second]] = [rho_a, rho_b];
    [sample.particles.pressure[first], sample.particles.pressure[second]] = [p_a, p_b];
    sample.particles.velocity[1][second] = 0.25;
    rates(&mut sample);
    let h = 1.2 * SPACING;
    let q: f64 = 1.0 / 1.2;
    let slope =
        7.0 / (478.0 * std::f64::consts::PI) / h.powi(4) * (-120.0 + 120.0 * q * q - 50.0 * q * q * q);
    let m = 1000.0 * SPACING * SPACING;
    let squares = (m / rho_a).powi(2) + (m / rho_b).powi(2);
    let push = squares / m * (rho_b * p_a + rho_a * p_b) / (rho_a + rho_b) * slope * SPACING;
    let drag = squares / m * 2.0 * NU * rho_a * rho_b / (rho_a + rho_b) * 0.25 * slope;
    let [along, across] = &sample.particles.acceleration;
    assert!((along[first] / push - 1.0).abs() < 1e-12 && (across[first] / -drag - 1.0).abs() < 1e-12);
    assert!((along[first] + along[second]).abs() < 1e-12 * push.abs());
    assert!((across[first] + across[second]).abs() < 1e-12 * drag.abs());
    let nu_edac = 0.5 * h * WATER.sound_speed / 8.0;
    let shared = squares / m * 2.0 * nu_edac * rho_a * rho_b / (rho_a + rho_b) * (p_a - p_b) * slope;
    assert!((sample.sums.pressure_rate.read(AfterPasses)[first] / shared - 1.0).abs() < 1e-12);
    assert!((sample.sums.pressure_rate.read(AfterPasses)[second] / -shared - 1.0).abs() < 1e-12);
}

#[test]
fn momentum_is_conserved_to_rounding_without_the_mean_pressure() {
    for kernel in Kernel::ALL {
        let edac = Edac { average_pressure: false, ..Edac::default() };
        let mut sample = sample::<f64, 2>(evolved(kernel, 2, 1.2, edac), [20, 14], true);
        stir(&mut sample);
        density(&mut sample);
        rates(&mut sample);
        for column in &sample.particles.acceleration {
            let sum: f64 = column.iter().sum();
            let size: f64 = column.iter().map(|a| a.abs()).sum();
            assert!(sum.abs() < 1e-12 * size, "Σ dv/dt = {sum} of {size}");
        }
    }
}

#[test]
fn a_body_gains_the_momentum_that_the_fluid_loses() {
    for wall_model in [WallModel::default(), WallModel::Dummy, WallModel::Ghost] {
        let edac = Edac { average_pressure: false, ..Edac::default() };
        let pair = PairSettings { wall_model, ..evolved(Kernel::QuinticSpline, 2, 1.2, edac) };
        let mut sample = sample::<f64, 2>(pair, [13, 11], false);
        stir(&mut sample);
        for row in 0..sample.particles.len() {
            let height = (sample.particles.position[1][row] + 0.3) / SPACING - 3.9;
            sample.particles.wall_distance[row] = height.abs().max(0.1) * SPACING;
            if height < 0.0 {
                sample.particles.zone[row] = Zone::Wall;
                sample.particles.drift[0][row] = 0.0;
                sample.particles.drift[1][row] = 0.0;
            }
        }
        rates(&mut sample);
        let mut body = Body::new(0, DVec3::ZERO);
        let Sample { pair, grid, particles, sums } = &mut sample;
        let found = sum_body_force(pair, &edac, grid, particles, sums, &mut body).value();
        let (mut lost, mut size) = (DVec3::ZERO, 0.0);
        for row in (0..particles.len()).filter(|&row| particles.zone[row] == Zone::Fluid) {
            let [x, y] = particles.acceleration.each_ref().map(|column| column[row]);
            lost -= DVec3::new(x, y, 0.0) * pair.discretisation.mass;
            size += x.hypot(y) * pair.discretisation.mass;
        }
        let force = found.pressure_force + found.viscous_force;
        assert!((force - lost).length() < 1e-12 * size, "{wall_model:?}: {force}, not {lost} of {size}");
        assert!(found.pressure_force.length() > 1e-3 * size && found.viscous_force.length() > 1e-6 * size);
    }
}

#[test]
fn dissipation_takes_energy_from_every_particle_that_moves_alone() {
    let mut sample =
        sample::<f64, 2>(evolved(Kernel::QuinticSpline, 2, 1.2, Edac::default()), [13, 13], false);
    sample.stir(0.2, 0.0);
    density(&mut sample);
    let middle = sample.row(6 * 13 + 6);
    sample.particles.pressure[middle] = 1.0;
    let damping = rates(&mut sample).damping;
    let fallen = -sample.sums.pressure_rate.read(AfterPasses)[middle];
    sample.particles.pressure[middle] = 0.0;
    sample.particles.velocity[0][middle] = 1.0;
    rates(&mut sample);
    let slowed = -sample.particles.acceleration[0][middle];
    // The time step is bound by the faster of the two.
    assert!(0.0 < slowed && slowed < fallen && fallen <= damping, "{slowed}, {fallen}, {damping} 1/s");
}

#[test]
fn a_lattice_has_the_reference_density_and_stays_at_rest() {
    for (kernel, ratio) in [(Kernel::QuinticSpline, 1.2), (Kernel::WendlandC2, 1.5)] {
        for set in InstructionSet::available() {
            let mut pair = evolved(kernel, 2, ratio, Edac::default());
            pair.lanes = set;
            let mut sample = sample::<f64, 2>(pair, [13, 15], true);
            sample.particles.pressure.fill(4000.0);
            density(&mut sample);
            rates(&mut sample);
            for row in 0..sample.particles.len() {
                let error = sample.particles.density[row] / WATER.reference_density - 1.0;
                assert!(error.abs() < 1e-12, "{kernel:?}, {} lanes: {error}", set.name());
                assert_eq!(sample.particles.pressure[row], 4000.0, "the sum leaves the pressure alone");
                let fields = [&sample.particles.acceleration, sample.sums.shift.read(AfterPasses)];
                for column in fields.into_iter().flatten() {
                    assert!(column[row].abs() < 1e-11 * 16.0 / SPACING, "{} m/s²", column[row]);
                }
                assert_eq!(sample.sums.pressure_rate.read(AfterPasses)[row], 0.0);
            }
        }
    }
}

#[test]
fn the_pressure_relaxes_to_that_of_the_density() {
    for pressure in [-4000.0, 0.0, 4000.0] {
        let edac = Edac { relaxation: 0.1, ..Edac::default() };
        let mut sample = sample::<f64, 2>(evolved(Kernel::QuinticSpline, 2, 1.2, edac), [13, 15], true);
        sample.particles.pressure.fill(pressure);
        sample.particles.density.fill(1.01 * WATER.reference_density);
        rates(&mut sample);
        let (h, c) = (sample.pair.discretisation.smoothing_length, WATER.sound_speed);
        let rate = 0.1 * c / h * (0.01 * WATER.reference_density * c * c - pressure);
        for found in sample.sums.pressure_rate.read(AfterPasses) {
            assert!((found / rate - 1.0).abs() < 1e-12, "{found}, not {rate} Pa/s");
        }
    }
}

#[test]
fn single_precision_and_all_sets_agree() {
    let pair = evolved(Kernel::QuinticSpline, 2, 1.2, Edac::default());
    let results = |sample: &Sample<f64, 2>| sample.results();
    let mut double = sample::<f64, 2>(pair.clone(), [21, 17], true);
    stir(&mut double);
    double.particles.pressure.iter_mut().for_each(|p| *p += 5000.0);
    density(&mut double);
    rates(&mut double);
    let expected = results(&double);
    for set in InstructionSet::available() {
        let mut other = sample::<f64, 2>(PairSettings { lanes: set, ..pair.clone() }, [21, 17], true);
        stir(&mut other);
        other.particles.pressure.iter_mut().for_each(|p| *p += 5000.0);
        density(&mut other);
        rates(&mut other);
        assert_close(&results(&other), &expected, 1e-11, set.name());
        let mut single = sample::<f32, 2>(PairSettings { lanes: set, ..pair.clone() }, [21, 17], true);
        stir(&mut single);
        single.particles.pressure.iter_mut().for_each(|p| *p += 5000.0);
        density(&mut single);
        rates(&mut single);
        // Rounding of a pressure of 5000 Pa is 5e-4 Pa of differences of 500 Pa.
        assert_close(&single.results(), &expected, 2e-5, set.name());
    }
}
