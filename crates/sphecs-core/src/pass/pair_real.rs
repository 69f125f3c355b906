//! The pair passes compiled for every precision and number of dimensions.
//!
//! The passes are generic, and a generic function is compiled in every crate that calls it: the
//! engine, its tests and the tools would each compile all vectorised loops again, which takes
//! minutes. The methods of [`PairReal`] are not generic, so the loops are compiled here, once.

use super::body::{Body, ExactBodySum};
use super::edac::EdacSummary;
use super::fits::PointFit;
use super::points::PointFlows;
use super::rates::{RatesSummary, TimeLevel};
use super::settings::PairSettings;
use super::sums::PairSums;
use super::waves::WaveFound;
use super::{
    density, edac, gradients, points, rates, strain, stress, wall_distance, wall_friction, wall_velocity,
    walls, waves,
};
use crate::math::grid::CellGrid;
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::physics::edac::Edac;
use crate::physics::wave_sums::WaveSetting;

/// Declares [`PairReal`] and implements it for `f32` and `f64` in 2D and 3D.
macro_rules! pair_passes {
    ($($module:ident::$pass:ident as fn $name:ident($($argument:ident: $kind:ty),* $(,)?) $(-> $result:ty)?;)*) => {
        /// Scalar with compiled pair passes in `D` dimensions: `f32` or `f64`, in 2D or 3D.
        ///
        /// Each method is the function of the same name in the module of its pass.
        pub trait PairReal<const D: usize>: Real {
            $(
                #[doc = concat!("Runs [`", stringify!($module), "::", stringify!($pass), "`].")]
                fn $name($($argument: $kind),*) $(-> $result)?;
            )*
        }
        pair_passes!(@implement f32, 2, $($module::$pass as fn $name($($argument: $kind),*) $(-> $result)?;)*);
        pair_passes!(@implement f32, 3, $($module::$pass as fn $name($($argument: $kind),*) $(-> $result)?;)*);
        pair_passes!(@implement f64, 2, $($module::$pass as fn $name($($argument: $kind),*) $(-> $result)?;)*);
        pair_passes!(@implement f64, 3, $($module::$pass as fn $name($($argument: $kind),*) $(-> $result)?;)*);
    };
    (@implement $real:ty, $dimensions:literal,
        $($module:ident::$pass:ident as fn $name:ident($($argument:ident: $kind:ty),*) $(-> $result:ty)?;)*) => {
        const _: () = {
            const D: usize = $dimensions;

            impl PairReal<D> for $real {
                $(
                    #[inline(never)]
                    fn $name($($argument: $kind),*) $(-> $result)? {
                        $module::$pass($($argument),*)
                    }
                )*
            }
        };
    };
}

pair_passes! {
    density::sum_density as fn sum_density(
        pair: &PairSettings,
        grid: &CellGrid<D>,
        particles: &mut ParticleArrays<Self, D>,
        sums: &mut PairSums<Self, D>,
    );
    strain::sum_density_and_strain as fn sum_density_and_strain(
        pair: &PairSettings,
        grid: &CellGrid<D>,
        particles: &mut ParticleArrays<Self, D>,
        level: TimeLevel,
        sums: &mut PairSums<Self, D>,
    );
    gradients::sum_gradients as fn sum_gradients(
        pair: &PairSettings,
        grid: &CellGrid<D>,
        particles: &ParticleArrays<Self, D>,
        level: TimeLevel,
        sums: &mut PairSums<Self, D>,
    );
    stress::find_stress as fn find_stress(
        pair: &PairSettings,
        grid: &CellGrid<D>,
        particles: &ParticleArrays<Self, D>,
        sums: &mut PairSums<Self, D>,
    );
    rates::sum_rates as fn sum_rates(
        pair: &PairSettings,
        grid: &CellGrid<D>,
        particles: &mut ParticleArrays<Self, D>,
        level: TimeLevel,
        sums: &mut PairSums<Self, D>,
    ) -> RatesSummary;
    rates::sum_body_force as fn sum_body_force(
        pair: &PairSettings,
        grid: &CellGrid<D>,
        particles: &ParticleArrays<Self, D>,
        level: TimeLevel,
        sums: &mut PairSums<Self, D>,
        body: &mut Body,
    ) -> ExactBodySum;
    edac::sum_rates as fn sum_edac_rates(
        pair: &PairSettings,
        edac: &Edac,
        grid: &CellGrid<D>,
        particles: &mut ParticleArrays<Self, D>,
        sums: &mut PairSums<Self, D>,
    ) -> EdacSummary;
    edac::sum_body_force as fn sum_edac_body_force(
        pair: &PairSettings,
        edac: &Edac,
        grid: &CellGrid<D>,
        particles: &ParticleArrays<Self, D>,
        sums: &mut PairSums<Self, D>,
        body: &mut Body,
    ) -> ExactBodySum;
    wall_distance::find_wall_distance as fn find_wall_distance(
        pair: &PairSettings,
        grid: &CellGrid<D>,
        particles: &mut ParticleArrays<Self, D>,
        sums: &mut PairSums<Self, D>,
    );
    walls::extrapolate_wall_pressure as fn extrapolate_wall_pressure(
        pair: &PairSettings,
        grid: &CellGrid<D>,
        particles: &mut ParticleArrays<Self, D>,
        sums: &mut PairSums<Self, D>,
        force: &(dyn Fn(&ParticleArrays<Self, D>, usize) -> [f64; D] + Sync),
    );
    wall_velocity::find_velocity_seen as fn find_velocity_seen(
        pair: &PairSettings,
        grid: &CellGrid<D>,
        particles: &ParticleArrays<Self, D>,
        level: TimeLevel,
        sums: &mut PairSums<Self, D>,
    );
    wall_friction::add_wall_friction as fn add_wall_friction(
        pair: &PairSettings,
        grid: &CellGrid<D>,
        particles: &mut ParticleArrays<Self, D>,
        level: TimeLevel,
        sums: &mut PairSums<Self, D>,
    );
    points::fit_points as fn fit_points(
        flows: &mut PointFlows<D>,
        fit: PointFit,
        pressure: &[Self],
        pair: &PairSettings,
        grid: &CellGrid<D>,
        particles: &ParticleArrays<Self, D>,
        sums: &mut PairSums<Self, D>,
    );
    waves::sum_waves as fn sum_waves(
        setting: &WaveSetting,
        pair: &PairSettings,
        grid: &CellGrid<D>,
        particles: &ParticleArrays<Self, D>,
        sums: &mut PairSums<Self, D>,
        rows: &[u32],
        found: &mut Vec<WaveFound>,
    );
}
