//! Fits of the fluid's fields at a point, over the neighbours in a pack.
//!
//! ```text
//! minimise Σ_b V_b W_b (f_b − Σ_i c_i φ_i(x_b − x))²
//! →   f(x) = c_0,   φ_0 = 1, the others 0 at x
//! ```
//!
//! These are moving least squares over the fluid; with φ_0 alone they are the kernel mean, Σ V W
//! f/Σ V W.

use glam::DVec3;

use super::density::LEAST_Q2;
use super::pack::{Entry, Pack};
use super::sampling::solve_linear;
use crate::math::kernel::KernelShape;
use crate::math::lanes::{self, Lanes};
use crate::math::linear::solve;
use crate::math::real::Real;

/// Columns besides the coordinates: volume of the fluid, pressure, velocity.
pub(super) const COLUMNS: usize = 2 + 3;
/// Index of the fluid's volume among the columns behind the coordinates.
pub(super) const VOLUME: usize = 0;
/// Index of the pressure among them.
pub(super) const PRESSURE: usize = 1;
/// Index of the first component of velocity among them.
pub(super) const VELOCITY: usize = 2;

/// Quantities that are fitted at each point, and their bases.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointFit {
    /// The pressure, by a linear basis.
    Pressure,
    /// The kernel mean of the pressure, and the velocity along the normal of a section.
    ///
    /// The basis of the velocity is linear along the normal and quadratic across it. A kernel mean
    /// would lower the peak of a Poiseuille profile with 25 particles across by 3 %. It would also
    /// raise the velocity of the layer at the wall, which no outlet can follow.
    Section {
        /// Unit normal of the section.
        normal: DVec3,
        /// Unit vectors in the section; the second is not used in 2D.
        across: [DVec3; 2],
    },
    /// The kernel means of the pressure and of the velocity along a normal.
    Mean {
        /// Unit normal.
        normal: DVec3,
    },
    /// The kernel mean of a column of the caller, returned as the pressure.
    Column,
    /// Velocity and pressure with their slopes along a normal, by a linear basis.
    Image {
        /// Unit normal.
        normal: DVec3,
    },
}

impl PointFit {
    /// Returns the number of columns that a pack must have behind the coordinates.
    pub(super) fn columns(self, dimensions: usize) -> usize {
        match self {
            PointFit::Pressure | PointFit::Column => VELOCITY,
            PointFit::Section { .. } | PointFit::Mean { .. } | PointFit::Image { .. } => {
                VELOCITY + dimensions
            }
        }
    }

    /// Fits at a point of a pack, in units of h; None where no fluid is in the support.
    #[inline(always)]
    pub(super) fn at<K: KernelShape, L: Lanes, const D: usize>(
        self,
        pack: &Pack<L::Real>,
        at: [L::Real; D],
        inverse_h: f64,
    ) -> Option<PointFlow> {
        match self {
            PointFit::Pressure => pressure::<K, L, D>(pack, at),
            PointFit::Section { normal, across } if D == 2 => section::<K, L, D, 4>(pack, at, normal, across),
            PointFit::Section { normal, across } => section::<K, L, D, 7>(pack, at, normal, across),
            PointFit::Mean { normal } => mean::<K, L, D>(pack, at, Some(normal)),
            PointFit::Column => mean::<K, L, D>(pack, at, None),
            PointFit::Image { normal } if D == 2 => image::<K, L, D, 3>(pack, at, normal, inverse_h),
            PointFit::Image { normal } => image::<K, L, D, 4>(pack, at, normal, inverse_h),
        }
    }
}

/// Fields at a point and their slopes along a normal.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Image {
    /// Velocity, m/s.
    pub velocity: DVec3,
    /// ∂v/∂n, 1/s.
    pub velocity_slope: DVec3,
    /// Pressure, Pa.
    pub pressure: f64,
    /// ∂p/∂n, Pa/m.
    pub pressure_slope: f64,
}

/// The flow found at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct PointFlow {
    /// Velocity along the normal of the section, m/s; 0 where only the pressure is fitted.
    pub velocity: f64,
    /// Pressure, Pa.
    pub pressure: f64,
    /// Velocity, m/s, and pressure with their slopes along the normal, 1/s and Pa/m, of an image
    /// fit; else 0.
    pub image: Image,
}

