//! SIMD vectors in which the pair terms are written, one neighbour per lane.
//!
//! A pair function is generic over `L: Lanes`: one source for f64 and f32 and for every instruction
//! set. [`Real::dispatch`] chooses the set once per task: it calls [`Vectorised::run`] inside a
//! function that is compiled for that set. Everything from there to the arithmetic is
//! `#[inline(always)]`; otherwise the compiler could move the inner loop to a function compiled
//! without these instructions.
//!
//! | instruction set | lanes of f64 | lanes of f32 |
//! |---|---|---|
//! | AVX-512 | 8 | 16 |
//! | AVX2 with FMA and BMI | 4 | 8 |
//! | portable | 2 | 4 |

mod instruction_set;
mod portable;
#[cfg(target_arch = "x86_64")]
mod x86;

use std::ops::{Add, Div, Mul, Neg, Sub};

pub use instruction_set::InstructionSet;
pub use portable::Array;

use super::real::Real;

/// Largest number of lanes of any instruction set.
pub const MOST_LANES: usize = 16;

/// For each byte, four bits, one for each pair of its bits: set if at least one bit of the pair is.
static PAIRS: [u8; 256] = {
    let mut pairs = [0; 256];
    let mut bits = 0;
    while bits < 256 {
        let mut pair = 0;
        while pair < 4 {
            if bits >> (2 * pair) & 3 != 0 {
                pairs[bits] |= 1 << pair;
            }
            pair += 1;
        }
        bits += 1;
    }
    pairs
};

/// SIMD vector: the numbers that one instruction processes.
pub trait Lanes:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// Number in one lane.
    type Real: Real;
    /// One boolean per lane.
    type Mask: Copy;
    /// Number of lanes.
    const COUNT: usize;
    /// True if [`roots`](Lanes::roots) uses the instructions for square root and division, whose
    /// latency would dominate a loop that has one in every vector.
    const COSTLY_ROOTS: bool = false;

    /// Returns a vector with the same number in every lane.
    fn splat(value: Self::Real) -> Self;

    /// Loads `COUNT` consecutive numbers.
    ///
    /// # Safety
    /// `from` must be valid for reading `COUNT` numbers.
    unsafe fn load(from: *const Self::Real) -> Self;

    /// Loads the first `COUNT` of the numbers.
    #[inline(always)]
    fn first_of(numbers: &[Self::Real; MOST_LANES]) -> Self {
        const { assert!(Self::COUNT <= MOST_LANES) };
        // SAFETY: the array has at least `COUNT` numbers.
        unsafe { Self::load(numbers.as_ptr()) }
    }

    /// Returns the lanes as an array, followed by zeros.
    #[inline(always)]
    fn to_array(self) -> [Self::Real; MOST_LANES] {
        const { assert!(Self::COUNT <= MOST_LANES) };
        let mut numbers = [Self::Real::default(); MOST_LANES];
        // SAFETY: the array has space for `COUNT` numbers.
        unsafe { self.store(numbers.as_mut_ptr()) };
        numbers
    }

    /// Loads the first `COUNT` of the numbers, padded with zeros if there are fewer.
    #[inline(always)]
    fn read(numbers: &[Self::Real]) -> Self {
        if numbers.len() >= Self::COUNT {
            // SAFETY: the slice has at least `COUNT` numbers.
            return unsafe { Self::load(numbers.as_ptr()) };
        }
        let mut copy = [Self::Real::default(); MOST_LANES];
        copy[..numbers.len()].copy_from_slice(numbers);
        Self::first_of(&copy)
    }

    /// Stores the lanes to the first `COUNT` of the numbers.
    ///
    /// # Panics
    /// If there are fewer than `COUNT` numbers.
    #[inline(always)]
    fn write(self, numbers: &mut [Self::Real]) {
        assert!(numbers.len() >= Self::COUNT);
        // SAFETY: the slice has at least `COUNT` numbers.
        unsafe { self.store(numbers.as_mut_ptr()) }
    }

    /// Loads `COUNT` consecutive positions relative to an origin, as `(x − origin) · scale`, which
    /// is computed in f64 and then converted.
    ///
    /// # Safety
    /// `from` must be valid for reading `COUNT` numbers.
    unsafe fn load_relative(from: *const f64, origin: f64, scale: f64) -> Self;

    /// Stores `COUNT` consecutive numbers.
    ///
    /// # Safety
    /// `to` must be valid for writing `COUNT` numbers.
    unsafe fn store(self, to: *mut Self::Real);

    /// Stores the lanes under the mask consecutively; the numbers behind them, up to `COUNT`, are
    /// arbitrary.
    ///
    /// # Safety
    /// `to` must be valid for writing `COUNT` numbers.
    unsafe fn compress(self, mask: Self::Mask, to: *mut Self::Real);

    /// Returns `self · factor + term`, rounded once if the set has the instruction.
    fn mul_add(self, factor: Self, term: Self) -> Self;

    /// Returns the larger number of each lane.
    fn max(self, other: Self) -> Self;

    /// Returns the smaller number of each lane.
    fn min(self, other: Self) -> Self;

    /// Returns the absolute values.
    fn abs(self) -> Self;

    /// Returns the square roots.
    fn sqrt(self) -> Self;

    /// Returns 1/x to a few units in the last place, for normal x.
    fn inverse(self) -> Self;

    /// Returns √x and 1/√x to a few units in the last place, for normal x > 0.
    ///
    /// The compiler drops the one that is not used.
    fn roots(self) -> (Self, Self);

    /// Returns the mask of the lanes in which `self < other`.
    fn less(self, other: Self) -> Self::Mask;

    /// Returns `yes` under the mask and `no` elsewhere.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;

    /// Returns `value` under the mask and 0 elsewhere.
    #[inline(always)]
    fn keep(mask: Self::Mask, value: Self) -> Self {
        Self::select(mask, value, Self::constant(0.0))
    }

    /// Returns the mask as bits, with the first lane in the lowest bit.
    fn bits(mask: Self::Mask) -> u32;

    /// Returns one bit per pair of lanes, the first pair in the lowest bit: set if at least one of
    /// the two is under the mask.
    #[inline(always)]
    fn pair_bits(mask: Self::Mask) -> u32 {
        let [lower, upper, ..] = Self::bits(mask).to_le_bytes();
        u32::from(PAIRS[usize::from(lower)]) | u32::from(PAIRS[usize::from(upper)]) << 4
    }

    /// Returns the sum over the lanes.
    fn sum(self) -> Self::Real;

    /// Returns the sums over the lanes of the first `COUNT` vectors, the sum of vector i in lane i.
    ///
    /// Takes fewer than half the operations of `COUNT` calls of [`Lanes::sum`].
    fn sum_each(vectors: &[Self; MOST_LANES]) -> Self;

    /// Returns the largest number of all lanes.
    fn largest(self) -> Self::Real;

    /// Returns a vector with a number, given in double precision, in every lane.
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self::splat(Self::Real::from_f64(value))
    }
}

