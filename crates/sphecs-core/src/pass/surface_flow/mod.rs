//! Pressure and wall shear stress at points of the walls, by fits over the fluid before them.
//!
//! ```text
//! minimise Σ_b V_b W_b (v_b − v_w(x_b) − Σ_i c_i φ_i((x_b − x)/h))²
//! φ = n, n², n s, n t, s², s t, t²
//! v_w(x_b) = v_w + G_w (x_b − x),   τ = μ P (c_n/h + (G_w + G_wᵀ) n),   P = 1 − n n
//! p(x): linear fit,   |τ| = ρ u_τ² on walls with a wall function
//! ```
//!
//! n is the distance from the tangent plane, s and t are coordinates in it. The fit has neither a
//! constant nor slopes along the wall: there the fluid has the velocity v_w of the wall, with its
//! gradient G_w. The squares s² and t² follow a curved wall. Parabolas are exact. The fits are
//! moving least squares (Liu & Liu 2006), as those of [`sampling`](super::sampling). Where the
//! quadratic fit would amplify noise, the fit is linear. Fluid behind the plane of the surface,
//! such as that on the other side of a plate, does not count.

#[cfg(test)]
mod tests;

use std::marker::PhantomData;

use glam::{DMat3, DVec3};
use rayon::iter::{IndexedParallelIterator, ParallelIterator};
use rayon::slice::{ParallelSlice, ParallelSliceMut};

use super::density::LEAST_Q2;
use super::near_columns::{NearColumns, sums_of, whole};
use super::neighbours::Neighbours;
use super::sampling::solve_linear;
use super::settings::PairSettings;
use crate::math::grid::CellGrid;
use crate::math::kernel::{KernelShape, WithShape};
use crate::math::lanes::{Lanes, Vectorised};
use crate::math::linear::solve;
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::zone::Zone;
use crate::physics::wall::law::friction_velocity;

/// Index of the pressure among the columns; the velocity is before it.
const PRESSURE: usize = 3;

/// Largest variance of a quadratic slope along the normal over that of the velocity of a particle,
/// times h².
///
/// On a flat wall it is 3 to 10 with h = 2.6 to 1.5 Δ in 2D, and 0.2 to 0.5 for a linear fit.
const MOST_GAIN: f64 = 40.0;

/// Cosine of the angle to the normal below which fluid is behind the surface: on the other side of
/// a plate of one spacing, but not around a cylinder with a radius of six.
const BEHIND: f64 = -0.35;

/// Points that a thread takes at a time.
const POINTS: usize = 16;

/// Friction of a wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Friction {
    /// None: the wall slips.
    FreeSlip,
    /// Friction by the viscosity.
    NoSlip,
    /// Friction of a turbulent boundary layer (`WallFunction`).
    WallFunction,
}

/// Point of the surface of a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Position, m.
    pub position: DVec3,
    /// Unit normal, into the fluid.
    pub normal: DVec3,
    /// Velocity of the wall, m/s.
    pub velocity: DVec3,
    /// Gradient of that velocity, whose columns are its slopes along the axes, 1/s.
    pub gradient: DMat3,
    /// Friction of the wall.
    pub friction: Friction,
}

/// Flow at a point of a wall.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SurfaceFlow {
    /// Pressure, Pa.
    pub pressure: f64,
    /// Shear stress of the fluid on the wall, Pa.
    pub shear: DVec3,
}

/// Samples the flow at the walls.
pub struct SurfaceSampler<'a, R: Real, const D: usize> {
    neighbours: Neighbours<'a, R, D>,
    pair: &'a PairSettings,
    /// Kinematic viscosity, m²/s.
    viscosity: f64,
}

impl<'a, R: Real, const D: usize> SurfaceSampler<'a, R, D> {
    /// Returns a sampler of a fluid of a kinematic viscosity, m²/s.
    pub fn new(
        grid: &'a CellGrid<D>,
        particles: &'a ParticleArrays<R, D>,
        pair: &'a PairSettings,
        viscosity: f64,
    ) -> Self {
        Self { neighbours: Neighbours::new(grid, particles), pair, viscosity }
    }

    /// Returns the flow at each point; None where no fluid is in the support.
    ///
    /// A result depends on the particles around its point alone, so it is bitwise independent of
    /// the other points and of the number of threads.
    pub fn sample(&self, points: &[SurfacePoint]) -> Vec<Option<SurfaceFlow>> {
        let mut found = vec![None; points.len()];
        let task = AtPoints { sampler: self, points, found: &mut found };
        self.pair.discretisation.kernel.with_shape(task);
        found
    }

