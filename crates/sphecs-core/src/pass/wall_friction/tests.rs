//! Tests of the wall friction: balance of momentum and the law of the wall.

use glam::DVec3;

use super::*;
use crate::math::kernel::Kernel;
use crate::pass::neighbours::Neighbours;
use crate::pass::samples::{SPACING, Sample, WATER, noise, settings};
use crate::pass::settings::WallPartSettings;

const VISCOSITY: f64 = 1e-4;

fn wall_function() -> WallPartSettings {
    WallPartSettings { free_slip: true, wall_function: true }
}

/// Fluid over a wall of five layers, which is flat in y; `offset` (Δ) puts its surface between two
/// layers.
fn over_a_wall<R: Real, const D: usize>(
    pair: PairSettings,
    counts: [usize; D],
    periodic: bool,
    offset: f64,
) -> Sample<R, D> {
    let mut sample = Sample::<R, D>::lattice(pair, counts, periodic);
    let surface = (4.5 + offset) * SPACING - 0.3;
    for row in 0..sample.particles.len() {
        let depth = surface - sample.particles.position[1][row];
        sample.particles.zone[row] = if depth > 0.0 { Zone::Wall } else { Zone::Fluid };
        sample.particles.wall_distance[row] = R::from_f64(depth);
        sample.particles.wall_normal[1][row] = R::from_f64(if depth > 0.0 { 1.0 } else { 0.0 });
    }
    sample
}

fn add_friction<R: Real, const D: usize>(sample: &mut Sample<R, D>) {
    let Sample { pair, grid, particles, sums } = sample;
    for column in &mut particles.acceleration {
        column.clear();
        column.resize(particles.id.len(), R::default());
    }
    add_wall_friction(pair, grid, particles, TimeLevel::Present, sums);
}

/// Momentum that the fluid gains per second, N.
fn gained<R: Real, const D: usize>(sample: &Sample<R, D>) -> DVec3 {
    let mut sum = DVec3::ZERO;
    for d in 0..D {
        sum[d] = sample.pair.discretisation.mass
            * sample.particles.acceleration[d].iter().map(|a| a.to_f64()).sum::<f64>();
    }
    sum
}

/// Returns the accelerations from the formulas, neighbour by neighbour.
fn expected<R: Real, const D: usize>(sample: &Sample<R, D>) -> Vec<[f64; D]> {
    let Sample { pair, grid, particles, .. } = sample;
    let neighbours = Neighbours::new(grid, particles);
    let flows = |row: usize| particles.zone[row] != Zone::Wall;
    let place = |row: usize| -> [f64; D] { std::array::from_fn(|d| particles.position[d][row]) };
    let mut found = vec![[0.0; D]; particles.len()];
    for w in 0..particles.len() {
        let depth = particles.wall_distance[w].to_f64();
        let takes = !flows(w) && pair.wall_part(particles.patch[w]).wall_function && depth < SPACING;
        if !takes {
            continue;
        }
        let (mut velocity, mut height, mut weights) = ([0.0; D], 0.0, 0.0);
        neighbours.for_each(place(w), |b, x, r2| {
            if flows(b) {
                let weight = pair.discretisation.w(r2.sqrt());
                weights += weight;
                for d in 0..D {
                    velocity[d] +=
                        weight * (particles.velocity[d][b].to_f64() - particles.velocity[d][w].to_f64());
                    // x is from b to w.
                    height -= weight * x[d] * particles.wall_normal[d][w].to_f64();
                }
            }
        });
        if weights < 1e-9 {
            continue;
        }
        let y = (height / weights - depth).max(0.1 * SPACING);
        let mean = velocity.map(|v| v / weights);
        let into: f64 = (0..D).map(|d| mean[d] * particles.wall_normal[d][w].to_f64()).sum();
        let along: [f64; D] = std::array::from_fn(|d| mean[d] - into * particles.wall_normal[d][w].to_f64());
        let speed = along.iter().map(|v| v * v).sum::<f64>().sqrt();
        let u_tau = friction_velocity(speed, y, pair.viscosity);
        let force = WATER.reference_density * u_tau * u_tau * SPACING.powi(D as i32 - 1);
        neighbours.for_each(place(w), |b, _, r2| {
            if particles.zone[b] == Zone::Fluid {
                for d in 0..D {
                    found[b][d] -= force * along[d] / speed * pair.discretisation.w(r2.sqrt())
                        / (weights * pair.discretisation.mass);
                }
            }
        });
    }
    found
}

