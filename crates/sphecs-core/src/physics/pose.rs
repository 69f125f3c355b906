//! Pose of a rigid body at one time: its place, orientation, velocities and accelerations.
//!
//! ```text
//! x = R X + o                    place of the material point X of the reference configuration
//! v = v_o + ω × (x − o)
//! a = a_o + α × (x − o) + ω × (ω × (x − o))
//!
//! motion 1, then motion 2 (the axes of motion 1 are moved by motion 2):
//! R  = R₂ R₁                     o   = R₂ o₁ + o₂
//! ω  = ω₂ + R₂ ω₁                v_o = v₂(o) + R₂ v₁
//! α  = α₂ + R₂ α₁ + ω₂ × R₂ ω₁   a_o = a₂(o) + 2 ω₂ × R₂ v₁ + R₂ a₁
//! ```
//!
//! v₂(o) and a₂(o) are those of the material point of motion 2 that is at o; 2 ω₂ × R₂ v₁ is the
//! Coriolis acceleration.

use glam::{DMat3, DVec3};

/// The pose of a rigid body and its rates at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Rotation from the reference configuration.
    pub rotation: DMat3,
    /// Place of the material point that is at zero in the reference configuration, m.
    pub origin: DVec3,
    /// Velocity of that point, m/s.
    pub velocity: DVec3,
    /// Angular velocity, 1/s.
    pub spin: DVec3,
    /// Acceleration of that point, m/s².
    pub acceleration: DVec3,
    /// Angular acceleration, 1/s².
    pub spin_rate: DVec3,
}

impl Pose {
    /// The reference configuration, at rest.
    pub const IDENTITY: Self = Self {
        rotation: DMat3::IDENTITY,
        origin: DVec3::ZERO,
        velocity: DVec3::ZERO,
        spin: DVec3::ZERO,
        acceleration: DVec3::ZERO,
        spin_rate: DVec3::ZERO,
    };

    /// Returns a translation by a displacement, m, with its velocity, m/s, and acceleration, m/s².
    pub fn translated(displacement: DVec3, velocity: DVec3, acceleration: DVec3) -> Self {
        Self { origin: displacement, velocity, acceleration, ..Self::IDENTITY }
    }

    /// Returns a rotation about the line through the point `about`, m, along the unit vector
    /// `axis`, by an angle, rad, with its rate, 1/s, and acceleration, 1/s².
    ///
    /// The right hand gives the sense. An angle of 0 leaves all places bitwise unchanged.
    pub fn rotated(about: DVec3, axis: DVec3, angle: f64, rate: f64, acceleration: f64) -> Self {
        let rotation = DMat3::from_axis_angle(axis, angle);
        let (spin, spin_rate) = (rate * axis, acceleration * axis);
        let origin = about - rotation * about;
        // The point on the axis is at rest, so that the arm is from there.
        let arm = origin - about;
        let velocity = spin.cross(arm);
        let acceleration = spin_rate.cross(arm) + spin.cross(velocity);
        Self { rotation, origin, velocity, spin, acceleration, spin_rate }
    }

    /// Returns this motion as moved by an outer one, which turns and carries its axes.
    #[must_use]
    pub fn then(&self, outer: &Self) -> Self {
        let origin = outer.place(self.origin);
        let (velocity, spin) = (outer.direction(self.velocity), outer.direction(self.spin));
        let coriolis = 2.0 * outer.spin.cross(velocity);
        Self {
            rotation: outer.rotation * self.rotation,
            origin,
            velocity: outer.velocity_at(origin) + velocity,
            spin: outer.spin + spin,
            acceleration: outer.acceleration_at(origin) + coriolis + outer.direction(self.acceleration),
            spin_rate: outer.spin_rate + outer.direction(self.spin_rate) + outer.spin.cross(spin),
        }
    }

    /// Returns the place of a material point, m, from its place in the reference configuration, m.
    ///
    /// The identity returns it bitwise unchanged, and a translation rounds once.
    #[inline]
    pub fn place(&self, reference: DVec3) -> DVec3 {
        let turned = self.direction(reference);
        // Adding zero would lose the sign of a zero.
        if self.origin == DVec3::ZERO { turned } else { turned + self.origin }
    }

