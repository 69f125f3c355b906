//! Fits at the nodes of grids: exact for constant and linear fields, next to walls and openings
//! too, and in agreement with the samples of probes.

use super::*;
use crate::math::kernel::Kernel;
use crate::math::lanes::InstructionSet;
use crate::particles::zone::Zone;
use crate::pass::samples::{SPACING, Sample as Particles, WATER, settings};
use crate::pass::sampling::Sampler;

/// Returns rows of nodes oblique to the axes through a box of particles that begins at −0.3 m.
fn rows<const D: usize>(counts: [usize; D]) -> Vec<NodeRow> {
    let step = if D == 2 { DVec3::new(0.9, 0.2, 0.0) } else { DVec3::new(0.8, 0.1, 0.05) } * SPACING;
    let width = counts[0] as f64;
    (0..5)
        .map(|row| {
            let mut start = DVec3::ZERO;
            for d in 0..D {
                start[d] =
                    -0.3 + SPACING * (0.1 + f64::from(row) * 0.21 * width * f64::from(u8::from(d > 0)));
            }
            NodeRow { start, step, wanted: (0..13).map(|node| node != 5).collect() }
        })
        .collect()
}

fn sampled<R: Real, const D: usize>(
    sampler: &RowSampler<'_, R, D>,
    rows: &[NodeRow],
) -> Vec<Vec<NodeFields>> {
    let mut found = vec![Vec::new(); rows.len()];
    sampler.sample(rows, &mut found, |sink, fields| sink.extend_from_slice(fields));
    found
}

/// Returns the point of a node.
fn point(row: &NodeRow, node: usize) -> DVec3 {
    row.start + node as f64 * row.step
}

/// Plane of the outlet, m.
const OUTLET: f64 = -0.3 + 9.5 * SPACING;

/// Returns true for a node that is wanted and before the outlet.
fn is_checked(row: &NodeRow, node: usize) -> bool {
    row.wanted[node] && point(row, node).x < OUTLET
}

/// Disordered particles with linear fields. Every seventh is a wall particle with meaningless
/// values, and the last columns are the zone of an outlet.
fn linear_flow<const D: usize>(kernel: Kernel, set: InstructionSet) -> Particles<f64, D> {
    let mut pair = settings(kernel, D, if kernel == Kernel::WendlandC2 { 1.5 } else { 1.0 });
    pair.lanes = set;
    let mut flow = Particles::<f64, D>::lattice(pair, [12; D], false);
    flow.stir(0.2, 0.0);
    for row in 0..flow.particles.len() {
        let x = flow.particles.position_of(row);
        for d in 0..D {
            flow.particles.velocity[d][row] = velocity(x)[d];
        }
        flow.particles.pressure[row] = 100.0 * height(x);
        flow.particles.density[row] = WATER.reference_density + height(x);
        flow.particles.zone[row] = match flow.particles.id[row] {
            id if id % 7 == 3 => Zone::Wall,
            _ if x.x > OUTLET => Zone::Outflow,
            _ => Zone::Fluid,
        };
        if flow.particles.zone[row] != Zone::Fluid {
            flow.particles.pressure[row] = 1e5;
            flow.particles.velocity[0][row] = -77.0;
        }
    }
    flow
}

fn height(x: DVec3) -> f64 {
    3.0 - 7.0 * (x.x + 0.3) + 4.0 * x.y - 2.0 * x.z
}

fn velocity(x: DVec3) -> DVec3 {
    DVec3::new(2.0 * x.y + 0.5, 5.0 * x.x - x.y + 3.0 * x.z, 4.0 * x.x)
}

fn check<const D: usize>(kernel: Kernel, set: InstructionSet) {
    let flow = linear_flow::<D>(kernel, set);
    let tags: Vec<f32> = vec![0.7; flow.particles.len()];
    let sampler = RowSampler {
        grid: &flow.grid,
        particles: &flow.particles,
        pair: &flow.pair,
        tags: &tags,
        sides: None,
    };
    let rows = rows([12; D]);
    let curl = if D == 2 { DVec3::Z * 3.0 } else { DVec3::new(-3.0, -4.0, 3.0) };
    for (row, found) in rows.iter().zip(sampled(&sampler, &rows)) {
        assert!(found[5].pressure.is_nan() && found[5].fraction == 0.0, "the node is left out");
        for (node, field) in found.iter().enumerate().filter(|&(node, _)| is_checked(row, node)) {
            let x = point(row, node);
            let near = |found: f64, expected: f64, tolerance: f64| {
                assert!((found - expected).abs() < tolerance, "{found}, not {expected}, at {x}");
            };
            for d in 0..D {
                near(field.velocity[d], velocity(x)[d], 1e-10);
            }
            (0..3).for_each(|d| near(field.vorticity[d], curl[d], 1e-7));
            near(field.pressure, 100.0 * height(x), 1e-8);
            near(field.density, WATER.reference_density + height(x), 1e-8);
            // A constant is exact.
            assert_eq!(field.tag, f64::from(0.7_f32));
        }
    }
}

