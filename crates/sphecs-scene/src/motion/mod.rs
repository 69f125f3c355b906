//! Prescribed motion of a rigid wall: its pose as a function of time.
//!
//! ```text
//! x(t) = P_n(t) ∘ … ∘ P_2(t) ∘ P_1(t) X
//! ```
//!
//! X is the place in the scene file and P_i the motions of a chain. A place is always computed from
//! X and never from an earlier place, so that it neither drifts nor depends on the time steps.
//!
//! - [`curve`]: displacement or angle in time
//! - [`integral`]: the curve of a given rate
//! - [`spline`]: the curve through samples

pub mod curve;
pub mod integral;
pub mod spline;

use glam::DVec3;
use sphecs_core::format::significant;
use sphecs_core::physics::pose::Pose;

pub use curve::Curve;

use crate::sampled_times::sampled_times;

/// Fault of a motion: the value found and the value required.
///
/// The caller adds its place in the file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MotionFault {
    /// An axis of rotation that has no direction.
    #[error("the axis is ({}, {}, {}), must be finite and have a length", .0.x, .0.y, .0.z)]
    Axis(DVec3),
    /// A point of the axis that is not finite, m.
    #[error("the point of the axis is ({}, {}, {}) m, must be finite", .0.x, .0.y, .0.z)]
    About(DVec3),
    /// Number of samples of a table that does not suffice.
    #[error("the number of samples is {0}, must be at least two")]
    TooFewSamples(usize),
    /// Sample with a number that is not finite.
    #[error("sample {} has a number that is not finite", .sample + 1)]
    SampleNotFinite {
        /// Index of the sample.
        sample: usize,
    },
    /// Sample that is not later than the one before.
    #[error("the time of sample {} is {time} s, must be greater than {previous} s", .sample + 1)]
    TimesDoNotRise {
        /// Index of the sample.
        sample: usize,
        /// Its time, s.
        time: f64,
        /// Time of the sample before, s.
        previous: f64,
    },
    /// End of a run for which a rate cannot be integrated, s.
    #[error("the run ends at {0} s, must end at a finite time greater than 0 for a rate")]
    End(f64),
    /// Rate that is not finite at some time of a short interval.
    #[error("the rate is not finite shortly after {} s, must be finite during the run", significant(*.time))]
    RateNotFinite {
        /// Beginning of the interval, s.
        time: f64,
    },
}

/// The motion of a rigid body.
#[derive(Clone, Debug)]
pub enum Motion {
    /// Displacement along x, y and z, m.
    Translation([Curve; 3]),
    /// Rotation about a line that is at rest.
    Rotation {
        /// A point of the line, m.
        about: DVec3,
        /// Unit vector along the line.
        axis: DVec3,
        /// Angle, rad; the right hand gives its sense.
        angle: Curve,
    },
    /// Motions from the first to the last. The first one moves the body; each later one moves all
    /// that the earlier ones moved, their axes and the points that they turn about too.
    ///
    /// `about` and `axis` of each motion are thus places in the scene as drawn: in the chain of a
    /// rotation and a translation the body turns about a point that travels with it. In the chain
    /// of a translation and a rotation its path turns.
    Chain(Vec<Motion>),
}

impl Motion {
    /// Returns a rotation about the line through `about` (m) along `axis`, of any length.
    ///
    /// # Errors
    /// An axis of length 0, or numbers that are not finite.
    pub fn rotation(about: DVec3, axis: DVec3, angle: Curve) -> Result<Self, MotionFault> {
        if !about.is_finite() {
            return Err(MotionFault::About(about));
        }
        // By its largest component first: the square of a tiny or huge length is not a number.
        let scaled = axis / axis.abs().max_element();
        if !axis.is_finite() || !scaled.is_finite() {
            return Err(MotionFault::Axis(axis));
        }
        Ok(Self::Rotation { about, axis: scaled.normalize(), angle })
    }

    /// Returns the pose at a time, s.
    ///
    /// It depends on the time alone, bitwise, not on what was evaluated before.
    pub fn pose(&self, time: f64) -> Pose {
        match self {
            Self::Translation(curves) => {
                let [x, y, z] = curves.each_ref().map(|curve| curve.at(time));
                let [place, velocity, acceleration] = [0, 1, 2].map(|k| DVec3::new(x[k], y[k], z[k]));
                Pose::translated(place, velocity, acceleration)
            }
            Self::Rotation { about, axis, angle } => {
                let [angle, rate, acceleration] = angle.at(time);
                Pose::rotated(*about, *axis, angle, rate, acceleration)
            }
            Self::Chain(motions) => {
                let poses = motions.iter().map(|motion| motion.pose(time));
                poses.reduce(|inner, outer| inner.then(&outer)).unwrap_or(Pose::IDENTITY)
            }
        }
    }

