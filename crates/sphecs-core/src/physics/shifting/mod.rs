//! Particle shifting: displacement of fluid particles towards an even distribution after a step.
//!
//! One file per method holds its equation, parameters, requirements and scale. To add one: a file,
//! a variant of [`Shifting`] with its arm of `dispatch!`, and its entry in docs/REFERENCES.md.
//!
//! | file | method |
//! |---|---|
//! | [`fickian`] | down the concentration gradient, with the largest speed of the fluid |
//! | [`local`] | down the concentration gradient, with the particle's own speed |
//! | [`vacondio`] | repulsion of near neighbours |
//! | [`concentration`] | concentration gradient and drift correction, common to the first two |
//!
//! The pair loop of the rates sums the shifting vector; [`Shifting::scales`] and
//! [`ShiftStep::shortened`] turn it into a displacement.
//!
//! A method that carries the velocity along adds δx·∇v by [`add_carried`] (Lind et al. (2012), by
//! Taylor's series). That gradient must not contain the particle's own velocity. With v' the part
//! of it that the neighbours do not share, Σ V_b (v_b − v_a) ∇W contains −v' ∇C. Then δx·∇v = A h
//! |v_a| Δt |∇C|² v' makes v' grow without bound. So it is fitted to the neighbours alone: see
//! `pass/strain/mod.rs`.

pub mod concentration;
pub mod fickian;
pub mod local;
pub mod vacondio;

use serde::{Deserialize, Serialize};

pub use concentration::DriftCorrection;
pub use fickian::Fickian;
pub use local::Local;
pub use vacondio::Vacondio;

use super::parameter_fault::ParameterFault;
use crate::math::real::Real;

/// Parameters of the methods, for scenes that are described in Rust.
pub mod parameters {
    pub use super::{DriftCorrection, Fickian, Local, Vacondio};
}

/// Method by which fluid particles are moved towards an even distribution after a step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Shifting {
    /// Particles are not shifted. Take it for flows in which they stay in order.
    Off,
    /// Lind et al. (2012): down the concentration gradient, with the largest speed of the fluid.
    /// Take it for channels, ducts and pipes.
    Fickian(Fickian),
    /// Skillen et al. (2013): the same with a particle's own speed; the velocity is carried along.
    /// Take it for jets and shear layers.
    Local(Local),
    /// Vacondio et al. (2013): repulsion of near neighbours. Take it to compare with
    /// Alvarado-Rodríguez et al. (2017).
    Vacondio(Vacondio),
}

/// Evaluates an expression for the method of a [`Shifting`], or another one if it is off.
macro_rules! dispatch {
    ($shifting:expr, off => $off:expr, $method:ident => $call:expr) => {
        match $shifting {
            Shifting::Off => $off,
            Shifting::Fickian($method) => $call,
            Shifting::Local($method) => $call,
            Shifting::Vacondio($method) => $call,
        }
    };
}

/// Requirements of a shifting method.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShiftingNeeds {
    /// The velocity gradient among the neighbours, by which velocities are carried along.
    pub velocity_gradient: bool,
    /// The concentration gradient of all neighbours, before the pair loop runs.
    pub concentration_gradient: bool,
    /// The repulsion of the neighbours in place of the concentration gradient.
    pub repulsion: bool,
}

/// One shifting method: what its file says of it.
trait ShiftingMethod {
    /// Returns the dimensionless strength.
    fn strength(&self) -> f64;

    /// Returns the name of the parameter that is the strength, in the scene notation.
    fn strength_field(&self) -> &'static str;

    /// Returns what the passes must find for the method.
    fn needs(&self) -> ShiftingNeeds;

    /// Replaces squares of the particles' speeds, m²/s², by the displacements, m, over the
    /// shifting vectors.
    fn scales(&self, squared_speeds: &mut [f64], step: ShiftStep);
}

/// Longest shift in one step, over Δ.
const LONGEST: f64 = 0.1;

/// Quantities of a step that its shifts depend on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShiftStep {
    /// Smoothing length h, m.
    pub smoothing_length: f64,
    /// Initial spacing Δ, m.
    pub spacing: f64,
    /// Largest speed of the fluid, m/s.
    pub largest_speed: f64,
    /// Time step, s.
    pub time_step: f64,
}