    /// Collects the fluid before a point, with velocities relative to the wall, and returns the
    /// number of particles.
    #[inline(always)]
    fn gather(&self, point: &SurfacePoint, near: &mut NearColumns<D>) -> usize {
        let particles = self.neighbours.particles;
        let (mass, scale) = (self.pair.discretisation.mass, 1.0 / self.pair.discretisation.smoothing_length);
        let frame = frame::<D>(point.normal);
        near.clear();
        self.neighbours.for_each(std::array::from_fn(|d| point.position[d]), |row, x_ab, _| {
            if particles.zone[row] != Zone::Fluid {
                return;
            }
            let mut way = DVec3::ZERO;
            for d in 0..D {
                way[d] = -x_ab[d];
            }
            if way.dot(point.normal) < BEHIND * way.length() {
                return;
            }
            let wall = point.velocity + point.gradient * way;
            for d in 0..D {
                near.offset[d].push(way.dot(frame[d]) * scale);
                near.fields[d].push(particles.velocity[d][row].to_f64() - wall[d]);
            }
            let density = particles.density[row].to_f64();
            near.fields[PRESSURE].push(particles.pressure[row].to_f64());
            near.fields[PRESSURE + 1].push(density);
            near.volume.push(mass / density);
        });
        near.pad()
    }

    /// Fits at a point by `N` functions: 1, `D` coordinates and their products.
    #[inline(always)]
    fn fit<K: KernelShape, L: Lanes<Real = f64>, const N: usize>(
        &self,
        point: &SurfacePoint,
        near: &mut NearColumns<D>,
    ) -> Option<SurfaceFlow> {
        let count = self.gather(point, near);
        let zero = L::constant(0.0);
        let (mut moments, mut sums) = ([[zero; N]; N], [[zero; N]; PRESSURE + 1]);
        let mut density = zero;
        for at in (0..count).step_by(L::COUNT) {
            let basis = near.basis::<L, N>(at);
            let mut q2 = L::constant(LEAST_Q2);
            for d in 0..D {
                q2 = basis[1 + d].mul_add(basis[1 + d], q2);
            }
            let weight = L::read(&near.volume[at..]) * K::value(q2.roots().0);
            // The gain needs it once more.
            weight.write(&mut near.volume[at..]);
            density = weight.mul_add(L::read(&near.fields[PRESSURE + 1][at..]), density);
            for i in 0..N {
                let weighted = weight * basis[i];
                for j in i..N {
                    moments[i][j] = weighted.mul_add(basis[j], moments[i][j]);
                }
                for field in (0..D).chain([PRESSURE]) {
                    let value = L::read(&near.fields[field][at..]);
                    sums[field][i] = weighted.mul_add(value, sums[field][i]);
                }
            }
        }
        let moments = whole(moments);
        let mut right = [[0.0; N]; PRESSURE + 1];
        for field in 0..=PRESSURE {
            right[field] = sums_of(&sums[field]);
        }
        let total = moments[0][0];
        if total <= 0.0 {
            return None;
        }
        let density = density.sum() / total;
        let shear = match point.friction {
            Friction::FreeSlip => DVec3::ZERO,
            Friction::NoSlip => {
                let slope = quadratic::<L, N, D>(near, count, (&moments, &right));
                let slope = slope.unwrap_or_else(|| linear::<N, D>(&moments, &right));
                let slope = slope / self.pair.discretisation.smoothing_length;
                traction(slope, point) * (density * self.viscosity)
            }
            Friction::WallFunction => self.turbulent(point, density, (&moments, &right)),
        };
        let block =
            std::array::from_fn(|i| std::array::from_fn(|j| if i.max(j) <= D { moments[i][j] } else { 0.0 }));
        let of_pressure = std::array::from_fn(|i| if i <= D { right[PRESSURE][i] } else { 0.0 });
        Some(SurfaceFlow { pressure: solve_linear(block, of_pressure, D), shear })
    }

    /// Returns the shear stress of the law of the wall, Pa, for the mean flow in the support.
    fn turbulent<const N: usize>(
        &self,
        point: &SurfacePoint,
        density: f64,
        (moments, right): (&[[f64; N]; N], &[[f64; N]; PRESSURE + 1]),
    ) -> DVec3 {
        let total = moments[0][0];
        let mut velocity = DVec3::ZERO;
        for d in 0..D {
            velocity[d] = right[d][0] / total;
        }
        let distance = moments[0][1] / total;
        let along = velocity - velocity.dot(point.normal) * point.normal;
        let Some(direction) = along.try_normalize() else { return DVec3::ZERO };
        let distance = distance * self.pair.discretisation.smoothing_length;
        let friction = friction_velocity(along.length(), distance, self.viscosity);
        direction * (density * friction * friction)
    }
}

