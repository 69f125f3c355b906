//! The rate pass against its formulas, conservation and limits.

mod reference;

use glam::DVec3;

use super::*;
use crate::math::kernel::Kernel;
use crate::math::lanes::InstructionSet;
use crate::math::symmetric::components;
use crate::particles::zone::Zone;
use crate::pass::body::BodySum;
use crate::pass::samples::{SPACING, Sample, WATER, assert_close, noise, settings};
use crate::physics::viscosity::{Artificial, Sps, Viscosity};
use crate::physics::wall::{WallModel, WallPressure};

const NU: f64 = 1e-3;

fn viscous(kernel: Kernel, dimensions: usize, ratio: f64) -> PairSettings {
    PairSettings { viscosity: NU, ..settings(kernel, dimensions, ratio) }
}

#[test]
fn two_particles_push_and_drag_each_other() {
    let mut sample = Sample::<f64, 2>::lattice(viscous(Kernel::WendlandC2, 2, 1.3), [2, 1], false);
    let h = sample.pair.discretisation.smoothing_length;
    let slope = -5.0 * 7.0 / (4.0 * std::f64::consts::PI) / h.powi(4) * (1.0 - 0.5 * SPACING / h).powi(3);
    let (first, second) = (sample.row(0), sample.row(1));
    let (rho_a, rho_b, p_a, p_b) = (1000.0, 1010.0, 30.0, 170.0);
    [sample.particles.density[first], sample.particles.density[second]] = [rho_a, rho_b];
    [sample.particles.pressure[first], sample.particles.pressure[second]] = [p_a, p_b];
    sample.particles.velocity[1][second] = 0.25;
    sample.rates();
    let mass = 1000.0 * SPACING * SPACING;
    let push = mass / (rho_a * rho_b) * (p_a + p_b) * slope * SPACING;
    let drag = 4.0 * NU / sample.pair.lattice.viscosity * mass * 0.25 / (rho_a + rho_b) * slope;
    let [along, across] = &sample.particles.acceleration;
    assert!((along[first] / push - 1.0).abs() < 1e-12 && (across[first] / -drag - 1.0).abs() < 1e-12);
    assert!((along[first] + along[second]).abs() < 1e-12 * push.abs());
    assert!((across[first] + across[second]).abs() < 1e-12 * drag.abs());
}

/// Settings of a wall that is a body, and its sums for a sample whose rates are found.
fn body_of<const D: usize>(sample: &mut Sample<f64, D>, about: DVec3) -> BodySum {
    sample.rates();
    let mut body = Body::new(0, about);
    let level = TimeLevel::Present;
    sum_body_force(&sample.pair, &sample.grid, &sample.particles, level, &mut sample.sums, &mut body).value()
}

const WALLS: [WallModel; 3] = [
    WallModel::Image { velocity_cap: None, pressure: WallPressure::Extrapolated },
    WallModel::Dummy,
    WallModel::Ghost,
];

#[test]
fn a_body_of_one_particle_gains_the_momentum_of_its_neighbour() {
    for wall_model in WALLS {
        let pair =
            PairSettings { wall_model, body_force: [0.0, -9.0, 0.0], ..viscous(Kernel::WendlandC2, 3, 1.3) };
        let mut sample = Sample::<f64, 3>::lattice(pair, [2, 1, 1], false);
        let [fluid, wall] = [0, 1].map(|id| sample.row(id));
        sample.particles.zone[wall] = Zone::Wall;
        sample.particles.position[1][wall] += 0.3 * SPACING;
        for distance in &mut sample.particles.wall_distance {
            *distance = 0.5 * SPACING;
        }
        sample.particles.pressure[fluid] = 50.0;
        sample.particles.velocity[1][fluid] = 0.3;
        sample.particles.velocity[2][fluid] = -0.2;
        let about = DVec3::new(0.1, -0.2, 0.3);
        let found = body_of(&mut sample, about);
        let of =
            |columns: &[Vec<f64>; 3], row: usize| DVec3::from(columns.each_ref().map(|column| column[row]));
        let lost = of(&sample.particles.acceleration, fluid) * -sample.pair.discretisation.mass;
        let (force, torque) =
            (found.pressure_force + found.viscous_force, found.pressure_torque + found.viscous_torque);
        assert!((force - lost).length() < 1e-13 * lost.length(), "{force} {lost}");
        let arm = of(&sample.particles.position, wall) - about;
        let expected = arm.cross(lost);
        assert!((torque - expected).length() < 1e-12 * expected.length(), "{torque} {expected}");
        let along = of(&sample.particles.position, fluid) - of(&sample.particles.position, wall);
        assert!(
            found.pressure_force.cross(along).length()
                < 1e-13 * found.pressure_force.length() * along.length()
        );
        // The velocity stands across x_ab in z and nearly so in y; F = −m · 4 ν m v/(ρ_a + ρ_b) ·
        // F_ab.
        assert!(
            found.viscous_force.length() > 0.0 && found.viscous_force.x == 0.0,
            "{}",
            found.viscous_force
        );
    }
}

