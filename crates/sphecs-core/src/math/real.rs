//! Scalar type of the pair passes: `f64` or `f32`, as the scene chooses.

use std::fmt::{Debug, Display};
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use super::column::Element;
use super::lanes::{InstructionSet, Vectorised};

/// Floating-point scalar in which pair sums are computed.
pub trait Real:
    bytemuck::Pod
    + Element
    + Copy
    + Send
    + Sync
    + Default
    + PartialOrd
    + Debug
    + Display
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
{
    /// Rounds to the nearest value of this type.
    fn from_f64(value: f64) -> Self;
    /// Converts to double precision without loss.
    fn to_f64(self) -> f64;
    /// Returns the absolute value.
    fn abs(self) -> Self;
    /// Returns the square root.
    fn sqrt(self) -> Self;
    /// Runs a task with the SIMD vectors of an instruction set for this type.
    fn dispatch<T: Vectorised<Self>>(set: InstructionSet, task: T) -> T::Output;
}
