//! Exact sums of floating-point numbers: the same in any order and grouping.
//!
//! ```text
//! Σ x = Σ_k c_k 2^(32 k − 1074),   c_k: integers of 64 bits
//! ```
//!
//! A number adds the bits of its significand to three of the integers, and nothing is rounded until
//! the sum is read: Neal (2015), the small superaccumulator. Sums over parts of the particles can
//! be joined in any order, so that a figure depends neither on the order of the particles nor on
//! how they are shared among threads. The crates for exact sums do not hand out sums that can be
//! joined.

use std::ops::AddAssign;

/// Bits of a chunk.
const CHUNK_BITS: usize = 32;

/// Largest value of a chunk after carries, and its mask.
const MASK: i64 = (1 << CHUNK_BITS) - 1;

/// Number of chunks: from 2⁻¹⁰⁷⁴ to 2¹⁰²⁴, and what 2⁶⁴ of the largest numbers add up to.
const CHUNKS: usize = 68;

/// Additions after which carries are resolved: each adds less than 2³² to a chunk.
const MOST_ADDITIONS: u32 = 1 << 30;

/// Bits of the significand that are stored.
const STORED_BITS: usize = 52;

/// A sum without rounding.
#[derive(Clone, Debug, PartialEq)]
pub struct ExactSum {
    chunks: [i64; CHUNKS],
    /// Additions since carries were resolved.
    additions: u32,
    /// Sum of what is infinite or not a number.
    special: f64,
}

impl Default for ExactSum {
    fn default() -> Self {
        Self { chunks: [0; CHUNKS], additions: 0, special: 0.0 }
    }
}

impl AddAssign<f64> for ExactSum {
    fn add_assign(&mut self, value: f64) {
        let bits = value.to_bits();
        let exponent = (bits >> STORED_BITS & 0x7ff) as usize;
        if exponent == 0x7ff {
            self.special += value;
            return;
        }
        let stored = bits & ((1 << STORED_BITS) - 1);
        // A subnormal number has the exponent of the smallest normal one, without its leading bit.
        let (significand, shift) =
            if exponent == 0 { (stored, 0) } else { (stored | 1 << STORED_BITS, exponent - 1) };
        let (chunk, wide) = (shift / CHUNK_BITS, u128::from(significand) << (shift % CHUNK_BITS));
        let sign = if value.is_sign_negative() { -1 } else { 1 };
        for (part, chunk) in self.chunks[chunk..chunk + 3].iter_mut().enumerate() {
            *chunk += sign * ((wide >> (part * CHUNK_BITS)) as i64 & MASK);
        }
        self.additions += 1;
        if self.additions >= MOST_ADDITIONS {
            self.carry();
        }
    }
}

impl AddAssign<&ExactSum> for ExactSum {
    fn add_assign(&mut self, other: &ExactSum) {
        let mut other = other.clone();
        other.carry();
        self.carry();
        self.chunks.iter_mut().zip(other.chunks).for_each(|(chunk, other)| *chunk += other);
        self.additions += other.additions;
        self.special += other.special;
    }
}

impl ExactSum {
    /// Returns the sum, rounded to the nearest number.
    pub fn value(&self) -> f64 {
        if self.special != 0.0 || self.special.is_nan() {
            return self.special;
        }
        let mut magnitude = self.clone();
        magnitude.carry();
        let is_negative = magnitude.chunks[CHUNKS - 1] < 0;
        if is_negative {
            magnitude.chunks.iter_mut().for_each(|chunk| *chunk = -*chunk);
            magnitude.carry();
        }
        let rounded = magnitude.rounded();
        if is_negative { -rounded } else { rounded }
    }

    /// Bytes of a sum in a message.
    pub const BYTES: usize = (CHUNKS + 2) * size_of::<u64>();

    /// Writes the sum to a message of [`Self::BYTES`].
    pub fn write(&self, message: &mut [u8]) {
        let Self { chunks, additions, special } = self;
        let (numbers, rest) = message.split_at_mut(CHUNKS * size_of::<u64>());
        numbers.copy_from_slice(bytemuck::cast_slice(chunks));
        rest[..8].copy_from_slice(&u64::from(*additions).to_ne_bytes());
        rest[8..].copy_from_slice(&special.to_ne_bytes());
    }

    /// Reads what [`Self::write`] wrote on a machine of the same kind.
    pub fn read(message: &[u8]) -> Self {
        let number = |at: usize| bytemuck::pod_read_unaligned::<u64>(&message[at * 8..(at + 1) * 8]);
        Self {
            chunks: std::array::from_fn(|at| number(at) as i64),
            additions: number(CHUNKS) as u32,
            special: f64::from_bits(number(CHUNKS + 1)),
        }
    }

    /// Moves what exceeds a chunk to the next: all but the last are from 0 to 2³² − 1 then.
    fn carry(&mut self) {
        let mut carried = 0;
        for chunk in &mut self.chunks[..CHUNKS - 1] {
            *chunk += carried;
            carried = *chunk >> CHUNK_BITS;
            *chunk &= MASK;
        }
        self.chunks[CHUNKS - 1] += carried;
        self.additions = 1;
    }

