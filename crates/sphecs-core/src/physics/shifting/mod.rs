//! Particle shifting: the door lists the rooms and holds the closed choice.
//!
//! ```text
//! Fickian: δx_a = −A h v_max Δt ∇C_a,   ∇C_a = Σ_b V_b ∇W
//! Local:   δx_a = −A h |v_a| Δt ∇C_a,   v_a → v_a + δx_a·∇v
//! ```
//!
//! Lind et al. (2012): particles drift down the gradient of their concentration; with a particle's own speed in place of the
//! largest, Skillen et al. (2013). The rate pass sums ∇C or, for [`vacondio`], its repulsion;
//! [`Shifting::scales`] makes the step of it, [`add_carried`] takes the velocity along (Lind et al. (2012), by Taylor's
//! series).
//!
//! Where a stream is stretched, its lattice is, too, and ∇C has ½ ∇·M in it (M = −Σ V_b x_ab ∇W, which is the unit matrix on a lattice at
//! rest). That evens nothing out: it is a drift of the fluid as a whole, for which the velocities of a steady flow make up (docs/noise.md).
//! [`Drift::Removed`] takes the mean around from ∇C: a wave of the wave number k is multiplied by 1 − Ŵ(k), with Ŵ the transform of the kernel, so that next to nothing is left of
//! what is even over several supports, and next to all of a wave of two spacings. It is ours; no source has it.
//!
//! The gradient that carries a velocity must not contain the particle's own: with v' the part of it that the neighbours
//! do not share, Σ V_b (v_b − v_a) ∇W holds −v' ∇C, and δx·∇v = A h |v_a| Δt |∇C|² v' makes v' grow
//! without bound. So it is fitted to the neighbours alone: see `pass/strain/mod.rs`.

pub mod vacondio;

use serde::{Deserialize, Serialize};

use crate::math::real::Real;

/// How fluid particles are moved towards an even distribution after a step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Shifting {
    /// No shifting.
    Off,
    /// Lind et al. (2012): `δx = −coefficient h v_max Δt ∇C`.
    Fickian {
        /// Strength, dimensionless.
        #[serde(default = "fickian_coefficient")]
        coefficient: f64,
        /// What becomes of the drift.
        #[serde(default)]
        drift: Drift,
    },
    /// Skillen et al. (2013): `δx = −coefficient h |v_a| Δt ∇C`, and the velocity is carried along its gradient.
    ///
    /// For flows with fast and slow regions: slow ones are not stirred by what the fast ones need.
    Local {
        /// Strength, dimensionless.
        #[serde(default = "local_coefficient")]
        coefficient: f64,
        /// What becomes of the drift.
        #[serde(default)]
        drift: Drift,
    },
    /// Vacondio et al. (2013) with the local mean spacing of Xu et al. (2009).
    Vacondio {
        /// Strength β, dimensionless.
        #[serde(default = "vacondio_coefficient")]
        beta: f64,
    },
}

/// What becomes of the part of a shift that neighbours share.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Drift {
    /// It is kept, and carries fluid upstream where a stream is stretched.
    #[default]
    Kept,
    /// The mean of the shifting vectors around, weighted with V_b W_ab, is taken from a particle's own.
    Removed,
}

fn fickian_coefficient() -> f64 {
    4.0
}

fn local_coefficient() -> f64 {
    32.0
}

fn vacondio_coefficient() -> f64 {
    0.04
}

impl Default for Shifting {
    fn default() -> Self {
        Shifting::Fickian { coefficient: fickian_coefficient(), drift: Drift::Kept }
    }
}

/// Longest shift in one step, over Δ.
const LONGEST: f64 = 0.1;

/// Largest A v Δt/h. A shift diffuses the concentration: on a square or cubic lattice its shortest waves overshoot and
/// grow above 0.71 (Wendland's kernel, 3D, h = 1.3 Δ; 0.73 in 2D, twice as much for the quintic kernel; test
/// `a_shift_is_a_stable_diffusion`).
const LARGEST_DIFFUSION: f64 = 0.6;

/// What a step's shift depends on beside the particle.
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

impl Shifting {
    /// Largest strength that a scene may ask for: beyond it a step's shift is at its limits everywhere.
    pub const LARGEST_STRENGTH: f64 = 1000.0;

    /// The dimensionless strength, 0 where it is off.
    pub fn strength(&self) -> f64 {
        match *self {
            Shifting::Off => 0.0,
            Shifting::Fickian { coefficient, .. } | Shifting::Local { coefficient, .. } => coefficient,
            Shifting::Vacondio { beta } => beta,
        }
    }