impl Default for Shifting {
    fn default() -> Self {
        Shifting::Fickian(Fickian::default())
    }
}

impl Shifting {
    /// No shifting.
    pub const NONE: Self = Self::Off;

    /// Largest strength of a scene: above it the shifts of a step are at their limits everywhere.
    pub const LARGEST_STRENGTH: f64 = 1000.0;

    /// Returns true if nothing is shifted.
    pub fn is_off(&self) -> bool {
        dispatch!(self, off => true, _method => false)
    }

    /// Returns the dimensionless strength, 0 where it is off.
    pub fn strength(&self) -> f64 {
        dispatch!(self, off => 0.0, method => method.strength())
    }

    /// Returns what the passes must find for the method.
    pub fn needs(&self) -> ShiftingNeeds {
        dispatch!(self, off => ShiftingNeeds::default(), method => method.needs())
    }

    /// Returns the parameters that are out of bounds.
    pub fn faults(&self) -> Vec<ParameterFault> {
        let field = dispatch!(self, off => return Vec::new(), method => method.strength_field());
        let fault = ParameterFault::unless_within(0.0..=Self::LARGEST_STRENGTH, field, self.strength());
        let usual =
            "`Fickian(coefficient: 4)`, `Local(coefficient: 32)` and `Vacondio(beta: 0.04)` are usual";
        fault.map(|fault| fault.advise(usual)).into_iter().collect()
    }

    /// Returns true if the shift keeps the part that neighbours share. True where nothing is
    /// shifted.
    pub fn keeps_drift(&self) -> bool {
        !self.needs().concentration_gradient
    }

    /// Returns true if a shifted particle takes the velocity of the place that it is moved to.
    pub fn carries_velocity(&self) -> bool {
        self.needs().velocity_gradient
    }

    /// Replaces squares of the particles' own speeds, m²/s², by the displacements, m, over the
    /// shifting vectors of the pair loop; to be [`ShiftStep::shortened`].
    #[inline(always)]
    pub fn scales(&self, squared_speeds: &mut [f64], step: ShiftStep) {
        dispatch!(self, off => squared_speeds.fill(0.0), method => method.scales(squared_speeds, step));
    }
}

impl ShiftStep {
    /// Returns the square of the longest shift, m².
    #[inline(always)]
    pub fn squared_limit(&self) -> f64 {
        (LONGEST * self.spacing).powi(2)
    }

    /// Returns the scale that leaves a displacement of this squared length, m², no longer
    /// than 0.1 Δ.
    #[inline(always)]
    pub fn shortened(&self, scale: f64, squared: f64) -> f64 {
        // Few are that long: the others need no root.
        if squared > self.squared_limit() { scale * (LONGEST * self.spacing) / squared.sqrt() } else { scale }
    }
}

