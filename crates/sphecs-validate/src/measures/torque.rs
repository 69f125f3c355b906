//! Torque on the fluid inside a closed curve.
//!
//! ```text
//! T = −∮ p (x × n) ds − ∮ ρ (x × v) (v·n) ds
//! ```
//!
//! The momentum theorem for moments about the origin, in 2D: n points out of the curve, and the
//! viscous stresses on it are left out. The curve is the polygon through the points of line probes.
//! Between two points p, ρ, v and x are linear, and the integrals are those of Simpson's rule.

use super::fields::column;
use crate::schema::FieldFile;
use sphecs_output::probes::history::ProbeHistory;

/// State of the fluid at a point of the curve.
#[derive(Clone, Copy, Debug)]
struct State {
    at: [f64; 2],
    velocity: [f64; 2],
    pressure: f64,
    density: f64,
}

impl State {
    /// Returns the state halfway to another.
    fn middle(self, other: Self) -> Self {
        let mean = |a: f64, b: f64| 0.5 * (a + b);
        let both = |a: [f64; 2], b: [f64; 2]| [mean(a[0], b[0]), mean(a[1], b[1])];
        Self {
            at: both(self.at, other.at),
            velocity: both(self.velocity, other.velocity),
            pressure: mean(self.pressure, other.pressure),
            density: mean(self.density, other.density),
        }
    }

    /// Returns the torque per length through a normal of length 1, N/m.
    fn torque(self, normal: [f64; 2]) -> f64 {
        let flux = self.density * (self.velocity[0] * normal[0] + self.velocity[1] * normal[1]);
        -self.pressure * cross(self.at, normal) - flux * cross(self.at, self.velocity)
    }
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// Returns the time mean of the torque (N) through the points of a probe in an interval, s.
///
/// # Errors
/// The points are not a closed curve, or there are no samples.
pub fn through(probe: &ProbeHistory, over: (f64, f64)) -> Result<f64, String> {
    let (Some(first), Some(last)) = (probe.places.first(), probe.places.last()) else {
        return Err(format!("probe `{}` has no points", probe.name));
    };
    if first != last {
        return Err(format!("the points of `{}` must end where they begin", probe.name));
    }
    let values = |field: FieldFile| column(probe, &field);
    let (u, v) = (values(FieldFile::U)?, values(FieldFile::V)?);
    let (pressure, density) = (values(FieldFile::Pressure)?, values(FieldFile::Density)?);
    let points = probe.places.len();
    let area: f64 = probe.places.windows(2).map(|pair| cross(plane(pair[0]), plane(pair[1]))).sum();
    // Outwards is to the right of a curve that runs counter-clockwise.
    let sign = area.signum();
    let of_sample = |sample: usize| -> f64 {
        let state = |point: usize| {
            let row = sample * points + point;
            State {
                at: plane(probe.places[point]),
                velocity: [u[row], v[row]],
                pressure: pressure[row],
                density: density[row],
            }
        };
        (1..points).map(|point| of_edge(state(point - 1), state(point), sign)).sum()
    };
    let inside = (0..probe.times.len()).filter(|sample| (over.0..=over.1).contains(&probe.times[*sample]));
    let torques: Vec<f64> = inside.map(of_sample).collect();
    if torques.is_empty() {
        return Err(format!("no samples from {} to {} s", over.0, over.1));
    }
    Ok(torques.iter().sum::<f64>() / torques.len() as f64)
}

fn plane(place: [f64; 3]) -> [f64; 2] {
    [place[0], place[1]]
}

/// Returns the torque through an edge of the curve, N.
fn of_edge(from: State, to: State, sign: f64) -> f64 {
    let way = [to.at[0] - from.at[0], to.at[1] - from.at[1]];
    let length = f64::hypot(way[0], way[1]);
    // Lines meet at corners, where both have a point.
    if length == 0.0 {
        return 0.0;
    }
    let normal = [sign * way[1] / length, -sign * way[0] / length];
    let of = |state: State| state.torque(normal);
    length / 6.0 * (of(from) + 4.0 * of(from.middle(to)) + of(to))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Square of half width 1 about (2, 1), with a state at each of 8 points.
    fn square(reversed: bool, state: impl Fn([f64; 2]) -> ([f64; 2], f64)) -> ProbeHistory {
        let ring =
            [[1.0, 0.0], [2.0, 0.0], [3.0, 0.0], [3.0, 1.0], [3.0, 2.0], [2.0, 2.0], [1.0, 2.0], [1.0, 1.0]];
        let mut places: Vec<[f64; 3]> = ring.iter().chain([&ring[0]]).map(|p| [p[0], p[1], 0.0]).collect();
        if reversed {
            places.reverse();
        }
        let states: Vec<([f64; 2], f64)> = places.iter().map(|place| state(plane(*place))).collect();
        ProbeHistory {
            name: "ring".to_owned(),
            times: vec![0.0],
            columns: vec![
                ("u", states.iter().map(|state| state.0[0]).collect()),
                ("v", states.iter().map(|state| state.0[1]).collect()),
                ("w", vec![0.0; places.len()]),
                ("pressure", states.iter().map(|state| state.1).collect()),
                ("density", vec![1000.0; places.len()]),
            ],
            places,
        }
    }

    #[test]
    fn linear_pressure_acts_at_the_centre_with_its_gradient() {
        for reversed in [false, true] {
            // Force −∇p A at (2, 1): the torque is −(2 ∂p/∂y − 1 ∂p/∂x) A with A = 4.
            let ring = square(reversed, |at| ([0.0; 2], 5.0 + 3.0 * at[0] + 7.0 * at[1]));
            let torque = through(&ring, (0.0, 1.0)).expect("a torque");
            assert!((torque + 4.0 * (2.0 * 7.0 - 3.0)).abs() < 1e-12, "{torque}");
        }
    }

    #[test]
    fn momentum_that_leaves_takes_its_moment_with_it() {
        // v = (x, 0): ρ ∮ (x × v)(v·n) ds = ρ ∫ ∇·(−y x v) dV = −2 ρ ∫ x y dV = −2 ρ 2·1·4.
        let ring = square(false, |at| ([at[0], 0.0], 0.0));
        let torque = through(&ring, (0.0, 1.0)).expect("a torque");
        assert!((torque / (1000.0 * 16.0) - 1.0).abs() < 1e-12, "{torque}");
        // Uniform flow brings as much as it takes.
        let ring = square(false, |_| ([0.3, 0.4], 0.0));
        assert!(through(&ring, (0.0, 1.0)).expect("a torque").abs() < 1e-9);
    }

    #[test]
    fn open_curve_and_empty_interval_are_refused() {
        let mut ring = square(false, |_| ([0.0; 2], 0.0));
        assert!(through(&ring, (2.0, 3.0)).is_err());
        ring.places.pop();
        assert!(through(&ring, (0.0, 1.0)).is_err());
    }
}