/// Task that is compiled for each instruction set; `run` must be `#[inline(always)]`.
pub trait Vectorised<R: Real> {
    /// Result of the task.
    type Output;
    /// Type in whose module the task is compiled: `Self`, or the method that a driver of several
    /// methods runs.
    ///
    /// Without it the tasks of all passes would be compiled by one thread, for minutes.
    type Module;
    /// Runs the task with vectors of type `L`.
    fn run<L: Lanes<Real = R>>(self) -> Self::Output;
}

/// Returns the dot product of two spatial vectors, one pair of vectors per lane.
#[inline(always)]
pub fn dot<L: Lanes, const D: usize>(a: [L; D], b: [L; D]) -> L {
    let mut sum = a[0] * b[0];
    for d in 1..D {
        sum = a[d].mul_add(b[d], sum);
    }
    sum
}

/// Returns the sum over the lanes of each vector.
///
/// A loop instead of `map`, which may be compiled as a function without the instructions of the
/// set.
#[inline(always)]
pub fn sums<L: Lanes, const N: usize>(vectors: [L; N]) -> [f64; N] {
    let mut sums = [0.0; N];
    for i in 0..N {
        sums[i] = vectors[i].sum().to_f64();
    }
    sums
}

/// Adds a multiple of a spatial vector to a sum, lane by lane.
#[inline(always)]
pub fn add_scaled<L: Lanes>(sum: &mut [L; 3], scale: L, vector: [L; 3]) {
    for (sum, component) in sum.iter_mut().zip(vector) {
        *sum = scale.mul_add(component, *sum);
    }
}

/// Returns the cross product of two spatial vectors, lane by lane; in 2D it has only a z component.
#[inline(always)]
pub fn cross<L: Lanes, const D: usize>(a: [L; D], b: [L; D]) -> [L; 3] {
    let component =
        |i: usize, j: usize| if i < D && j < D { a[i] * b[j] - a[j] * b[i] } else { L::constant(0.0) };
    [component(1, 2), component(2, 0), component(0, 1)]
}

impl Real for f64 {
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }
    #[inline(always)]
    fn abs(self) -> Self {
        f64::abs(self)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
    fn dispatch<T: Vectorised<Self>>(set: InstructionSet, task: T) -> T::Output {
        instruction_set::run_f64(set, task)
    }
}