/// Adds the change of a velocity component along one axis of the displacements, m/s: δx_j
/// ∂v_i/∂x_j, with displacements in m and slopes in 1/s.
#[inline(always)]
pub fn add_carried<R: Real>(changes: &mut [f64], displacements: &[f64], slopes: &[R]) {
    for (change, (displacement, slope)) in changes.iter_mut().zip(displacements.iter().zip(slopes)) {
        *change += displacement * slope.to_f64();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::kernel::Kernel;

    const STEP: ShiftStep =
        ShiftStep { smoothing_length: 0.15, spacing: 0.1, largest_speed: 2.0, time_step: 1e-3 };

    fn local(coefficient: f64) -> Shifting {
        Shifting::Local(Local { coefficient, ..Local::default() })
    }

    /// Displacement of a particle, m.
    fn displacement<const D: usize>(
        shifting: Shifting,
        vector: [f64; D],
        squared_speed: f64,
        step: ShiftStep,
    ) -> [f64; D] {
        let mut scale = [squared_speed];
        shifting.scales(&mut scale, step);
        let [scale] = scale;
        let squared = vector.iter().map(|x| (scale * x).powi(2)).sum();
        vector.map(|x| step.shortened(scale, squared) * x)
    }

    #[test]
    fn particles_drift_down_the_concentration() {
        let [x, y] = displacement(Shifting::default(), [0.5, -1.0], 0.25, STEP);
        assert!((x + 4.0 * 0.15 * 2e-3 * 0.5).abs() < 1e-15 && (y - 12e-4).abs() < 1e-15);
    }

    #[test]
    fn a_local_shift_scales_with_the_own_speed_up_to_the_largest() {
        let slow = local(8.0);
        let [x, _] = displacement(slow, [0.5, 0.0], 0.0625, STEP);
        assert!((x + 8.0 * 0.15 * 0.25e-3 * 0.5).abs() < 1e-18);
        assert_eq!(displacement(slow, [0.5, 0.0], 0.0, STEP), [0.0, 0.0]);
        assert_eq!(displacement(slow, [0.5, 0.0], 81.0, STEP), displacement(slow, [0.5, 0.0], 4.0, STEP));
    }

    #[test]
    fn velocity_is_carried_along_its_gradient() {
        let mut changes = [0.0; 2];
        add_carried(&mut changes, &[0.5, 1.0], &[1.0, -4.0]);
        add_carried(&mut changes, &[-2.0, 3.0], &[3.0, 0.25]);
        assert_eq!(changes, [-5.5, -3.25]);
        assert!(local(1.0).carries_velocity() && !Shifting::default().carries_velocity());
    }

    /// Largest eigenvalue over the waves of a square lattice of −h² ∂(δ∇C)/∂(δx): what a
    /// displacement of the particles does to the gradient of their concentration.
    fn stiffness(kernel: Kernel, ratio: f64) -> f64 {
        let spacing = 1.0 / ratio;
        let reach = (kernel.support_ratio() * ratio).ceil() as i32;
        let waves = 8;
        let mut largest: f64 = 0.0;
        for (i, j) in (0..=waves).flat_map(|i| (0..=waves).map(move |j| (i, j))) {
            let k = [i, j].map(|n| f64::from(n) * std::f64::consts::PI / (f64::from(waves) * spacing));
            let mut matrix = [[0.0; 2]; 2];
            for (m, n) in (-reach..=reach).flat_map(|m| (-reach..=reach).map(move |n| (m, n))) {
                let x = [m, n].map(|n| f64::from(n) * spacing);
                let gradient = |x: [f64; 2]| x.map(|along| kernel.slope(2, 1.0, x[0].hypot(x[1])) * along);
                let seen = spacing * spacing * (1.0 - (k[0] * x[0] + k[1] * x[1]).cos());
                for d in 0..2 {
                    let mut there = x;
                    let mut back = x;
                    there[d] += 1e-5;
                    back[d] -= 1e-5;
                    for e in 0..2 {
                        matrix[d][e] += seen * (gradient(there)[e] - gradient(back)[e]) / 2e-5;
                    }
                }
            }
            let [[a, b], [_, d]] = matrix;
            let (mean, spread) = (0.5 * (a + d), (0.25 * (a - d).powi(2) + b * b).sqrt());
            largest = largest.max((mean + spread).abs()).max((mean - spread).abs());
        }
        largest
    }

    #[test]
    fn a_shift_is_a_stable_diffusion() {
        // One shift multiplies a wave by 1 − A v Δt/h · stiffness.
        for ratio in [1.3, 1.5, 2.0] {
            let wendland = 2.0 / stiffness(Kernel::WendlandC2, ratio);
            assert!((0.72..0.80).contains(&wendland), "{wendland} for h = {ratio} Δ");
            assert!(2.0 / stiffness(Kernel::QuinticSpline, ratio) > 1.3);
        }
        let [x, _] = displacement(local(1e3), [0.01, 0.0], 1.0, STEP);
        assert!((x + 0.6 * 0.15 * 0.15 * 0.01).abs() < 1e-18);
    }

    #[test]
    fn a_shift_is_never_longer_than_a_tenth_of_the_spacing() {
        let corrected = Local { coefficient: 32.0, drift_correction: DriftCorrection::On };
        let repulsion = Vacondio { beta: 0.04 };
        for shifting in [Shifting::default(), Shifting::Local(corrected), Shifting::Vacondio(repulsion)] {
            let shift = displacement(shifting, [3e9, -4e9, 0.0], 4.0, STEP);
            assert!((shift.iter().map(|x| x * x).sum::<f64>().sqrt() - 0.01).abs() < 1e-12);
        }
        assert_eq!(displacement(Shifting::Off, [1.0, 1.0], 4.0, STEP), [0.0, 0.0]);
    }
}
