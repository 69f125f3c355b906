//! Lanes: the vectors of numbers that pair physics is written in, one neighbour per lane.
//!
//! A pair function takes `L: Lanes` and is the same text for f64 and f32 and for every instruction set. Which set
//! runs is chosen once per task by [`Real::dispatch`]: it calls [`Vectorised::run`] inside a function compiled for
//! that set. Everything between there and the arithmetic is `#[inline(always)]`, or the compiler would put the inner
//! loop into a function without the instructions.
//!
//! | set | f64 | f32 |
//! |---|---|---|
//! | AVX-512 | 8 | 16 |
//! | AVX2 with FMA and BMI | 4 | 8 |
//! | portable | 2 | 4 |

mod portable;
mod set;
#[cfg(target_arch = "x86_64")]
mod x86;

use std::ops::{Add, Div, Mul, Neg, Sub};

pub use portable::Array;
pub use set::InstructionSet;

use super::real::Real;

/// The most lanes that a set has.
pub const MOST_LANES: usize = 16;

/// Of each two of eight bits, whether one is set.
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

/// As many numbers as one instruction works on.
pub trait Lanes:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// The number in one lane.
    type Real: Real;
    /// One truth value per lane.
    type Mask: Copy;
    /// Number of lanes.
    const COUNT: usize;
    /// Whether [`roots`](Lanes::roots) are by instructions for which arithmetic would wait, were there one in every vector.
    const DEAR_ROOTS: bool = false;

    /// The same number in every lane.
    fn splat(value: Self::Real) -> Self;

    /// Reads `COUNT` consecutive numbers.
    ///
    /// # Safety
    /// `from` must be valid for reading `COUNT` numbers.
    unsafe fn load(from: *const Self::Real) -> Self;

    /// The first `COUNT` of the numbers.
    #[inline(always)]
    fn first_of(numbers: &[Self::Real; MOST_LANES]) -> Self {
        const { assert!(Self::COUNT <= MOST_LANES) };
        // SAFETY: there are as many.
        unsafe { Self::load(numbers.as_ptr()) }
    }

    /// The lanes, followed by zeros.
    #[inline(always)]
    fn to_array(self) -> [Self::Real; MOST_LANES] {
        const { assert!(Self::COUNT <= MOST_LANES) };
        let mut numbers = [Self::Real::default(); MOST_LANES];
        // SAFETY: it has room for as many.
        unsafe { self.store(numbers.as_mut_ptr()) };
        numbers
    }

    /// The first `COUNT` of the numbers; where they are fewer, zeros follow them.
    #[inline(always)]
    fn read(numbers: &[Self::Real]) -> Self {
        if numbers.len() >= Self::COUNT {
            // SAFETY: there are as many.
            return unsafe { Self::load(numbers.as_ptr()) };
        }
        let mut copy = [Self::Real::default(); MOST_LANES];
        copy[..numbers.len()].copy_from_slice(numbers);
        Self::first_of(&copy)
    }

    /// Writes the lanes over the first `COUNT` of the numbers.
    ///
    /// # Panics
    /// If they are fewer.
    #[inline(always)]
    fn write(self, numbers: &mut [Self::Real]) {
        assert!(numbers.len() >= Self::COUNT);
        // SAFETY: there are as many.
        unsafe { self.store(numbers.as_mut_ptr()) }
    }

    /// Reads `COUNT` consecutive positions relative to an origin: `(x − origin) · scale`, rounded once.
    ///
    /// # Safety
    /// `from` must be valid for reading `COUNT` numbers.
    unsafe fn load_relative(from: *const f64, origin: f64, scale: f64) -> Self;

    /// Writes `COUNT` consecutive numbers.
    ///
    /// # Safety
    /// `to` must be valid for writing `COUNT` numbers.
    unsafe fn store(self, to: *mut Self::Real);

    /// Writes the lanes under the mask consecutively; what follows them, up to `COUNT`, is arbitrary.
    ///
    /// # Safety
    /// `to` must be valid for writing `COUNT` numbers.
    unsafe fn compress(self, mask: Self::Mask, to: *mut Self::Real);

    /// `self · factor + term`, rounded once where the set has the instruction.
    fn mul_add(self, factor: Self, term: Self) -> Self;

    /// The larger in each lane.
    fn max(self, other: Self) -> Self;

    /// The smaller in each lane.
    fn min(self, other: Self) -> Self;

    /// Magnitude.
    fn abs(self) -> Self;

    /// Square root.
    fn sqrt(self) -> Self;

    /// 1/x, to a few units in the last place, for normal x.
    fn inverse(self) -> Self;

    /// √x and 1/√x, to a few units in the last place, for normal x > 0. Where only one is used, the other costs nothing.
    fn roots(self) -> (Self, Self);

    /// Where `self < other`.
    fn less(self, other: Self) -> Self::Mask;

    /// `yes` under the mask, `no` elsewhere.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;

    /// `value` under the mask, 0 elsewhere.
    #[inline(always)]
    fn keep(mask: Self::Mask, value: Self) -> Self {
        Self::select(mask, value, Self::constant(0.0))
    }

    /// The mask as bits, the first lane lowest.
    fn bits(mask: Self::Mask) -> u32;

    /// A bit for each two lanes, the first two lowest: whether one of them is under the mask.
    #[inline(always)]
    fn pair_bits(mask: Self::Mask) -> u32 {
        let [lower, upper, ..] = Self::bits(mask).to_le_bytes();
        u32::from(PAIRS[usize::from(lower)]) | u32::from(PAIRS[usize::from(upper)]) << 4
    }

    /// Sum over the lanes.
    fn sum(self) -> Self::Real;

    /// Sums over the lanes of the first `COUNT` vectors, that of each in the lane of its place: fewer than half the operations of
    /// as many sums one by one.
    fn sum_each(vectors: &[Self; MOST_LANES]) -> Self;

    /// Largest lane.
    fn largest(self) -> Self::Real;

    /// The same number, given in double precision, in every lane.
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self::splat(Self::Real::from_f64(value))
    }
}

