//! Terms of a pair under `Wcsph`, called one after another for every vector of neighbours.

use std::marker::PhantomData;

use super::wcsph_columns::WcsphColumns;
use super::wcsph_sums::WcsphSums;
use crate::math::kernel::KernelShape;
use crate::math::lanes::{Lanes, add_scaled, cross, dot};
use crate::math::real::Real;
use crate::pass::fused::{FluidRow, FusedInputs, LoopShape, OwnParticle, PairTerms, WallImage};
use crate::pass::pack::{Entry, Source};
use crate::pass::settings::PairSettings;
use crate::physics::momentum;
use crate::physics::pair::{PairDensities, PairGeometry};
use crate::physics::shifting::{concentration, vacondio};
use crate::physics::viscosity::{ViscousTerms, artificial, reconstructed, sps};
use crate::physics::wall::WallPressure;

/// Settings of the loop, ready for lanes.
pub(super) struct WcsphSettings<'a, L: Lanes, const D: usize> {
    inputs: &'a FusedInputs<'a, L::Real, D>,
    pub source: &'a Source<'a, L::Real, D>,
    columns: WcsphColumns,
    choices: WcsphChoices,
    /// Largest image factor.
    cap: L,
    /// Support over h, squared.
    limit: L,
    /// c0/ρ0³, m¹⁰/(kg³ s): times ρ³ it is the speed of sound.
    speed_scale: f64,
    /// m ∇W over slope · x_ab/h, kg/m^(D+1): all neighbours have one mass, so it is multiplied at
    /// the end.
    pub gradient_scale: f64,
    /// 4 ν m ∇W/(slope · x_ab), of the viscous sum.
    pub viscous_scale: f64,
    /// Share of the row itself in the sum of the damping rates, times its density, kg/(m³ s).
    pub own_damping: f64,
}

/// Terms of a loop of a shape.
pub(super) struct WcsphTerms<'s, 'a, L: Lanes, S, const D: usize> {
    pub settings: &'s WcsphSettings<'a, L, D>,
    shape: PhantomData<S>,
}

/// Terms beyond those of the fixed shapes: branches that always go the same way.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct WcsphChoices {
    /// Viscous terms beyond the laminar one.
    viscous: ViscousTerms,
    /// The repulsion of the neighbours takes the place of the concentration gradient.
    pub repulsion: bool,
    /// The pressure of walls is mirrored from the particle's own.
    mirrored: bool,
}

impl WcsphChoices {
    /// Returns the choices of a scene.
    pub(super) fn new(pair: &PairSettings) -> Self {
        Self {
            viscous: pair.viscous_term.pair_terms(),
            repulsion: pair.shifting.needs().repulsion,
            mirrored: pair.wall_model.pressure() == WallPressure::Mirrored,
        }
    }
}

/// Quantities of a particle, in every lane.
pub(super) struct WcsphParticle<L, const D: usize> {
    common: OwnParticle<L, D>,
    /// ρ_a once, kg/m³.
    scalar_density: f64,
    /// ρ_a², kg²/m⁶.
    square: L,
    /// Pressure that the particle adds to each of its neighbours', Pa.
    added_pressure: L,
    /// Rate of strain, 1/s.
    strain: [L; 6],
    /// T/ρ², m⁵/(kg s²).
    stress: [L; 6],
    /// Terms along x_ab that are not divided by ρ_a are multiplied by −ρ_a first: scales of the
    /// artificial viscosity, of the noise damping and of the stress.
    artificial_scale: L,
    noise_scale: L,
    stress_scale: L,
}

impl<'a, L: Lanes, const D: usize> WcsphSettings<'a, L, D> {
    /// Returns the settings of a scene, whose columns have these places in the pack.
    #[inline(always)]
    pub(super) fn new(
        inputs: &'a FusedInputs<'a, L::Real, D>,
        source: &'a Source<'a, L::Real, D>,
        columns: WcsphColumns,
    ) -> Self {
        let pair = inputs.pair;
        let choices = WcsphChoices::new(pair);
        let gradient_scale = pair.discretisation.mass * pair.discretisation.slope_scale()
            / pair.discretisation.smoothing_length;
        let own_slope = if choices.viscous.as_published {
            0.0
        } else {
            pair.discretisation.kernel.slope(D, pair.discretisation.smoothing_length, 0.0)
        };
        Self {
            inputs,
            source,
            columns,
            choices,
            cap: L::constant(pair.wall_model.largest_factor()),
            limit: L::constant(pair.discretisation.kernel.support_ratio().powi(2)),
            speed_scale: pair.tait.sound_speed / pair.tait.reference_density.powi(3),
            gradient_scale,
            viscous_scale: 4.0 * pair.pair_viscosity() * gradient_scale
                / pair.discretisation.smoothing_length,
            own_damping: -2.0 * pair.pair_viscosity() * pair.discretisation.mass * own_slope,
        }
    }