    /// Returns the first sampled time of a run to `end` (s) at which the pose is not finite, s.
    pub fn first_not_finite(&self, end: f64) -> Option<f64> {
        sampled_times(end).find(|time| !self.pose(*time).is_finite())
    }

    /// Returns a bound of the speed of the points of a ball (reference centre and radius, m) at
    /// `samples` + 1 times of an interval (s), m/s; infinite if a pose is not finite.
    ///
    /// It is |v(centre)| + |ω| radius, which a ball that moves across the axis of its rotation has.
    pub fn largest_speed(&self, centre: DVec3, radius: f64, interval: [f64; 2], samples: u32) -> f64 {
        let step = (interval[1] - interval[0]) / f64::from(samples.max(1));
        let speeds = (0..=samples).map(|index| {
            let pose = self.pose(interval[0] + f64::from(index) * step);
            let speed = pose.velocity_at(pose.place(centre)).length() + pose.spin.length() * radius;
            if speed.is_finite() { speed } else { f64::INFINITY }
        });
        speeds.fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, TAU};

    use super::*;
    use crate::expression::{Constants, TimeFunction};

    fn curve(text: &str) -> Curve {
        TimeFunction::read(text, &Constants::default()).expect("a function").into()
    }

    fn translation(path: [&str; 3]) -> Motion {
        Motion::Translation(path.map(curve))
    }

    fn rotation(about: DVec3, axis: DVec3, angle: &str) -> Motion {
        Motion::rotation(about, axis, curve(angle)).expect("a rotation")
    }

    fn assert_near(found: DVec3, expected: DVec3) {
        assert!((found - expected).length() < 1e-12 * (1.0 + expected.length()), "{found}, not {expected}");
    }

    #[test]
    fn translation_has_its_path_and_derivatives() {
        let pose = translation(["0.01*sin(2*pi*t)", "t^2", "3"]).pose(0.3);
        let phase = TAU * 0.3;
        assert_near(pose.place(DVec3::X), DVec3::new(1.0 + 0.01 * phase.sin(), 0.09, 3.0));
        assert_near(pose.velocity_at(DVec3::ONE), DVec3::new(0.01 * TAU * phase.cos(), 0.6, 0.0));
        assert_near(pose.acceleration_at(DVec3::Y), DVec3::new(-0.01 * TAU * TAU * phase.sin(), 2.0, 0.0));
    }

    #[test]
    fn rotation_has_its_angle_whatever_the_length_of_the_axis() {
        for length in [1.0, 7.0, 1e-200, 1e200] {
            let about = DVec3::new(1.0, 0.0, 0.0);
            let motion = rotation(about, length * DVec3::Z, "3*t^2");
            let (angle, rate, acceleration) = (0.75_f64, 3.0, 6.0);
            let pose = motion.pose(0.5);
            let place = pose.place(DVec3::new(3.0, 0.0, 0.2));
            let (radial, along) =
                (DVec3::new(angle.cos(), angle.sin(), 0.0), DVec3::new(-angle.sin(), angle.cos(), 0.0));
            assert_near(place, about + 2.0 * radial + 0.2 * DVec3::Z);
            assert_near(pose.velocity_at(place), 2.0 * rate * along);
            assert_near(pose.acceleration_at(place), 2.0 * acceleration * along - 2.0 * rate * rate * radial);
        }
    }

    #[test]
    fn body_turns_about_a_point_that_a_later_translation_moves() {
        let about = DVec3::new(0.0, 0.5, 0.0);
        let turn = rotation(about, DVec3::Z, "2*t");
        let motion = Motion::Chain(vec![turn, translation(["3*t", "t^2", "0"])]);
        let time = 0.4;
        let pose = motion.pose(time);
        let (angle, moved) = (2.0 * time, DVec3::new(3.0 * time, time * time, 0.0));
        let (radial, along) =
            (DVec3::new(angle.cos(), angle.sin(), 0.0), DVec3::new(-angle.sin(), angle.cos(), 0.0));
        let place = pose.place(about + DVec3::X);
        assert_near(place, about + moved + radial);
        assert_near(pose.velocity_at(place), DVec3::new(3.0, 2.0 * time, 0.0) + 2.0 * along);
        assert_near(pose.acceleration_at(place), DVec3::new(0.0, 2.0, 0.0) - 4.0 * radial);
        assert_near(pose.velocity_at(about + moved), DVec3::new(3.0, 2.0 * time, 0.0));
    }

