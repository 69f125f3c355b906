//! Walls that move: bodies with a prescribed motion, and the casing around the fluid.
//!
//! ```text
//! x(t) = R(t) X + o(t),   fluid where max(φ_casing(x), max_m −φ_m(X)) < 0
//! ```
//!
//! A mover is a shape that is taken out of the domain. The casing is all other walls, which also
//! stand where a mover is at the start, so that they are there when it has moved on. The pose of
//! each is a function of time alone: there is no drift, and a resumed run has the same positions.

use glam::DVec3;

use super::fill::periodic_distance;
use super::geometry::Shape;
use super::geometry::measure::exit_distance;
use super::model::Scene;
use super::motion::Motion;
use super::sampled_times::largest_in_time;
use sphecs_core::physics::pose::Pose;

/// A body with a prescribed motion.
#[derive(Clone, Debug)]
pub struct Mover {
    /// Name of its wall part.
    pub name: String,
    /// Index of its wall part.
    pub part: u16,
    /// Shape in reference coordinates, those of a body without displacement, m.
    pub shape: Shape,
    /// Motion.
    pub motion: Motion,
    /// Pose at the start.
    pub start: Pose,
    /// Centre of a ball around the shape in reference coordinates, m.
    pub centre: DVec3,
    /// Radius of the ball, m.
    pub radius: f64,
}

impl Mover {
    /// Returns a mover; `dimensions` is 2 or 3.
    pub fn new(name: String, part: u16, shape: Shape, motion: Motion, dimensions: usize) -> Self {
        let (centre, radius) = ball(&shape, dimensions);
        let start = motion.pose(0.0);
        Self { name, part, shape, motion, start, centre, radius }
    }

    /// Returns the shape in the place that it has in a pose.
    pub fn placed(&self, pose: &Pose) -> Shape {
        placed(&self.shape, pose)
    }
}

/// Returns a shape in the place that it has in a pose.
fn placed(shape: &Shape, pose: &Pose) -> Shape {
    let shape = Box::new(shape.clone());
    Shape::Placed { shape, rotation: pose.rotation, scale: 1.0, origin: pose.origin }
}

/// Returns centre and radius of a ball around a shape, m.
fn ball(shape: &Shape, dimensions: usize) -> (DVec3, f64) {
    let (low, high) = shape.bounds();
    let (mut centre, mut half) = (low.midpoint(high), 0.5 * (high - low));
    if dimensions == 2 {
        (centre.z, half.z) = (0.0, 0.0);
    }
    (centre, half.length())
}

/// Number of intervals of the run at whose ends the swept box is found.
const SWEEP_TIMES: u32 = 512;

/// Poses of the walls that move, at one time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WallPoses {
    /// Pose of the casing; None if it is at rest.
    pub casing: Option<Pose>,
    /// Poses of the movers, in the order of the scene.
    pub movers: Vec<Pose>,
}

/// A wall: the casing or a mover.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Wall {
    /// All walls that are not of a mover.
    Casing,
    /// The surface of the mover with this index.
    Mover(usize),
}

impl Wall {
    /// Returns the number by which the places of a fill name their wall.
    pub fn number(self) -> u16 {
        match self {
            Wall::Casing => 0,
            Wall::Mover(index) => index as u16 + 1,
        }
    }

    /// Returns the wall with a [number](Self::number).
    pub fn numbered(number: u16) -> Self {
        number.checked_sub(1).map_or(Wall::Casing, |index| Wall::Mover(usize::from(index)))
    }

    /// Returns the wall of a wall part of a scene.
    pub fn of_part(scene: &Scene, part: u16) -> Self {
        let mover = scene.walls.parts.get(usize::from(part)).and_then(|part| part.mover);
        mover.map_or(Wall::Casing, |index| Wall::Mover(usize::from(index)))
    }

    /// Returns the signed distance behind the wall at the start, m: positive in the solid.
    /// Periodic images count.
    pub fn distance(self, scene: &Scene, point: DVec3) -> f64 {
        match self {
            Wall::Casing => periodic_distance(&scene.layout.casing.confines, &scene.periodic, point),
            Wall::Mover(index) => {
                let mover = &scene.movers[index];
                let near = scene.nearest_image(point, mover.start.place(mover.centre));
                -mover.shape.signed_distance(mover.start.reference(near))
            }
        }
    }

    /// Returns true if a part of its surface is a mesh.
    pub fn has_mesh(self, scene: &Scene) -> bool {
        match self {
            Wall::Casing => scene.layout.casing.confines.has_mesh(),
            Wall::Mover(index) => scene.movers[index].shape.has_mesh(),
        }
    }

