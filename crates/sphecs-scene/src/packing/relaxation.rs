//! Relaxation of particles until the fluid has the same density everywhere.
//!
//! ```text
//! x_i ← x_i − β h² Σ_j V ∇W_ij,   V = Δ^D
//! ```
//!
//! This is the packing of Colagrossi et al. (2012) with the kernel of the scene and without
//! inertia: particles go down the gradient of their concentration, C_i = Σ_j V W_ij, as they do in
//! the shifting of a run. Wall and zone particles stay where they are. Sums run over sorted cells
//! in a fixed order, so the result does not depend on the number of threads.

use glam::DVec3;
use rayon::iter::{
    IndexedParallelIterator, IntoParallelRefIterator, IntoParallelRefMutIterator, ParallelIterator,
};

use crate::near_points::{NearPoints, Region};
use sphecs_core::discretisation::Discretisation;
use sphecs_core::math::kernel::{KernelShape, WithShape};
use sphecs_core::math::lanes::Array;

/// Step of the relaxation β.
const STEP: f64 = 0.4;

/// Largest displacement in the first step, in spacings.
const MOST: f64 = 0.1;

/// Largest displacement, in spacings, at which the particles are at rest.
const AT_REST: f64 = 2e-3;

/// Largest number of steps.
const MOST_STEPS: u32 = 100;

/// Gradient of the concentration at a point.
struct Gradient<'a, const D: usize> {
    sorted: &'a NearPoints<D>,
    point: DVec3,
    lengths: &'a Discretisation,
}

impl<const D: usize> WithShape for Gradient<'_, D> {
    /// The gradient, 1/m.
    type Output = DVec3;

    fn run<K: KernelShape>(self) -> DVec3 {
        let mut sums = [0.0; D];
        let inverse = 1.0 / self.lengths.smoothing_length;
        self.sorted.for_each_near(self.point, |way, distance| {
            let q = distance * inverse;
            let Array([slope]) = K::slope(Array([q]), Array([1.0 / q.max(f64::MIN_POSITIVE.sqrt())]));
            for axis in 0..D {
                sums[axis] += way[axis] * slope;
            }
        });
        let mut gradient = DVec3::ZERO;
        (0..D).for_each(|axis| gradient[axis] = sums[axis]);
        let scale = K::norm(D) * K::SLOPE_NORM * inverse.powi(D as i32 + 2) * self.lengths.cell_volume();
        scale * gradient
    }
}

/// Returns the concentration C at some points amid particles, m.
pub(super) fn concentrations<const D: usize>(
    points: &[DVec3],
    particles: &[DVec3],
    region: &Region,
    lengths: &Discretisation,
) -> Vec<f64> {
    let mut sorted = NearPoints::<D>::new(region, lengths.support);
    sorted.sort(particles.iter().copied());
    let concentration = |point: &DVec3| {
        let mut sum = 0.0;
        let (kernel, h) = (lengths.kernel, lengths.smoothing_length);
        sorted.for_each_near(*point, |_, distance| sum += kernel.value(D, h, distance));
        lengths.cell_volume() * sum
    };
    points.par_iter().map(concentration).collect()
}

/// Moves particles amid others that are fixed until their concentration is even.
///
/// `held` takes a point and a bound of its signed distance behind the walls, m, and returns the
/// point before walls and openings with its bound.
pub(super) fn relax<const D: usize>(
    moving: &mut [DVec3],
    fixed: &[DVec3],
    region: &Region,
    lengths: &Discretisation,
    held: impl Fn(DVec3, f64) -> (DVec3, f64) + Sync,
) {
    let spacing = lengths.spacing;
    let mut sorted = NearPoints::<D>::new(region, lengths.support);
    // Upper bounds of the distances behind the walls, m.
    let mut bounds = vec![f64::INFINITY; moving.len()];
    for step in 0..MOST_STEPS {
        // Ever smaller steps, so that particles between fixed ones do not swing.
        let most = MOST * spacing * (1.0 - f64::from(step) / f64::from(MOST_STEPS));
        sorted.sort(moving.iter().chain(fixed).copied());
        let largest = moving
            .par_iter_mut()
            .zip(bounds.par_iter_mut())
            .map(|(point, bound)| {
                let gradient =
                    lengths.kernel.with_shape(Gradient { sorted: &sorted, point: *point, lengths });
                let step = -STEP * lengths.smoothing_length.powi(2) * gradient;
                let step = step.clamp_length_max(most);
                let (to, behind) = held(*point + step, *bound + step.length());
                let moved = to.distance(*point);
                (*point, *bound) = (region.wrapped(to), behind);
                moved
            })
            .reduce(|| 0.0, f64::max);
        if largest < AT_REST * spacing {
            break;
        }
    }
}
