//! Velocity gradient of the flow, exact for linear fields.
//!
//! ```text
//! G_ij = Σ_b V_b (v_b − v_a)_i ∂W/∂x_j,   M_kj = −Σ_b V_b x_ab,k ∂W/∂x_j,
//! ∂v_i/∂x_j = Σ_k G_ik (M⁻¹)_kj
//! ```
//!
//! The sum is that of Alvarado-Rodríguez et al. (2017), section 2, with the correction of Bonet &
//! Lok (1999). So the gradient is exact even where the support is cut and on a coarse lattice.
//! Walls enter with their image velocities, so the gradient at a wall is that of the velocity
//! continued through it. Where M is singular (fewer neighbours than dimensions) the uncorrected sum
//! is kept.

use super::density::LEAST_Q2;
use super::pack::{NeighbourMask, Only, Pack, Source, Vector};
use super::rates::TimeLevel;
use super::row_pass::{PassInput, RowPass, splat};
use super::settings::PairSettings;
use super::sums::PairSums;
use super::wall_sides::{Behind, OwnSide, SideColumns};
use crate::math::grid::CellGrid;
use crate::math::kernel::KernelShape;
use crate::math::lanes::{Lanes, dot};
use crate::math::linear::invert;
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::physics::wall::image;

/// Largest number of columns besides the coordinates: velocity, density, image distance, normal and
/// facing in 3D.
const MOST_COLUMNS: usize = 3 + 2 + 3 + 3;

/// Columns of the neighbours that describe walls, after velocity and density.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum WallColumns {
    /// No walls: no column.
    None,
    /// The image distance.
    NoSlip,
    /// The image distance, negative at free-slip walls, and the wall normal.
    FreeSlip,
}

impl WallColumns {
    fn new(pair: &PairSettings, has_walls: bool) -> Self {
        match (has_walls, pair.has_free_slip()) {
            (false, _) => Self::None,
            (true, false) => Self::NoSlip,
            (true, true) => Self::FreeSlip,
        }
    }

    /// Returns the number of columns behind the coordinates, those of velocity and density
    /// included.
    fn columns(self, dimensions: usize) -> usize {
        let flow = dimensions + 1;
        match self {
            Self::None => flow,
            Self::NoSlip => flow + 1,
            Self::FreeSlip => flow + 1 + dimensions,
        }
    }
}

/// Writer of the velocity gradient.
#[derive(Debug)]
pub struct Gradients(());

/// Sums the velocity gradient of fluid, inflow and outflow particles over all particles, into
/// `sums.gradient`.
pub fn sum_gradients<R: Real, const D: usize>(
    pair: &PairSettings,
    grid: &CellGrid<D>,
    particles: &ParticleArrays<R, D>,
    level: TimeLevel,
    sums: &mut PairSums<R, D>,
) {
    sums.packs.prepare();
    let has_walls = sums.columns.find_images(pair, particles);
    let PairSums { gradient, near, velocity_seen, sides, columns, packs, .. } = sums;
    let gradient = gradient.write(Gradients(()));
    for column in gradient.iter_mut().flatten() {
        column.resize(particles.len(), R::default());
    }
    let sees_mean = has_walls && pair.wall_model.sees_kernel_mean();
    let velocity = if sees_mean { velocity_seen.read(Gradients(())) } else { level.columns(particles) };
    let mut neighbours: [&[R]; MOST_COLUMNS] = [&[]; MOST_COLUMNS];
    for d in 0..D {
        neighbours[d] = &velocity[d];
        neighbours[D + 2 + d] = &particles.wall_normal[d];
    }
    neighbours[D] = &particles.density;
    neighbours[D + 1] = &columns.image_distance;
    let walls = WallColumns::new(pair, has_walls);
    let mut count = walls.columns(D);
    let sides = sides.read(Gradients(()));
    let facing = (!sides.facing[0].is_empty()).then(|| {
        for (slot, column) in neighbours[count..].iter_mut().zip(&sides.facing) {
            *slot = column;
        }
        count += D;
        Vector(count)
    });
    let columns = &neighbours[..count];
    let input = PassInput { pair, grid, position: &particles.position, columns, only: Only::All, packs };
    let outputs = gradient.each_mut().map(|row| row.each_mut().map(Vec::as_mut_slice));
    input.run(&GradientPass { pair, particles, near, walls, sides, facing }, outputs);
}

struct GradientPass<'a, R: Real, const D: usize> {
    pair: &'a PairSettings,
    particles: &'a ParticleArrays<R, D>,
    near: &'a [NeighbourMask],
    walls: WallColumns,
    sides: &'a SideColumns<R, D>,
    /// Facing of the neighbours, only where a wall is thin.
    facing: Option<Vector>,
}

