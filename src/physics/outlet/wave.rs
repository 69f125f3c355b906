//! The outgoing wave equation of an outlet, in particle form.
//!
//! ```text
//! ∂v/∂t + v_n ∂v/∂n − ν ∇²_t v = f          Alvarado-Rodríguez et al. (2017), Eq. 27 with the body force f
//! ∂v/∂n |_o = Σ V_b (v_b − v_o) ∂W/∂n       Eq. 29, first term
//! v̄_n,o    = Σ V_b v_n,b W / Σ V_b W        Eq. 30, Shepard-normalised: the far end of the zone cuts the support
//! ```
//!
//! `Frame::Fixed` integrates the rate of a fixed point along the moving particle, as they do:
//! dv/dt = −v̄_n ∂v/∂n + ν L v + f. `Frame::Moving` takes the equation at its word: the particle moves with the
//! convective velocity, the convective term drops out, dv/dt = ν L v + f, as Negi et al. (2020), Sec. 3.1, remark.
//!
//! Forms of the transverse Laplacian L v ≈ ∇²_t v, with e = x_ob/r, F = (dW/dr)/r and e_t² = 1 − e_n²:
//!
//! ```text
//! Normalised  L v = 2 (D−1) Σ V_b v_ob g / (−Σ V_b t_ob² g),  g = e_t² F, t_ob² = r² e_t²   (zero-sum where nothing is across)
//! Printed     L v = 2 Σ V_b v_ob (r² e_t²) F/(r² + η²)        sign mended: as printed a bump sharpens
//! Consistent  L v = Σ V_b v_ob ((D+2) e_t² − (D−1)) F         Español & Revenga (2003)
//! ```
//!
//! In 3D the sums run over both transverse axes. `Consistent` diverges where the support is cut.

use glam::DVec3;

use super::{Frame, TransverseOperator};

/// Running sums over the neighbours of one outflow particle.
#[derive(Clone, Copy, Debug, Default)]
pub struct WaveSums {
    normal_gradient: DVec3,
    transverse: DVec3,
    transverse_weight: f64,
    shepard_velocity: f64,
    shepard_weight: f64,
}

/// What the sums of one particle need to know.
#[derive(Clone, Copy, Debug)]
pub struct WaveSetting {
    /// Frame of the rate.
    pub frame: Frame,
    /// Transverse operator; None drops the diffusion term (Orlanski, Eq. 28).
    pub transverse: Option<TransverseOperator>,
    /// Unit normal in the direction of the outflow.
    pub normal: DVec3,
    /// Dimensions, 2 or 3.
    pub dimensions: usize,
    /// η² = 0.01 h², m².
    pub eta_squared: f64,
    /// Kinematic viscosity ν, m²/s.
    pub viscosity: f64,
}

/// One neighbour as the sums see it.
#[derive(Clone, Copy, Debug)]
pub struct WavePair {
    /// x_o − x_b, m.
    pub x_ob: DVec3,
    /// v_o − v_b with wall images, m/s: what diffusion and gradient see.
    pub v_ob: DVec3,
    /// Normal velocity of the neighbour, m/s.
    pub v_n_b: f64,
    /// Volume V_b, m³ (m² in 2D).
    pub volume: f64,
    /// Kernel W, 1/m³ (1/m² in 2D).
    pub w: f64,
    /// F = (dW/dr)/r, 1/m⁵ (1/m⁴ in 2D).
    pub f: f64,
    /// Whether the neighbour moves with the flow (not a wall).
    pub flows: bool,
}