/// Returns x_b − x in units of h, and V_b w(q), of the neighbours in an entry.
#[inline(always)]
fn offset<K: KernelShape, L: Lanes, const D: usize>(entry: &Entry<'_, L>, at: [L::Real; D]) -> ([L; D], L) {
    let mut offset = [L::constant(0.0); D];
    let mut q2 = L::constant(LEAST_Q2);
    for d in 0..D {
        offset[d] = entry.column(d) - L::splat(at[d]);
        q2 = offset[d].mul_add(offset[d], q2);
    }
    (offset, entry.column(D + VOLUME) * K::value(q2.roots().0))
}

/// Fits the pressure by a linear basis.
#[inline(always)]
fn pressure<K: KernelShape, L: Lanes, const D: usize>(
    pack: &Pack<L::Real>,
    at: [L::Real; D],
) -> Option<PointFlow> {
    let mut moments = [[L::constant(0.0); 4]; 4];
    let mut right = [L::constant(0.0); 4];
    for entry in pack.entries::<L>(D + VELOCITY) {
        let (offset, weight) = offset::<K, L, D>(&entry, at);
        let mut basis = [L::constant(1.0); 4];
        basis[1..=D].copy_from_slice(&offset);
        add(&mut moments, &mut right, basis, D + 1, weight, entry.column(D + PRESSURE));
    }
    let moments = symmetric(moments, D + 1);
    let right = lanes::sums(right);
    if moments[0][0] <= 0.0 {
        return None;
    }
    Some(PointFlow { pressure: solve_linear(moments, right, D), ..PointFlow::default() })
}

/// Fits the velocity along a normal by `N` functions; the pressure is a kernel mean.
#[inline(always)]
fn section<K: KernelShape, L: Lanes, const D: usize, const N: usize>(
    pack: &Pack<L::Real>,
    at: [L::Real; D],
    normal: DVec3,
    across: [DVec3; 2],
) -> Option<PointFlow> {
    let directions = [normal, across[0], across[1]];
    let mut moments = [[L::constant(0.0); N]; N];
    let mut right = [L::constant(0.0); N];
    let mut pressure = L::constant(0.0);
    for entry in pack.entries::<L>(D + VELOCITY + D) {
        let (offset, weight) = offset::<K, L, D>(&entry, at);
        let mut along = [L::constant(0.0); 3];
        let mut velocity = L::constant(0.0);
        for d in 0..D {
            for (along, direction) in along.iter_mut().zip(directions) {
                *along = offset[d].mul_add(L::constant(direction[d]), *along);
            }
            velocity = entry.column(D + VELOCITY + d).mul_add(L::constant(normal[d]), velocity);
        }
        let [n, s, t] = along;
        let one = L::constant(1.0);
        let mut basis = [one; N];
        if N == 4 {
            basis.copy_from_slice(&[one, n, s, s * s]);
        } else {
            basis.copy_from_slice(&[one, n, s, t, s * s, s * t, t * t]);
        }
        add(&mut moments, &mut right, basis, N, weight, velocity);
        pressure = weight.mul_add(entry.column(D + PRESSURE), pressure);
    }
    let moments = symmetric(moments, N);
    let weight = moments[0][0];
    if weight <= 0.0 {
        return None;
    }
    let right = lanes::sums(right).map(|sum| sum / weight);
    let fitted = solve(moments.map(|row| row.map(|moment| moment / weight)), right);
    Some(PointFlow {
        // The kernel mean applies where the neighbours do not span the basis.
        velocity: fitted.map_or(right[0], |coefficients| coefficients[0]),
        pressure: pressure.sum().to_f64() / weight,
        ..PointFlow::default()
    })
}

