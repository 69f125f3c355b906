//! The scalar of the pair passes: `f64` or `f32`, a scene choice.

use std::fmt::{Debug, Display};
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use super::column::Element;
use super::lanes::{InstructionSet, Vectorised};

/// A floating-point scalar in which pair sums are taken.
pub trait Real:
    Element
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
    /// The nearest value of this type.
    fn from_f64(value: f64) -> Self;
    /// The same value in double precision.
    fn to_f64(self) -> f64;
    /// Magnitude.
    fn abs(self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Runs a task on the lanes that an instruction set has for this type.
    fn dispatch<T: Vectorised<Self>>(set: InstructionSet, task: T) -> T::Output;
}
