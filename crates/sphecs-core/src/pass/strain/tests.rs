//! Gradients of linear flows, and what a shift without drift leaves of a wave.

use super::*;
use crate::math::kernel::Kernel;
use crate::math::lanes::InstructionSet;
use crate::math::symmetric::component;
use crate::pass::column_access::AfterPasses;
use crate::pass::samples::{SPACING, Sample, settings};
use crate::physics::shifting::{DriftCorrection, Local, Shifting};

const SLOPES: [[f64; 3]; 3] = [[1.0, -2.0, 0.5], [3.0, 0.2, 0.0], [-1.0, 0.7, 2.0]];

/// A disordered linear flow whose lowest layers are a wall at rest.
fn check<const D: usize>(kernel: Kernel, counts: [usize; D]) {
    for lanes in InstructionSet::available() {
        let pair = PairSettings { lanes, ..settings(kernel, D, 1.3) };
        let mut sample = Sample::<f64, D>::lattice(pair, counts, false);
        sample.stir(0.2, 0.0);
        for row in 0..sample.particles.len() {
            let point: [f64; D] = std::array::from_fn(|d| sample.particles.position[d][row]);
            if point[1] + 0.3 < 2.0 * SPACING {
                sample.particles.zone[row] = Zone::Wall;
                continue;
            }
            for i in 0..D {
                let velocity = 0.3 + (0..D).map(|j| SLOPES[i][j] * point[j]).sum::<f64>();
                sample.particles.velocity[i][row] = velocity;
                sample.particles.previous_velocity[i][row] = -2.0 * velocity;
            }
        }
        sample.density();
        let density = sample.particles.density.clone();
        sample.particles.density.fill(0.0);
        for (level, factor) in [(TimeLevel::Present, 1.0), (TimeLevel::Previous, -2.0)] {
            let Sample { pair, grid, particles, sums, .. } = &mut sample;
            sum_density_and_strain(pair, grid, particles, level, sums);
            for row in (0..particles.len()).filter(|&row| particles.zone[row] == Zone::Fluid) {
                // Other vectors of the same neighbours.
                assert!((particles.density[row] / density[row] - 1.0).abs() < 1e-14);
                for i in 0..D {
                    for j in 0..=i {
                        let expected = 0.5 * factor * (SLOPES[i][j] + SLOPES[j][i]);
                        let found = sums.strain.read(AfterPasses)[component::<D>(i, j)][row];
                        assert!((found - expected).abs() < 1e-11, "S_{i}{j} = {found}");
                    }
                }
            }
        }
    }
}

#[test]
fn strain_of_a_linear_flow_is_exact_beside_walls_and_faces_and_density_is_the_same() {
    for kernel in Kernel::ALL {
        check(kernel, [13, 9]);
        check(kernel, [7, 6, 6]);
    }
}

/// Returns ∇C and shifting vectors of a periodic lattice, stretched and compressed along x by
/// `amplitude` Δ sin(k x) and disordered by `noise` Δ.
fn shifts(drift_correction: DriftCorrection, amplitude: f64, noise: f64) -> [Vec<[f64; 2]>; 2] {
    let shifting = Shifting::Local(Local { coefficient: 32.0, drift_correction });
    let pair = PairSettings { shifting, ..settings(Kernel::WendlandC2, 2, 1.5) };
    let mut sample = Sample::<f64, 2>::lattice(pair, [24, 12], true);
    let wave = 2.0 * std::f64::consts::PI / (24.0 * SPACING);
    for x in &mut sample.particles.position[0] {
        *x += amplitude * SPACING * (wave * *x).sin();
    }
    sample.stir(noise, 0.0);
    // Twice: the second has the volumes of this arrangement, as if nobody had moved in a step.
    sample.strain();
    sample.strain();
    sample.rates();
    let of = |columns: &[Vec<f64>; 2], row: usize| columns.each_ref().map(|column| column[row]);
    let rows = || (0..24 * 12).map(|id| sample.row(id));
    let concentration_gradient = if drift_correction == DriftCorrection::Off {
        sample.sums.shift.read(AfterPasses)
    } else {
        sample.sums.concentration_gradient.read(AfterPasses)
    };
    [
        rows().map(|row| of(concentration_gradient, row)).collect(),
        rows().map(|row| of(sample.sums.shift.read(AfterPasses), row)).collect(),
    ]
}

fn size(shifts: &[[f64; 2]]) -> f64 {
    (shifts.iter().flatten().map(|x| x * x).sum::<f64>() / shifts.len() as f64).sqrt()
}

#[test]
fn the_gradient_of_the_concentration_is_that_of_the_rates_when_nobody_has_moved() {
    let [concentration_gradient, _] = shifts(DriftCorrection::On, 0.1, 0.2);
    let [shift, _] = shifts(DriftCorrection::Off, 0.1, 0.2);
    for (concentration_gradient, shift) in concentration_gradient.iter().zip(&shift) {
        for d in 0..2 {
            assert!(
                (concentration_gradient[d] - shift[d]).abs()
                    < 1e-12 * size(std::slice::from_ref(shift)).max(1.0)
            );
        }
    }
}

#[test]
fn drift_correction_removes_long_waves_of_the_shift_and_keeps_short_ones() {
    let [concentration_gradient, removed] = shifts(DriftCorrection::On, 0.3, 0.0);
    let share = size(&removed) / size(&concentration_gradient);
    // 1 − Ŵ(k) of Wendland's kernel with h = 1.5 Δ and a wave of 24 Δ.
    assert!((0.01..0.06).contains(&share), "{share}");
    let [[_, kept], [_, removed]] =
        [DriftCorrection::Off, DriftCorrection::On].map(|drift| shifts(drift, 0.0, 0.2));
    let along = kept.iter().zip(&removed).map(|(a, b)| a[0] * b[0] + a[1] * b[1]).sum::<f64>();
    let likeness = along / (kept.len() as f64 * size(&kept) * size(&removed));
    let share = size(&removed) / size(&kept);
    assert!(likeness > 0.9 && (0.7..1.05).contains(&share), "{likeness} {share}");
    for d in 0..2 {
        let [of_kept, of_removed] =
            [&kept, &removed].map(|all| all.iter().map(|s| s[d]).sum::<f64>() / all.len() as f64);
        assert!(of_removed.abs() < 0.02 * size(&removed), "{of_kept} {of_removed}");
    }
}

#[test]
fn a_particles_own_velocity_does_not_show_in_its_gradient_but_in_its_neighbours() {
    let shifting = Shifting::Local(Local { coefficient: 32.0, ..Local::default() });
    let pair = PairSettings { shifting, ..settings(Kernel::WendlandC2, 2, 1.3) };
    let mut sample = Sample::<f64, 2>::lattice(pair, [8, 8], true);
    sample.stir(0.2, 1.0);
    let (own, other) = (sample.row(27), sample.row(28));
    let gradients = |sample: &mut Sample<f64, 2>| {
        sample.strain();
        let gradient = sample.sums.neighbour_gradient.read(AfterPasses);
        [own, other].map(|row| [gradient[0][1][row], gradient[0][0][row], gradient[1][0][row]])
    };
    let before = gradients(&mut sample);
    sample.particles.velocity[0][own] += 3.0;
    let after = gradients(&mut sample);
    for (before, after) in before[0].iter().zip(after[0]) {
        assert!((before - after).abs() < 1e-12, "{before} and {after}");
    }
    assert!((before[1][1] - after[1][1]).abs() > 1.0);
    assert_eq!(
        sample.sums.strain.read(AfterPasses)[1][own],
        sample.sums.neighbour_gradient.read(AfterPasses)[1][1][own]
    );
}
