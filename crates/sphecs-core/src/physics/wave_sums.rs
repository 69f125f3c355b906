//! Pair sums of the outgoing wave equation of an outlet.
//!
//! ```text
//! ∂v/∂n |_o = Σ V_b (v_b − v_o) ∂W/∂n       Eq. 29, first term
//! v̄_n,o    = Σ V_b v_n,b W / Σ V_b W        Eq. 30, normalised where the far end cuts the support
//! ```
//!
//! Equations of Alvarado-Rodríguez et al. (2017).
//!
//! Forms of the transverse Laplacian L v ≈ ∇²_t v, with e = x_ob/r, F = (dW/dr)/r and e_t² = 1 −
//! e_n²:
//!
//! ```text
//! Normalised  L v = 2 (D−1) Σ V_b v_ob g / (−Σ V_b t_ob² g),  g = e_t² F, t_ob² = r² e_t²
//! Printed     L v = 2 Σ V_b v_ob (r² e_t²) F/(r² + η²)
//! Consistent  L v = Σ V_b v_ob ((D+2) e_t² − (D−1)) F
//! ```
//!
//! `Normalised` is 0 where no neighbour has a transverse distance from o. `Printed` has the sign
//! corrected: as published a bump steepens. `Consistent` is that of Español & Revenga (2003).
//!
//! On a complete lattice `Normalised` returns ∇²_t v and 1/3 (in 3D 1/2) of ∂²v/∂n². `Printed`
//! returns 3/4 of the transverse part and 1/4 of ∂²v/∂n² in 2D.
//!
//! In 3D the sums run over both transverse axes. `Consistent` diverges where the support is cut.
//! The equation itself is in [`wave_equation`](crate::boundary::outlet::wave_equation).

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::math::lanes::{Lanes, dot};
use crate::math::real::Real;

/// Smallest r² of a division, over h²: the sums include the particle itself.
const LEAST_R2: f64 = 1e-30;

/// Frame in which the wave equation of an outlet is integrated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename = "Frame")]
pub enum ReferenceFrame {
    /// As published: ∂v/∂t of a fixed point, integrated along the moving particle. Take it to
    /// compare with published results.
    Fixed,
    /// Carried by the particle; the convective term drops out. Take it unless results are compared
    /// with published ones.
    #[default]
    Moving,
}

/// Discrete form of the transverse Laplacian of Alvarado-Rodríguez et al. (2017), Eq. 29.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum TransverseOperator {
    /// The sum 2 Σ V v_ob g / (−Σ V y_ob² g) with g = e_y² F, walls included. Take it unless
    /// operators are compared.
    #[default]
    Normalised,
    /// As published, with the sign corrected. Take it to compare with published results.
    Printed,
    /// The consistent second derivative of Español & Revenga (2003). Take it
    /// to compare operators only: it diverges.
    Consistent,
}

/// Sums over the neighbours of one outflow particle.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct WaveSums {
    normal_gradient: DVec3,
    transverse: DVec3,
    transverse_weight: f64,
    shepard_velocity: f64,
    shepard_weight: f64,
}

/// Running sums with one neighbour per lane. Lengths are in units of h, W and F without their norm.
#[derive(Clone, Copy)]
pub struct WaveLanes<L, const D: usize> {
    normal_gradient: [L; D],
    transverse: [L; D],
    transverse_weight: L,
    shepard_velocity: L,
    shepard_weight: L,
}

/// Settings of the sums at one outlet.
#[derive(Clone, Copy, Debug)]
pub struct WaveSetting {
    /// Frame of the rate.
    pub frame: ReferenceFrame,
    /// Transverse operator; None drops the diffusion term (Orlanski, Eq. 28).
    pub transverse: Option<TransverseOperator>,
    /// Unit normal in the direction of the outflow.
    pub normal: DVec3,
    /// Dimensions, 2 or 3.
    pub dimensions: usize,
    /// (η/h)² of the form `Printed`: 0.01.
    pub eta_squared: f64,
    /// Kinematic viscosity ν, m²/s.
    pub viscosity: f64,
}

