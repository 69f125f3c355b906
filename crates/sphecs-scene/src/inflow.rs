//! Velocity that an inlet prescribes.

use glam::DVec3;

use super::expression::Expression;
use super::model::{Inlet, InletVelocity, Scene};
use super::time_value::interpolated;
use sphecs_core::boundary::inlet::poiseuille::startup_velocity;

impl InletVelocity {
    /// Returns the speed along the normal at a point (m) and time (s), m/s; None if it is given
    /// by components or over a section.
    pub fn speed(&self, point: DVec3, time: f64) -> Option<f64> {
        match self {
            Self::Normal(speed) => Some(speed.value(point.x, point.y, point.z, time)),
            Self::TimeTable(rows) => {
                Some(interpolated(rows.len(), |row| rows[row].0, time, |row| rows[row].1))
            }
            Self::MassFlow { rate, profile, scale } => {
                let shape = profile.value(point.x, point.y, point.z, 0.0);
                Some(rate.value(0.0, 0.0, 0.0, time) * shape * scale)
            }
            Self::Components(_) | Self::ProfileTable { .. } | Self::PoiseuilleStartup { .. } => None,
        }
    }

    /// Returns true if it varies in time.
    pub fn is_unsteady(&self) -> bool {
        let varies = |expression: &Expression| expression.depends_on(&[3]);
        match self {
            Self::Normal(speed) => varies(speed),
            Self::Components(components) => components.iter().any(varies),
            Self::MassFlow { rate, profile, .. } => varies(rate) || varies(profile),
            Self::TimeTable(_) | Self::ProfileTable { .. } | Self::PoiseuilleStartup { .. } => true,
        }
    }
}

impl Inlet {
    /// Returns the points of a grid over the inlet that lie in its section, m, a spacing apart or
    /// closer if there are fewer than `least` along a side.
    pub fn section_points(&self, scene: &Scene, least: usize) -> Vec<DVec3> {
        let patch = &self.patch;
        let inwards = 1e-3 * scene.spacing * patch.towards;
        let counts = [0, 1].map(|side| {
            if side + 1 < scene.dimensions {
                ((2.0 * patch.half_extent[side] / scene.spacing).round() as usize).max(least).max(1)
            } else {
                1
            }
        });
        let offset = |index: usize, side: usize| {
            let share = (index as f64 + 0.5) / counts[side] as f64 * 2.0 - 1.0;
            share * patch.half_extent[side] * patch.across[side]
        };
        let points = (0..counts[0] * counts[1])
            .map(|index| patch.at + offset(index % counts[0], 0) + offset(index / counts[0], 1));
        points
            .filter(|point| patch.covers(*point, 0.0) && scene.domain.contains(*point + inwards, 0.0))
            .collect()
    }

    /// Returns the volume flow at a time (s), from the velocity at points of the section, m³/s
    /// (m²/s in 2D).
    pub fn volume_flow(&self, viscosity: f64, points: &[DVec3], time: f64) -> f64 {
        let speed = |point: &DVec3| self.velocity_at(viscosity, *point, time).dot(self.patch.towards);
        self.patch.area * points.iter().map(speed).sum::<f64>() / points.len().max(1) as f64
    }

    /// Returns true if the prescribed velocity varies in time.
    pub fn is_unsteady(&self) -> bool {
        self.velocity.is_unsteady()
    }

    /// Velocity at a point (m) and time (s), m/s, for a kinematic viscosity in m²/s.
    ///
    /// A point of the zone has the velocity of the plane in front of it. A velocity that varied
    /// along the zone would compress the particles of a row.
    pub fn velocity_at(&self, viscosity: f64, point: DVec3, time: f64) -> DVec3 {
        let towards = self.patch.towards;
        let point = point - towards * (point - self.patch.at).dot(towards);
        let across = (point - self.patch.at).dot(self.patch.across[0]);
        if let Some(speed) = self.velocity.speed(point, time) {
            return towards * speed;
        }
        match &self.velocity {
            InletVelocity::Components(components) => {
                DVec3::from(components.each_ref().map(|c| c.value(point.x, point.y, point.z, time)))
            }
            InletVelocity::ProfileTable { times, positions, speeds } => {
                let profile = |row: usize| {
                    interpolated(positions.len(), |p| positions[p], across, |column| speeds[row][column])
                };
                towards * interpolated(times.len(), |row| times[row], time, profile)
            }
            InletVelocity::PoiseuilleStartup { half_width, body_force } => {
                towards * startup_velocity(across, time, *half_width, *body_force, viscosity)
            }
            // Those have a speed.
            InletVelocity::Normal(_) | InletVelocity::TimeTable(_) | InletVelocity::MassFlow { .. } => {
                DVec3::ZERO
            }
        }
    }

