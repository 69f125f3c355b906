//! Smoothing kernels and the choice among them.
//!
//! ```text
//! W(r) = α_D/h^D w(q),   F(r) = (dW/dr)/r = α_D/h^(D+2) (dw/dq)/q ≤ 0,   q = r/h
//! (dw/dq)/q = β f(q)
//! ```
//!
//! F is finite at r = 0 for both kernels, so `∇W = F x_ab` needs no special case for a particle and
//! itself. The pair loops sum with f; the factor β is applied once, to the sum.
//!
//! To add a kernel: a file with a unit type that implements [`KernelShape`], a variant of
//! [`Kernel`] and its arms below. The tests take the kernels from `Kernel::ALL`.

mod quintic;
mod wendland;

use serde::{Deserialize, Serialize};

pub use quintic::Quintic;
pub use wendland::Wendland;

use super::lanes::{Array, Lanes};

/// Smoothing kernel W(r, h) of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Kernel {
    /// Wendland (1995) C2, support 2h, as in Alvarado-Rodríguez et al. (2017), Eq. 15. Take it
    /// under either scheme.
    WendlandC2,
    /// Quintic spline, support 3h, as in Negi et al. (2020), Eq. 5. Take it to compare with them.
    QuinticSpline,
}

/// Shape of a kernel over the dimensionless distance q = r/h, written over lanes.
pub trait KernelShape: Copy + Send + Sync + 'static {
    /// Radius of the compact support over h.
    const SUPPORT: f64;

    /// Norm β < 0 of the slope: (dw/dq)/q = β f(q).
    const SLOPE_NORM: f64;

    /// True if w(q) takes more operations than q itself.
    const COSTLY_VALUE: bool = false;

    /// Returns the norm α_D: W = α_D/h^D w(q).
    fn norm(dimensions: usize) -> f64;

    /// Returns w(q), which is zero beyond the support.
    fn value<L: Lanes>(q: L) -> L;

    /// Returns `sum` + w(q), with the last multiplication fused into the addition where the shape
    /// allows it.
    #[inline(always)]
    fn add_value<L: Lanes>(q: L, sum: L) -> L {
        sum + Self::value(q)
    }

    /// Returns f(q) ≥ 0, which is finite at q = 0 and zero beyond the support. `inverse_q` is 1/q,
    /// or any finite number where q = 0.
    fn slope<L: Lanes>(q: L, inverse_q: L) -> L;
}

/// Task that is compiled for each kernel shape.
pub trait WithShape {
    /// Result of the task.
    type Output;
    /// Runs the task with the shape `K`.
    fn run<K: KernelShape>(self) -> Self::Output;
}

impl Kernel {
    /// All kernels.
    pub const ALL: [Kernel; 2] = [Kernel::WendlandC2, Kernel::QuinticSpline];

    /// Returns the radius of the compact support over the smoothing length h.
    pub fn support_ratio(self) -> f64 {
        match self {
            Kernel::WendlandC2 => Wendland::SUPPORT,
            Kernel::QuinticSpline => Quintic::SUPPORT,
        }
    }

    /// Returns the norm α_D: W = α_D/h^D w(q).
    #[inline]
    pub fn norm(self, dimensions: usize) -> f64 {
        match self {
            Kernel::WendlandC2 => Wendland::norm(dimensions),
            Kernel::QuinticSpline => Quintic::norm(dimensions),
        }
    }

    /// Returns the norm β of the slope: (dw/dq)/q = β f(q).
    pub fn slope_norm(self) -> f64 {
        match self {
            Kernel::WendlandC2 => Wendland::SLOPE_NORM,
            Kernel::QuinticSpline => Quintic::SLOPE_NORM,
        }
    }

    /// Returns W(r), 1/m^D, for a smoothing length h, m.
    #[inline]
    pub fn value(self, dimensions: usize, h: f64, r: f64) -> f64 {
        let q = Array([r / h]);
        let Array([w]) = match self {
            Kernel::WendlandC2 => Wendland::value(q),
            Kernel::QuinticSpline => Quintic::value(q),
        };
        self.norm(dimensions) * w / power(h, dimensions)
    }