    #[test]
    fn later_rotation_turns_the_path_of_an_earlier_translation() {
        let slide = translation(["3*t", "0", "0"]);
        let motion = Motion::Chain(vec![slide, rotation(DVec3::ZERO, DVec3::Z, "pi/2")]);
        let pose = motion.pose(2.0);
        assert_near(pose.place(DVec3::ZERO), 6.0 * DVec3::Y);
        assert_near(pose.velocity_at(DVec3::ZERO), 3.0 * DVec3::Y);
    }

    #[test]
    fn later_rotation_turns_the_axis_of_an_earlier_one() {
        let roll = rotation(DVec3::ZERO, DVec3::X, "5*t");
        let yaw = rotation(DVec3::ZERO, DVec3::Z, "2*t");
        let pose = Motion::Chain(vec![roll, yaw]).pose(FRAC_PI_2 / 2.0);
        assert_near(pose.spin, 2.0 * DVec3::Z + 5.0 * DVec3::Y);
        assert_near(pose.spin_rate, -10.0 * DVec3::X);
    }

    #[test]
    fn chains_nest_and_an_empty_one_is_at_rest() {
        let parts = || {
            [
                translation(["t", "0", "t^2"]),
                rotation(DVec3::Y, DVec3::ONE, "t"),
                translation(["0", "t", "0"]),
            ]
        };
        let [a, b, c] = parts();
        let flat = Motion::Chain(parts().to_vec()).pose(0.7);
        assert_eq!(flat, Motion::Chain(vec![Motion::Chain(vec![a, b]), c]).pose(0.7));
        assert_eq!(Motion::Chain(Vec::new()).pose(3.0), Pose::IDENTITY);
    }

    #[test]
    fn pose_is_bitwise_the_same_whatever_was_evaluated_before() {
        let rate = TimeFunction::read("1 + sin(9*t)", &Constants::default()).expect("a function");
        let turn = Motion::rotation(DVec3::X, DVec3::Z, Curve::integral(rate, 1.0).expect("an integral"));
        let table = Curve::table(&[(0.0, 0.0), (0.3, 1.0), (0.8, 0.2)]).expect("a table");
        let slide = Motion::Translation([table, Curve::Constant(0.0), curve("sin(t)")]);
        let motion = Motion::Chain(vec![turn.expect("a rotation"), slide]);
        let first = motion.pose(0.61);
        for k in 0..50 {
            motion.pose(f64::from(50 - k) * 0.04);
        }
        assert_eq!(motion.clone().pose(0.61), first);
    }

    #[test]
    fn largest_speed_bounds_the_points_of_the_ball() {
        let motion = rotation(DVec3::ZERO, DVec3::Z, "2*t + 0.1*sin(3*t)");
        // The farthest point of the ball from the axis has the bound exactly.
        let speed = motion.largest_speed(DVec3::X, 0.5, [0.0, TAU], 60);
        assert!((speed - 1.5 * 2.3).abs() < 1e-12, "{speed}");
        let shaken = translation(["0", "0.2*sin(t)", "0"]);
        assert!((shaken.largest_speed(DVec3::X, 9.0, [0.0, TAU], 64) - 0.2).abs() < 1e-15);
        assert!(
            translation(["1/(t - 1)", "0", "0"]).largest_speed(DVec3::X, 1.0, [0.0, 2.0], 2).is_infinite()
        );
    }

    #[test]
    fn motions_that_cannot_be_are_faults() {
        for axis in [DVec3::ZERO, DVec3::new(f64::NAN, 1.0, 0.0), DVec3::new(f64::INFINITY, 1.0, 0.0)] {
            let fault = Motion::rotation(DVec3::ZERO, axis, curve("t")).expect_err("has no direction");
            assert!(matches!(fault, MotionFault::Axis(_)), "{fault}");
        }
        let fault = Motion::rotation(DVec3::ZERO, DVec3::ZERO, curve("t")).expect_err("has no direction");
        assert_eq!(fault.to_string(), "the axis is (0, 0, 0), must be finite and have a length");
        assert!(Motion::rotation(DVec3::NAN, DVec3::Z, curve("t")).is_err());
        assert_eq!(translation(["1/(t - 1)", "0", "0"]).first_not_finite(2.0), Some(1.0));
        assert_eq!(translation(["sin(t)", "0", "0"]).first_not_finite(2.0), None);
    }
}