/// Returns the normal and unit vectors in the tangent plane.
fn frame<const D: usize>(normal: DVec3) -> [DVec3; D] {
    let (first, second) = match D {
        2 => (normal.truncate().perp().extend(0.0), DVec3::Z),
        _ => normal.any_orthonormal_pair(),
    };
    std::array::from_fn(|axis| [normal, first, second][axis])
}

/// Returns P (∂v/∂n + (G_w + G_wᵀ) n), 1/s, of the slope of the velocity relative to the wall, 1/s.
fn traction(slope: DVec3, point: &SurfacePoint) -> DVec3 {
    let of_wall = point.gradient * point.normal + point.gradient.transpose() * point.normal;
    let rate = slope + of_wall;
    rate - rate.dot(point.normal) * point.normal
}

/// Index of the coordinate along the normal in the basis; those along the wall are behind it.
const NORMAL: usize = 1;

/// Returns the slope along the normal of a quadratic fit times h; None where it would amplify
/// noise.
#[inline(always)]
fn quadratic<L: Lanes<Real = f64>, const N: usize, const D: usize>(
    near: &NearColumns<D>,
    count: usize,
    (moments, right): (&[[f64; N]; N], &[[f64; N]; PRESSURE + 1]),
) -> Option<DVec3> {
    let total = moments[0][0];
    let is_left_out = |index: usize| index <= D && index != NORMAL;
    let matrix = std::array::from_fn(|i| {
        std::array::from_fn(|j| match is_left_out(i) || is_left_out(j) {
            true => f64::from(u8::from(i == j)),
            false => moments[i][j] / total,
        })
    });
    // The slope is Σ_b V_b W_b Σ_i a_i φ_i v_b.
    let shares: [f64; N] = solve(matrix, std::array::from_fn(|i| f64::from(u8::from(i == NORMAL))))?;
    if near.gain::<L, N>(count, total, &shares) > MOST_GAIN {
        return None;
    }
    let mut slope = DVec3::ZERO;
    for field in 0..D {
        slope[field] = shares.iter().zip(right[field]).map(|(share, sum)| share * sum / total).sum();
    }
    Some(slope)
}

/// Returns the slope along the normal of a linear fit times h.
fn linear<const N: usize, const D: usize>(
    moments: &[[f64; N]; N],
    right: &[[f64; N]; PRESSURE + 1],
) -> DVec3 {
    let mut slope = DVec3::ZERO;
    for field in 0..D {
        slope[field] = right[field][NORMAL] / moments[NORMAL][NORMAL];
    }
    slope
}

/// Samples at a list of points, before the kernel is known.
struct AtPoints<'a, R: Real, const D: usize> {
    sampler: &'a SurfaceSampler<'a, R, D>,
    points: &'a [SurfacePoint],
    found: &'a mut [Option<SurfaceFlow>],
}

impl<R: Real, const D: usize> WithShape for AtPoints<'_, R, D> {
    type Output = ();

    fn run<K: KernelShape>(self) {
        let Self { sampler, points, found } = self;
        points.par_chunks(POINTS).zip(found.par_chunks_mut(POINTS)).for_each_init(
            NearColumns::new,
            |near, (points, found)| {
                let chunk = VectorPoints::<K, R, D> { sampler, points, found, near, shape: PhantomData };
                f64::dispatch(sampler.pair.lanes, chunk);
            },
        );
    }
}

/// Samples at consecutive points of the list.
struct VectorPoints<'a, K, R: Real, const D: usize> {
    sampler: &'a SurfaceSampler<'a, R, D>,
    points: &'a [SurfacePoint],
    found: &'a mut [Option<SurfaceFlow>],
    near: &'a mut NearColumns<D>,
    shape: PhantomData<K>,
}

impl<K: KernelShape, R: Real, const D: usize> Vectorised<f64> for VectorPoints<'_, K, R, D> {
    type Output = ();
    type Module = Self;

    #[inline(always)]
    fn run<L: Lanes<Real = f64>>(self) {
        for (point, found) in self.points.iter().zip(self.found) {
            *found = match D {
                2 => self.sampler.fit::<K, L, 6>(point, self.near),
                _ => self.sampler.fit::<K, L, 10>(point, self.near),
            };
        }
    }
}
