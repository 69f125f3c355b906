//! Terms of a pair under `EdacTvf`, called one after another for every vector of neighbours.

use std::marker::PhantomData;

use super::edac_columns::EdacColumns;
use super::edac_sums::EdacSums;
use crate::math::kernel::KernelShape;
use crate::math::lanes::{Lanes, add_scaled, cross, dot};
use crate::math::lattice::ETA_SQUARED;
use crate::math::real::Real;
use crate::pass::fused::{FluidRow, FusedInputs, LoopShape, OwnParticle, PairTerms, WallImage};
use crate::pass::pack::{Entry, Source};
use crate::pass::settings::PairSettings;
use crate::physics::edac::{self, Edac};
use crate::physics::pair::PairGeometry;
use crate::physics::wall::WallPressure;

/// Settings of the loop, ready for lanes.
pub(super) struct EdacSettings<'a, L: Lanes, const D: usize> {
    inputs: &'a FusedInputs<'a, L::Real, D>,
    pub source: &'a Source<'a, L::Real, D>,
    pub edac: &'a Edac,
    columns: EdacColumns,
    choices: EdacChoices,
    /// Largest image factor.
    cap: L,
    /// Support over h, squared.
    limit: L,
    /// m ∇W over slope · x_ab/h, kg/m^(D+1).
    pub gradient_scale: f64,
    /// ν and ν_edac as they enter the sums, m²/s.
    pub viscosity: [f64; 2],
    /// Share of the row itself in the sum of the damping rates, times its density, kg/(m³ s).
    pub own_damping: f64,
}

/// Terms of a loop of a shape.
pub(super) struct EdacTerms<'s, 'a, L: Lanes, S, const D: usize> {
    pub settings: &'s EdacSettings<'a, L, D>,
    shape: PhantomData<S>,
}

/// Terms beyond those of the fixed shapes: branches that always go the same way.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct EdacChoices {
    /// The viscous sums have the published denominator r² + η².
    as_published: bool,
    /// The pressure of walls is mirrored from the particle's own.
    mirrored: bool,
    /// The divergence takes the velocity of the image in walls.
    image_in_divergence: bool,
}

/// Quantities of a particle, in every lane.
pub(super) struct EdacParticle<L, const D: usize> {
    common: OwnParticle<L, D>,
    /// Transport velocity less the velocity, m/s.
    drift: [L; D],
    /// V_a²/m², m⁶/kg².
    volume_square: L,
    /// −1/(2 ρ_a), m³/kg.
    half_of_stress: L,
}

/// A pair as the terms of the scheme see it.
struct EdacPair<L, const D: usize> {
    geometry: PairGeometry<L, D>,
    image: WallImage<L>,
    /// ρ_b, kg/m³.
    density: L,
    /// V_b/m, m³/kg.
    volume: L,
    /// S_ab/m² times the slope of the kernel.
    weight: L,
    /// The weight over ρ_a + ρ_b.
    shared: L,
    /// p_b − p_a, Pa.
    pressure_difference: L,
}

impl<'a, L: Lanes, const D: usize> EdacSettings<'a, L, D> {
    /// Returns the settings of a scene, whose columns have these places in the pack.
    #[inline(always)]
    pub(super) fn new(
        inputs: &'a FusedInputs<'a, L::Real, D>,
        source: &'a Source<'a, L::Real, D>,
        edac: &'a Edac,
        columns: EdacColumns,
    ) -> Self {
        let pair = inputs.pair;
        let of_pressure =
            edac.pressure_viscosity(pair.discretisation.smoothing_length, pair.tait.sound_speed);
        let viscosity = [pair.pair_viscosity(), of_pressure / pair.edac_coefficient(edac)];
        let own_slope = if edac.as_published {
            0.0
        } else {
            pair.discretisation.kernel.slope(D, pair.discretisation.smoothing_length, 0.0)
        };
        Self {
            inputs,
            source,
            edac,
            columns,
            choices: EdacChoices {
                as_published: edac.as_published,
                mirrored: pair.wall_model.pressure() == WallPressure::Mirrored,
                image_in_divergence: pair.wall_model.mirrors_velocity(),
            },
            cap: L::constant(pair.wall_model.largest_factor()),
            limit: L::constant(pair.discretisation.kernel.support_ratio().powi(2)),
            gradient_scale: pair.discretisation.mass * pair.discretisation.slope_scale()
                / pair.discretisation.smoothing_length,
            viscosity,
            own_damping: -2.0 * viscosity[0].max(viscosity[1]) * pair.discretisation.mass * own_slope,
        }
    }