impl<'a, R: Real, const D: usize> RowPass<R, D> for GradientPass<'a, R, D> {
    type Outputs = [[&'a mut [R]; D]; D];
    /// The corrected gradient, 1/s.
    type Sum = [[f64; D]; D];

    #[inline(always)]
    fn includes(&self, row: usize) -> bool {
        self.particles.zone[row].flows()
    }

    #[inline(always)]
    fn sum<K: KernelShape, L: Lanes<Real = R>>(
        &self,
        pack: &Pack<R>,
        source: &Source<'_, R, D>,
        row: usize,
    ) -> [[f64; D]; D] {
        let (zero, one) = (L::constant(0.0), L::constant(1.0));
        let x_a = splat::<L, D>(pack.relative(source, row));
        let mut v_a = [zero; D];
        for d in 0..D {
            v_a[d] = L::splat(source.columns[d][row]);
        }
        let wall_distance = self.particles.wall_distance[row].to_f64();
        let model = self.pair.wall_model;
        let inverse_distance =
            L::constant(model.inverse_distance(wall_distance, self.pair.discretisation.spacing));
        let cap = L::constant(model.largest_factor());
        let (has_walls, free_slip) = (self.walls != WallColumns::None, self.walls == WallColumns::FreeSlip);

        let h = self.pair.discretisation.smoothing_length;
        let side = OwnSide::<L, D>::new(self.sides, row, wall_distance, h, None);

        let mut sum = [[zero; D]; D];
        let mut moment = [[zero; D]; D];
        let near = NeighbourMask::of_row(self.near, row);
        for entry in pack.masked_entries::<L, D>(D + source.columns.len(), near) {
            let mut x = [zero; D];
            let mut v = [zero; D];
            let mut q2 = L::constant(LEAST_Q2);
            for d in 0..D {
                x[d] = x_a[d] - entry.column(d);
                v[d] = v_a[d] - entry.column(D + d);
                q2 = x[d].mul_add(x[d], q2);
            }
            let (q, inverse_q) = q2.roots();
            let slope = K::slope(q, inverse_q);
            let volume_slope = slope * entry.column(2 * D).inverse();
            let mut factor = one;
            if has_walls {
                let mut distance = entry.column(2 * D + 1).abs();
                if let Some(facing) = self.facing {
                    let behind = Behind::new(&side, facing, entry, x);
                    v = side.relative_velocity(&behind, v_a, v);
                    distance = L::select(behind.mask(), behind.depth, distance);
                }
                factor = image::velocity_factor(distance, inverse_distance, cap);
            }
            if free_slip {
                let slips = entry.column(2 * D + 1).less(zero);
                let normal = entry.vector::<D>(2 * D + 2);
                let across = dot(normal, v);
                for d in 0..D {
                    v[d] = L::select(slips, across * normal[d], v[d]);
                }
            }
            for i in 0..D {
                let across = volume_slope * factor * v[i];
                let along = volume_slope * x[i];
                for j in 0..D {
                    sum[i][j] = across.mul_add(x[j], sum[i][j]);
                    moment[i][j] = along.mul_add(x[j], moment[i][j]);
                }
            }
        }
        corrected(self.pair, sum, moment)
    }

    #[inline(always)]
    fn store(&self, _row: usize, slot: usize, sum: [[f64; D]; D], gradient: &mut Self::Outputs) {
        for (columns, components) in gradient.iter_mut().zip(sum) {
            for (column, component) in columns.iter_mut().zip(components) {
                column[slot] = R::from_f64(component);
            }
        }
    }
}

/// Returns the gradient, 1/s, of the lane sums of G and M without their dimensions.
#[inline(always)]
fn corrected<L: Lanes, const D: usize>(
    pair: &PairSettings,
    sum: [[L; D]; D],
    moment: [[L; D]; D],
) -> [[f64; D]; D] {
    // m ∇W = scale · slope · x_ab/h; in the moments one more h.
    let h = pair.discretisation.smoothing_length;
    let scale = pair.discretisation.mass * pair.discretisation.slope_scale() / h;
    let mut uncorrected = [[0.0; D]; D];
    let mut moments = [[0.0; D]; D];
    for i in 0..D {
        for j in 0..D {
            uncorrected[i][j] = -scale * sum[i][j].sum().to_f64();
            moments[i][j] = -scale * h * moment[i][j].sum().to_f64();
        }
    }
    let Some(inverse) = invert(moments) else {
        return uncorrected;
    };
    let mut gradient = [[0.0; D]; D];
    for i in 0..D {
        for j in 0..D {
            gradient[i][j] = (0..D).map(|k| uncorrected[i][k] * inverse[k][j]).sum();
        }
    }
    gradient
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::kernel::Kernel;
    use crate::particles::zone::Zone;
    use crate::pass::column_access::AfterPasses;
    use crate::pass::samples::{SPACING, Sample, settings};
    use crate::pass::settings::WallPartSettings;

    const SLOPES: [[f64; 3]; 3] = [[1.0, -2.0, 0.5], [3.0, 0.2, 0.0], [-1.0, 0.7, 2.0]];

    fn linear<const D: usize>(point: [f64; D]) -> [f64; D] {
        std::array::from_fn(|i| 0.3 + (0..D).map(|j| SLOPES[i][j] * point[j]).sum::<f64>())
    }

    fn check<const D: usize>(kernel: Kernel, counts: [usize; D]) {
        // Not periodic: at the faces the support is cut.
        let mut sample = Sample::<f64, D>::lattice(settings(kernel, D, 1.3), counts, false);
        sample.stir(0.2, 0.0);
        for row in 0..sample.particles.len() {
            let point: [f64; D] = std::array::from_fn(|d| sample.particles.position[d][row]);
            let velocity = linear(point);
            for d in 0..D {
                sample.particles.velocity[d][row] = velocity[d];
            }
        }
        sum_gradients(&sample.pair, &sample.grid, &sample.particles, TimeLevel::Present, &mut sample.sums);
        for i in 0..D {
            for j in 0..D {
                for found in &sample.sums.gradient.read(AfterPasses)[i][j] {
                    assert!((found - SLOPES[i][j]).abs() < 1e-11, "∂v_{i}/∂x_{j} = {found}");
                }
            }
        }
    }

    #[test]
    fn gradient_of_a_linear_flow_is_exact_up_to_the_faces() {
        for kernel in Kernel::ALL {
            check(kernel, [13, 9]);
            check(kernel, [7, 5, 6]);
        }
    }

    #[test]
    fn gradient_is_that_of_the_requested_level() {
        let mut sample = Sample::<f64, 2>::lattice(settings(Kernel::WendlandC2, 2, 1.3), [9, 9], false);
        for row in 0..sample.particles.len() {
            sample.particles.previous_velocity[0][row] = 3.0 * sample.particles.position[1][row];
            sample.particles.velocity[0][row] = row as f64;
        }
        let level = TimeLevel::Previous;
        sum_gradients(&sample.pair, &sample.grid, &sample.particles, level, &mut sample.sums);
        for (found, expected) in [
            (&sample.sums.gradient.read(AfterPasses)[0][1], 3.0),
            (&sample.sums.gradient.read(AfterPasses)[0][0], 0.0),
        ] {
            assert!(found.iter().all(|found| (found - expected).abs() < 1e-11));
        }
    }

    /// A flow over a wall at rest whose velocity at height y above it is `velocity(y)`.
    fn over_a_wall(free_slip: bool, velocity: impl Fn(f64) -> [f64; 2]) -> Sample<f64, 2> {
        let part = WallPartSettings { free_slip, ..Default::default() };
        let pair = PairSettings { wall_parts: [part].into(), ..settings(Kernel::WendlandC2, 2, 1.3) };
        let mut sample = Sample::<f64, 2>::lattice(pair, [12, 12], false);
        for row in 0..sample.particles.len() {
            let height = sample.particles.position[1][row] + 0.3 - 4.0 * SPACING;
            sample.particles.wall_distance[row] = height.abs();
            sample.particles.wall_normal[1][row] = 1.0;
            if height < 0.0 {
                sample.particles.zone[row] = Zone::Wall;
            } else {
                [sample.particles.velocity[0][row], sample.particles.velocity[1][row]] = velocity(height);
            }
        }
        sum_gradients(&sample.pair, &sample.grid, &sample.particles, TimeLevel::Present, &mut sample.sums);
        sample
    }

    #[test]
    fn wall_images_continue_the_flow() {
        let sample = over_a_wall(false, |y| [3.0 * y, -2.0 * y]);
        let slip = over_a_wall(true, |y| [3.0, -2.0 * y]);
        for row in 0..sample.particles.len() {
            if sample.particles.zone[row] == Zone::Fluid {
                assert!((sample.sums.gradient.read(AfterPasses)[0][1][row] - 3.0).abs() < 1e-11);
                assert!((sample.sums.gradient.read(AfterPasses)[1][1][row] + 2.0).abs() < 1e-11);
                assert!(
                    slip.sums.gradient.read(AfterPasses)[0][1][row].abs() < 1e-11,
                    "a free-slip wall shears nothing"
                );
                assert!((slip.sums.gradient.read(AfterPasses)[1][1][row] + 2.0).abs() < 1e-11);
            }
        }
    }
}