#[test]
fn bodies_gain_the_momentum_that_the_fluid_loses() {
    let viscous_terms = [
        Viscosity::default(),
        Viscosity::Artificial(Artificial { alpha: 0.1 }),
        Viscosity::Sps(Sps::default()),
    ];
    for (wall_model, viscous_term) in
        WALLS.into_iter().flat_map(|wall| viscous_terms.map(|term| (wall, term)))
    {
        let pair = PairSettings {
            wall_model,
            viscous_term,
            tensile_control: false,
            ..viscous(Kernel::WendlandC2, 2, 1.3)
        };
        let mut sample = Sample::<f64, 2>::lattice(pair, [13, 11], false);
        sample.stir(0.3, 1.0);
        for column in sample.sums.stress.choose().iter_mut().take(components(2)) {
            *column = sample.particles.id.iter().map(|id| 0.1 * noise(id * 64 + 5)).collect();
        }
        for row in 0..sample.particles.len() {
            sample.particles.pressure[row] = 100.0 * noise(8 * sample.particles.id[row] + 7);
            let height = (sample.particles.position[1][row] + 0.3) / SPACING - 2.9;
            sample.particles.wall_distance[row] = height.abs().max(0.1) * SPACING;
            if height < 0.0 {
                sample.particles.zone[row] = Zone::Wall;
            }
        }
        let found = body_of(&mut sample, DVec3::ZERO);
        let mut lost = DVec3::ZERO;
        let mut size = 0.0;
        for row in (0..sample.particles.len()).filter(|&row| sample.particles.zone[row] == Zone::Fluid) {
            let [x, y] = sample.particles.acceleration.each_ref().map(|column| column[row]);
            lost -= DVec3::new(x, y, 0.0) * sample.pair.discretisation.mass;
            size += x.hypot(y) * sample.pair.discretisation.mass;
        }
        let force = found.pressure_force + found.viscous_force;
        assert!(
            (force - lost).length() < 1e-13 * size,
            "{wall_model:?}, {viscous_term:?}: {force}, not {lost}"
        );
        assert!(found.pressure_force.length() > 0.0 && found.viscous_force.length() > 0.0);
    }
}

#[test]
fn momentum_is_conserved_to_rounding_in_a_periodic_box() {
    for (kernel, noise_damping) in Kernel::ALL.into_iter().flat_map(|kernel| [(kernel, 0.0), (kernel, 0.3)]) {
        let pair = PairSettings { tensile_control: false, noise_damping, ..viscous(kernel, 2, 1.3) };
        let mut sample = Sample::<f64, 2>::lattice(pair, [20, 14], true);
        sample.stir(0.2, 1.0);
        sample.density();
        sample.strain();
        sample.rates();
        for column in &sample.particles.acceleration {
            let sum: f64 = column.iter().sum();
            let size: f64 = column.iter().map(|a| a.abs()).sum();
            assert!(sum.abs() < 1e-13 * size, "Σ dv/dt = {sum} of {size}");
        }
    }
}

#[test]
fn a_parabola_has_the_viscous_force_of_its_curvature() {
    for ratio in [1.2, 1.5, 2.02] {
        let mut sample = Sample::<f64, 2>::lattice(viscous(Kernel::WendlandC2, 2, ratio), [15, 15], false);
        for row in 0..sample.particles.len() {
            sample.particles.velocity[0][row] = 50.0 * sample.particles.position[1][row].powi(2);
        }
        sample.rates();
        let found = sample.particles.acceleration[0][sample.row(7 * 15 + 7)];
        assert!((found / (100.0 * NU) - 1.0).abs() < 1e-10, "h = {ratio} Δ: {found}");
    }
}

