//! Which instruction set runs: found out once, or asked for.

use std::sync::OnceLock;

use super::Vectorised;
use super::portable::Array;

/// An instruction set that this machine has. There is no way to make one that it has not.
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
    /// Plain Rust, on every machine.
    pub const PORTABLE: InstructionSet = InstructionSet(Kind::Portable);

    /// The sets that this machine has, the widest last.
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

    /// The widest set of this machine, or the one that the environment variable `SPHECS_LANES` names
    /// (`portable`, `avx2` or `avx512`) if the machine has it. Asked once; the answer holds for the process.
    pub fn best() -> InstructionSet {
        static BEST: OnceLock<InstructionSet> = OnceLock::new();
        *BEST.get_or_init(|| {
            let available = Self::available();
            let wanted = std::env::var("SPHECS_LANES").unwrap_or_default();
            let found = available.iter().find(|set| set.name() == wanted);
            found.or(available.last()).copied().unwrap_or(Self::PORTABLE)
        })
    }

    /// Lower-case name, as in `SPHECS_LANES`.
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

/// Runs a task on the f64 lanes of a set.
pub(super) fn run_f64<T: Vectorised<f64>>(set: InstructionSet, task: T) -> T::Output {
    match set.0 {
        Kind::Portable => task.run::<Array<f64, 2>>(),
        // SAFETY: an `InstructionSet` exists only for sets that were detected.
        #[cfg(target_arch = "x86_64")]
        Kind::Avx2 => unsafe { with_avx2::<super::x86::F64x4, T>(task) },
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        Kind::Avx512 => unsafe { with_avx512::<super::x86::F64x8, T>(task) },
    }
}

/// Runs a task on the f32 lanes of a set.
pub(super) fn run_f32<T: Vectorised<f32>>(set: InstructionSet, task: T) -> T::Output {
    match set.0 {
        Kind::Portable => task.run::<Array<f32, 4>>(),
        // SAFETY: an `InstructionSet` exists only for sets that were detected.
        #[cfg(target_arch = "x86_64")]
        Kind::Avx2 => unsafe { with_avx2::<super::x86::F32x8, T>(task) },
        // SAFETY: as above.
        #[cfg(target_arch = "x86_64")]
        Kind::Avx512 => unsafe { with_avx512::<super::x86::F32x16, T>(task) },
    }
}

/// # Safety
/// The machine must have AVX2, FMA, BMI1 and 2, LZCNT and POPCNT.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
unsafe fn with_avx2<L: super::Lanes, T: Vectorised<L::Real>>(task: T) -> T::Output {
    let line = Line::default();
    std::hint::black_box(&line);
    task.run::<L>()
}

/// # Safety
/// The machine must have AVX-512 F, DQ, BW and VL beside them.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512bw,avx512vl,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
unsafe fn with_avx512<L: super::Lanes, T: Vectorised<L::Real>>(task: T) -> T::Output {
    let line = Line::default();
    std::hint::black_box(&line);
    task.run::<L>()
}

/// A line of the cache. A function that has one of its own begins its frame at a line, so that vectors that the compiler
/// keeps in memory lie in one line each; without, it puts them at any multiple of 16 B, and half of those of AVX2 and nearly all of AVX-512
/// lie in two, from which a sum that is kept there comes back many cycles later.
#[derive(Default)]
#[repr(align(64))]
struct Line(#[expect(dead_code, reason = "it is there for its alignment")] u8);