    /// Returns the place in the reference configuration, m, of the material point at a place, m.
    #[inline]
    pub fn reference(&self, place: DVec3) -> DVec3 {
        let arm = if self.origin == DVec3::ZERO { place } else { place - self.origin };
        self.reference_direction(arm)
    }

    /// Returns the direction that a direction of the reference configuration is turned to.
    #[inline]
    pub fn direction(&self, reference: DVec3) -> DVec3 {
        if self.rotation == DMat3::IDENTITY { reference } else { self.rotation * reference }
    }

    /// Returns the direction in the reference configuration that is turned to a direction.
    #[inline]
    pub fn reference_direction(&self, direction: DVec3) -> DVec3 {
        if self.rotation == DMat3::IDENTITY { direction } else { self.rotation.transpose() * direction }
    }

    /// Returns the velocity of the material point at a place (m), m/s.
    #[inline]
    pub fn velocity_at(&self, place: DVec3) -> DVec3 {
        self.velocity + self.spin.cross(place - self.origin)
    }

    /// Returns the acceleration of the material point at a place (m), m/s².
    #[inline]
    pub fn acceleration_at(&self, place: DVec3) -> DVec3 {
        let arm = place - self.origin;
        self.acceleration + self.spin_rate.cross(arm) + self.spin.cross(self.spin.cross(arm))
    }