    /// Returns F(r) = (dW/dr)/r, 1/m^(D+2), for a smoothing length h, m.
    #[inline]
    pub fn slope(self, dimensions: usize, h: f64, r: f64) -> f64 {
        let q = Array([r / h]);
        let inverse_q = Array([h / r.max(f64::MIN_POSITIVE.sqrt() * h)]);
        let Array([slope]) = match self {
            Kernel::WendlandC2 => Wendland::slope(q, inverse_q),
            Kernel::QuinticSpline => Quintic::slope(q, inverse_q),
        };
        self.norm(dimensions) * self.slope_norm() * slope / power(h, dimensions + 2)
    }

    /// Runs a task with the shape of this kernel as a type, so that the kernel is matched once per
    /// task.
    #[inline(always)]
    pub fn with_shape<T: WithShape>(self, task: T) -> T::Output {
        match self {
            Kernel::WendlandC2 => task.run::<Wendland>(),
            Kernel::QuinticSpline => task.run::<Quintic>(),
        }
    }
}

/// Returns h to a power. Sampling needs it for every neighbour, and `powi` with an exponent known
/// only at run time is a call with a loop.
#[inline]
fn power(h: f64, exponent: usize) -> f64 {
    let square = h * h;
    match exponent {
        2 => square,
        3 => h * square,
        4 => square * square,
        5 => h * (square * square),
        _ => h.powi(exponent as i32),
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    const H: f64 = 0.37;

    #[test]
    fn integral_over_space_is_one() {
        for kernel in Kernel::ALL {
            for dimensions in [2, 3] {
                let steps = 20_000;
                let dr = kernel.support_ratio() * H / f64::from(steps);
                let sum: f64 = (0..steps)
                    .map(|i| (f64::from(i) + 0.5) * dr)
                    .map(|r| {
                        let shell = if dimensions == 2 { 2.0 * PI * r } else { 4.0 * PI * r * r };
                        kernel.value(dimensions, H, r) * shell * dr
                    })
                    .sum();
                // The midpoint rule leaves (dr/h)² ≈ 1e-8.
                assert!((sum - 1.0).abs() < 1e-7, "{kernel:?} in {dimensions}D: {sum}");
            }
        }
    }

    #[test]
    fn slope_is_the_finite_difference_of_the_value() {
        for kernel in Kernel::ALL {
            for dimensions in [2, 3] {
                let scale = kernel.value(dimensions, H, 0.0) / (H * H);
                for step in 1..100 {
                    let r = 0.0307 * H * f64::from(step);
                    let e = 1e-5 * H;
                    let difference = kernel.value(dimensions, H, r + e) - kernel.value(dimensions, H, r - e);
                    let slope = difference / (2.0 * e * r);
                    let found = kernel.slope(dimensions, H, r);
                    // Central differences have an error of e² from truncation and 1e-16/e from
                    // rounding.
                    assert!((found - slope).abs() < 1e-8 * scale, "{kernel:?} at {r}: {found}, not {slope}");
                    assert!(found <= 0.0);
                }
            }
        }
    }

    #[test]
    fn add_value_adds_the_value() {
        struct Adding;
        impl WithShape for Adding {
            type Output = ();
            fn run<K: KernelShape>(self) {
                for step in 0..70 {
                    let q = Array([0.05 * f64::from(step)]);
                    let (Array([value]), Array([sum])) = (K::value(q), K::add_value(q, Array([3.0])));
                    assert!((sum - 3.0 - value).abs() <= 1e-13 * (3.0 + value), "q = {}", q.0[0]);
                }
            }
        }
        for kernel in Kernel::ALL {
            kernel.with_shape(Adding);
        }
    }

    #[test]
    fn slope_is_finite_and_continuous_at_zero() {
        for kernel in Kernel::ALL {
            let at_zero = kernel.slope(2, H, 0.0);
            let near = kernel.slope(2, H, 1e-9 * H);
            assert!(at_zero < 0.0 && (at_zero - near).abs() < 1e-7 * at_zero.abs());
        }
    }

    #[test]
    fn value_and_slope_vanish_beyond_the_support() {
        for kernel in Kernel::ALL {
            for q in [1.0, 1.0 + 1e-12, 1.5, 1e6] {
                let r = q * kernel.support_ratio() * H;
                // At the edge itself r/h may round to just inside.
                let allowed = if q == 1.0 { 1e-40 } else { 0.0 };
                assert!(kernel.value(3, H, r).abs() <= allowed);
                assert!(kernel.slope(3, H, r).abs() <= allowed);
            }
        }
    }
}