#[test]
fn noise_damping_slows_a_single_particle_and_no_linear_flow() {
    let accelerations = |noise_damping: f64, kick: f64| {
        let pair = PairSettings { noise_damping, ..settings(Kernel::WendlandC2, 2, 1.5) };
        let mut sample = Sample::<f64, 2>::lattice(pair, [13, 13], false);
        sample.stir(0.2, 0.0);
        for row in 0..sample.particles.len() {
            let [x, y] = [0, 1].map(|d| sample.particles.position[d][row]);
            sample.particles.velocity[0][row] = 2.0 * x - 3.0 * y;
            sample.particles.velocity[1][row] = 5.0 * x + 0.5 * y;
        }
        let middle = sample.row(6 * 13 + 6);
        sample.particles.velocity[0][middle] += kick;
        sample.density();
        sample.strain();
        sample.rates();
        (sample.particles.acceleration.clone(), middle)
    };
    let ((plain, middle), (damped, _)) = (accelerations(0.0, 0.0), accelerations(0.3, 0.0));
    let size = plain[0].iter().fold(0.0_f64, |size, a| size.max(a.abs()));
    for (plain, damped) in plain.iter().flatten().zip(damped.iter().flatten()) {
        assert!((plain - damped).abs() < 1e-11 * size, "{plain} {damped}");
    }
    let slowed = accelerations(0.3, 1.0).0[0][middle] - accelerations(0.0, 1.0).0[0][middle];
    // On an even lattice the rate is 1.75 α c0/h: the bound that the time step relies on.
    let rate = 1.75 * 0.3 * WATER.sound_speed / (1.5 * SPACING);
    assert!((0.5..1.2).contains(&(-slowed / rate)), "{} of the rate", -slowed / rate);
}

/// Results of a disordered periodic box.
fn disordered<R: Real, const D: usize>(
    set: InstructionSet,
    kernel: Kernel,
    counts: [usize; D],
) -> Vec<Vec<f64>> {
    let pair = PairSettings { lanes: set, noise_damping: 0.2, ..viscous(kernel, D, 1.5) };
    let mut sample = Sample::<R, D>::lattice(pair, counts, true);
    sample.stir(0.2, 1.0);
    sample.density();
    sample.strain();
    sample.rates();
    sample.results()
}

#[test]
fn instruction_sets_agree() {
    let sets = InstructionSet::available();
    for kernel in Kernel::ALL {
        let flat = disordered::<f64, 2>(InstructionSet::PORTABLE, kernel, [23, 17]);
        let deep = disordered::<f64, 3>(InstructionSet::PORTABLE, kernel, [9, 8, 11]);
        for &set in &sets {
            assert_close(&disordered::<f64, 2>(set, kernel, [23, 17]), &flat, 1e-12, set.name());
            assert_close(&disordered::<f64, 3>(set, kernel, [9, 8, 11]), &deep, 1e-12, set.name());
        }
    }
}

#[test]
fn single_precision_agrees_with_double() {
    // Pressures come from ρ − ρ0: 6e-8 of ρ in a density that varies by some percent, seven times
    // over by Tait.
    let tolerance = 2e-5;
    for set in InstructionSet::available() {
        let single = disordered::<f32, 2>(set, Kernel::WendlandC2, [23, 17]);
        assert_close(
            &single,
            &disordered::<f64, 2>(set, Kernel::WendlandC2, [23, 17]),
            tolerance,
            set.name(),
        );
        let single = disordered::<f32, 3>(set, Kernel::WendlandC2, [9, 8, 11]);
        assert_close(
            &single,
            &disordered::<f64, 3>(set, Kernel::WendlandC2, [9, 8, 11]),
            tolerance,
            set.name(),
        );
    }
}

#[test]
fn a_narrow_period_equals_its_replicas() {
    let mut narrow = Sample::<f64, 2>::lattice(viscous(Kernel::WendlandC2, 2, 1.5), [13, 2], true);
    narrow.stir(0.2, 1.0);
    let copies = 5;
    let mut wide = Sample::<f64, 2>::lattice(viscous(Kernel::WendlandC2, 2, 1.5), [13, 2 * copies], true);
    for row in 0..wide.particles.len() {
        let id = wide.particles.id[row];
        let original = narrow.row(id % 26);
        let copy = f64::from(id / 26);
        wide.particles.position[0][row] = narrow.particles.position[0][original];
        wide.particles.position[1][row] = narrow.particles.position[1][original] + copy * 2.0 * SPACING;
        for d in 0..2 {
            wide.particles.velocity[d][row] = narrow.particles.velocity[d][original];
        }
    }
    wide.sort();
    for sample in [&mut narrow, &mut wide] {
        sample.density();
        sample.rates();
    }
    let expected: Vec<Vec<f64>> = narrow.results().iter().map(|column| column.repeat(copies)).collect();
    assert_close(&wide.results(), &expected, 1e-11, "copies");
}

#[test]
fn any_number_of_threads_is_bitwise_identical() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| disordered::<f64, 2>(InstructionSet::best(), Kernel::WendlandC2, [90, 90]))
    };
    let alone = run(1);
    for threads in [2, 3] {
        assert_eq!(run(threads), alone, "{threads} threads");
    }
}

#[test]
fn a_nan_reaches_the_summary() {
    let mut sample = Sample::<f64, 2>::lattice(viscous(Kernel::WendlandC2, 2, 1.5), [8, 8], true);
    sample.particles.velocity[0][13] = f64::NAN;
    assert!(sample.rates().speed.is_nan());
}