    /// Returns true if every number of the pose is finite.
    pub fn is_finite(&self) -> bool {
        let vectors = [self.origin, self.velocity, self.spin, self.acceleration, self.spin_rate];
        self.rotation.is_finite() && vectors.iter().all(|vector| vector.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use proptest::collection::vec;
    use proptest::prelude::{Strategy, any, prop_assert, proptest};

    use super::*;

    /// A motion in time with random numbers: a translation or a rotation.
    #[derive(Clone, Debug)]
    struct Sample {
        turns: bool,
        numbers: [f64; 8],
    }

    impl Sample {
        /// Value, first and second derivative of a sine with a drift.
        fn curve(&self, phase: f64, time: f64) -> [f64; 3] {
            let (size, rate, drift) = (self.numbers[6], 2.0 + self.numbers[7], self.numbers[5]);
            let (sin, cos) = (rate * time + phase).sin_cos();
            [size * sin + drift * time, size * rate * cos + drift, -size * rate * rate * sin]
        }

        fn pose(&self, time: f64) -> Pose {
            let [a, b, c, d, e, ..] = self.numbers;
            if self.turns {
                let axis = DVec3::new(d, e, 1.5).normalize();
                let [angle, rate, acceleration] = self.curve(a, time);
                return Pose::rotated(DVec3::new(a, b, c), axis, angle, rate, acceleration);
            }
            let curves = [a, b, c].map(|phase| self.curve(phase, time));
            let part = |k: usize| DVec3::new(curves[0][k], curves[1][k], curves[2][k]);
            Pose::translated(part(0), part(1), part(2))
        }
    }

    fn motions() -> impl Strategy<Value = Vec<Sample>> {
        let numbers = vec(-1.0..1.0_f64, 8).prop_map(|numbers| std::array::from_fn(|k| numbers[k]));
        vec((any::<bool>(), numbers).prop_map(|(turns, numbers)| Sample { turns, numbers }), 1..5)
    }

    fn chain(motions: &[Sample], time: f64) -> Pose {
        let poses = motions.iter().map(|motion| motion.pose(time));
        poses.fold(Pose::IDENTITY, |inner, outer| inner.then(&outer))
    }

    const POINT: DVec3 = DVec3::new(0.7, -0.4, 1.1);

    proptest! {
        #[test]
        fn rates_of_a_chain_are_those_of_finite_differences(
            motions in motions(), time in -2.0..2.0_f64
        ) {
            // Errors: h² of the differences and rounding over h or h², for sizes of about 10.
            const STEP: f64 = 1e-3;
            let [before, now, after] = [-STEP, 0.0, STEP].map(|step| chain(&motions, time + step));
            let [a, b, c] = [before, now, after].map(|pose| pose.place(POINT));
            let velocity = now.velocity_at(b);
            prop_assert!(((c - a) / (2.0 * STEP) - velocity).length() < 1e-2, "{velocity}");
            let acceleration = now.acceleration_at(b);
            prop_assert!(
                ((c - 2.0 * b + a) / (STEP * STEP) - acceleration).length() < 1e-2 * (1.0 + acceleration.length()),
                "{acceleration}"
            );
            let spin_rate = (after.spin - before.spin) / (2.0 * STEP);
            prop_assert!((spin_rate - now.spin_rate).length() < 1e-2 * (1.0 + spin_rate.length()));
        }

        #[test]
        fn composition_places_points_as_one_motion_after_the_other(
            motions in motions(), time in -2.0..2.0_f64
        ) {
            let one_by_one = motions.iter().fold(POINT, |place, motion| motion.pose(time).place(place));
            let pose = chain(&motions, time);
            prop_assert!((pose.place(POINT) - one_by_one).length() < 1e-13);
            // Rounding of four rotations of points within 10 m.
            prop_assert!((pose.reference(one_by_one) - POINT).length() < 1e-13);
            let direction = pose.direction(DVec3::Y);
            prop_assert!((pose.reference_direction(direction) - DVec3::Y).length() < 1e-14);
            prop_assert!((direction.length() - 1.0).abs() < 1e-14);
        }
    }

    #[test]
    fn identity_leaves_places_bitwise_unchanged() {
        let still = Pose::rotated(DVec3::new(0.3, -7.0, 0.1), DVec3::Z, 0.0, 2.0, 0.0);
        for pose in [Pose::IDENTITY, Pose::IDENTITY.then(&Pose::IDENTITY), still, still.then(&Pose::IDENTITY)]
        {
            for place in [POINT, DVec3::new(-0.0, 0.0, -0.0), DVec3::new(1e-300, 0.1, -1e300)] {
                let bits = |place: DVec3| place.to_array().map(f64::to_bits);
                assert_eq!(bits(pose.place(place)), bits(place));
                assert_eq!(bits(pose.reference(place)), bits(place));
                assert_eq!(bits(pose.direction(place)), bits(place));
            }
        }
    }

    #[test]
    fn rotation_has_the_closed_form() {
        let (about, angle, rate, acceleration) = (DVec3::new(1.0, 2.0, 3.0), 0.3_f64, 5.0, -7.0);
        let pose = Pose::rotated(about, DVec3::Z, angle, rate, acceleration);
        let place = pose.place(about + DVec3::new(2.0, 0.0, 0.5));
        let (radial, along) =
            (DVec3::new(angle.cos(), angle.sin(), 0.0), DVec3::new(-angle.sin(), angle.cos(), 0.0));
        assert!((place - about - 2.0 * radial - 0.5 * DVec3::Z).length() < 1e-15);
        assert!((pose.velocity_at(place) - 2.0 * rate * along).length() < 1e-13);
        let expected = 2.0 * acceleration * along - 2.0 * rate * rate * radial;
        assert!((pose.acceleration_at(place) - expected).length() < 1e-13);
        assert!(pose.velocity_at(about).length() < 1e-14);
    }

    #[test]
    fn point_that_slides_along_a_turning_arm_has_its_coriolis_acceleration() {
        // x = s t e_r with the angle ω t: a = 2 s ω e_φ − ω² s t e_r.
        let (speed, rate, time) = (3.0, 2.0, 0.4);
        let slide = Pose::translated(speed * time * DVec3::X, speed * DVec3::X, DVec3::ZERO);
        let turn = Pose::rotated(DVec3::ZERO, DVec3::Z, rate * time, rate, 0.0);
        let pose = slide.then(&turn);
        let (radial, along) = (turn.direction(DVec3::X), turn.direction(DVec3::Y));
        assert!((pose.velocity - speed * radial - rate * speed * time * along).length() < 1e-14);
        let expected = 2.0 * speed * rate * along - rate * rate * speed * time * radial;
        assert!((pose.acceleration - expected).length() < 1e-14);
        assert_eq!((pose.spin, pose.spin_rate), (rate * DVec3::Z, DVec3::ZERO));
    }
}