    /// Returns the sum of chunks that are not negative, each below 2³², to the nearest number.
    fn rounded(&self) -> f64 {
        let Some(top) = self.chunks.iter().rposition(|&chunk| chunk != 0) else { return 0.0 };
        let chunk = |index: usize| self.chunks.get(index).map_or(0, |&chunk| chunk as u128);
        let below = |steps: usize| top.checked_sub(steps).map_or(0, chunk);
        let window = chunk(top) << (2 * CHUNK_BITS) | below(1) << CHUNK_BITS | below(2);
        // Places of the leading bit in the window and in the sum.
        let in_window = 127 - window.leading_zeros() as usize;
        let mut leading = top * CHUNK_BITS + in_window - 2 * CHUNK_BITS;
        if leading <= STORED_BITS {
            // Multiples of the smallest number, exact.
            return f64::from_bits((chunk(1) << CHUNK_BITS | chunk(0)) as u64);
        }
        let dropped = in_window - STORED_BITS;
        let (mut significand, rest) = (window >> dropped, window & ((1 << dropped) - 1));
        let half = 1_u128 << (dropped - 1);
        let is_above_half = rest > half
            || rest == half && self.chunks[..top.saturating_sub(2)].iter().any(|&chunk| chunk != 0);
        if is_above_half || rest == half && significand & 1 == 1 {
            significand += 1;
        }
        if significand >> (STORED_BITS + 1) != 0 {
            significand >>= 1;
            leading += 1;
        }
        let exponent = leading - STORED_BITS + 1;
        if exponent >= 0x7ff {
            return f64::INFINITY;
        }
        f64::from_bits((exponent as u64) << STORED_BITS | (significand as u64 & ((1 << STORED_BITS) - 1)))
    }
}

impl FromIterator<f64> for ExactSum {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        let mut sum = Self::default();
        values.into_iter().for_each(|value| sum += value);
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::{collection, num, prop_assert_eq, proptest};

    fn sum(values: &[f64]) -> f64 {
        values.iter().copied().collect::<ExactSum>().value()
    }

    #[test]
    fn what_cancels_leaves_no_error() {
        assert_eq!(sum(&[1e100, 1.0, -1e100]), 1.0);
        assert_eq!(sum(&[1.0, f64::EPSILON / 4.0, -1.0]), f64::EPSILON / 4.0);
        assert_eq!(sum(&[f64::MAX, f64::MAX, -f64::MAX]), f64::MAX);
        assert_eq!(sum(&[f64::MAX, f64::MAX]), f64::INFINITY);
        assert_eq!(sum(&[-f64::MAX, -f64::MAX]), f64::NEG_INFINITY);
        assert_eq!(sum(&[f64::MIN_POSITIVE, -5e-324]), f64::MIN_POSITIVE - 5e-324);
        assert_eq!(sum(&[5e-324, 5e-324]), 1e-323);
        assert_eq!(sum(&[]), 0.0);
    }

    #[test]
    fn values_that_are_not_finite_survive() {
        assert_eq!(sum(&[1.0, f64::INFINITY]), f64::INFINITY);
        assert!(sum(&[f64::NEG_INFINITY, f64::INFINITY]).is_nan());
        assert!(sum(&[f64::NAN, 1.0]).is_nan());
    }

    #[test]
    fn halves_are_rounded_to_even() {
        let ulp = f64::EPSILON;
        assert_eq!(sum(&[1.0, ulp / 2.0]), 1.0);
        assert_eq!(sum(&[1.0 + ulp, ulp / 2.0]), 1.0 + 2.0 * ulp);
        // A last bit far below decides.
        assert_eq!(sum(&[1.0, ulp / 2.0, 1e-300]), 1.0 + ulp);
        assert_eq!(sum(&[-1.0, -ulp / 2.0, -1e-300]), -1.0 - ulp);
    }

    proptest! {
        /// Multiples of 2⁻⁴⁰, whose sum is one of integers.
        #[test]
        fn sum_is_that_of_integers(integers in collection::vec(-(1_i64 << 60)..1_i64 << 60, 0..300)) {
            let values: Vec<f64> = integers.iter().map(|&n| n as f64 * 2.0_f64.powi(-40)).collect();
            let exact: i128 = integers.iter().map(|&n| n as f64 as i128).sum();
            prop_assert_eq!(sum(&values), exact as f64 * 2.0_f64.powi(-40));
        }

        /// Any numbers, in another order and joined from groups.
        #[test]
        fn order_and_grouping_do_not_matter(
            values in collection::vec(num::f64::NORMAL | num::f64::SUBNORMAL | num::f64::ZERO, 1..200),
            groups in 1_usize..20,
            turn in 0_usize..200,
        ) {
            let mut other = values.clone();
            other.rotate_left(turn % values.len());
            other.reverse();
            let mut joined = ExactSum::default();
            for group in other.chunks(groups) {
                joined += &group.iter().copied().collect::<ExactSum>();
            }
            prop_assert_eq!(joined.value().to_bits(), sum(&values).to_bits());
        }
    }
}