    /// Returns true if a fixed shape has all terms of the scene.
    #[inline(always)]
    pub(super) fn fit_fixed_shapes(&self) -> bool {
        self.choices == WcsphChoices::default()
            && self.columns.normal.is_none()
            && self.columns.stress.is_none()
            && self.columns.facing.is_none()
    }

    /// Returns the settings of the pair passes.
    #[inline(always)]
    pub(super) fn pair(&self) -> &'a PairSettings {
        self.inputs.pair
    }

    /// Returns the terms of a loop of a shape.
    #[inline(always)]
    pub(super) fn with_shape<S: LoopShape>(&self) -> WcsphTerms<'_, 'a, L, S, D> {
        WcsphTerms { settings: self, shape: PhantomData }
    }
}

impl<L: Lanes, S: LoopShape, const D: usize> WcsphTerms<'_, '_, L, S, D> {
    /// Returns the places of the columns, known to the compiler in a loop of a fixed shape.
    #[inline(always)]
    pub(super) fn columns(&self) -> WcsphColumns {
        if S::FIXED { WcsphColumns::of_shape::<S, D>() } else { self.settings.columns }
    }

    /// Returns the choices of the scene, known to the compiler in a loop of a fixed shape.
    #[inline(always)]
    pub(super) fn choices(&self) -> WcsphChoices {
        if S::FIXED { WcsphChoices::default() } else { self.settings.choices }
    }

    /// Adds the damping of particle noise to the coefficient of x_ab.
    #[inline(always)]
    fn add_noise_damping(
        &self,
        along_line: L,
        own: &WcsphParticle<L, D>,
        other_strain: [L; 6],
        pair: &WcsphPair<L, D>,
    ) -> L {
        let h = self.settings.pair().discretisation.smoothing_length;
        let strains = [own.strain, other_strain];
        let term = reconstructed::pair_term(&pair.geometry, &pair.densities, strains, pair.product, h);
        let term = pair.image.without_walls(term * own.noise_scale);
        term.mul_add(pair.geometry.slope, along_line)
    }

    /// Adds the artificial viscosity to the coefficient of x_ab.
    #[inline(always)]
    fn add_artificial_viscosity(
        &self,
        along_line: L,
        own: &WcsphParticle<L, D>,
        pair: &WcsphPair<L, D>,
    ) -> L {
        let term = artificial::pair_term(&pair.densities, pair.image_product) * own.artificial_scale;
        pair.image.without_free_slip(term).mul_add(pair.geometry.slope, along_line)
    }

    /// Adds the sub-particle-scale stress to the acceleration.
    #[inline(always)]
    fn add_stress(
        &self,
        own: &WcsphParticle<L, D>,
        other_stress: [L; 6],
        pair: &PairGeometry<L, D>,
        sums: &mut WcsphSums<L, D>,
    ) {
        let product = sps::pair_term(own.stress, other_stress, pair.x);
        let scale = pair.slope * own.stress_scale;
        for d in 0..D {
            sums.along_x[d] = scale.mul_add(product[d], sums.along_x[d]);
        }
        if S::WITH_MOMENTS {
            add_scaled(&mut sums.moments[0], scale, cross(pair.x, product));
        }
    }

    /// Adds the neighbours to the shifting vector.
    #[inline(always)]
    fn add_shift<K: KernelShape>(
        &self,
        neighbours: Entry<'_, L>,
        pair: &PairGeometry<L, D>,
        volume_slope: L,
        sums: &mut WcsphSums<L, D>,
    ) {
        if let Some(columns) = self.columns().concentration {
            let weight = K::value(pair.q) * neighbours.scalar(columns.volume);
            let gradient = neighbours.vector_at(columns.gradient);
            concentration::add_to_mean(weight, gradient, &mut sums.shift, &mut sums.shift_weights);
            return;
        }
        let mut factor = volume_slope;
        if self.choices().repulsion {
            let in_support = pair.q2.less(self.settings.limit);
            factor = vacondio::pair_term(in_support, pair.q, pair.inverse_q, &mut sums.repulsion);
        }
        for d in 0..D {
            sums.shift[d] = factor.mul_add(pair.x[d], sums.shift[d]);
        }
    }
}

/// A pair as the terms of the scheme see it.
struct WcsphPair<L, const D: usize> {
    geometry: PairGeometry<L, D>,
    densities: PairDensities<L>,
    image: WallImage<L>,
    /// x_ab·v_ab/h, m/s.
    product: L,
    /// Product of the above with the image velocity in walls, m/s.
    image_product: L,
}

