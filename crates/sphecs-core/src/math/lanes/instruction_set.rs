//! Choice of the instruction set: the widest of the machine, or the one that the user names.

use std::sync::OnceLock;

use super::portable::Array;
use super::{Lanes, Vectorised};
use crate::math::real::Real;

/// Instruction set that this machine supports. A value for an unsupported set cannot be
/// constructed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InstructionSet(Kind);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl InstructionSet {
    /// Plain Rust, for every machine.
    pub const PORTABLE: InstructionSet = InstructionSet(Kind::Portable);

    /// Returns the sets that this machine supports, the widest last.
    pub fn available() -> Vec<InstructionSet> {
        #[cfg(target_arch = "x86_64")]
        {
            let mut sets = vec![Self::PORTABLE];
            let has_bits = is_x86_feature_detected!("bmi1")
                && is_x86_feature_detected!("bmi2")
                && is_x86_feature_detected!("lzcnt")
                && is_x86_feature_detected!("popcnt");
            if has_bits && is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                sets.push(Self(Kind::Avx2));
                if is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512dq")
                    && is_x86_feature_detected!("avx512bw")
                    && is_x86_feature_detected!("avx512vl")
                {
                    sets.push(Self(Kind::Avx512));
                }
            }
            sets
        }
        #[cfg(not(target_arch = "x86_64"))]
        vec![Self::PORTABLE]
    }

    /// Returns the widest set of this machine, or the one that the environment variable
    /// `SPHECS_LANES` names (`portable`, `avx2` or `avx512`) if the machine supports it.
    ///
    /// The variable is read once per process; [`named`](Self::named) tells whether it is valid.
    pub fn best() -> InstructionSet {
        static BEST: OnceLock<InstructionSet> = OnceLock::new();
        *BEST.get_or_init(|| {
            let wanted = std::env::var("SPHECS_LANES").unwrap_or_default();
            Self::named(&wanted)
                .ok()
                .flatten()
                .or(Self::available().last().copied())
                .unwrap_or(Self::PORTABLE)
        })
    }

    /// Returns the set of a name; None for an empty name.
    ///
    /// # Errors
    /// No set has the name, or this machine does not support it.
    pub fn named(name: &str) -> Result<Option<InstructionSet>, String> {
        let available = Self::available();
        let found = available.iter().find(|set| set.name() == name).copied();
        if found.is_some() || name.is_empty() {
            return Ok(found);
        }
        let supported: Vec<String> = available.iter().map(|set| format!("`{}`", set.name())).collect();
        Err(format!("is `{name}`, must be one of those of this machine: {}", supported.join(", ")))
    }

    /// Returns the lower-case name, as in `SPHECS_LANES`.
    pub fn name(self) -> &'static str {
        match self.0 {
            Kind::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 => "avx512",
        }
    }
}

/// Runs a task with the f64 vectors of a set.
pub(super) fn run_f64<T: Vectorised<f64>>(set: InstructionSet, task: T) -> T::Output {
    match set.0 {
        Kind::Portable => T::Module::portable::<Array<f64, 2>>(task),
        // SAFETY: an `InstructionSet` exists only for sets that were detected.
        #[cfg(target_arch = "x86_64")]
        Kind::Avx2 => unsafe { T::Module::with_avx2::<super::x86::F64x4>(task) },
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        Kind::Avx512 => unsafe { T::Module::with_avx512::<super::x86::F64x8>(task) },
    }
}

/// Runs a task with the f32 vectors of a set.
pub(super) fn run_f32<T: Vectorised<f32>>(set: InstructionSet, task: T) -> T::Output {
    match set.0 {
        Kind::Portable => T::Module::portable::<Array<f32, 4>>(task),
        // SAFETY: an `InstructionSet` exists only for sets that were detected.
        #[cfg(target_arch = "x86_64")]
        Kind::Avx2 => unsafe { T::Module::with_avx2::<super::x86::F32x8>(task) },
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        Kind::Avx512 => unsafe { T::Module::with_avx512::<super::x86::F32x16>(task) },
    }
}

/// Task compiled for each instruction set, in the module of `Self`.
///
/// The functions are default methods, since the compiler translates a default method together with
/// the module of `Self`, and each module by a thread of its own. As functions of this module, all
/// pair loops of the engine would be translated by one thread, which takes minutes.
trait Compiled<R: Real, T: Vectorised<R>> {
    /// Runs a task without instructions beyond those of every machine.
    #[inline(never)]
    fn portable<L: Lanes<Real = R>>(task: T) -> T::Output {
        task.run::<L>()
    }

    /// Runs a task compiled for AVX2.
    ///
    /// # Safety
    /// The machine must support AVX2, FMA, BMI1, BMI2, LZCNT and POPCNT.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    unsafe fn with_avx2<L: Lanes<Real = R>>(task: T) -> T::Output {
        let line = CacheLine::default();
        std::hint::black_box(&line);
        task.run::<L>()
    }

    /// Runs a task compiled for AVX-512.
    ///
    /// # Safety
    /// The machine must support AVX-512 F, DQ, BW and VL and everything that [`Self::with_avx2`]
    /// needs.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx512f,avx512dq,avx512bw,avx512vl,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
    unsafe fn with_avx512<L: Lanes<Real = R>>(task: T) -> T::Output {
        let line = CacheLine::default();
        std::hint::black_box(&line);
        task.run::<L>()
    }
}

impl<R: Real, T: Vectorised<R>, M> Compiled<R, T> for M {}

/// Local variable that aligns the stack frame of its function to a cache line.
///
/// Vectors that the compiler spills to the stack then lie in one cache line each. Without it they
/// start at any multiple of 16 B, and half of the AVX2 vectors and nearly all AVX-512 vectors
/// straddle two lines. That delays the reload of a spilled sum by many cycles.
#[derive(Default)]
#[repr(align(64))]
struct CacheLine(#[expect(dead_code, reason = "only the alignment matters")] u8);
