//! The pair loop of one row: what every neighbour contributes to it.

use super::ends::{RowRates, RowSums};
use super::layout::Layout;
use crate::math::kernel::KernelShape;
use crate::math::lanes::{Lanes, add_scaled, cross, dot};
use crate::math::lattice::ETA_SQUARED;
use crate::math::real::Real;
use crate::pass::density::LEAST_Q2;
use crate::pass::pack::{Near, Pack, Source};
use crate::pass::settings::PairSettings;
use crate::physics::eos;
use crate::physics::momentum;
use crate::physics::shifting::{Shifting, vacondio};
use crate::physics::sps;
use crate::physics::viscosity::{Viscosity, artificial, laminar, reconstructed};
use crate::physics::wall::{WallPressure, image};

/// The settings of the loop, ready for lanes.
pub(super) struct PairLoop<'a, L: Lanes, const D: usize> {
    pub pair: &'a PairSettings,
    layout: Layout,
    /// Body force of the rows, m/s²; empty where it is that of `pair`.
    body_force: &'a [Vec<L::Real>; D],
    terms: Terms,
    /// Largest image factor.
    cap: L,
    /// Support over h, squared.
    limit: L,
    /// c0/ρ0³, m¹⁰/(kg³ s): times ρ³ it is the speed of sound.
    speed_scale: f64,
    /// α of the artificial viscosity.
    artificial_alpha: f64,
    /// m ∇W over slope · x_ab/h, kg/m^(D+1): the mass, which all neighbours have, comes at the end.
    pub gradient_scale: f64,
    /// 4 ν m ∇W/(slope · x_ab), of the viscous sum.
    pub viscous_scale: f64,
    /// What the sum of the damping rates has of the row itself, times its density, kg/(m³ s).
    pub own_damping: f64,
}

/// Terms beyond the plain ones: branches that always go the same way.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Terms {
    artificial: bool,
    printed: bool,
    pub vacondio: bool,
    mirrored: bool,
}

impl<'a, L: Lanes, const D: usize> PairLoop<'a, L, D> {
    #[inline(always)]
    pub fn new(pair: &'a PairSettings, layout: Layout, body_force: &'a [Vec<L::Real>; D]) -> Self {
        let (artificial, printed) = match pair.viscous_term {
            Viscosity::Laminar { printed, .. } => (0.0, printed),
            Viscosity::Artificial { alpha } => (alpha, false),
            Viscosity::Sps { .. } => (0.0, false),
        };
        let gradient_scale = pair.mass * pair.slope_scale() / pair.smoothing_length;
        let own_slope = if printed { 0.0 } else { pair.kernel.slope(D, pair.smoothing_length, 0.0) };
        Self {
            pair,
            layout,
            body_force,
            terms: Terms {
                artificial: artificial != 0.0,
                printed,
                vacondio: matches!(pair.shifting, Shifting::Vacondio { .. }),
                mirrored: pair.wall_model.pressure() == WallPressure::Mirrored,
            },
            cap: L::constant(pair.wall_model.largest_factor()),
            limit: L::constant(pair.kernel.support_ratio().powi(2)),
            speed_scale: pair.tait.sound_speed / pair.tait.reference_density.powi(3),
            artificial_alpha: artificial,
            gradient_scale,
            viscous_scale: 4.0 * pair.pair_viscosity() * gradient_scale / pair.smoothing_length,
            own_damping: -2.0 * pair.pair_viscosity() * pair.mass * own_slope,
        }
    }

    /// Whether the loop has no terms beyond the plain ones and the damping: then it is compiled without their branches,
    /// which would keep half of the accumulators out of the registers.
    #[inline(always)]
    pub fn is_plain(&self) -> bool {
        self.terms == Terms::default() && self.layout.normal.is_none() && self.layout.stress.is_none()
    }

    /// Whether noise is damped.
    #[inline(always)]
    pub fn is_damped(&self) -> bool {
        self.layout.strain.is_some()
    }

    /// Whether the mean around is taken from the shifting vector.
    #[inline(always)]
    pub fn is_net(&self) -> bool {
        self.layout.crowding.is_some()
    }

    /// Whether there are walls: without them nothing is reflected.
    #[inline(always)]
    pub fn has_walls(&self) -> bool {
        self.layout.image_distance.is_some()
    }

    /// The columns and terms of a loop: of a plain one known when it is compiled; `SEEN`: some of the walls may be in the row's
    /// support.
    #[inline(always)]
    fn view<const PLAIN: bool, const DAMPED: bool, const WALLS: bool, const NET: bool, const SEEN: bool>(
        &self,
    ) -> (Layout, Terms) {
        if PLAIN {
            (Layout::plain::<D>(DAMPED, WALLS, NET, SEEN), Terms::default())
        } else {
            (self.layout, self.terms)
        }
    }