    /// Returns the unit normal at the start, out of the fluid, by differences of the distance
    /// without its periodic images.
    pub fn gradient(self, scene: &Scene, point: DVec3) -> DVec3 {
        let step = 1e-4 * scene.spacing;
        match self {
            Wall::Casing => scene.layout.casing.confines.gradient(point, step, scene.dimensions),
            Wall::Mover(index) => {
                let mover = &scene.movers[index];
                let near = scene.nearest_image(point, mover.start.place(mover.centre));
                let reference = mover.start.reference(near);
                -mover.start.direction(mover.shape.gradient(reference, step, scene.dimensions))
            }
        }
    }

    /// Returns the bounds of the region that the wall separates from its solid at the start, m.
    pub fn bounds(self, scene: &Scene) -> (DVec3, DVec3) {
        match self {
            Wall::Casing => scene.layout.casing.confines.bounds(),
            Wall::Mover(index) => {
                let mover = &scene.movers[index];
                mover.placed(&mover.start).bounds()
            }
        }
    }
}

/// Surface of a wall next to a point behind it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestSurface {
    /// Nearest point of the surface, m.
    pub point: DVec3,
    /// Unit normal, out of the fluid.
    pub outwards: DVec3,
    /// Velocity of the surface by the motion of the wall, m/s.
    pub velocity: DVec3,
}

impl Scene {
    /// Returns true if a wall changes its place.
    pub fn has_moving_walls(&self) -> bool {
        self.casing_motion.is_some() || !self.movers.is_empty()
    }

    /// Returns the point of a mover at the start, inside the casing, that is nearest to the outlets
    /// along a direction, m.
    pub fn wetted_end(&self, mover: &Mover, direction: DVec3) -> DVec3 {
        let centre = mover.start.place(mover.centre);
        let middle = self.outlets.iter().map(|outlet| outlet.patch.at).sum::<DVec3>();
        let middle = middle / (self.outlets.len().max(1) as f64);
        let towards = direction * (middle - centre).dot(direction).signum();
        // The surface on the line from the centre to the outlets.
        let inside =
            |length: f64| mover.shape.signed_distance(mover.start.reference(centre + length * towards)) < 0.0;
        let longest = 2.0 * mover.radius;
        let length = exit_distance(inside, 0.5 * self.spacing, longest).unwrap_or(0.0);
        centre + length * towards
    }

    /// Returns the largest speed that a wall has by its motion during the run, m/s.
    pub fn largest_wall_speed(&self) -> f64 {
        let movers = self.movers.iter().map(|mover| (&mover.motion, mover.centre, mover.radius));
        let casing = self.casing_motion.iter().map(|motion| {
            let (centre, radius) = ball(&self.layout.casing.container, self.dimensions);
            (motion, centre, radius)
        });
        let largest = |(motion, centre, radius): (&Motion, DVec3, f64)| {
            let speed = |time: f64| {
                let pose = motion.pose(time);
                pose.velocity_at(pose.place(centre)).length() + pose.spin.length() * radius
            };
            largest_in_time(self.time.end, speed)
        };
        movers.chain(casing).map(largest).fold(0.0, f64::max)
    }

    /// Returns the corners of a box that the moving walls do not leave during the run, m; None if
    /// there are none. `reach` is the thickness of the casing, m.
    pub fn swept_box(&self, reach: f64) -> Option<(DVec3, DVec3)> {
        if !self.has_moving_walls() {
            return None;
        }
        let interval = self.time.end / f64::from(SWEEP_TIMES);
        let margin = DVec3::splat(reach + 0.5 * interval * self.largest_wall_speed());
        let mut swept = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for at in 0..=SWEEP_TIMES {
            let poses = self.wall_poses(interval * f64::from(at));
            let movers = self.movers.iter().zip(&poses.movers).map(|(mover, pose)| mover.placed(pose));
            let casing = poses.casing.iter().map(|pose| placed(&self.layout.casing.confines, pose));
            for (low, high) in movers.chain(casing).map(|shape| shape.bounds()) {
                swept = (swept.0.min(low - margin), swept.1.max(high + margin));
            }
        }
        Some(swept)
    }

    /// Returns true if a wall part changes its place.
    pub fn part_moves(&self, part: u16) -> bool {
        match Wall::of_part(self, part) {
            Wall::Casing => self.casing_motion.is_some(),
            Wall::Mover(_) => true,
        }
    }