/// Returns the kernel means of the pressure and, along a normal, of the velocity.
#[inline(always)]
fn mean<K: KernelShape, L: Lanes, const D: usize>(
    pack: &Pack<L::Real>,
    at: [L::Real; D],
    normal: Option<DVec3>,
) -> Option<PointFlow> {
    let columns = if normal.is_some() { D + VELOCITY + D } else { D + VELOCITY };
    let normal = normal.unwrap_or_default();
    let mut sums = [L::constant(0.0); 3];
    for entry in pack.entries::<L>(columns) {
        let (_, weight) = offset::<K, L, D>(&entry, at);
        let mut velocity = L::constant(0.0);
        if columns > D + VELOCITY {
            for d in 0..D {
                velocity = entry.column(D + VELOCITY + d).mul_add(L::constant(normal[d]), velocity);
            }
        }
        sums[0] = sums[0] + weight;
        sums[1] = weight.mul_add(entry.column(D + PRESSURE), sums[1]);
        sums[2] = weight.mul_add(velocity, sums[2]);
    }
    let [weight, pressure, velocity] = lanes::sums(sums);
    (weight > 0.0).then(|| PointFlow {
        velocity: velocity / weight,
        pressure: pressure / weight,
        ..PointFlow::default()
    })
}

/// Fits pressure and velocity by a linear basis, with their slopes along a normal.
///
/// Returns the kernel means where the neighbours do not span the basis.
#[inline(always)]
fn image<K: KernelShape, L: Lanes, const D: usize, const N: usize>(
    pack: &Pack<L::Real>,
    at: [L::Real; D],
    normal: DVec3,
    inverse_h: f64,
) -> Option<PointFlow> {
    let mut moments = [[L::constant(0.0); N]; N];
    // Pressure, then velocity.
    let mut right = [[L::constant(0.0); N]; 4];
    for entry in pack.entries::<L>(D + VELOCITY + D) {
        let (offset, weight) = offset::<K, L, D>(&entry, at);
        let mut basis = [L::constant(1.0); N];
        basis[1..].copy_from_slice(&offset);
        for i in 0..N {
            let weighted = weight * basis[i];
            right[0][i] = weighted.mul_add(entry.column(D + PRESSURE), right[0][i]);
            for d in 0..D {
                right[1 + d][i] = weighted.mul_add(entry.column(D + VELOCITY + d), right[1 + d][i]);
            }
            for j in 0..=i {
                moments[i][j] = weighted.mul_add(basis[j], moments[i][j]);
            }
        }
    }
    let moments = symmetric(moments, N);
    let weight = moments[0][0];
    if weight <= 0.0 {
        return None;
    }
    let moments = moments.map(|row| row.map(|moment| moment / weight));
    let mut fields = [(0.0, 0.0); 4];
    for (field, right) in fields.iter_mut().zip(&right).take(1 + D) {
        let right = lanes::sums(*right).map(|sum| sum / weight);
        *field = match solve(moments, right) {
            Some(fitted) => (fitted[0], inverse_h * (0..D).map(|d| fitted[1 + d] * normal[d]).sum::<f64>()),
            None => (right[0], 0.0),
        };
    }
    let vector = |of: fn(&(f64, f64)) -> f64| DVec3::new(of(&fields[1]), of(&fields[2]), of(&fields[3]));
    let image = Image {
        velocity: vector(|field| field.0),
        velocity_slope: vector(|field| field.1),
        pressure: fields[0].0,
        pressure_slope: fields[0].1,
    };
    Some(PointFlow { velocity: image.velocity.dot(normal), pressure: image.pressure, image })
}

/// Adds neighbours to the lower triangle of the moments and to the right-hand side, for the first
/// `count` functions.
#[inline(always)]
fn add<L: Lanes, const N: usize>(
    moments: &mut [[L; N]; N],
    right: &mut [L; N],
    basis: [L; N],
    count: usize,
    weight: L,
    value: L,
) {
    for i in 0..count {
        let weighted = weight * basis[i];
        right[i] = weighted.mul_add(value, right[i]);
        for j in 0..=i {
            moments[i][j] = weighted.mul_add(basis[j], moments[i][j]);
        }
    }
}

/// Returns both triangles of the moments, summed over the lanes.
#[inline(always)]
fn symmetric<L: Lanes, const N: usize>(moments: [[L; N]; N], count: usize) -> [[f64; N]; N] {
    let mut all = [[0.0; N]; N];
    for i in 0..count {
        for j in 0..=i {
            all[i][j] = moments[i][j].sum().to_f64();
            all[j][i] = all[i][j];
        }
    }
    all
}