    /// Returns the acceleration that gravity and pressure must supply for the prescribed motion,
    /// dv/dt − ν ∇²v, m/s², at a point (m) and time (s).
    ///
    /// `spacing` (m) and `moment` (s) are the steps of the finite differences, shorter than the
    /// scales that an inlet resolves. The profile does not change along the flow, so the second
    /// differences are taken across it. Tables have none: they are piecewise linear.
    pub fn inertia(&self, viscosity: f64, point: DVec3, time: f64, spacing: f64, moment: f64) -> DVec3 {
        let velocity = |point, time| self.velocity_at(viscosity, point, time);
        if let InletVelocity::PoiseuilleStartup { body_force, .. } = self.velocity {
            // The series solves dv/dt − ν ∇²v = g.
            return self.patch.towards * body_force;
        }
        let (before, after) = ((time - moment).max(0.0), time + moment);
        let rate = (velocity(point, after) - velocity(point, before)) / (after - before);
        if matches!(self.velocity, InletVelocity::TimeTable(_) | InletVelocity::ProfileTable { .. }) {
            return rate;
        }
        let here = velocity(point, time);
        let second = |across: DVec3| {
            let step = across * spacing;
            (velocity(point + step, time) + velocity(point - step, time) - here * 2.0) / (spacing * spacing)
        };
        let curvature: DVec3 =
            self.patch.across.into_iter().filter(|across| *across != DVec3::ZERO).map(second).sum();
        rate - curvature * viscosity
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expression::{Constants, Expression};
    use crate::model::Patch;
    use sphecs_core::boundary::inlet::{Feed, InletPressure};

    fn inlet(velocity: InletVelocity) -> Inlet {
        Inlet {
            patch: Patch {
                name: "inlet".to_owned(),
                at: DVec3::new(0.0, 1.0, 0.0),
                towards: DVec3::X,
                across: [DVec3::Y, DVec3::ZERO],
                half_extent: [1.0, 0.0],
                depth: 0.5,
                area: 2.0,
                perimeter: 2.0,
                raster: None,
            },
            velocity,
            pressure: InletPressure::Extrapolated,
            feed: Feed::Fed,
        }
    }

    #[test]
    fn all_particles_of_a_row_have_the_velocity_at_the_plane() {
        let text = "x + 10*y + t";
        let speed = Expression::read(text, &Constants::default()).expect("an expression");
        let inlet = inlet(InletVelocity::Normal(speed));
        for x in [0.0, -0.1, -0.4] {
            assert_eq!(inlet.velocity_at(0.0, DVec3::new(x, 1.5, 0.0), 2.0), DVec3::X * 17.0);
        }
    }

    #[test]
    fn time_table_is_linear_between_rows_and_constant_outside() {
        let inlet = inlet(InletVelocity::TimeTable(vec![(1.0, 2.0), (3.0, 6.0)]));
        for (time, speed) in [(0.0, 2.0), (1.0, 2.0), (2.0, 4.0), (3.0, 6.0), (9.0, 6.0)] {
            assert_eq!(inlet.velocity_at(0.0, DVec3::ZERO, time), DVec3::X * speed, "t = {time}");
        }
    }

    #[test]
    fn profile_table_is_bilinear_about_the_centre_of_the_section() {
        let inlet = inlet(InletVelocity::ProfileTable {
            times: vec![0.0, 1.0],
            positions: vec![-1.0, 0.0, 1.0],
            speeds: vec![vec![0.0, 0.0, 0.0], vec![0.0, 4.0, 2.0]],
        });
        let speed = |y: f64, t: f64| inlet.velocity_at(0.0, DVec3::Y * y, t).x;
        assert_eq!(speed(1.0, 1.0), 4.0);
        assert_eq!(speed(1.5, 1.0), 3.0);
        assert_eq!(speed(1.5, 0.5), 1.5);
        assert_eq!(speed(9.0, 2.0), 2.0);
    }

    #[test]
    fn inertia_of_a_parabola_is_its_driving_force_and_of_a_ramp_its_rate() {
        let read = |text| Expression::read(text, &Constants::default()).unwrap();
        let inertia = |velocity| inlet(velocity).inertia(0.02, DVec3::Y * 0.3, 0.5, 0.01, 1e-4);
        let parabola = inertia(InletVelocity::Normal(read("3 * (1 - y^2)")));
        assert!((parabola - DVec3::X * (2.0 * 3.0 * 0.02)).length() < 1e-9, "{parabola}");
        let ramp = inertia(InletVelocity::Components([read("t^2"), read("0"), read("y*t")]));
        assert!((ramp - DVec3::new(1.0, 0.0, 0.3)).length() < 1e-9, "{ramp}");
        let table = inertia(InletVelocity::TimeTable(vec![(0.0, 0.0), (1.0, 4.0)]));
        assert!((table - DVec3::X * 4.0).length() < 1e-9, "{table}");
        let startup = InletVelocity::PoiseuilleStartup { half_width: 1.0, body_force: 0.1 };
        assert_eq!(inertia(startup), DVec3::X * 0.1);
    }

    #[test]
    fn mass_flow_velocity_is_scale_times_profile_times_rate() {
        let read = |text| Expression::read(text, &Constants::default()).unwrap();
        let (rate, profile) = (read("6*t"), read("1 - y^2"));
        let inlet = inlet(InletVelocity::MassFlow { rate, profile, scale: 0.5 });
        assert!(
            (inlet.velocity_at(0.0, DVec3::Y * 0.6, 2.0) - DVec3::X * (0.5 * 12.0 * 0.64)).length() < 1e-14
        );
        let inertia = inlet.inertia(0.02, DVec3::Y * 0.3, 0.5, 0.01, 1e-4);
        // dv/dt − ν ∇²v = ½ 6 (1 − y²) + ν ½ 6 t 2.
        assert!((inertia - DVec3::X * (3.0 * 0.91 + 0.02 * 3.0)).length() < 1e-9, "{inertia}");
    }

    #[test]
    fn acceleration_at_the_start_is_a_forward_difference() {
        let steps = InletVelocity::TimeTable(vec![(-1.0, 0.0), (0.0, 5.0), (1.0, 5.0)]);
        assert_eq!(inlet(steps).inertia(0.0, DVec3::ZERO, 0.0, 0.01, 1e-3), DVec3::ZERO);
    }
}
