//! Tests of the fits at walls: exact profiles, walls that move, plates.

use super::*;
use crate::math::kernel::Kernel;
use crate::math::lanes::InstructionSet;
use crate::pass::samples::{SPACING, Sample, settings};

/// Returns the flow at the wall y = −0.3, which has the velocity 0.5 m/s along x, before a
/// disordered fluid. Every seventh particle is a wall particle with meaningless fields.
fn at_wall<const D: usize>(
    (set, ratio): (InstructionSet, f64),
    (friction, gradient): (Friction, DMat3),
    velocity: impl Fn([f64; D]) -> [f64; 2],
    at: f64,
) -> SurfaceFlow {
    let mut pair = settings(Kernel::WendlandC2, D, ratio);
    pair.lanes = set;
    let mut sample = Sample::<f64, D>::lattice(pair, [12; D], false);
    sample.stir(0.2, 0.0);
    let particles = &mut sample.particles;
    for row in 0..particles.len() {
        let x = std::array::from_fn(|d| particles.position[d][row]);
        [particles.velocity[0][row], particles.velocity[1][row]] = velocity(x);
        particles.pressure[row] = 7.0 + 2.0 * x[0] - 3.0 * x[1];
        if particles.id[row] % 7 == 3 {
            particles.zone[row] = Zone::Wall;
            particles.pressure[row] = 1e5;
            particles.velocity[0][row] = -77.0;
        }
    }
    let sampler = SurfaceSampler::new(&sample.grid, &sample.particles, &sample.pair, 0.01);
    let mut position = DVec3::ZERO;
    for d in 0..D {
        position[d] = -0.3 + at * SPACING;
    }
    position.y = -0.3;
    let point = SurfacePoint { position, normal: DVec3::Y, velocity: 0.5 * DVec3::X, gradient, friction };
    sampler.sample(&[point])[0].expect("fluid is near")
}

fn check<const D: usize>(set: InstructionSet) {
    let parabola = |x: [f64; D]| [0.5 + 4.0 * (x[1] + 0.3) - 6.0 * (x[1] + 0.3).powi(2), 0.0];
    let found = at_wall::<D>((set, 2.2), (Friction::NoSlip, DMat3::ZERO), parabola, 5.6);
    assert!((found.shear.x / found.shear.length() - 1.0).abs() < 1e-9, "{found:?}");
    // The density of the sample is that of water.
    assert!((found.shear.x / (0.01 * 1000.0 * 4.0) - 1.0).abs() < 1e-3, "{found:?}");
    let pressure = 7.0 + 2.0 * (-0.3 + 5.6 * SPACING) + 0.9;
    assert!((found.pressure - pressure).abs() < 1e-8, "{} Pa, not {pressure}", found.pressure);
    let slips = at_wall::<D>((set, 2.2), (Friction::FreeSlip, DMat3::ZERO), parabola, 5.6);
    assert_eq!((slips.shear, slips.pressure), (DVec3::ZERO, found.pressure));
}

#[test]
fn shear_of_a_parabola_and_linear_pressure_are_exact_at_a_wall_that_moves() {
    for set in InstructionSet::available() {
        check::<2>(set);
        check::<3>(set);
    }
}

/// With h = 1.3 Δ the quadratic fit of two rows would amplify noise; a linear one is left,
/// which is exact for a Couette flow.
#[test]
fn shear_of_a_linear_profile_is_exact_at_every_smoothing_length() {
    let linear = |x: [f64; 2]| [0.5 + 4.0 * (x[1] + 0.3), 0.0];
    for ratio in [1.3, 1.5, 2.0] {
        let found =
            at_wall::<2>((InstructionSet::best(), ratio), (Friction::NoSlip, DMat3::ZERO), linear, 4.3);
        assert!((found.shear.x / 40.0 - 1.0).abs() < 1e-3, "{found:?} at {ratio}");
    }
}

/// The fluid rotates with the wall as a rigid body: the gradient is antisymmetric, the stress zero.
#[test]
fn rigid_rotation_has_no_shear() {
    let rotation = |x: [f64; 2]| [0.5 - 3.0 * (x[1] + 0.3), 3.0 * (x[0] + 0.3 - 5.6 * SPACING)];
    let spin = DMat3::from_cols(3.0 * DVec3::Y, -3.0 * DVec3::X, DVec3::ZERO);
    let found = at_wall::<2>((InstructionSet::best(), 2.0), (Friction::NoSlip, spin), rotation, 5.6);
    assert!(found.shear.length() < 1e-9, "{found:?}");
}

/// A plate of one spacing is between both fluids.
#[test]
fn fluid_behind_the_surface_does_not_count() {
    let pair = settings(Kernel::WendlandC2, 2, 2.0);
    let mut sample = Sample::<f64, 2>::lattice(pair, [12; 2], false);
    let surface = -0.3 + 5.0 * SPACING;
    for row in 0..sample.particles.len() {
        let y = sample.particles.position[1][row] - surface;
        sample.particles.pressure[row] = if y > 0.0 { 5.0 } else { -1e4 };
        sample.particles.velocity[0][row] = if y > 0.0 { 2.0 * y } else { 1e3 };
        if y < 0.0 && y > -1.1 * SPACING {
            sample.particles.zone[row] = Zone::Wall;
        }
    }
    let sampler = SurfaceSampler::new(&sample.grid, &sample.particles, &sample.pair, 0.01);
    let position = DVec3::new(-0.3 + 6.0 * SPACING, surface, 0.0);
    let (normal, velocity, friction) = (DVec3::Y, DVec3::ZERO, Friction::NoSlip);
    let point = SurfacePoint { position, normal, velocity, gradient: DMat3::ZERO, friction };
    let found = sampler.sample(&[point])[0].expect("fluid is near");
    assert!((found.pressure - 5.0).abs() < 1e-9 && (found.shear.x - 20.0).abs() < 0.1, "{found:?}");
    let apart = SurfacePoint { position: position - DVec3::Y, normal: -DVec3::Y, ..point };
    assert_eq!(sampler.sample(&[apart]), [None]);
}
