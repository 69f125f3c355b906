//! What the pairs leave out of the shear on a body whose surface turns: the traction of the transposed gradient.

use glam::DVec3;

use crate::pass::body::BodySum;
use crate::physics::wall::Slip;
use crate::physics::wall::transposed::transposed_traction;
use crate::scene::model::{Scene, WallPart};
use crate::scene::outline::{OutlinePoint, outline};

/// The surface of a body, with what its own motion adds to force and torque.
#[derive(Clone, Debug, Default)]
pub struct SurfaceShear {
    /// Its pieces; none where the velocity is the same all over it, or where it slips.
    pieces: Vec<OutlinePoint>,
    /// The sum, of a velocity that does not depend on time.
    steady: Option<BodySum>,
}

impl SurfaceShear {
    /// Of a wall part.
    pub fn new(scene: &Scene, part: u16, about: DVec3) -> Self {
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

    /// Force and torque at a time, s.
    pub fn at(&self, scene: &Scene, wall: &WallPart, about: DVec3, time: f64) -> BodySum {
        if let Some(steady) = self.steady {
            return steady;
        }
        let mut sum = BodySum::default();
        let step = 1e-3 * scene.spacing;
        let slope = |point: DVec3, way: DVec3| {
            let [before, after] = [-step, step].map(|step| wall.velocity_at(point + step * way, time));
            (way, (after - before) / (2.0 * step))
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
