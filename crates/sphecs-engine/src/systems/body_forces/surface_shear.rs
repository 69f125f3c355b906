//! Shear on a body with a rotating or deforming surface that the pair sums omit.
//!
//! The Laplacian form of the pair sums lacks the traction of the transposed velocity gradient,
//! which does not vanish on a surface whose velocity varies along it.

use glam::DVec3;

use sphecs_core::pass::body::BodySum;
use sphecs_core::physics::wall::Slip;
use sphecs_core::physics::wall::transposed::transposed_traction;
use sphecs_scene::model::{Scene, WallPart};
use sphecs_scene::outline::{OutlinePoint, outline};

/// Surface of a body, with the contribution of its own motion to force and torque.
#[derive(Clone, Debug, Default)]
pub(super) struct SurfaceShear {
    /// Surface elements; none if the surface slips or its velocity is uniform.
    pieces: Vec<OutlinePoint>,
    /// Sum over the surface, if the velocity does not depend on time.
    steady: Option<BodySum>,
}

impl SurfaceShear {
    /// Creates the surface of a wall part, with torques about the point `about`, m.
    pub(super) fn new(scene: &Scene, part: u16, about: DVec3) -> Self {
        let wall = &scene.walls.parts[usize::from(part)];
        let varies = wall.velocity.iter().any(|component| component.depends_on(&[0, 1, 2]));
        if !varies || wall.slip != Slip::NoSlip {
            return Self { pieces: Vec::new(), steady: Some(BodySum::default()) };
        }
        let mut shear = Self { pieces: outline(scene, part), steady: None };
        if !wall.velocity.iter().any(|component| component.depends_on(&[3])) {
            shear.steady = Some(shear.at(scene, wall, about, 0.0));
        }
        shear
    }

    /// Returns force and torque at a time, s.
    pub(super) fn at(&self, scene: &Scene, wall: &WallPart, about: DVec3, time: f64) -> BodySum {
        if let Some(steady) = self.steady {
            return steady;
        }
        let mut sum = BodySum::default();
        let step = 1e-3 * scene.spacing;
        let slope = |point: DVec3, direction: DVec3| {
            let [before, after] = [-step, step].map(|step| wall.velocity_at(point + step * direction, time));
            (direction, (after - before) / (2.0 * step))
        };
        for OutlinePoint { point, normal, area } in &self.pieces {
            let viscosity = scene.fluid.density * scene.fluid.viscosity;
            let traction = if scene.dimensions == 2 {
                transposed_traction(
                    viscosity,
                    *normal,
                    &[slope(*point, normal.truncate().perp().extend(0.0))],
                )
            } else {
                let (first, second) = normal.any_orthonormal_pair();
                transposed_traction(viscosity, *normal, &[slope(*point, first), slope(*point, second)])
            };
            sum.viscous_force += *area * traction;
            sum.viscous_torque += *area * (*point - about).cross(traction);
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use glam::DVec3;

    use super::SurfaceShear;
    use sphecs_scene::Scene;

    /// A sphere that rotates about z with increasing ω has the torque −2 μ ω V about any point, and
    /// no force. A sphere that slips or translates has neither.
    #[test]
    fn rotating_sphere_has_the_analytical_torque() {
        let scene = |wall: &str| {
            let text = format!(
                r#"Scene(
                    title: "Sphere", dimensions: 3, spacing: 0.05, smoke: 0.05,
                    fluid: (density: 1000.0, viscosity: 0.1, sound_speed: 10.0),
                    domain: Difference([
                        Box(min: (-0.5, -0.5, -0.5), max: (0.5, 0.5, 0.5)), Sphere(center: (0.0, 0.0, 0.0), radius: 0.25),
                    ]),
                    walls: (parts: [(name: "sphere", region: Sphere(center: (0.0, 0.0, 0.0), radius: 0.35), {wall})]),
                    reference: (velocity: 1.0, length: 1.0), time: (end: 1.0), output: (every: 1.0),
                )"#
            );
            Scene::from_text("sphere", &text).load().unwrap_or_else(|faults| panic!("{faults:?}"))
        };
        let about = DVec3::new(0.1, -0.2, 0.3);
        let at = |wall: &str, time: f64| {
            let scene = scene(wall);
            SurfaceShear::new(&scene, 1, about).at(&scene, &scene.walls.parts[1], about, time)
        };
        let rotating = "velocity: (\"-(1 + t)*y\", \"(1 + t)*x\", 0.0)";
        let torque = -2.0 * 100.0 * 4.0 / 3.0 * PI * 0.25_f64.powi(3);
        for (time, rate) in [(0.0, 1.0), (2.0, 3.0)] {
            let sum = at(rotating, time);
            let off = sum.viscous_torque - DVec3::Z * torque * rate;
            assert!(off.length() < 0.02 * torque.abs() * rate, "{} N m at {time} s", sum.viscous_torque);
            assert!(
                sum.viscous_force.length() < 0.02 * torque.abs() * rate / 0.25,
                "{} N",
                sum.viscous_force
            );
        }
        for wall in [format!("slip: FreeSlip, {rotating}"), "velocity: (0.5, 0.0, 0.0)".to_owned()] {
            assert_eq!(at(&wall, 1.0).viscous_torque, DVec3::ZERO, "{wall}");
        }
    }
}
