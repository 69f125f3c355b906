//! Outlet pressure that transmits acoustic waves at any angle.
//!
//! ```text
//! J2 = p' + ρ0 c0 (v' − u'),   du'/dt = (w' − u')/½τ,  dw'/dt = (v' − w')/½τ     outgoing
//! ∂²J3/∂t² + (2/τ) ∂J3/∂t + J3/τ² − ¼ c0² ∇_t² J3 = ¼ c0² ∇_t² J2                incoming
//! p_o' = ½ (J2 + J3)
//! ```
//!
//! p' and v' are the deviations of pressure and normal velocity of the fluid next to the plane from
//! their means over the section, which [`plane_waves`](super::plane_waves) treats. A plane wave at
//! the angle θ to the normal has ρ0 c0 v' = p' cos θ. So J3 = 0, Negi et al. (2020), Eqs. 25–27,
//! reflects the share R = (1 − cos θ)/(1 + cos θ). The second line is the wave equation in the
//! plane that follows from the second approximation of Engquist & Majda (1977),
//!
//! ```text
//! cos θ ≈ 1 − ½ sin² θ,   R = ((1 − cos θ)/(1 + cos θ))²
//! ```
//!
//! R is 0.03 at 45° and 0.11 at 60°. A field that varies along the plane but slowly in time is a
//! vortex. There J3 = −J2, and the outlet does not act on the pressure. Their third approximation
//! is R = ((1 − cos θ)/(1 + cos θ))³. It responds to a slow vortex with ⅓ ρ0 c0 v', orders of
//! magnitude above its pressure, which reverses the vortex before it leaves. It reflects a fifth
//! less at 45° (docs/notebook/2026-11-24-outlets.md).
//!
//! The velocity u' follows the flow in two stages within τ, the travel time of sound along the
//! section. So a stationary vortex is not taken for sound. Waves that are not plane propagate along
//! a channel only above the frequency c0/(2 width), so that little is lost.
//!
//! By itself J3 oscillates with ω = ½ c0 k, below the c0 k of any sound of the wave number k along
//! the plane. So only the flow next to the plane responds to it. With the third approximation waves
//! of some seven spacings grew between both (`scenes/quickstart.ron` with `EdacTvf` diverged by
//! them at 0.69 s). So ∂J3/∂t is damped at the rate β (c0/h) (h² ∇_t²)², β = 0.1. A wave of 7
//! points decays by e in 35 h/c0, one of 40 points in 33 000 h/c0.

use serde::{Deserialize, Serialize};

/// Largest Courant number of a step of the wave equation along the section.
const LARGEST_COURANT: f64 = 0.9;

/// β of the damping of short waves.
const DAMPING: f64 = 0.1;

/// Constants of the waves along one section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObliqueSetting {
    /// Time constant τ, s.
    pub time: f64,
    /// Reference density ρ0, kg/m³.
    pub density: f64,
    /// Sound speed c0, m/s.
    pub sound_speed: f64,
    /// Spacing of the section's points along its two directions, m; infinite in the second in 2D.
    pub spacing: [f64; 2],
}

/// State of the oblique waves at the points of a section.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObliqueWaves {
    /// Followed velocity u', m/s.
    pub followed: Vec<f64>,
    /// First stage w' of the following velocity, m/s.
    pub first_stage: Vec<f64>,
    /// J3, Pa.
    pub incoming: Vec<f64>,
    /// ∂J3/∂t, Pa/s.
    pub incoming_rate: Vec<f64>,
    /// J2 of the present step, Pa.
    outgoing: Vec<f64>,
    /// h² ∇_t² ∂J3/∂t of the present step, Pa/s.
    #[serde(skip)]
    roughness: Vec<f64>,
}

