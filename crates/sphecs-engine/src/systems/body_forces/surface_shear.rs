//! Shear on a body with a rotating or deforming surface that the pair sums omit.
//!
//! The Laplacian form of the pair sums lacks the traction of the transposed velocity gradient,
//! which does not vanish on a surface whose velocity varies along it.

use glam::DVec3;

use sphecs_core::pass::body::BodySum;
use sphecs_core::physics::pose::Pose;
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
    /// Creates the surface of a wall part; torques are about the point `about`, m, if it is at
    /// rest.
    pub(super) fn new(scene: &Scene, part: u16, about: DVec3) -> Self {
        let wall = &scene.walls.parts[usize::from(part)];
        if let Some(pose) = scene.pose_of_part(&scene.wall_poses(0.0), part) {
            let slips = wall.slip != Slip::NoSlip;
            let pieces = if slips { Vec::new() } else { outline(scene, part) };
            let to_reference = |piece: OutlinePoint| OutlinePoint {
                point: pose.reference(piece.point),
                normal: pose.reference_direction(piece.normal),
                ..piece
            };
            return Self { pieces: pieces.into_iter().map(to_reference).collect(), steady: None };
        }
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

    /// Returns force and torque about a point, m, on a surface that moves as a rigid body.
    pub(super) fn in_pose(&self, scene: &Scene, pose: &Pose, about: DVec3) -> BodySum {
        let mut sum = BodySum::default();
        if pose.spin == DVec3::ZERO {
            return sum;
        }
        // In reference coordinates, to which the surface is fixed.
        let (spin, about) = (pose.reference_direction(pose.spin), pose.reference(about));
        for piece in &self.pieces {
            let slope = |direction: DVec3| (direction, spin.cross(direction));
            let traction = traction(scene, piece.normal, slope);
            sum.viscous_force += piece.area * traction;
            sum.viscous_torque += piece.area * (piece.point - about).cross(traction);
        }
        sum.viscous_force = pose.direction(sum.viscous_force);
        sum.viscous_torque = pose.direction(sum.viscous_torque);
        sum
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
            let traction = traction(scene, *normal, |direction| slope(*point, direction));
            sum.viscous_force += *area * traction;
            sum.viscous_torque += *area * (*point - about).cross(traction);
        }
        sum
    }
}

/// Returns the traction of the transposed velocity gradient, Pa; `slope` returns a direction with
/// the derivative of the surface velocity along it.
fn traction(scene: &Scene, normal: DVec3, slope: impl Fn(DVec3) -> (DVec3, DVec3)) -> DVec3 {
    let viscosity = scene.fluid.density * scene.fluid.viscosity;
    if scene.dimensions == 2 {
        return transposed_traction(viscosity, normal, &[slope(normal.truncate().perp().extend(0.0))]);
    }
    let (first, second) = normal.any_orthonormal_pair();
    transposed_traction(viscosity, normal, &[slope(first), slope(second)])
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
