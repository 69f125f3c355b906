//! Tests on fluid that a plate divides.

use super::*;
use crate::math::kernel::Kernel;
use crate::particles::arrays::ParticleArrays;
use crate::particles::zone::Zone;
use crate::pass::edac;
use crate::pass::samples::{SPACING, Sample, WATER, assert_close, noise, settings};
use crate::pass::settings::PressureLaw;
use crate::pass::wall_distance::find_wall_distance;
use crate::pass::walls::extrapolate_wall_pressure;
use crate::physics::edac::Edac;
use crate::physics::shifting::Shifting;

/// Lattice rows below the plate, and of the plate.
const BELOW: usize = 6;
const PLATE: usize = 1;

/// Returns fluid above and below a plate across the second axis. The plate is one-sided if
/// `is_thin`; else all below its upper surface is a thick wall.
fn divided<const D: usize>(law: PressureLaw, is_thin: bool) -> Sample<f64, D> {
    let mut pair = settings(Kernel::WendlandC2, D, 1.5);
    pair.pressure = law;
    pair.viscosity = 1e-3;
    pair.shifting = Shifting::NONE;
    let mut sample = Sample::<f64, D>::lattice(pair, [13; D], false);
    let particles = &mut sample.particles;
    particles.evolves_pressure = law != PressureLaw::Tait;
    particles.drifts = particles.evolves_pressure;
    if particles.drifts {
        particles.previous_pressure.resize(particles.id.len(), 0.0);
        particles.drift.iter_mut().for_each(|column| column.resize(particles.id.len(), 0.0));
    }
    if is_thin {
        particles.wall_thickness.resize(particles.id.len(), 0.0);
    }
    let top = (BELOW + PLATE) as f64 * SPACING;
    for row in 0..particles.len() {
        let height = particles.position[1][row] + 0.3;
        if height > top || (is_thin && height < top - SPACING) {
            continue;
        }
        particles.zone[row] = Zone::Wall;
        particles.wall_normal[1][row] = 1.0;
        particles.wall_distance[row] = top - height;
        if is_thin {
            particles.wall_thickness[row] = SPACING;
        }
    }
    sample
}

/// Sums acceleration, divergence and, where it evolves, the rate of the pressure of the fluid
/// above the plate; each column in the order of the particle numbers.
fn above<const D: usize>(sample: &mut Sample<f64, D>) -> Vec<Vec<f64>> {
    find_wall_distance(&sample.pair, &sample.grid, &mut sample.particles, &mut sample.sums);
    let carried = |_: &ParticleArrays<f64, D>, _| [0.0; D];
    let (pair, grid) = (&sample.pair, &sample.grid);
    extrapolate_wall_pressure(pair, grid, &mut sample.particles, &mut sample.sums, &carried);
    match sample.pair.pressure {
        PressureLaw::Tait => {
            sample.rates();
        }
        PressureLaw::Evolved(edac) => {
            edac::sum_rates(&sample.pair, &edac, &sample.grid, &mut sample.particles, &mut sample.sums);
        }
    }
    let particles = &sample.particles;
    let is_above = |row: &usize| particles.position[1][*row] + 0.3 > (BELOW + PLATE) as f64 * SPACING;
    let mut rows: Vec<usize> = (0..particles.len()).filter(is_above).collect();
    rows.sort_by_key(|&row| particles.id[row]);
    particles.acceleration.iter().map(|column| rows.iter().map(|&row| column[row]).collect()).collect()
}

fn nothing_crosses<const D: usize>(law: PressureLaw) {
    let mut sample = divided::<D>(law, true);
    for row in 0..sample.particles.len() {
        let id = sample.particles.id[row];
        if sample.particles.zone[row] == Zone::Fluid {
            sample.particles.velocity[0][row] = 0.1 + 0.05 * noise(id);
            sample.particles.pressure[row] = 50.0 * noise(id + 7);
        }
    }
    let before = above(&mut sample);
    assert!(before[0].iter().any(|acceleration| *acceleration != 0.0));
    for row in 0..sample.particles.len() {
        if sample.particles.position[1][row] + 0.3 < BELOW as f64 * SPACING {
            sample.particles.velocity[0][row] *= -7.0;
            sample.particles.velocity[1][row] = 0.4;
            sample.particles.pressure[row] += 900.0;
        }
    }
    assert_eq!(above(&mut sample), before, "{law:?} in {D}D");
}

#[test]
fn neither_pressure_nor_friction_crosses_a_thin_wall() {
    for law in [PressureLaw::Tait, PressureLaw::Evolved(Edac::default())] {
        nothing_crosses::<2>(law);
        nothing_crosses::<3>(law);
    }
}

#[test]
fn thin_wall_is_to_its_fluid_as_a_thick_one() {
    for law in [PressureLaw::Tait, PressureLaw::Evolved(Edac::default())] {
        let [thin, thick] = [true, false].map(|is_thin| {
            let mut sample = divided::<2>(law, is_thin);
            for row in 0..sample.particles.len() {
                sample.particles.pressure[row] = 100.0;
                sample.particles.density[row] = WATER.density(100.0);
                if sample.particles.zone[row] == Zone::Fluid {
                    sample.particles.velocity[0][row] = (sample.particles.position[1][row] + 0.3).powi(2);
                }
            }
            above(&mut sample)
        });
        // Under `EdacTvf` there is no acceleration across: both directions have one scale.
        assert_close(&[thin.concat()], &[thick.concat()], 1e-3, &format!("{law:?}"));
    }
}

#[test]
fn particles_beyond_the_edge_have_no_side() {
    let mut sample = divided::<2>(PressureLaw::Tait, true);
    let half = 6.0 * SPACING;
    for row in 0..sample.particles.len() {
        if sample.particles.position[0][row] + 0.3 > half {
            sample.particles.zone[row] = Zone::Fluid;
            sample.particles.wall_thickness[row] = 0.0;
        }
    }
    sample.sums.forget_order();
    above(&mut sample);
    let sides = sample.sums.sides.read(FusedInputsReader);
    for row in 0..sample.particles.len() {
        let (x, y) = (sample.particles.position[0][row] + 0.3, sample.particles.position[1][row] + 0.3);
        let height = y - (BELOW as f64 + 0.5) * SPACING;
        if sample.particles.zone[row] != Zone::Fluid || height.abs() > 1.6 * SPACING {
            continue;
        }
        let facing = sides.facing[1][row];
        if x < half {
            let distance = height.abs() - 0.5 * SPACING;
            let expected = height.signum() * (distance + SPACING);
            assert!((facing - expected).abs() < 1e-12, "{facing} at ({x}, {y}), not {expected}");
            assert!((sample.particles.wall_distance[row] - distance).abs() < 1e-12);
        } else if x > half + SPACING {
            assert_eq!(facing, 0.0, "at ({x}, {y})");
        }
    }
}