#[test]
fn linear_fields_are_exact_next_to_walls_and_openings() {
    for set in InstructionSet::available() {
        for kernel in Kernel::ALL {
            check::<2>(kernel, set);
            check::<3>(kernel, set);
        }
    }
}

fn agree<const D: usize>() {
    let mut flow = linear_flow::<D>(Kernel::WendlandC2, InstructionSet::best());
    flow.stir(0.1, 1.0);
    let sampler =
        RowSampler { grid: &flow.grid, particles: &flow.particles, pair: &flow.pair, tags: &[], sides: None };
    let probe = Sampler::new(&flow.grid, &flow.particles, &flow.pair, |zone| zone == Zone::Fluid);
    let rows = rows([12; D]);
    for (row, found) in rows.iter().zip(sampled(&sampler, &rows)) {
        // In the corners one of them may be linear: each has its own bound of the gain.
        let is_far = |node: usize| (0..D).all(|d| point(row, node)[d] > -0.3 + 1.2 * SPACING);
        let checked = |&(node, _): &(usize, &NodeFields)| is_checked(row, node) && is_far(node);
        for (node, field) in found.iter().enumerate().filter(checked) {
            let expected = probe.sample(&[point(row, node)])[0].expect("fluid");
            let velocity = DVec3::from_array(field.velocity);
            assert!((velocity - expected.velocity).length() < 1e-9, "{field:?}, not {expected:?}");
            assert!((field.pressure - expected.pressure).abs() < 1e-6 * expected.pressure.abs());
        }
    }
}

#[test]
fn nodes_agree_with_the_samples_of_probes() {
    agree::<2>();
    agree::<3>();
}

#[test]
fn a_group_of_nodes_in_a_periodic_box_sees_the_images() {
    let mut flow = Particles::<f64, 2>::lattice(settings(Kernel::WendlandC2, 2, 1.5), [9, 7], true);
    flow.stir(0.1, 0.0);
    for row in 0..flow.particles.len() {
        flow.particles.velocity[0][row] = 0.3;
    }
    let sampler =
        RowSampler { grid: &flow.grid, particles: &flow.particles, pair: &flow.pair, tags: &[], sides: None };
    let row = |y: f64| NodeRow {
        start: DVec3::new(-0.3, -0.3 + y, 0.0),
        step: DVec3::X * 0.5 * SPACING,
        wanted: vec![true; 18],
    };
    for field in sampled(&sampler, &[row(0.0), row(6.9 * SPACING)]).iter().flatten() {
        assert_eq!((field.velocity[0], field.vorticity), (0.3, [0.0; 3]));
        assert!((field.fraction - 1.0).abs() < 0.05, "{}", field.fraction);
    }
}

#[test]
fn the_fraction_is_one_at_a_wall_and_half_at_a_free_surface() {
    let mut flow = Particles::<f64, 2>::lattice(settings(Kernel::WendlandC2, 2, 1.5), [20, 20], false);
    for row in 0..flow.particles.len() {
        if flow.particles.position[1][row] < -0.3 + 4.0 * SPACING {
            flow.particles.zone[row] = Zone::Wall;
        }
    }
    let sampler =
        RowSampler { grid: &flow.grid, particles: &flow.particles, pair: &flow.pair, tags: &[], sides: None };
    let at = |height: f64| NodeRow {
        start: DVec3::new(-0.3 + 9.7 * SPACING, -0.3 + height * SPACING, 0.0),
        step: DVec3::X * SPACING,
        wanted: vec![true; 2],
    };
    let found = sampled(&sampler, &[at(4.0), at(12.0), at(20.0), at(25.0)]);
    let fraction = |row: usize| found[row][0].fraction;
    assert!((fraction(0) - 1.0).abs() < 0.02 && (fraction(1) - 1.0).abs() < 0.02, "{found:?}");
    assert!((fraction(2) - 0.5).abs() < 0.02 && fraction(3) == 0.0, "{found:?}");
    assert!(found[3][0].velocity[0].is_nan());
}

#[test]
fn nodes_are_bitwise_independent_of_threads() {
    let mut flow = Particles::<f32, 2>::lattice(settings(Kernel::WendlandC2, 2, 1.5), [20; 2], false);
    flow.stir(0.2, 0.1);
    flow.density();
    let sampler =
        RowSampler { grid: &flow.grid, particles: &flow.particles, pair: &flow.pair, tags: &[], sides: None };
    let rows = rows([20; 2]);
    let on_threads = |count: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build().expect("a pool");
        let found = pool.install(|| sampled(&sampler, &rows));
        found.into_iter().flatten().map(|field| format!("{field:?}")).collect::<Vec<_>>()
    };
    assert_eq!(on_threads(1), on_threads(3));
}