impl Real for f32 {
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        value as f32
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        f32::abs(self)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f32::sqrt(self)
    }
    fn dispatch<T: Vectorised<Self>>(set: InstructionSet, task: T) -> T::Output {
        instruction_set::run_f32(set, task)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares every operation with its scalar counterpart in f64.
    struct Arithmetic;

    impl<R: Real> Vectorised<R> for Arithmetic {
        type Output = ();
        type Module = Self;
        #[inline(always)]
        fn run<L: Lanes<Real = R>>(self) {
            let epsilon = if std::mem::size_of::<R>() == 8 { 1e-15 } else { 4e-7 };
            let numbers = |scale: f64, offset: f64| -> Vec<R> {
                (0..L::COUNT).map(|i| R::from_f64(scale * i as f64 + offset)).collect()
            };
            let (first, second) = (numbers(0.71, 0.013), numbers(-0.37, 1.9));
            // SAFETY: both hold `COUNT` numbers.
            let (a, b) = unsafe { (L::load(first.as_ptr()), L::load(second.as_ptr())) };
            let check = |name: &str, lanes: L, expected: &dyn Fn(f64, f64) -> f64| {
                let mut found = numbers(0.0, 0.0);
                // SAFETY: it holds `COUNT` numbers.
                unsafe { lanes.store(found.as_mut_ptr()) };
                for i in 0..L::COUNT {
                    let expected = expected(first[i].to_f64(), second[i].to_f64());
                    let error = (found[i].to_f64() - expected).abs();
                    assert!(error <= epsilon * (1.0 + expected.abs()), "{name}: {} for {expected}", found[i]);
                }
            };
            check("add", a + b, &|a, b| a + b);
            check("sub", a - b, &|a, b| a - b);
            check("mul", a * b, &|a, b| a * b);
            check("div", b / a, &|a, b| b / a);
            check("neg", -a, &|a, _| -a);
            check("mul_add", a.mul_add(b, a), &|a, b| a * b + a);
            check("max", a.max(b), &f64::max);
            check("min", a.min(b), &f64::min);
            check("abs", b.abs(), &|_, b| b.abs());
            check("sqrt", a.sqrt(), &|a, _| a.sqrt());
            check("inverse", b.inverse(), &|_, b| 1.0 / b);
            check("root", a.roots().0, &|a, _| a.sqrt());
            check("inverse root", a.roots().1, &|a, _| 1.0 / a.sqrt());
            check("keep", L::keep(a.less(b), b), &|a, b| if a < b { b } else { 0.0 });
            check("select", L::select(a.less(b), a, b), &f64::min);
            let sum: f64 = first.iter().map(|x| x.to_f64()).sum();
            assert!((a.sum().to_f64() - sum).abs() <= epsilon * 4.0 * sum);
            assert_eq!(a.largest(), first[L::COUNT - 1]);
            let vectors: [L; MOST_LANES] = std::array::from_fn(|i| a * L::constant(i as f64 - 2.5) + b);
            let each = L::sum_each(&vectors);
            check_each(each, &vectors, epsilon);
            assert_eq!(L::first_of(&a.to_array()).to_array()[..L::COUNT], first);
            assert_eq!(L::read(&[&first[..], &second].concat()).to_array()[..L::COUNT], first);
            let short = L::read(&second[1..]).to_array();
            assert_eq!((&short[..L::COUNT - 1], short[L::COUNT - 1]), (&second[1..], R::default()));
            let mut written = [&second[..], &second].concat();
            a.write(&mut written);
            assert_eq!(written, [&first[..], &second].concat());
            let below = first.iter().zip(&second).filter(|(a, b)| a < b).count();
            assert_eq!(L::bits(a.less(b)).count_ones() as usize, below);
            assert_eq!(L::bits(a.less(L::constant(0.5))), 1);
            let bits = L::bits(a.less(b));
            for pair in 0..L::COUNT.div_ceil(2) {
                let any = bits >> (2 * pair) & 3 != 0;
                assert_eq!(L::pair_bits(a.less(b)) >> pair & 1, u32::from(any), "{bits:b}");
            }

            let mut packed = numbers(0.0, 0.0);
            // SAFETY: it holds `COUNT` numbers.
            unsafe { a.compress(a.less(L::constant(0.5)), packed.as_mut_ptr()) };
            assert_eq!(packed[0], first[0]);
            // SAFETY: it holds `COUNT` numbers.
            unsafe { a.compress(L::constant(0.5).less(a), packed.as_mut_ptr()) };
            assert_eq!(packed[..L::COUNT - 1], first[1..]);

            let positions: Vec<f64> = (0..L::COUNT).map(|i| 1e3 + 0.01 * i as f64).collect();
            // SAFETY: `positions` holds `COUNT` numbers.
            let relative = unsafe { L::load_relative(positions.as_ptr(), 1e3, 10.0) };
            let expected = R::from_f64((positions[L::COUNT - 1] - 1e3) * 10.0);
            assert_eq!(relative.largest(), expected);
        }
    }

    fn check_each<L: Lanes>(each: L, vectors: &[L; MOST_LANES], epsilon: f64) {
        for (found, vector) in each.to_array().into_iter().zip(vectors).take(L::COUNT) {
            let (found, expected) = (found.to_f64(), vector.sum().to_f64());
            let size: f64 = vector.to_array().iter().map(|x| x.to_f64().abs()).sum();
            assert!((found - expected).abs() <= 4.0 * epsilon * size, "{found}, not {expected}");
        }
    }

    #[test]
    fn every_instruction_set_agrees_with_scalar_arithmetic() {
        for set in InstructionSet::available() {
            f64::dispatch(set, Arithmetic);
            f32::dispatch(set, Arithmetic);
        }
    }
}
