//! Floating-point operations of an ordered pair in one step, counted from the source of the loops.
//!
//! +, −, ×, ÷ and √ count one each, a multiply-add two; comparisons, magnitudes and selections
//! count nothing. √x with 1/√x is a root and a division, whatever the instructions. The counts of a
//! loop are for Wendland's kernel. Candidates outside the support, packing, the end of a row and
//! distances that only find neighbours are omitted: the fraction of the peak is of useful work.
//!
//! The tests run the passes over numbers that count their operations, and obtain these counts.

use sphecs_core::math::kernel::Kernel;
use sphecs_core::math::symmetric::components;
use sphecs_core::physics::viscosity::reconstructed::NoiseDamping;
use sphecs_scene::model::{Scene, Scheme};

/// Returns the operations of the loop in `pass/density.rs`: x_ab and r² 3 D, 1/r and r 2, w(q) 7,
/// the sum 1.
pub const fn density(dimensions: usize) -> usize {
    3 * dimensions + 10
}

/// Returns the operations of the basic loop in `pass/rates/row.rs`.
pub const fn rates(dimensions: usize) -> usize {
    // x_ab, v_ab and r² 4 D, 1/r and r 2, F 4, the shared division and its products 10, x·v and the
    // signal 2 D, divergence 3, pressure 2, viscous factor and damping 2, acceleration 4 D,
    // shifting 2 D.
    12 * dimensions + 23
}

/// Operations added by walls to the rates: the image factor 2, its use in the divergence and in the
/// viscous term 2.
///
/// They count for rows with a wall in their support in the basic loop, and for all rows in the
/// other loops.
pub const WALLS: usize = 4;

/// Operations added by walls to the gradients: the image factor.
pub const WALLS_IN_GRADIENTS: usize = 2;

/// Returns the operations added by the damping of noise to the rates.
pub const fn damping(dimensions: usize) -> usize {
    // S_a + S_b by component, x·S·x 2 D² + 2 D − 1, (c_a + c_b)/(ρ_a + ρ_b) 3, the rest 7.
    components(dimensions) + 2 * dimensions * dimensions + 2 * dimensions + 9
}

/// Returns the operations added by shifting with drift correction to the sums of
/// `pass/strain/row.rs`: the volume 1, ∇C 2 D.
pub const fn concentration_gradient(dimensions: usize) -> usize {
    2 * dimensions + 1
}

/// Operations added by the drift correction to the rates: w(q) 7, weight and sum of the weights 2;
/// its sum replaces that of shifting.
pub const NET_SHIFT: usize = 9;

/// Returns the operations added by sub-particle stress to the rates: T_a + T_b by component, T·x 2
/// D², its scale 1, acceleration 2 D.
pub const fn stress(dimensions: usize) -> usize {
    components(dimensions) + 2 * dimensions * dimensions + 2 * dimensions + 1
}

/// Returns the operations of the loop in `pass/gradients.rs`.
pub const fn gradients(dimensions: usize) -> usize {
    // x_ab, v_ab and r² 4 D, 1/r and r 2, F 4, volume 2, the factors of the sums 3 D, gradient and
    // moments 2 D² each.
    4 * dimensions * dimensions + 7 * dimensions + 8
}

/// Returns the operations of the loop in `pass/strain/row.rs`, density included.
pub const fn density_and_strain(dimensions: usize) -> usize {
    // density 3 D + 10, F 5, x_ab once more, v_ab and the factors of the sums 4 D, the sums
    // themselves 2 D + 1, gradient 2 D², moments D² + D.
    3 * dimensions * dimensions + 10 * dimensions + 16
}

/// Returns the operations of the basic loop in `pass/edac/row.rs`.
pub const fn evolved_rates(dimensions: usize) -> usize {
    // x_ab, v_ab and r² 4 D, 1/r and r 2, F 4, the shared division and its products 5, weight 4,
    // x·v and w·x 4 D − 2, divergence 3, difference and mean 3, viscous factor, diffusion and
    // damping 4, pressure 1, the neighbour's stress 3, acceleration 6 D, background 2 D.
    16 * dimensions + 27
}

/// Operations added by walls to these rates: the image factor 2, its use in the viscous term 1.
pub const WALLS_IN_EVOLVED: usize = 3;

/// Returns the operations of a kernel value beyond the 7 of Wendland's kernel.
pub const fn value_beyond_wendland(kernel: Kernel) -> usize {
    match kernel {
        Kernel::WendlandC2 => 0,
        Kernel::QuinticSpline => 9,
    }
}