fn check<R: Real, const D: usize>(kernel: Kernel, counts: [usize; D], tolerance: f64) {
    let pair = PairSettings {
        viscosity: VISCOSITY,
        wall_parts: [wall_function(), WallPartSettings::default()].into(),
        ..settings(kernel, D, 1.3)
    };
    let mut sample = over_a_wall::<R, D>(pair, counts, false, 0.3);
    sample.stir(0.2, 1.0);
    for row in 0..sample.particles.len() {
        // A part of another kind, inflow that is felt but does not feel, and a surface that is not
        // flat.
        sample.particles.patch[row] = u16::from(noise(8 * sample.particles.id[row]) > 0.8);
        if sample.particles.zone[row] == Zone::Wall {
            sample.particles.wall_normal[0][row] = R::from_f64(0.6);
            sample.particles.wall_normal[1][row] = R::from_f64(0.8);
        } else if sample.particles.position[0][row] < -0.3 + 3.0 * SPACING {
            sample.particles.zone[row] = Zone::Inflow;
        }
    }
    add_friction(&mut sample);
    let mut felt = 0;
    let all = expected(&sample);
    let largest = all.iter().flatten().fold(0.0, |a: f64, b| a.max(b.abs()));
    for (row, expected) in all.iter().enumerate() {
        for d in 0..D {
            let found = sample.particles.acceleration[d][row].to_f64();
            assert!(
                (found - expected[d]).abs() < tolerance * largest,
                "{kernel:?} {row}: {found}, not {expected:?}"
            );
        }
        felt += usize::from(expected[0] != 0.0);
    }
    assert!(felt > counts[0], "{felt} rows feel the wall");
}

#[test]
fn friction_agrees_with_the_formulas() {
    for kernel in Kernel::ALL {
        check::<f64, 2>(kernel, [12, 14], 1e-11);
        check::<f64, 3>(kernel, [6, 12, 5], 1e-11);
        check::<f32, 2>(kernel, [12, 14], 1e-4);
    }
}

#[test]
fn a_resolved_shear_has_its_own_stress_wherever_the_lattice_is_cut() {
    for offset in [0.5, 0.1, 0.93] {
        let pair = PairSettings {
            viscosity: VISCOSITY,
            wall_parts: [wall_function()].into(),
            ..settings(Kernel::WendlandC2, 3, 1.5)
        };
        let counts = [12, 16, 12];
        let mut sample = over_a_wall::<f64, 3>(pair, counts, true, offset);
        let shear = 1e-2;
        for row in 0..sample.particles.len() {
            if sample.particles.zone[row] == Zone::Fluid {
                // Periodic in y too: a particle above has the wall's other side beneath it, too
                // far off to be met.
                let height = -sample.particles.wall_distance[row];
                sample.particles.velocity[0][row] = 0.8 * shear * height;
                sample.particles.velocity[2][row] = -0.6 * shear * height;
                if height > 8.0 * SPACING {
                    sample.particles.zone[row] = Zone::Reservoir;
                }
            }
        }
        let order = {
            let kept: Vec<bool> = sample.particles.zone.iter().map(|&zone| zone != Zone::Reservoir).collect();
            sample
                .grid
                .build(&sample.particles.position, &sample.particles.id, |row| kept[row])
                .expect("inside")
        };
        sample.particles.reorder(order, &mut Default::default());
        add_friction(&mut sample);
        let area = (counts[0] * counts[2]) as f64 * SPACING * SPACING;
        let stress = WATER.reference_density * VISCOSITY * shear;
        let found = gained(&sample);
        let wanted = DVec3::new(-0.8, 0.0, 0.6) * stress * area;
        assert!((found - wanted).length() < 2e-4 * wanted.length(), "offset {offset}: {found}, not {wanted}");
    }
}

#[test]
fn a_body_gains_the_momentum_that_the_fluid_loses() {
    let pair = PairSettings {
        viscosity: VISCOSITY,
        wall_parts: [wall_function()].into(),
        ..settings(Kernel::WendlandC2, 3, 1.5)
    };
    let mut sample = over_a_wall::<f64, 3>(pair, [7, 12, 6], false, 0.5);
    sample.stir(0.1, 1.0);
    add_friction(&mut sample);
    let body = Body::new(0, DVec3::new(-0.26, 0.1, -0.27));
    let mut sum = ExactBodySum::default();
    add_friction_on(&sample.pair, &sample.grid, &sample.particles, &sample.sums, &body, &mut sum);
    let sum = sum.value();
    let lost = -gained(&sample);
    assert!(lost.length() > 0.0 && (sum.viscous_force - lost).length() < 1e-12 * lost.length());
    assert_eq!(sum.pressure_force, DVec3::ZERO);
    // The stress acts at the surface, so that a point of the surface as centre leaves only the
    // torque about its normal.
    let below = 4.5 * SPACING + 0.5 * SPACING - 0.3;
    let mut sum = ExactBodySum::default();
    let body = Body::new(0, DVec3::new(-0.26, below, -0.27));
    add_friction_on(&sample.pair, &sample.grid, &sample.particles, &sample.sums, &body, &mut sum);
    let torque = sum.value().viscous_torque;
    assert!(
        torque.y.abs() > 0.0 && torque.x.abs().max(torque.z.abs()) < 0.3 * SPACING * lost.length(),
        "{torque}"
    );
}

#[test]
fn walls_without_a_wall_function_have_no_friction() {
    let pair = PairSettings { viscosity: VISCOSITY, ..settings(Kernel::WendlandC2, 2, 1.3) };
    let mut sample = over_a_wall::<f64, 2>(pair, [8, 10], false, 0.5);
    sample.stir(0.1, 1.0);
    add_friction(&mut sample);
    assert_eq!(gained(&sample), DVec3::ZERO);
}