    /// Returns true if a fixed shape has all terms of the scene.
    #[inline(always)]
    pub(super) fn fit_fixed_shapes(&self) -> bool {
        self.choices == EdacChoices::default()
            && self.columns.normal.is_none()
            && self.columns.viscous_velocity.is_none()
            && self.columns.facing.is_none()
    }

    /// Returns the settings of the pair passes.
    #[inline(always)]
    pub(super) fn pair(&self) -> &'a PairSettings {
        self.inputs.pair
    }

    /// Returns the terms of a loop of a shape.
    #[inline(always)]
    pub(super) fn with_shape<S: LoopShape>(&self) -> EdacTerms<'_, 'a, L, S, D> {
        EdacTerms { settings: self, shape: PhantomData }
    }
}

impl<L: Lanes, S: LoopShape, const D: usize> EdacTerms<'_, '_, L, S, D> {
    /// Returns the places of the columns, known to the compiler in a loop of a fixed shape.
    #[inline(always)]
    pub(super) fn columns(&self) -> EdacColumns {
        if S::FIXED { EdacColumns::of_shape::<S, D>() } else { self.settings.columns }
    }

    /// Returns the choices of the scene, known to the compiler in a loop of a fixed shape.
    #[inline(always)]
    fn choices(&self) -> EdacChoices {
        if S::FIXED { EdacChoices::default() } else { self.settings.choices }
    }

    /// Returns the pair of a particle and a vector of its neighbours.
    #[inline(always)]
    fn pair<K: KernelShape>(&self, own: &EdacParticle<L, D>, neighbours: Entry<'_, L>) -> EdacPair<L, D> {
        let columns = self.columns();
        let (mut geometry, behind) = own.common.geometry::<K>(neighbours, columns.velocity, columns.facing);
        // One division for 1/(ρ_a + ρ_b) and 1/ρ_b.
        let density = neighbours.scalar(columns.density);
        let density_sum = own.common.density + density;
        let inverse = (density_sum * density).inverse();
        // All neighbours have one mass, so it is multiplied at the end.
        let volume = inverse * density_sum;
        let cap = self.settings.cap;
        let image =
            WallImage::new(&own.common, neighbours, columns.image_distance, columns.normal, behind, cap);
        if S::WITH_MOMENTS {
            geometry.slope = geometry.slope * image.acts_on_body::<D>(neighbours, columns.facing);
        }
        let weight = edac::weight(own.volume_square, volume, geometry.slope);
        let shared = weight * (inverse * density);
        let mut pressure = neighbours.scalar(columns.pressure);
        if self.choices().mirrored {
            pressure = image.mirrored_pressure(pressure, &own.common, geometry.x);
        }
        pressure = image.mirrored_behind(pressure, &own.common, geometry.x);
        let pressure_difference = pressure - own.common.pressure;
        EdacPair { geometry, image, density, volume, weight, shared, pressure_difference }
    }

    /// Adds the neighbours to the divergence of the velocity.
    #[inline(always)]
    fn add_divergence(&self, pair: &EdacPair<L, D>, neighbours: Entry<'_, L>, sums: &mut EdacSums<L, D>) {
        let (geometry, image) = (&pair.geometry, &pair.image);
        let mut product = dot(geometry.x, geometry.v);
        let mut factor = L::constant(1.0);
        if self.choices().image_in_divergence {
            factor = image.factor;
            product = factor * product;
        }
        let product = image.free_slip_product(product, factor, geometry, neighbours);
        sums.divergence = (pair.volume * pair.geometry.slope).mul_add(product, sums.divergence);
    }

    /// Adds the neighbours in the support to the mean pressure.
    #[inline(always)]
    fn add_to_mean_pressure(&self, pair: &EdacPair<L, D>, sums: &mut EdacSums<L, D>) {
        let (zero, one) = (L::constant(0.0), L::constant(1.0));
        let in_support = pair.geometry.q2.less(self.settings.limit);
        sums.differences = sums.differences + L::select(in_support, pair.pressure_difference, zero);
        sums.neighbours = sums.neighbours + L::select(in_support, one, zero);
    }