impl WaveSums {
    /// Adds a neighbour.
    pub fn add(&mut self, setting: &WaveSetting, pair: &WavePair) {
        let r_squared = pair.x_ob.length_squared();
        if pair.flows {
            self.shepard_velocity += pair.volume * pair.v_n_b * pair.w;
            self.shepard_weight += pair.volume * pair.w;
        }
        if r_squared == 0.0 {
            return;
        }
        let along = pair.x_ob.dot(setting.normal);
        self.normal_gradient -= pair.v_ob * (pair.volume * along * pair.f);
        let across_squared = (r_squared - along * along).max(0.0);
        match setting.transverse {
            None => {}
            Some(TransverseOperator::Normalised) => {
                let g = across_squared / r_squared * pair.f;
                self.transverse += pair.v_ob * (pair.volume * g);
                self.transverse_weight -= pair.volume * across_squared * g;
            }
            Some(TransverseOperator::Printed) => {
                let g = 2.0 * across_squared * pair.f / (r_squared + setting.eta_squared);
                self.transverse += pair.v_ob * (pair.volume * g);
            }
            Some(TransverseOperator::Consistent) => {
                let d = setting.dimensions as f64;
                let g = ((d + 2.0) * across_squared / r_squared - (d - 1.0)) * pair.f;
                self.transverse += pair.v_ob * (pair.volume * g);
            }
        }
    }

    /// Smoothed convective velocity v̄_n, m/s.
    pub fn convective_velocity(&self) -> f64 {
        if self.shepard_weight > 0.0 { self.shepard_velocity / self.shepard_weight } else { 0.0 }
    }

    /// Transverse Laplacian of the velocity, 1/(m s).
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

    /// Rate of change of the particle's velocity without the body force, m/s².
    pub fn rate(&self, setting: &WaveSetting) -> DVec3 {
        let diffusion = self.transverse_laplacian(setting) * setting.viscosity;
        match setting.frame {
            Frame::Moving => diffusion,
            Frame::Fixed => diffusion - self.normal_gradient * self.convective_velocity(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums over a unit square lattice of spacing 1 around the origin, for a velocity field along x,
    /// with a Wendland kernel of h = 3 Δ:
    /// the fourth moments of the lattice are 2 % off at 2 Δ.
    fn lattice_sums(setting: &WaveSetting, v: impl Fn(f64, f64) -> f64) -> WaveSums {
        let mut sums = WaveSums::default();
        let h = 3.0;
        let norm = 7.0 / (4.0 * std::f64::consts::PI * h * h);
        for i in -6..=6 {
            for j in -6..=6 {
                let (x, y) = (f64::from(i), f64::from(j));
                let q = x.hypot(y) / h;
                let t = (1.0 - 0.5 * q).max(0.0);
                sums.add(
                    setting,
                    &WavePair {
                        x_ob: DVec3::new(-x, -y, 0.0),
                        v_ob: DVec3::X * (v(0.0, 0.0) - v(x, y)),
                        v_n_b: v(x, y),
                        volume: 1.0,
                        w: norm * t.powi(4) * (2.0 * q + 1.0),
                        f: -5.0 * norm / (h * h) * t.powi(3),
                        flows: true,
                    },
                );
            }
        }
        sums
    }

    fn setting(transverse: Option<TransverseOperator>) -> WaveSetting {
        WaveSetting {
            frame: Frame::Moving,
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
    fn the_printed_form_returns_three_quarters() {
        let k = 0.05;
        let setting = setting(Some(TransverseOperator::Printed));
        let rate = lattice_sums(&setting, |_, y| (k * y).cos()).rate(&setting).x;
        assert!((rate / (-k * k) - 0.75).abs() < 0.01, "{}", rate / (-k * k));
    }

    #[test]
    fn streamwise_curvature_is_not_diffused() {
        let setting = setting(Some(TransverseOperator::Consistent));
        let rate = lattice_sums(&setting, |x, _| x * x).rate(&setting).x;
        assert!(rate.abs() < 0.01, "{rate}");
    }

    #[test]
    fn the_fixed_frame_convects() {
        let setting = WaveSetting { frame: Frame::Fixed, ..setting(None) };
        let rate = lattice_sums(&setting, |x, _| 3.0 + 0.1 * x).rate(&setting).x;
        // −v ∂v/∂x = −3 · 0.1; the lattice sum of the gradient is 0.1 % off.
        assert!((rate + 0.3).abs() < 2e-3, "{rate}");
    }
}
