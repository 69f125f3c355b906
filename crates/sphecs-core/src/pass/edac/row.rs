//! The pair loop of one row: what every neighbour contributes to it.

use crate::math::kernel::KernelShape;
use crate::math::lanes::{self, Lanes, add_scaled, cross, dot};
use crate::math::lattice::ETA_SQUARED;
use crate::math::real::Real;
use crate::pass::density::LEAST_Q2;
use crate::pass::pack::{Near, Pack, Source};
use crate::pass::settings::PairSettings;
use crate::physics::edac::{self, Edac};
use crate::physics::wall::{WallModel, WallPressure, image};

/// Which of a pack's columns is what. The coordinates are the first `D`, velocity and drift the next.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    velocity: usize,
    drift: usize,
    density: usize,
    pressure: usize,
    /// Only where there are walls.
    pub image_distance: Option<usize>,
    /// Wall normals, only where a wall is free-slip.
    pub normal: Option<usize>,
    /// Velocities as the viscous term sees them, only where walls are dummy particles.
    pub seen: Option<usize>,
    /// All columns, coordinates included.
    count: usize,
}

impl Layout {
    /// Most columns beside the coordinates: velocity, drift, three scalars, normal and velocity seen in 3D.
    pub const MOST_COLUMNS: usize = 3 + 3 + 3 + 3 + 3;

    /// The columns that every pass has, and that of walls.
    #[inline(always)]
    const fn plain<const D: usize>(walls: bool) -> Self {
        let of_flow = 3 * D + 2;
        Self {
            velocity: D,
            drift: 2 * D,
            density: 3 * D,
            pressure: 3 * D + 1,
            image_distance: if walls { Some(of_flow) } else { None },
            normal: None,
            seen: None,
            count: if walls { of_flow + 1 } else { of_flow },
        }
    }

    pub fn new<const D: usize>(pair: &PairSettings, has_walls: bool) -> Self {
        let mut layout = Self::plain::<D>(has_walls);
        if has_walls && pair.has_free_slip() {
            layout.normal = Some(layout.count);
            layout.count += D;
        }
        if has_walls && pair.wall_model == WallModel::Dummy {
            layout.seen = Some(layout.count);
            layout.count += D;
        }
        layout
    }
}

impl Layout {
    /// The columns of a pack after the coordinates, and how many there are; the vectors are velocity, drift, wall normal and
    /// velocity seen.
    pub fn in_order<'a, R, const D: usize>(
        &self,
        [velocity, drift, wall_normal, seen]: [&'a [Vec<R>; D]; 4],
        scalars: [&'a [R]; 2],
        image_distance: &'a [R],
    ) -> ([&'a [R]; Self::MOST_COLUMNS], usize) {
        let of =
            |columns: &'a [Vec<R>; D], there: bool| columns.iter().filter(move |_| there).map(Vec::as_slice);
        let in_order = of(velocity, true)
            .chain(of(drift, true))
            .chain(scalars)
            .chain(self.image_distance.map(|_| image_distance))
            .chain(of(wall_normal, self.normal.is_some()))
            .chain(of(seen, self.seen.is_some()));
        let mut neighbours: [&[R]; Self::MOST_COLUMNS] = [&[]; Self::MOST_COLUMNS];
        let mut count = 0;
        for (slot, column) in neighbours.iter_mut().zip(in_order) {
            *slot = column;
            count += 1;
        }
        (neighbours, count)
    }
}

/// The settings of the loop, ready for lanes.
pub(super) struct PairLoop<'a, L: Lanes, const D: usize> {
    pair: &'a PairSettings,
    edac: &'a Edac,
    layout: Layout,
    /// Body force of the rows, m/s²; empty where it is that of `pair`.
    body_force: &'a [Vec<L::Real>; D],
    terms: Terms,
    /// Largest image factor.
    cap: L,
    /// Support over h, squared.
    limit: L,
    /// m ∇W over slope · x_ab/h, kg/m^(D+1).
    gradient_scale: f64,
    /// ν and ν_edac as they enter the sums, m²/s.
    viscosity: [f64; 2],
    /// What the sum of the damping rates has of the row itself, times its density, kg/(m³ s).
    own_damping: f64,
}

/// Terms beyond the plain ones: branches that always go the same way.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Terms {
    printed: bool,
    mirrored: bool,
    /// The divergence has the ghost's velocity in walls.
    ghost: bool,
}

/// What a row has summed up, in SI units.
pub(super) struct RowRates<const D: usize> {
    pub acceleration: [f64; D],
    pub background: [f64; D],
    pub pressure_rate: f64,
    pub divergence: f64,
    pub damping: f64,
    /// The part of the acceleration that is pressure, and Σ x_ab × (the pair's acceleration), m²/s²; 0 unless asked for.
    pub split: ([f64; D], [f64; 3]),
}