    /// Sums over what is `near` in a pack for the row at `point` (relative to the pack, in units of h); `SPLIT`: with pressure and moment apart.
    #[inline(always)]
    pub fn sum<
        K: KernelShape,
        const PLAIN: bool,
        const DAMPED: bool,
        const WALLS: bool,
        const NET: bool,
        const SPLIT: bool,
    >(
        &self,
        pack: &Pack<L::Real>,
        source: &Source<L::Real, D>,
        point: [L::Real; D],
        row: usize,
        near: Near,
        wall_distance: f64,
    ) -> RowRates<D> {
        let sums = self.walk::<K, PLAIN, DAMPED, WALLS, NET, true, SPLIT>(
            pack,
            source,
            point,
            row,
            near,
            wall_distance,
        );
        let (layout, terms) = self.view::<PLAIN, DAMPED, WALLS, NET, true>();
        self.end::<SPLIT>(sums, layout, terms, source, row)
    }

    /// The same, left as it lies in the lanes; `SEEN`: some of the walls may be in the row's support.
    #[inline(always)]
    pub fn walk<
        K: KernelShape,
        const PLAIN: bool,
        const DAMPED: bool,
        const WALLS: bool,
        const NET: bool,
        const SEEN: bool,
        const SPLIT: bool,
    >(
        &self,
        pack: &Pack<L::Real>,
        source: &Source<L::Real, D>,
        point: [L::Real; D],
        row: usize,
        near: Near,
        wall_distance: f64,
    ) -> RowSums<L, D> {
        let pair = self.pair;
        let (layout, terms) = self.view::<PLAIN, DAMPED, WALLS, NET, SEEN>();
        let h = pair.smoothing_length;
        let own = |column: usize| source.columns[column - D][row];
        let density = own(layout.density).to_f64();
        let pressure = own(layout.pressure).to_f64();
        let zero = L::constant(0.0);
        let one = L::constant(1.0);

        let mut x_a = [zero; D];
        let mut v_a = [zero; D];
        // ρ_a g·(x_b − x_a) for the mirrored pressure of a wall, per x_ab/h.
        let mut weight_a = [zero; D];
        for d in 0..D {
            x_a[d] = L::splat(point[d]);
            v_a[d] = L::splat(own(layout.velocity + d));
            let force = self.body_force[d].get(row).map_or(pair.body_force[d], |force| force.to_f64());
            weight_a[d] = L::constant(-density * force * h);
        }
        let mut strain_a = [zero; 6];
        if let Some(first) = layout.strain {
            for (c, strain) in strain_a.iter_mut().enumerate().take(sps::components(D)) {
                *strain = L::splat(own(first + c));
            }
        }
        let mut stress_a = [zero; 6];
        if let Some(first) = layout.stress {
            for (c, stress) in stress_a.iter_mut().enumerate().take(sps::components(D)) {
                *stress = L::splat(own(first + c));
            }
        }
        let rho_a = L::constant(density);
        let square_a = L::constant(density * density);
        let p_a = L::constant(pressure);
        let own_pressure =
            momentum::own_pressure(pressure, density, pair.tait.reference_density, pair.tensile_control);
        let own_pressure = L::constant(own_pressure);
        let inverse_distance = L::constant(pair.wall_model.inverse_distance(wall_distance, pair.spacing));
        // Terms along x_ab that are not divided by ρ_a are multiplied by −ρ_a first.
        let artificial_scale = L::constant(-density * self.speed_scale * self.artificial_alpha);
        let noise_scale = L::constant(-density * self.speed_scale * pair.noise_damping);
        let stress_scale = L::constant(-density);

        let mut along_x = [zero; D];
        let mut along_v = [zero; D];
        let mut shift = [zero; D];
        let mut shift_weights = zero;
        let mut divergence = zero;
        let mut damping = zero;
        let mut signal = zero;
        let mut distance = zero;
        let mut neighbours = zero;
        let mut pressed = [zero; D];
        let mut turn = [[zero; 3]; 2];

        for entry in pack.entries_near::<L, D>(layout.count, near) {
            let mut x = [zero; D];
            let mut v = [zero; D];
            let mut q2 = L::constant(LEAST_Q2);
            for d in 0..D {
                x[d] = x_a[d] - entry.column(d);
                v[d] = v_a[d] - entry.column(layout.velocity + d);
                q2 = x[d].mul_add(x[d], q2);
            }
            let (q, inverse_q) = q2.roots();
            let slope = K::slope(q, inverse_q);

            // One division for 1/(ρ_a + ρ_b), 1/(q² + η²/h²) and 1/ρ_b.
            let rho_b = entry.column(layout.density);
            let density_sum = rho_a + rho_b;
            let softened = q2 + L::constant(ETA_SQUARED);
            // What does not wait for the distance is multiplied first.
            let densities = density_sum * rho_b;
            let inverse = (densities * softened).inverse();
            let inverse_softened = inverse * densities;
            let inverse_rho_b = inverse * (density_sum * softened);
            let inverse_density_sum = inverse * (softened * rho_b);

            let xv = dot(x, v);
            let in_support = q2.less(self.limit);
            let speed = (xv * inverse_softened).abs();
            signal = signal.max(L::keep(in_support, speed));

            let mut factor = one;
            let mut image_distance = zero;
            let mut imaged_xv = xv;
            if let Some(column) = layout.image_distance {
                image_distance = entry.column(column);
                factor = image::velocity_factor(image_distance.abs(), inverse_distance, self.cap);
                imaged_xv = factor * xv;
            }
            let slips = image_distance.less(zero);
            if let Some(normal) = layout.normal {
                let product = image::free_slip_product(factor, entry.vector(normal), x, v);
                imaged_xv = L::select(slips, product, imaged_xv);
            }

            let volume_slope = inverse_rho_b * slope;
            divergence = volume_slope.mul_add(imaged_xv, divergence);

            let mut p_b = entry.column(layout.pressure);
            if terms.mirrored && layout.image_distance.is_some() {
                let is_wall = zero.less(image_distance.abs());
                p_b = L::select(is_wall, p_a + dot(weight_a, x), p_b);
            }
            let mut push = momentum::pressure_term(own_pressure, p_b, volume_slope);
            if SPLIT {
                for d in 0..D {
                    pressed[d] = push.mul_add(x[d], pressed[d]);
                }
            }
            if terms.artificial {
                let approach = imaged_xv * inverse_softened;
                let damping = artificial::factor(eos::stiffness(rho_a, square_a, rho_b), approach);
                let mut damping = damping * artificial_scale;
                if layout.normal.is_some() {
                    damping = L::select(slips, zero, damping);
                }
                push = damping.mul_add(slope, push);
            }
            if let Some(first) = layout.strain {
                let mut strain_sum = strain_a;
                for (c, strain) in strain_sum.iter_mut().enumerate().take(sps::components(D)) {
                    *strain = *strain + entry.column(first + c);
                }
                let approach = reconstructed::unexplained(xv, strain_sum, x, h) * inverse_softened;
                let damping = reconstructed::factor(eos::stiffness(rho_a, square_a, rho_b), approach);
                let mut damping = damping * noise_scale;
                if layout.image_distance.is_some() {
                    damping = L::select(zero.less(image_distance.abs()), zero, damping);
                }
                push = damping.mul_add(slope, push);
            }
            let drag = if terms.printed {
                laminar::printed_factor(slope, inverse_density_sum, q2, inverse_softened)
            } else {
                laminar::factor(slope, inverse_density_sum)
            };
            let mut drag = if layout.image_distance.is_some() { drag * factor } else { drag };
            if layout.normal.is_some() {
                drag = L::select(slips, zero, drag);
            }
            damping = damping + drag;
            for d in 0..D {
                along_x[d] = push.mul_add(x[d], along_x[d]);
                along_v[d] = drag.mul_add(v[d], along_v[d]);
            }
            if SPLIT {
                add_scaled(&mut turn[1], drag, cross(x, v));
            }
            if let Some(first) = layout.stress {
                let mut stress = stress_a;
                for (c, stress) in stress.iter_mut().enumerate().take(sps::components(D)) {
                    *stress = *stress + entry.column(first + c);
                }
                let product = sps::product(stress, x);
                let scale = slope * stress_scale;
                for d in 0..D {
                    along_x[d] = scale.mul_add(product[d], along_x[d]);
                }
                if SPLIT {
                    add_scaled(&mut turn[0], scale, cross(x, std::array::from_fn::<L, D, _>(|d| product[d])));
                }
            }

            if let Some(first) = layout.crowding {
                let weight = K::value(q) * entry.column(first + D);
                shift_weights = shift_weights + weight;
                for d in 0..D {
                    shift[d] = weight.mul_add(entry.column(first + d), shift[d]);
                }
            } else {
                let mut spread = volume_slope;
                if terms.vacondio {
                    spread = L::select(in_support, vacondio::repulsion(inverse_q), zero);
                    distance = distance + L::select(in_support, q, zero);
                    neighbours = neighbours + L::select(in_support, one, zero);
                }
                for d in 0..D {
                    shift[d] = spread.mul_add(x[d], shift[d]);
                }
            }
        }

        RowSums {
            density,
            along_x,
            along_v,
            shift,
            shift_weights,
            divergence,
            damping,
            signal,
            distance,
            neighbours,
            pressed,
            turn,
        }
    }
}