/// State of the neighbours in a vector of lanes.
#[derive(Clone, Copy)]
pub struct WavePair<L, const D: usize> {
    /// (x_o − x_b)/h.
    pub x_ob: [L; D],
    /// v_o − v_b with wall images, m/s, for diffusion and gradient.
    pub v_ob: [L; D],
    /// Normal velocity of the neighbour, m/s.
    pub v_n_b: L,
    /// Volume V_b, m³ (m² in 2D).
    pub volume: L,
    /// Shape of the kernel, w(q).
    pub w: L,
    /// (dw/dq)/q.
    pub f: L,
    /// 1 for a neighbour that moves with the flow, 0 for a wall.
    pub flows: L,
}

impl<L: Lanes, const D: usize> WaveLanes<L, D> {
    /// Returns empty sums.
    #[inline(always)]
    pub fn new() -> Self {
        let zero = L::constant(0.0);
        Self {
            normal_gradient: [zero; D],
            transverse: [zero; D],
            transverse_weight: zero,
            shepard_velocity: zero,
            shepard_weight: zero,
        }
    }

    /// Adds neighbours.
    #[inline(always)]
    pub fn add(&mut self, setting: &WaveSetting, pair: &WavePair<L, D>) {
        let mut normal = [L::constant(0.0); D];
        for d in 0..D {
            normal[d] = L::constant(setting.normal[d]);
        }
        let weight = pair.volume * pair.w * pair.flows;
        self.shepard_velocity = weight.mul_add(pair.v_n_b, self.shepard_velocity);
        self.shepard_weight = self.shepard_weight + weight;
        let r_squared = dot(pair.x_ob, pair.x_ob) + L::constant(LEAST_R2);
        let along = dot(pair.x_ob, normal);
        let volume_f = pair.volume * pair.f;
        let gradient = -(volume_f * along);
        for d in 0..D {
            self.normal_gradient[d] = pair.v_ob[d].mul_add(gradient, self.normal_gradient[d]);
        }
        let across_squared = (r_squared - along * along).max(L::constant(0.0));
        let g = match setting.transverse {
            None => return,
            Some(TransverseOperator::Normalised) => across_squared * r_squared.inverse() * volume_f,
            Some(TransverseOperator::Printed) => {
                let softened = r_squared + L::constant(setting.eta_squared);
                L::constant(2.0) * across_squared * softened.inverse() * volume_f
            }
            Some(TransverseOperator::Consistent) => {
                let d = D as f64;
                let share = across_squared * r_squared.inverse();
                (L::constant(d + 2.0) * share - L::constant(d - 1.0)) * volume_f
            }
        };
        for d in 0..D {
            self.transverse[d] = pair.v_ob[d].mul_add(g, self.transverse[d]);
        }
        self.transverse_weight = self.transverse_weight - across_squared * g;
    }

    /// Returns the sums over all lanes in SI units; `f_scale` is F over (dw/dq)/q, 1/m^(D+2), `h`
    /// the smoothing length, m.
    #[inline(always)]
    pub fn total(self, f_scale: f64, h: f64) -> WaveSums {
        let (mut normal_gradient, mut transverse) = (DVec3::ZERO, DVec3::ZERO);
        for d in 0..D {
            normal_gradient[d] = f_scale * h * self.normal_gradient[d].sum().to_f64();
            transverse[d] = f_scale * self.transverse[d].sum().to_f64();
        }
        WaveSums {
            normal_gradient,
            transverse,
            transverse_weight: f_scale * h * h * self.transverse_weight.sum().to_f64(),
            // Only their ratio is used.
            shepard_velocity: self.shepard_velocity.sum().to_f64(),
            shepard_weight: self.shepard_weight.sum().to_f64(),
        }
    }
}

impl<L: Lanes, const D: usize> Default for WaveLanes<L, D> {
    fn default() -> Self {
        Self::new()
    }
}

impl WaveSums {
    /// Returns the smoothed convective velocity v̄_n, m/s.
    pub fn convective_velocity(&self) -> f64 {
        if self.shepard_weight > 0.0 { self.shepard_velocity / self.shepard_weight } else { 0.0 }
    }

    /// Returns the transverse Laplacian of the velocity, 1/(m s).
    pub fn transverse_laplacian(&self, setting: &WaveSetting) -> DVec3 {
        match setting.transverse {
            None => DVec3::ZERO,
            Some(TransverseOperator::Normalised) => {
                if self.transverse_weight > 0.0 {
                    let axes = (setting.dimensions - 1) as f64;
                    self.transverse * (2.0 * axes / self.transverse_weight)
                } else {
                    DVec3::ZERO
                }
            }
            Some(_) => self.transverse,
        }
    }