impl<'a, L: Lanes, const D: usize> PairLoop<'a, L, D> {
    #[inline(always)]
    pub fn new(
        pair: &'a PairSettings,
        edac: &'a Edac,
        layout: Layout,
        body_force: &'a [Vec<L::Real>; D],
    ) -> Self {
        let of_pressure = edac.pressure_viscosity(pair.smoothing_length, pair.tait.sound_speed);
        let viscosity = [pair.pair_viscosity(), of_pressure / pair.edac_coefficient(edac)];
        let own_slope = if edac.printed { 0.0 } else { pair.kernel.slope(D, pair.smoothing_length, 0.0) };
        Self {
            pair,
            edac,
            layout,
            body_force,
            terms: Terms {
                printed: edac.printed,
                mirrored: pair.wall_model.pressure() == WallPressure::Mirrored,
                ghost: pair.wall_model == WallModel::Ghost,
            },
            cap: L::constant(pair.wall_model.largest_factor()),
            limit: L::constant(pair.kernel.support_ratio().powi(2)),
            gradient_scale: pair.mass * pair.slope_scale() / pair.smoothing_length,
            viscosity,
            own_damping: -2.0 * viscosity[0].max(viscosity[1]) * pair.mass * own_slope,
        }
    }

    /// Whether the loop has no terms beyond the plain ones: then it is compiled without their branches.
    #[inline(always)]
    pub fn is_plain(&self) -> bool {
        self.terms == Terms::default() && self.layout.normal.is_none() && self.layout.seen.is_none()
    }

    /// Whether there are walls: without them nothing is reflected.
    #[inline(always)]
    pub fn has_walls(&self) -> bool {
        self.layout.image_distance.is_some()
    }