    /// Returns the poses of all walls that move at a time, s.
    pub fn wall_poses(&self, time: f64) -> WallPoses {
        WallPoses {
            casing: self.casing_motion.as_ref().map(|motion| motion.pose(time)),
            movers: self.movers.iter().map(|mover| mover.motion.pose(time)).collect(),
        }
    }

    /// Returns the pose of a wall part; None if it is at rest.
    pub fn pose_of_part<'a>(&self, poses: &'a WallPoses, part: u16) -> Option<&'a Pose> {
        match Wall::of_part(self, part) {
            Wall::Casing => poses.casing.as_ref(),
            Wall::Mover(index) => poses.movers.get(index),
        }
    }

    /// Returns the image of a point next to a wall part in the periodic directions in which the
    /// pose of the part places it, m.
    pub fn image_at_wall(&self, poses: &WallPoses, part: u16, point: DVec3) -> DVec3 {
        match Wall::of_part(self, part) {
            Wall::Casing => point,
            Wall::Mover(index) => {
                self.nearest_image(point, poses.movers[index].place(self.movers[index].centre))
            }
        }
    }

    /// Returns the image of a point inside the periodic box, m.
    pub fn wrapped(&self, mut point: DVec3) -> DVec3 {
        for (axis, bounds) in self.periodic.iter().enumerate() {
            if let Some((low, high)) = bounds {
                let period = high - low;
                point[axis] -= period * ((point[axis] - low) / period).floor();
            }
        }
        point
    }

    /// Returns the image of a point in the periodic directions that is nearest to another, m.
    pub fn nearest_image(&self, mut point: DVec3, to: DVec3) -> DVec3 {
        for (axis, bounds) in self.periodic.iter().enumerate() {
            if let Some((low, high)) = bounds {
                let period = high - low;
                point[axis] -= period * ((point[axis] - to[axis]) / period).round();
            }
        }
        point
    }

    /// Returns the signed distance behind the nearest wall, m, negative in the fluid, and the wall.
    ///
    /// `confines` is what the casing encloses, [`Casing::container`](super::model::Casing) or
    /// [`Casing::confines`](super::model::Casing). Of a mover whose ball does not hold the point
    /// only the sign counts.
    pub fn nearest_wall(&self, confines: &Shape, poses: &WallPoses, point: DVec3) -> (f64, Wall) {
        let at = poses.casing.as_ref().map_or(point, |pose| pose.reference(point));
        let mut nearest = (confines.signed_distance(at), Wall::Casing);
        for (index, (mover, pose)) in self.movers.iter().zip(&poses.movers).enumerate() {
            let centre = pose.place(mover.centre);
            let near = self.nearest_image(point, centre);
            if near.distance_squared(centre) <= mover.radius * mover.radius {
                let behind = -mover.shape.signed_distance(pose.reference(near));
                if behind > nearest.0 {
                    nearest = (behind, Wall::Mover(index));
                }
            }
        }
        nearest
    }

    /// Returns the surface of a wall next to a point behind it; `step` is that of differences, m.
    pub fn nearest_surface(
        &self,
        (wall, confines): (Wall, &Shape),
        poses: &WallPoses,
        point: DVec3,
        step: f64,
    ) -> NearestSurface {
        let (pose, shape, side, near) = match wall {
            Wall::Casing => (poses.casing.as_ref(), confines, 1.0, point),
            Wall::Mover(index) => {
                let (mover, pose) = (&self.movers[index], &poses.movers[index]);
                (Some(pose), &mover.shape, -1.0, self.nearest_image(point, pose.place(mover.centre)))
            }
        };
        let reference = pose.map_or(near, |pose| pose.reference(near));
        let outwards = side * shape.gradient(reference, step, self.dimensions);
        let surface = shape.nearest_surface(reference, step, self.dimensions);
        let Some(pose) = pose else {
            return NearestSurface { point: surface, outwards, velocity: DVec3::ZERO };
        };
        let placed = pose.place(surface);
        NearestSurface {
            point: placed + (point - near),
            outwards: pose.direction(outwards),
            velocity: pose.velocity_at(placed),
        }
    }
}

/// Returns a shape without the movers in their places at the start.
pub fn without_movers(shape: &Shape, movers: &[Mover]) -> Shape {
    let mut bodies: Vec<Shape> = movers.iter().map(|mover| mover.placed(&mover.start)).collect();
    match bodies.len() {
        0 => shape.clone(),
        1 => Shape::Difference(Box::new(shape.clone()), Box::new(bodies.remove(0))),
        _ => Shape::Difference(Box::new(shape.clone()), Box::new(Shape::Union(bodies))),
    }
}