/// Returns the operations of a kernel slope beyond the 4 of Wendland's kernel.
pub const fn slope_beyond_wendland(kernel: Kernel) -> usize {
    match kernel {
        Kernel::WendlandC2 => 0,
        Kernel::QuinticSpline => 10,
    }
}

/// Returns the operations of a step of a scene with Fickian or local shifting, or an evolved
/// pressure, and without artificial viscosity.
pub fn per_pair(scene: &Scene) -> usize {
    let dimensions = scene.dimensions;
    let kernel = scene.scheme.kernel();
    let slope = slope_beyond_wendland(kernel);
    let of_kernel = value_beyond_wendland(kernel) + slope;
    if let Scheme::EdacTvf(_) = scene.scheme {
        let walls = if scene.layout.walled { WALLS_IN_EVOLVED } else { 0 };
        return density(dimensions) + evolved_rates(dimensions) + of_kernel + walls;
    }
    let is_damped = scene.scheme.wcsph().is_some_and(|scheme| scheme.noise_damping != NoiseDamping::Off);
    let carries = scene.scheme.wcsph().is_some_and(|scheme| scheme.shifting.carries_velocity());
    let is_net = scene.scheme.wcsph().is_some_and(|scheme| !scheme.shifting.keeps_drift());
    let has_stress = scene.scheme.has_stress();
    let has_walls = scene.layout.walled;
    // In the basic loop few rows have walls nearby.
    let counts_walls = has_walls && (has_stress || is_net);
    let mut operations = of_kernel + rates(dimensions) + if counts_walls { WALLS } else { 0 };
    operations += if is_damped || carries || is_net {
        density_and_strain(dimensions) + slope
    } else {
        density(dimensions)
    };
    if is_net {
        operations += concentration_gradient(dimensions) + NET_SHIFT + value_beyond_wendland(kernel);
    }
    if has_stress {
        operations += gradients(dimensions) + stress(dimensions) + slope;
        operations += if has_walls { WALLS_IN_GRADIENTS } else { 0 };
    }
    if is_damped {
        operations += damping(dimensions);
    }
    operations
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::fmt::{Display, Formatter};
    use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

    use glam::DVec3;

    use super::*;
    use sphecs_core::discretisation::Discretisation;
    use sphecs_core::math::column::{Column, Element};
    use sphecs_core::math::grid::CellGrid;
    use sphecs_core::math::lanes::{Array, InstructionSet, Vectorised};
    use sphecs_core::math::real::Real;
    use sphecs_core::particles::arrays::{ParticleArrays, SpareColumns};
    use sphecs_core::particles::rows::ParticleRow;
    use sphecs_core::particles::zone::Zone;
    use sphecs_core::pass::density::sum_density;
    use sphecs_core::pass::edac;
    use sphecs_core::pass::gradients::sum_gradients;
    use sphecs_core::pass::rates::{TimeLevel, sum_rates};
    use sphecs_core::pass::settings::{PairSettings, PressureLaw, WallPartSettings};
    use sphecs_core::pass::strain::sum_density_and_strain;
    use sphecs_core::pass::stress::find_stress;
    use sphecs_core::pass::sums::PairSums;
    use sphecs_core::physics::edac::Edac;
    use sphecs_core::physics::eos::Tait;
    use sphecs_core::physics::shifting::{DriftCorrection, Local, Shifting};
    use sphecs_core::physics::viscosity::{Sps, Viscosity};

    thread_local! {
        static OPERATIONS: Cell<usize> = const { Cell::new(0) };
    }

    /// Number that counts its operations.
    #[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd, bytemuck::Pod, bytemuck::Zeroable)]
    #[repr(transparent)]
    struct Counted(f64);

    impl Counted {
        fn of_operation(value: f64) -> Self {
            OPERATIONS.set(OPERATIONS.get() + 1);
            Self(value)
        }
    }

    macro_rules! operators {
        ($($operator:ident $function:ident $sign:tt),*) => { $(
            impl $operator for Counted {
                type Output = Self;
                fn $function(self, other: Self) -> Self {
                    Self::of_operation(self.0 $sign other.0)
                }
            }
        )* };
    }
    operators!(Add add +, Sub sub -, Mul mul *, Div div /);

    impl AddAssign for Counted {
        fn add_assign(&mut self, other: Self) {
            *self = *self + other;
        }
    }

    impl SubAssign for Counted {
        fn sub_assign(&mut self, other: Self) {
            *self = *self - other;
        }
    }

    impl Neg for Counted {
        type Output = Self;
        fn neg(self) -> Self {
            Self(-self.0)
        }
    }

    impl Display for Counted {
        fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
            self.0.fmt(f)
        }
    }

    impl Element for Counted {
        fn into_column(values: Vec<Self>) -> Column {
            Column::F64(values.into_iter().map(|value| value.0).collect())
        }

        fn from_column(column: Column) -> Option<Vec<Self>> {
            f64::from_column(column).map(|values| values.into_iter().map(Counted).collect())
        }
    }

    impl Real for Counted {
        fn from_f64(value: f64) -> Self {
            Self(value)
        }
        fn to_f64(self) -> f64 {
            self.0
        }
        fn abs(self) -> Self {
            Self(self.0.abs())
        }
        fn sqrt(self) -> Self {
            Self::of_operation(self.0.sqrt())
        }
        fn dispatch<T: Vectorised<Self>>(_: InstructionSet, task: T) -> T::Output {
            task.run::<Array<Self, 1>>()
        }
    }

    /// Passes over some particles.
    type Passes<const D: usize> =
        fn(&PairSettings, &CellGrid<D>, &mut ParticleArrays<Counted, D>, &mut PairSums<Counted, D>);

    /// Returns the operations of finding neighbours before the sums, in 2D only: x_ab and r².
    fn finding(dimensions: usize) -> usize {
        if dimensions < 3 { 3 * dimensions } else { 0 }
    }

    /// Returns the operations of passes for each ordered pair.
    ///
    /// With all particles in one cell the count is a parabola of their number, and its curvature is
    /// due to pairs.
    fn of_pair<const D: usize>(settings: &PairSettings, passes: Passes<D>) -> usize {
        let counts = [8, 9, 10].map(|particles| of_all(settings, particles, passes));
        let curvature = counts[2] + counts[0] - 2 * counts[1];
        assert_eq!(curvature % 2, 0);
        curvature / 2
    }

    /// Returns the operations of passes over some particles in one cell, with a wall particle if
    /// the settings have walls.
    fn of_all<const D: usize>(pair: &PairSettings, particles: usize, passes: Passes<D>) -> usize {
        let upper = [0.9 * pair.discretisation.cell_size(); D];
        let mut grid = CellGrid::new(
            [0.0; D],
            upper,
            [false; D],
            pair.discretisation.support,
            pair.discretisation.cell_size(),
        );
        let mut arrays = ParticleArrays::<Counted, D> {
            evolves_pressure: matches!(pair.pressure, PressureLaw::Evolved(_)),
            drifts: matches!(pair.pressure, PressureLaw::Evolved(_)),
            ..Default::default()
        };
        let wall_distance = if pair.wall_parts.is_empty() { f64::INFINITY } else { 0.005 };
        for id in 0..particles as u32 {
            let mut row = ParticleRow { id, density: 1000.0, wall_distance, ..Default::default() };
            for d in 0..D {
                let noise = (0.37 + 0.618 * f64::from(id) + 0.271 * f64::from(id).powi(2 + d as i32)).fract();
                row.position[d] = noise * upper[d];
                row.velocity[d] = noise - 0.5;
            }
            arrays.push(&row);
        }
        if !pair.wall_parts.is_empty() {
            let position = DVec3::splat(0.3 * upper[0]);
            let zone = Zone::Wall;
            arrays.push(&ParticleRow {
                id: 100,
                zone,
                density: 1000.0,
                wall_distance: 0.005,
                position,
                ..Default::default()
            });
        }
        let order = grid.build(&arrays.position, &arrays.id, |_| true).expect("inside");
        arrays.reorder(order, &mut SpareColumns::default());
        let mut sums = PairSums::default();
        // Columns that a pass reads from the passes before it in a step.
        sum_density_and_strain(pair, &grid, &mut arrays, TimeLevel::Present, &mut sums);
        sum_gradients(pair, &grid, &arrays, TimeLevel::Present, &mut sums);
        find_stress(pair, &grid, &arrays, &mut sums);
        OPERATIONS.set(0);
        passes(pair, &grid, &mut arrays, &mut sums);
        OPERATIONS.get()
    }

    fn check<const D: usize>() {
        let tait = Tait { reference_density: 1000.0, sound_speed: 10.0 };
        let discretisation = Discretisation::new(Kernel::WendlandC2, D, 0.01, 2.0, tait.reference_density);
        let plain = PairSettings::new(&discretisation, tait);
        let damped = PairSettings { noise_damping: 0.4, ..plain.clone() };
        let sps = Viscosity::Sps(Sps::default());
        let stressed = PairSettings { viscous_term: sps, ..plain.clone() };
        let walled = |pair: &PairSettings| PairSettings {
            wall_parts: [WallPartSettings::default()].into(),
            ..pair.clone()
        };
        let rates_of = |pair: &PairSettings| {
            of_pair::<D>(pair, |pair, grid, arrays, sums| {
                sum_rates(pair, grid, arrays, TimeLevel::Present, sums);
            })
        };
        assert_eq!(of_pair::<D>(&plain, sum_density), density(D), "density in {D}D");
        assert_eq!(rates_of(&plain), rates(D), "rates in {D}D");
        assert_eq!(rates_of(&damped), rates(D) + damping(D), "damped rates in {D}D");
        assert_eq!(rates_of(&stressed), rates(D) + stress(D), "rates with stress in {D}D");
        assert_eq!(
            rates_of(&walled(&damped)),
            rates(D) + damping(D) + WALLS,
            "damped rates with walls in {D}D"
        );
        assert_eq!(
            rates_of(&walled(&stressed)),
            rates(D) + stress(D) + WALLS,
            "rates with stress and walls in {D}D"
        );
        let gradients_of = |pair: &PairSettings| {
            of_pair::<D>(pair, |pair, grid, arrays, sums| {
                sum_gradients(pair, grid, arrays, TimeLevel::Present, sums);
            })
        };
        assert_eq!(gradients_of(&stressed), gradients(D), "gradients in {D}D");
        let with_walls = gradients(D) + WALLS_IN_GRADIENTS;
        assert_eq!(gradients_of(&walled(&stressed)), with_walls, "gradients with walls in {D}D");
        let of_strain = of_pair::<D>(&damped, |pair, grid, arrays, sums| {
            sum_density_and_strain(pair, grid, arrays, TimeLevel::Present, sums);
        });
        assert_eq!(of_strain, density_and_strain(D) + finding(D), "density with strain in {D}D");
        let shifting = Shifting::Local(Local { coefficient: 32.0, drift_correction: DriftCorrection::On });
        let net = walled(&PairSettings { shifting, ..damped.clone() });
        assert_eq!(rates_of(&net), rates(D) + damping(D) + WALLS + NET_SHIFT, "net rates in {D}D");
        let with_concentration_gradient = of_pair::<D>(&net, |pair, grid, arrays, sums| {
            sum_density_and_strain(pair, grid, arrays, TimeLevel::Present, sums);
        });
        let expected = density_and_strain(D) + concentration_gradient(D) + finding(D);
        assert_eq!(with_concentration_gradient, expected, "density with strain and ∇C in {D}D");
        let evolved = PairSettings { pressure: PressureLaw::Evolved(Edac::default()), ..plain.clone() };
        let evolved_of = |pair: &PairSettings| {
            of_pair::<D>(pair, |pair, grid, arrays, sums| {
                edac::sum_rates(pair, &Edac::default(), grid, arrays, sums);
            })
        };
        assert_eq!(of_pair::<D>(&evolved, sum_density), density(D), "volumes in {D}D");
        assert_eq!(evolved_of(&evolved), evolved_rates(D), "evolved rates in {D}D");
        let with_walls = evolved_rates(D) + WALLS_IN_EVOLVED;
        assert_eq!(evolved_of(&walled(&evolved)), with_walls, "evolved rates with walls in {D}D");
        let quintic = |pair: &PairSettings| {
            let discretisation = Discretisation { kernel: Kernel::QuinticSpline, ..pair.discretisation };
            PairSettings { discretisation, ..pair.clone() }
        };
        let value = value_beyond_wendland(Kernel::QuinticSpline);
        let slope = slope_beyond_wendland(Kernel::QuinticSpline);
        assert_eq!(of_pair::<D>(&quintic(&plain), sum_density), density(D) + value + finding(D));
        assert_eq!(rates_of(&quintic(&plain)), rates(D) + slope);
        assert_eq!(evolved_of(&quintic(&evolved)), evolved_rates(D) + slope);
    }

    #[test]
    fn counts_match_the_loops() {
        // One thread, since the counter is thread-local.
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
        pool.install(|| {
            check::<2>();
            check::<3>();
        });
    }
}