    /// Whether a particle is shifted by what its neighbours share, too. What is not shifted keeps everything that it has.
    pub fn keeps_drift(&self) -> bool {
        match *self {
            Shifting::Off | Shifting::Vacondio { .. } => true,
            Shifting::Fickian { drift, .. } | Shifting::Local { drift, .. } => drift == Drift::Kept,
        }
    }

    /// Whether a shifted particle takes the velocity of the place that it is moved to.
    pub fn carries_velocity(&self) -> bool {
        matches!(self, Shifting::Local { .. })
    }

    /// Displacements, m, over the vectors that the rate pass summed, in the place of the squares of the particles' own speeds, m²/s²; to be
    /// [`ShiftStep::shortened`].
    #[inline(always)]
    pub fn scales(&self, squared_speeds: &mut [f64], step: ShiftStep) {
        let h = step.smoothing_length;
        // As the instruction does it: `min` asks for a number that is none.
        let smaller = |a: f64, b: f64| if a < b { a } else { b };
        let diffused = |coefficient: f64, speed: f64| {
            -h * smaller(coefficient * speed * step.time_step, LARGEST_DIFFUSION * h)
        };
        match *self {
            Shifting::Off => squared_speeds.fill(0.0),
            Shifting::Fickian { coefficient, .. } => {
                squared_speeds.fill(diffused(coefficient, step.largest_speed));
            }
            Shifting::Local { coefficient, .. } => {
                for scale in squared_speeds {
                    *scale = diffused(coefficient, smaller(scale.sqrt(), step.largest_speed));
                }
            }
            Shifting::Vacondio { beta } => squared_speeds.fill(beta * step.largest_speed * step.time_step),
        }
    }
}

impl ShiftStep {
    /// Square of the longest shift, m².
    #[inline(always)]
    pub fn squared_limit(&self) -> f64 {
        (LONGEST * self.spacing).powi(2)
    }

    /// The scale that leaves a displacement of this squared length, m², no longer than 0.1 Δ.
    #[inline(always)]
    pub fn shortened(&self, scale: f64, squared: f64) -> f64 {
        // Few are that long: no root for the others.
        if squared > self.squared_limit() { scale * (LONGEST * self.spacing) / squared.sqrt() } else { scale }
    }
}

/// Adds what a component of velocities changes by along one axis of displacements, m/s: δx_j ∂v_i/∂x_j, the displacements in m and the
/// slopes in 1/s.
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
    fn a_local_shift_goes_with_the_particles_own_speed_which_is_never_above_the_largest() {
        let local = Shifting::Local { coefficient: 8.0, drift: Drift::Kept };
        let [x, _] = displacement(local, [0.5, 0.0], 0.0625, STEP);
        assert!((x + 8.0 * 0.15 * 0.25e-3 * 0.5).abs() < 1e-18);
        assert_eq!(displacement(local, [0.5, 0.0], 0.0, STEP), [0.0, 0.0]);
        assert_eq!(displacement(local, [0.5, 0.0], 81.0, STEP), displacement(local, [0.5, 0.0], 4.0, STEP));
    }

    #[test]
    fn velocity_is_carried_along_its_gradient() {
        let mut changes = [0.0; 2];
        add_carried(&mut changes, &[0.5, 1.0], &[1.0, -4.0]);
        add_carried(&mut changes, &[-2.0, 3.0], &[3.0, 0.25]);
        assert_eq!(changes, [-5.5, -3.25]);
        assert!(
            Shifting::Local { coefficient: 1.0, drift: Drift::Kept }.carries_velocity()
                && !Shifting::default().carries_velocity()
        );
    }

    /// Largest eigenvalue over the waves of a square lattice of −h² ∂(δ∇C)/∂(δx): what a displacement of the particles
    /// does to the gradient of their concentration.
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
        let [x, _] =
            displacement(Shifting::Local { coefficient: 1e3, drift: Drift::Kept }, [0.01, 0.0], 1.0, STEP);
        assert!((x + 0.6 * 0.15 * 0.15 * 0.01).abs() < 1e-18);
    }

    #[test]
    fn a_shift_is_never_longer_than_a_tenth_of_the_spacing() {
        let local = Shifting::Local { coefficient: 32.0, drift: Drift::Removed };
        for shifting in [Shifting::default(), local, Shifting::Vacondio { beta: 0.04 }] {
            let shift = displacement(shifting, [3e9, -4e9, 0.0], 4.0, STEP);
            assert!((shift.iter().map(|x| x * x).sum::<f64>().sqrt() - 0.01).abs() < 1e-12);
        }
        assert_eq!(displacement(Shifting::Off, [1.0, 1.0], 4.0, STEP), [0.0, 0.0]);
    }
}