/// A task that runs on the lanes of an instruction set; `run` must be `#[inline(always)]`.
pub trait Vectorised<R: Real> {
    /// What the task returns.
    type Output;
    /// Does the task with lanes of type `L`.
    fn run<L: Lanes<Real = R>>(self) -> Self::Output;
}

/// Dot product of two vectors of lanes.
#[inline(always)]
pub fn dot<L: Lanes, const D: usize>(a: [L; D], b: [L; D]) -> L {
    let mut sum = a[0] * b[0];
    for d in 1..D {
        sum = a[d].mul_add(b[d], sum);
    }
    sum
}

/// The sum over the lanes of each of some vectors. To be taken for `map`, which the compiler may put into a function without the
/// instructions of the set.
#[inline(always)]
pub fn sums<L: Lanes, const N: usize>(vectors: [L; N]) -> [f64; N] {
    let mut sums = [0.0; N];
    for i in 0..N {
        sums[i] = vectors[i].sum().to_f64();
    }
    sums
}

/// Adds a multiple of a vector of lanes to a sum.
#[inline(always)]
pub fn add_scaled<L: Lanes>(sum: &mut [L; 3], scale: L, vector: [L; 3]) {
    for (sum, component) in sum.iter_mut().zip(vector) {
        *sum = scale.mul_add(component, *sum);
    }
}

/// Cross product of two vectors of lanes; in 2D along z alone.
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
        set::run_f64(set, task)
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
        set::run_f32(set, task)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every operation against the same in plain f64.
    struct Arithmetic;

    impl<R: Real> Vectorised<R> for Arithmetic {
        type Output = ();
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
            // SAFETY: as above.
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
    fn every_set_computes_what_scalars_do() {
        for set in InstructionSet::available() {
            f64::dispatch(set, Arithmetic);
            f32::dispatch(set, Arithmetic);
        }
    }
}