    /// Sums over a pack for the row at `point` (relative to the pack, in units of h); `SPLIT`: with pressure and moment apart.
    #[inline(always)]
    pub fn sum<K: KernelShape, const PLAIN: bool, const WALLS: bool, const SPLIT: bool>(
        &self,
        pack: &Pack<L::Real>,
        source: &Source<L::Real, D>,
        point: [L::Real; D],
        row: usize,
        near: Near,
        wall_distance: f64,
    ) -> RowRates<D> {
        let pair = self.pair;
        let (layout, terms) =
            if PLAIN { (Layout::plain::<D>(WALLS), Terms::default()) } else { (self.layout, self.terms) };
        let h = pair.smoothing_length;
        let reference = pair.tait.reference_density;
        let own = |column: usize| source.columns[column - D][row];
        let density = own(layout.density).to_f64();
        let pressure = own(layout.pressure).to_f64();
        let zero = L::constant(0.0);
        let one = L::constant(1.0);

        let mut x_a = [zero; D];
        let mut v_a = [zero; D];
        let mut drift_a = [zero; D];
        // ρ_a g·(x_b − x_a) for the mirrored pressure of a wall, per x_ab/h.
        let mut weight_a = [zero; D];
        for d in 0..D {
            x_a[d] = L::splat(point[d]);
            v_a[d] = L::splat(own(layout.velocity + d));
            drift_a[d] = L::splat(own(layout.drift + d));
            let force = self.body_force[d].get(row).map_or(pair.body_force[d], |force| force.to_f64());
            weight_a[d] = L::constant(-density * force * h);
        }
        let rho_a = L::constant(density);
        let p_a = L::constant(pressure);
        let own_square = L::constant(density.powi(-2));
        let half_of_stress = L::constant(-0.5 / density);
        let inverse_distance = L::constant(pair.wall_model.inverse_distance(wall_distance, pair.spacing));

        let mut along_x = [zero; D];
        let mut along_v = [zero; D];
        let mut push = [zero; D];
        let mut divergence = zero;
        let mut diffusion = zero;
        let mut damping = zero;
        let mut differences = zero;
        let mut neighbours = zero;
        let mut pressures = [zero; D];
        let mut turn = [[zero; 3]; 3];

        for entry in pack.entries_near::<L, D>(layout.count, near) {
            let mut x = [zero; D];
            let mut v_b = [zero; D];
            let mut v = [zero; D];
            let mut q2 = L::constant(LEAST_Q2);
            for d in 0..D {
                x[d] = x_a[d] - entry.column(d);
                v_b[d] = entry.column(layout.velocity + d);
                v[d] = v_a[d] - v_b[d];
                q2 = x[d].mul_add(x[d], q2);
            }
            let (q, inverse_q) = q2.roots();
            let slope = K::slope(q, inverse_q);

            // One division for 1/(ρ_a + ρ_b) and 1/ρ_b.
            let rho_b = entry.column(layout.density);
            let density_sum = rho_a + rho_b;
            let inverse = (density_sum * rho_b).inverse();
            // The mass, which all volumes share, comes at the end.
            let volume = inverse * density_sum;
            let weight = edac::weight(own_square, volume, slope);
            let shared = weight * (inverse * rho_b);

            let mut factor = one;
            let mut image_distance = zero;
            let mut xv = dot(x, v);
            if let Some(column) = layout.image_distance {
                image_distance = entry.column(column);
                factor = image::velocity_factor(image_distance.abs(), inverse_distance, self.cap);
            }
            let of_divergence = if terms.ghost { factor } else { one };
            if terms.ghost {
                xv = factor * xv;
            }
            let slips = image_distance.less(zero);
            if let Some(normal) = layout.normal {
                let product = image::free_slip_product(of_divergence, entry.vector(normal), x, v);
                xv = L::select(slips, product, xv);
            }
            divergence = (volume * slope).mul_add(xv, divergence);

            let mut p_b = entry.column(layout.pressure);
            if terms.mirrored && layout.image_distance.is_some() {
                let is_wall = zero.less(image_distance.abs());
                p_b = L::select(is_wall, p_a + dot(weight_a, x), p_b);
            }
            let difference = p_b - p_a;
            let in_support = q2.less(self.limit);
            differences = differences + L::select(in_support, difference, zero);
            neighbours = neighbours + L::select(in_support, one, zero);

            let mut drag = edac::viscous_term(shared, rho_b);
            if terms.printed {
                drag = drag * (q2 * (q2 + L::constant(ETA_SQUARED)).inverse());
            }
            diffusion = drag.mul_add(difference, diffusion);
            if layout.image_distance.is_some() {
                drag = drag * factor;
            }
            if layout.normal.is_some() {
                drag = L::select(slips, zero, drag);
            }
            damping = damping + drag;
            if let Some(seen) = layout.seen {
                for d in 0..D {
                    v[d] = v_a[d] - entry.column(seen + d);
                }
            }

            let pressed = edac::pressure_term(shared, difference);
            let drift_along = dot(entry.vector::<D>(layout.drift), x);
            let carried = edac::transport_term(weight, rho_b, drift_along) * half_of_stress;
            for d in 0..D {
                let along = carried.mul_add(v_b[d], along_x[d]);
                along_x[d] = pressed.mul_add(x[d], along);
                along_v[d] = drag.mul_add(v[d], along_v[d]);
                push[d] = weight.mul_add(x[d], push[d]);
            }
            if SPLIT {
                for d in 0..D {
                    pressures[d] = pressed.mul_add(x[d], pressures[d]);
                }
                add_scaled(&mut turn[0], carried, cross(x, v_b));
                add_scaled(&mut turn[1], drag, cross(x, v));
                add_scaled(&mut turn[2], weight * dot(drift_a, x), cross(x, v_a));
            }
        }

        // Weights are of volumes over masses: V²/m ∇W is m ∇W times them.
        let scale = self.gradient_scale;
        let [nu, nu_of_pressure] = self.viscosity.map(|nu| 2.0 * nu * density * scale / h);
        let squared_speed = pair.tait.sound_speed * pair.tait.sound_speed;
        let push = lanes::sums(push);
        let drift: [f64; D] = std::array::from_fn(|d| own(layout.drift + d).to_f64());
        let drift_along: f64 = drift.iter().zip(push).map(|(w, push)| w * push).sum();
        // p̄_a − p_a, or −p_a where no mean is subtracted.
        let mean = if self.edac.average_pressure {
            differences.sum().to_f64() / neighbours.sum().to_f64()
        } else {
            -pressure
        };
        let along_x_scale = L::constant(-density * scale);
        let along_v_scale = L::constant(nu);
        let background = self.edac.background * reference * squared_speed;
        let inflow = scale * divergence.sum().to_f64();
        let diffusion = -nu_of_pressure * diffusion.sum().to_f64();
        let relaxing = self.edac.relaxing(h, pair.tait.sound_speed, density - reference, pressure);
        let mut rates = RowRates {
            acceleration: [0.0; D],
            background: push.map(|push| -background * scale * push),
            pressure_rate: density * squared_speed * inflow + diffusion + relaxing,
            divergence: -inflow,
            damping: -nu.min(nu_of_pressure) * damping.sum().to_f64() - self.own_damping / density
                + self.edac.relaxation * pair.tait.sound_speed / h,
            split: ([0.0; D], [0.0; 3]),
        };
        for d in 0..D {
            let total = along_x[d].mul_add(along_x_scale, along_v[d] * along_v_scale);
            let carried = 0.5 * density * own(layout.velocity + d).to_f64() * drift_along;
            rates.acceleration[d] = total.sum().to_f64() + scale * (mean * push[d] + carried);
            if SPLIT {
                let pressed = (pressures[d] * along_x_scale).sum().to_f64();
                rates.split.0[d] = pressed + scale * mean * push[d];
            }
        }
        if SPLIT {
            let own_half = L::constant(0.5 * density * scale);
            rates.split.1 = std::array::from_fn(|c| {
                let moment = turn[0][c].mul_add(along_x_scale, turn[1][c] * along_v_scale);
                h * turn[2][c].mul_add(own_half, moment).sum().to_f64()
            });
        }
        rates
    }
}