    /// Adds the diffusion of the pressure and returns the factor of v_ab of the viscous term.
    #[inline(always)]
    fn add_diffusion(&self, pair: &EdacPair<L, D>, sums: &mut EdacSums<L, D>) -> L {
        let mut drag = edac::viscous_term(pair.shared, pair.density);
        if self.choices().as_published {
            let q2 = pair.geometry.q2;
            drag = drag * (q2 * (q2 + L::constant(ETA_SQUARED)).inverse());
        }
        sums.diffusion = drag.mul_add(pair.pressure_difference, sums.diffusion);
        let drag = pair.image.viscous(drag);
        sums.damping = sums.damping + drag;
        drag
    }

    /// Returns the relative velocity of the viscous term, m/s: dummy walls have one of their own.
    #[inline(always)]
    fn viscous_velocity(
        &self,
        own: &EdacParticle<L, D>,
        neighbours: Entry<'_, L>,
        pair: &EdacPair<L, D>,
    ) -> [L; D] {
        let mut v = pair.geometry.v;
        if let Some(velocity) = self.columns().viscous_velocity {
            for d in 0..D {
                v[d] = own.common.v[d] - neighbours.column(velocity.0 + d);
            }
        }
        v
    }
}

impl<L: Lanes, S: LoopShape, const D: usize> PairTerms<L, D> for EdacTerms<'_, '_, L, S, D> {
    type Own = EdacParticle<L, D>;
    type Sums = EdacSums<L, D>;

    #[inline(always)]
    fn width(&self) -> usize {
        self.columns().width
    }

    #[inline(always)]
    fn own(&self, row: &FluidRow<L::Real, D>) -> EdacParticle<L, D> {
        let (source, columns) = (self.settings.source, self.columns());
        let density = source.scalar(columns.density, row.row).to_f64();
        let pressure = source.scalar(columns.pressure, row.row).to_f64();
        let velocity = source.splat_vector(columns.velocity, row.row);
        EdacParticle {
            common: OwnParticle::new(self.settings.inputs, row, velocity, density, pressure),
            drift: source.splat_vector(columns.drift, row.row),
            volume_square: L::constant(density.powi(-2)),
            half_of_stress: L::constant(-0.5 / density),
        }
    }

    #[inline(always)]
    fn no_sums(&self, _own: &EdacParticle<L, D>) -> EdacSums<L, D> {
        EdacSums::none()
    }

    #[inline(always)]
    fn add<K: KernelShape>(
        &self,
        own: &EdacParticle<L, D>,
        neighbours: Entry<'_, L>,
        sums: &mut EdacSums<L, D>,
    ) {
        let columns = self.columns();
        let pair = self.pair::<K>(own, neighbours);
        let x = pair.geometry.x;
        self.add_divergence(&pair, neighbours, sums);
        self.add_to_mean_pressure(&pair, sums);
        let drag = self.add_diffusion(&pair, sums);
        let v = self.viscous_velocity(own, neighbours, &pair);

        let pressure = edac::pressure_term(pair.shared, pair.pressure_difference);
        let v_b: [L; D] = neighbours.vector_at(columns.velocity);
        let drift_along = dot(neighbours.vector_at::<D>(columns.drift), x);
        let drift_along = pair.image.without_behind(drift_along);
        let carried = edac::transport_term(pair.weight, pair.density, drift_along) * own.half_of_stress;
        for d in 0..D {
            let along = carried.mul_add(v_b[d], sums.along_x[d]);
            sums.along_x[d] = pressure.mul_add(x[d], along);
            sums.along_v[d] = drag.mul_add(v[d], sums.along_v[d]);
            sums.background[d] = pair.weight.mul_add(x[d], sums.background[d]);
        }
        if S::WITH_MOMENTS {
            for d in 0..D {
                sums.pressure_part[d] = pressure.mul_add(x[d], sums.pressure_part[d]);
            }
            add_scaled(&mut sums.moments[0], carried, cross(x, v_b));
            add_scaled(&mut sums.moments[1], drag, cross(x, v));
            let own_drift = pair.weight * dot(own.drift, x);
            add_scaled(&mut sums.moments[2], own_drift, cross(x, own.common.v));
        }
    }
}