impl ObliqueWaves {
    /// Advances the waves by a step (s) and replaces p' (Pa) in `pressure` by p_o' (Pa) at every
    /// point.
    ///
    /// `neighbours` are the previous and the next point along both directions; a point at a wall is
    /// its own.
    pub fn advance(
        &mut self,
        setting: &ObliqueSetting,
        neighbours: &[[u32; 4]],
        velocity: &[f64],
        pressure: &mut [f64],
        time_step: f64,
    ) {
        let points = neighbours.len();
        if self.followed.len() != points {
            // A flow already in motion is not a wave.
            self.followed = velocity.to_vec();
            self.first_stage = velocity.to_vec();
            self.incoming = vec![0.0; points];
            self.incoming_rate = vec![0.0; points];
            self.outgoing = vec![0.0; points];
        }
        // Not saved by a checkpoint.
        self.roughness.resize(points, 0.0);
        let impedance = setting.density * setting.sound_speed;
        let share = -(-2.0 * time_step / setting.time).exp_m1();
        for point in 0..points {
            self.outgoing[point] = pressure[point] + impedance * (velocity[point] - self.followed[point]);
            self.followed[point] += share * (self.first_stage[point] - self.followed[point]);
            self.first_stage[point] += share * (velocity[point] - self.first_stage[point]);
        }
        let c2 = setting.sound_speed * setting.sound_speed;
        let laplacian = |field: &[f64], point: usize| {
            let [before, behind, left, right] = neighbours[point].map(|at| field[at as usize]);
            let [h, k] = setting.spacing;
            (before + behind - 2.0 * field[point]) / (h * h) + (left + right - 2.0 * field[point]) / (k * k)
        };
        let leak = 1.0 / setting.time;
        // The leapfrog is stable while c0 Δt is below the spacing in both directions, and the
        // damping while it does not reverse the shortest wave; a scene may choose longer steps.
        let nearest = setting.spacing[0].min(setting.spacing[1]);
        let roughest: f64 = setting.spacing.iter().map(|spacing| 4.0 * (nearest / spacing).powi(2)).sum();
        let largest = LARGEST_COURANT.min(1.0 / (DAMPING * roughest * roughest));
        let parts = (setting.sound_speed * time_step / (largest * nearest)).ceil().max(1.0);
        let part = time_step / parts;
        let damped = DAMPING * setting.sound_speed * part / nearest;
        for _ in 0..parts as usize {
            for point in 0..points {
                let force = 0.25 * c2 * laplacian(&self.incoming, point)
                    + 0.25 * c2 * laplacian(&self.outgoing, point)
                    - leak * leak * self.incoming[point];
                let rate = self.incoming_rate[point] * (1.0 - leak * part) + force * part;
                self.incoming_rate[point] = rate / (1.0 + leak * part);
            }
            for point in 0..points {
                self.roughness[point] = nearest * nearest * laplacian(&self.incoming_rate, point);
            }
            for point in 0..points {
                self.incoming_rate[point] -= damped * nearest * nearest * laplacian(&self.roughness, point);
            }
            for (incoming, rate) in self.incoming.iter_mut().zip(&self.incoming_rate) {
                *incoming += rate * part;
            }
        }
        for point in 0..points {
            pressure[point] = 0.5 * (self.outgoing[point] + self.incoming[point]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    const POINTS: usize = 40;

    fn setting(time: f64) -> ObliqueSetting {
        ObliqueSetting { time, density: 1000.0, sound_speed: 10.0, spacing: [0.01, f64::INFINITY] }
    }

    fn periodic() -> Vec<[u32; 4]> {
        let points = POINTS as u32;
        (0..points).map(|point| [(point + points - 1) % points, (point + 1) % points, point, point]).collect()
    }

    /// Returns the largest difference between the pressure of the outlet and that of a wave at this
    /// angle, of unit amplitude, which rises slowly.
    fn error_at(degrees: f64) -> f64 {
        let setting = setting(1e6);
        let impedance = setting.density * setting.sound_speed;
        let angle = degrees.to_radians();
        let across = TAU / (POINTS as f64 * setting.spacing[0]);
        let omega = setting.sound_speed * across / angle.sin();
        let periods = 30.0;
        let time_step = 2e-3 / omega;
        let mut state = ObliqueWaves::default();
        let mut worst: f64 = 0.0;
        let end = periods * TAU / omega;
        for step in 0..(end / time_step) as usize {
            let time = step as f64 * time_step;
            // The ramp is smooth at both ends, since an abrupt start has all frequencies and
            // excites waves along the plane that remain.
            let rise = (1.25 * time / end).min(1.0);
            let amplitude = rise.powi(3) * (10.0 - 15.0 * rise + 6.0 * rise * rise);
            let wave =
                |point: usize| amplitude * (across * setting.spacing[0] * point as f64 - omega * time).cos();
            let mut pressure: Vec<f64> = (0..POINTS).map(wave).collect();
            let velocity: Vec<f64> = (0..POINTS).map(|point| wave(point) * angle.cos() / impedance).collect();
            state.advance(&setting, &periodic(), &velocity, &mut pressure, time_step);
            if time > 0.8 * end {
                let differences = (0..POINTS).map(|point| (pressure[point] - wave(point)).abs());
                worst = differences.fold(worst, f64::max);
            }
        }
        worst
    }

    #[test]
    fn an_oblique_wave_meets_its_own_pressure() {
        for degrees in [15.0_f64, 30.0, 45.0, 60.0] {
            let cosine = degrees.to_radians().cos();
            // J3 should be (1 − cos θ) p and is ¼ s/(1 − ¼ s) (1 + cos θ) p with s = sin² θ; the
            // discrete Laplacian is 0.2 % too small.
            let s = 1.0 - cosine * cosine;
            let missing = 0.5 * (1.0 - cosine - 0.25 * s / (1.0 - 0.25 * s) * (1.0 + cosine)).abs();
            let normal_alone = 0.5 * (1.0 - cosine);
            let error = error_at(degrees);
            assert!((error - missing).abs() < 2e-3, "{error} at {degrees}°, not {missing}");
            assert!(error < 0.4 * normal_alone, "{error} at {degrees}°");
        }
    }

    #[test]
    fn slow_vortex_is_not_taken_for_a_wave() {
        // The velocity of a slow vortex counts as that of the flow, and its pressure is released.
        let setting = setting(0.04);
        let shape = |point: usize| (TAU * point as f64 / POINTS as f64).sin();
        let velocity: Vec<f64> = (0..POINTS).map(|point| 0.1 * shape(point)).collect();
        let mut state = ObliqueWaves::default();
        let mut pressure = Vec::new();
        for step in 0..4000 {
            pressure = (0..POINTS).map(|point| 5.0 * shape(point)).collect();
            let velocity = if step == 0 { vec![0.0; POINTS] } else { velocity.clone() };
            state.advance(&setting, &periodic(), &velocity, &mut pressure, 2e-4);
        }
        for (point, pressure) in pressure.iter().enumerate() {
            assert!(pressure.abs() <= 0.25 * shape(point).abs() + 1e-3, "{pressure} Pa");
        }
    }

    /// Returns the discrete k h of a wave of `points_of_a_wave` points.
    fn roughness_of(points_of_a_wave: usize) -> f64 {
        2.0 * (std::f64::consts::PI / points_of_a_wave as f64).sin()
    }

    /// Returns the remaining share of the amplitude of a wave of `points_of_a_wave` points after a
    /// time, in h/c0, without an outgoing wave.
    fn remaining_of(points_of_a_wave: usize, time: f64) -> f64 {
        let setting = setting(1e6);
        let shape = |point: usize| (TAU * point as f64 / points_of_a_wave as f64).sin();
        let mut state = ObliqueWaves {
            followed: vec![0.0; POINTS],
            first_stage: vec![0.0; POINTS],
            incoming: (0..POINTS).map(shape).collect(),
            incoming_rate: vec![0.0; POINTS],
            outgoing: vec![0.0; POINTS],
            roughness: Vec::new(),
        };
        let time_step = 0.05 * setting.spacing[0] / setting.sound_speed;
        for _ in 0..(time / 0.05) as usize {
            state.advance(&setting, &periodic(), &[0.0; POINTS], &mut [0.0; POINTS], time_step);
        }
        // J3 and (∂J3/∂t + ½ γ J3)/ω are the two phases of a damped oscillation of the frequency ½
        // c0 k.
        let unit = setting.sound_speed / setting.spacing[0];
        let rough = roughness_of(points_of_a_wave);
        let (omega, gamma) = (0.5 * rough * unit, DAMPING * rough.powi(4) * unit);
        let phases = state.incoming.iter().zip(&state.incoming_rate);
        let amplitudes = phases.map(|(j, rate)| j.hypot((rate + 0.5 * gamma * j) / omega));
        let start = (0..POINTS).map(shape).fold(0.0, f64::max);
        amplitudes.fold(0.0, f64::max) / start
    }

    #[test]
    fn short_waves_decay_and_long_waves_stay() {
        for (points, time) in [(5, 30.0), (8, 60.0), (40, 300.0)] {
            let expected = (-0.5 * DAMPING * roughness_of(points).powi(4) * time).exp();
            let remaining = remaining_of(points, time);
            assert!(
                (remaining / expected - 1.0).abs() < 0.1,
                "{remaining} of a wave of {points} points, not {expected}"
            );
        }
    }

    #[test]
    fn steps_longer_than_the_travel_time_between_points_are_stable() {
        // In both directions, for the shortest wave that the points resolve.
        let setting = ObliqueSetting { spacing: [0.01, 0.01], ..setting(0.04) };
        let side = 8_u32;
        let at = |i: u32, j: u32| i % side + side * (j % side);
        let neighbours: Vec<[u32; 4]> = (0..side * side)
            .map(|point| (point % side, point / side))
            .map(|(i, j)| [at(i + side - 1, j), at(i + 1, j), at(i, j + side - 1), at(i, j + 1)])
            .collect();
        let checkers = |point: u32| if (point % side + point / side).is_multiple_of(2) { 1.0 } else { -1.0 };
        let mut state = ObliqueWaves::default();
        for _ in 0..400 {
            let mut pressure: Vec<f64> = (0..side * side).map(checkers).collect();
            let still = vec![0.0; neighbours.len()];
            state.advance(&setting, &neighbours, &still, &mut pressure, 2.3 * 0.01 / 10.0);
            assert!(pressure.iter().all(|pressure| pressure.abs() < 2.0), "{pressure:?}");
        }
    }

    #[test]
    fn a_uniform_deviation_is_halved() {
        let mut state = ObliqueWaves::default();
        let mut pressure = vec![3.0; POINTS];
        state.advance(&setting(0.04), &periodic(), &[0.2; POINTS], &mut pressure, 1e-4);
        assert!(pressure.iter().all(|pressure| (pressure - 1.5).abs() < 1e-12));
    }
}