    /// Returns the rate of change of the particle's velocity without the body force, m/s².
    pub fn rate(&self, setting: &WaveSetting) -> DVec3 {
        let diffusion = self.transverse_laplacian(setting) * setting.viscosity;
        match setting.frame {
            ReferenceFrame::Moving => diffusion,
            ReferenceFrame::Fixed => diffusion - self.normal_gradient * self.convective_velocity(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::Array;

    /// Returns the sums over a square lattice of spacing 1 about the origin, for a velocity field
    /// along x. The kernel is Wendland with h = 3 Δ, since at 2 Δ the fourth moments of the lattice
    /// are 2 % off.
    fn lattice_sums(setting: &WaveSetting, v: impl Fn(f64, f64) -> f64) -> WaveSums {
        let mut sums = WaveLanes::<Array<f64, 1>, 2>::new();
        let h = 3.0;
        for i in -6..=6 {
            for j in -6..=6 {
                let (x, y) = (f64::from(i), f64::from(j));
                let q = x.hypot(y) / h;
                let t = (1.0 - 0.5 * q).max(0.0);
                let pair = WavePair {
                    x_ob: [-x / h, -y / h],
                    v_ob: [v(0.0, 0.0) - v(x, y), 0.0],
                    v_n_b: v(x, y),
                    volume: 1.0,
                    w: t.powi(4) * (2.0 * q + 1.0),
                    f: -5.0 * t.powi(3),
                    flows: 1.0,
                };
                sums.add(
                    setting,
                    &WavePair {
                        x_ob: pair.x_ob.map(|x| Array([x])),
                        v_ob: pair.v_ob.map(|v| Array([v])),
                        v_n_b: Array([pair.v_n_b]),
                        volume: Array([pair.volume]),
                        w: Array([pair.w]),
                        f: Array([pair.f]),
                        flows: Array([pair.flows]),
                    },
                );
            }
        }
        sums.total(7.0 / (4.0 * std::f64::consts::PI * h.powi(4)), h)
    }

    fn setting(transverse: Option<TransverseOperator>) -> WaveSetting {
        WaveSetting {
            frame: ReferenceFrame::Moving,
            transverse,
            normal: DVec3::X,
            dimensions: 2,
            eta_squared: 0.0,
            viscosity: 1.0,
        }
    }

    #[test]
    fn a_transverse_bump_spreads_at_the_exact_rate() {
        let k = 0.05;
        for (form, tolerance) in [
            // Both are second order in k times the support: (0.05 · 6)² / 12 = 0.8 %.
            (TransverseOperator::Normalised, 0.01),
            (TransverseOperator::Consistent, 0.01),
        ] {
            let setting = setting(Some(form));
            let rate = lattice_sums(&setting, |_, y| (k * y).cos()).rate(&setting).x;
            assert!((rate / (-k * k) - 1.0).abs() < tolerance, "{form:?}: {rate} for {}", -k * k);
        }
    }

    #[test]
    fn the_printed_form_returns_three_quarters_across_and_a_quarter_along() {
        let k = 0.05;
        let setting = setting(Some(TransverseOperator::Printed));
        let rate = lattice_sums(&setting, |_, y| (k * y).cos()).rate(&setting).x;
        assert!((rate / (-k * k) - 0.75).abs() < 0.01, "{}", rate / (-k * k));
        let streamwise = lattice_sums(&setting, |x, _| x * x).rate(&setting).x;
        assert!((streamwise / 2.0 - 0.25).abs() < 0.01, "{streamwise}");
    }

    #[test]
    fn streamwise_curvature_is_not_diffused() {
        let setting = setting(Some(TransverseOperator::Consistent));
        let rate = lattice_sums(&setting, |x, _| x * x).rate(&setting).x;
        assert!(rate.abs() < 0.01, "{rate}");
    }

    #[test]
    fn the_fixed_frame_convects() {
        let setting = WaveSetting { frame: ReferenceFrame::Fixed, ..setting(None) };
        let rate = lattice_sums(&setting, |x, _| 3.0 + 0.1 * x).rate(&setting).x;
        // −v ∂v/∂x = −3 · 0.1; the lattice sum of the gradient is 0.1 % off.
        assert!((rate + 0.3).abs() < 2e-3, "{rate}");
    }
}