impl<L: Lanes, const D: usize> WcsphPair<L, D> {
    /// Returns the pair of a particle and a vector of its neighbours.
    #[inline(always)]
    fn new<K: KernelShape>(
        own: &WcsphParticle<L, D>,
        neighbours: Entry<'_, L>,
        columns: &WcsphColumns,
        cap: L,
    ) -> Self {
        let (geometry, behind) = own.common.geometry::<K>(neighbours, columns.velocity, columns.facing);
        let other = neighbours.scalar(columns.density);
        let densities = PairDensities::new(own.common.density, own.square, other, geometry.q2);
        let product = dot(geometry.x, geometry.v);
        let image =
            WallImage::new(&own.common, neighbours, columns.image_distance, columns.normal, behind, cap);
        let image_product = image.product(product, &geometry, neighbours);
        Self { geometry, densities, image, product, image_product }
    }
}

impl<L: Lanes, S: LoopShape, const D: usize> PairTerms<L, D> for WcsphTerms<'_, '_, L, S, D> {
    type Own = WcsphParticle<L, D>;
    type Sums = WcsphSums<L, D>;

    #[inline(always)]
    fn width(&self) -> usize {
        self.columns().width
    }

    #[inline(always)]
    fn own(&self, row: &FluidRow<L::Real, D>) -> WcsphParticle<L, D> {
        let (settings, source, columns) = (self.settings, self.settings.source, self.columns());
        let pair = settings.pair();
        let density = source.scalar(columns.density, row.row).to_f64();
        let pressure = source.scalar(columns.pressure, row.row).to_f64();
        let velocity = source.splat_vector(columns.velocity, row.row);
        let reference_density = pair.tait.reference_density;
        let added_pressure =
            momentum::own_pressure(pressure, density, reference_density, pair.tensile_control);
        let alpha = self.choices().viscous.artificial_alpha;
        WcsphParticle {
            common: OwnParticle::new(settings.inputs, row, velocity, density, pressure),
            scalar_density: density,
            square: L::constant(density * density),
            added_pressure: L::constant(added_pressure),
            strain: source.splat_optional(columns.strain, row.row),
            stress: source.splat_optional(columns.stress, row.row),
            artificial_scale: L::constant(-density * settings.speed_scale * alpha),
            noise_scale: L::constant(-density * settings.speed_scale * pair.noise_damping),
            stress_scale: L::constant(-density),
        }
    }

    #[inline(always)]
    fn no_sums(&self, own: &WcsphParticle<L, D>) -> WcsphSums<L, D> {
        WcsphSums::none(own.scalar_density)
    }

    #[inline(always)]
    fn add<K: KernelShape>(
        &self,
        own: &WcsphParticle<L, D>,
        neighbours: Entry<'_, L>,
        sums: &mut WcsphSums<L, D>,
    ) {
        let (columns, choices) = (self.columns(), self.choices());
        let mut pair = WcsphPair::new::<K>(own, neighbours, &columns, self.settings.cap);
        if S::WITH_MOMENTS {
            pair.geometry.slope =
                pair.geometry.slope * pair.image.acts_on_body::<D>(neighbours, columns.facing);
        }
        let WcsphPair { geometry, densities, image, .. } = &pair;
        let volume_slope = densities.inverse_other * geometry.slope;

        let in_support = geometry.q2.less(self.settings.limit);
        let speed = (pair.product * densities.inverse_softened_q2).abs();
        sums.signal = sums.signal.max(L::keep(in_support, speed));
        sums.divergence = volume_slope.mul_add(pair.image_product, sums.divergence);

        let mut pressure = neighbours.scalar(columns.pressure);
        if choices.mirrored {
            pressure = image.mirrored_pressure(pressure, &own.common, geometry.x);
        }
        pressure = image.mirrored_behind(pressure, &own.common, geometry.x);
        let mut along_line = momentum::pressure_term(own.added_pressure, pressure, volume_slope);
        if S::WITH_MOMENTS {
            for d in 0..D {
                sums.pressure_part[d] = along_line.mul_add(geometry.x[d], sums.pressure_part[d]);
            }
        }
        if choices.viscous.artificial_alpha != 0.0 {
            along_line = self.add_artificial_viscosity(along_line, own, &pair);
        }
        if let Some(strain) = columns.strain {
            let other_strain = neighbours.symmetric::<D>(strain);
            along_line = self.add_noise_damping(along_line, own, other_strain, &pair);
        }
        let drag = image.viscous(choices.viscous.drag(geometry, densities));
        sums.damping = sums.damping + drag;
        for d in 0..D {
            sums.along_x[d] = along_line.mul_add(geometry.x[d], sums.along_x[d]);
            sums.along_v[d] = drag.mul_add(geometry.v[d], sums.along_v[d]);
        }
        if S::WITH_MOMENTS {
            add_scaled(&mut sums.moments[1], drag, cross(geometry.x, geometry.v));
        }
        if let Some(stress) = columns.stress {
            let other = image.own_behind(own.stress, neighbours.symmetric::<D>(stress));
            self.add_stress(own, other, geometry, sums);
        }
        self.add_shift::<K>(neighbours, geometry, volume_slope, sums);
    }
}
