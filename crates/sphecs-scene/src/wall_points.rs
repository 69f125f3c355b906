//! Points of the walls at which a run measures pressure and shear stress.
//!
//! In 2D they lie on the curves of the surface at equal distances of about a spacing. In 3D they
//! are the pieces of [`outline`], moved onto the surface, one for each cell
//! that the surface passes. The planes of openings are not walls.

use glam::{DMat3, DVec3};
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::distance_grid::spread;
use super::fill::periodic_distance;
use super::layers::surface_curves;
use super::model::{Scene, WallPart};
use super::movers::{Wall, WallPoses};
use super::outline::{OutlinePoint, outline};
use super::wall_particles::surface_of;
use sphecs_core::physics::pose::Pose;
use sphecs_core::physics::wall::Slip;

/// Quantities at the walls of a scene, for `walls.nc`.
#[derive(Clone, Debug, PartialEq)]
pub struct WallOutput {
    /// Indices of the wall parts.
    pub parts: Vec<u16>,
    /// Interval between the times that are written, s.
    pub every: f64,
    /// Interval of means, s; None: no means.
    pub mean: Option<(f64, f64)>,
    /// Interval between the samples of the means, s; None: that of
    /// [`Scene::wall_mean_interval`].
    pub mean_every: Option<f64>,
}

/// Point of a wall.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct WallPoint {
    /// Position at the start, m.
    pub position: DVec3,
    /// Unit normal at the start, into the fluid.
    pub normal: DVec3,
    /// Its area, m² (m in 2D).
    pub area: f64,
    /// Index of the wall part.
    pub part: u16,
    /// Index of its curve in 2D; else 0.
    pub curve: u32,
    /// Distance along the curve from its first point in 2D, m; else 0.
    pub arc_length: f64,
}

/// Place of a point of a wall at some time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlacedPoint {
    /// Position, m.
    pub position: DVec3,
    /// Unit normal, into the fluid.
    pub normal: DVec3,
    /// Velocity of the surface, m/s.
    pub velocity: DVec3,
    /// Gradient of that velocity, whose columns are its slopes along the axes, 1/s.
    pub gradient: DMat3,
}

/// Largest distance of a point of the surface from the domain, in spacings.
const OFF_THE_DOMAIN: f64 = 1e-3;

impl Scene {
    /// Returns the points of the walls that the output names; none without that output.
    pub fn wall_points(&self) -> Vec<WallPoint> {
        let Some(output) = &self.output.walls else { return Vec::new() };
        let mut walls: Vec<Wall> = output.parts.iter().map(|part| Wall::of_part(self, *part)).collect();
        walls.sort_by_key(|wall| wall.number());
        walls.dedup();
        let mut points = match self.dimensions {
            2 => curve_points(self, &walls),
            _ => output.parts.iter().flat_map(|part| pieces(self, *part)).collect(),
        };
        let is_seen = |point: &WallPoint| {
            let wall = Wall::of_part(self, point.part);
            output.parts.contains(&point.part) && is_at_fluid(self, wall, point.position)
        };
        points.retain(is_seen);
        points
    }

    /// Returns the place of a point of a wall in the poses of a time, s.
    pub fn placed_wall_point(&self, point: &WallPoint, poses: &WallPoses, time: f64) -> PlacedPoint {
        match self.pose_of_part(poses, point.part) {
            Some(pose) => {
                let start = self.pose_at_start(point.part).unwrap_or(*pose);
                let position = pose.place(start.reference(point.position));
                let normal = pose.direction(start.reference_direction(point.normal));
                let velocity = pose.velocity_at(position);
                let slope = |axis: DVec3| pose.spin.cross(axis);
                let gradient = DMat3::from_cols(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z));
                PlacedPoint { position: self.wrapped(position), normal, velocity, gradient }
            }
            None => {
                let part = &self.walls.parts[usize::from(point.part)];
                let (position, normal) = (point.position, point.normal);
                let velocity = part.velocity_at(position, time);
                let gradient = if part.moves() { self.slopes(part, position, time) } else { DMat3::ZERO };
                PlacedPoint { position, normal, velocity, gradient }
            }
        }
    }

    /// Returns a vector at a wall part in the directions that it has at the start.
    pub fn wall_direction_at_start(&self, part: u16, poses: &WallPoses, vector: DVec3) -> DVec3 {
        match (self.pose_of_part(poses, part), self.pose_at_start(part)) {
            (Some(pose), Some(start)) => start.direction(pose.reference_direction(vector)),
            _ => vector,
        }
    }

    /// Returns the gradient of the velocity of a wall part, 1/s, by central differences.
    fn slopes(&self, part: &WallPart, position: DVec3, time: f64) -> DMat3 {
        let step = 1e-3 * self.spacing;
        let slope = |axis: DVec3| {
            let [before, after] = [-step, step].map(|step| part.velocity_at(position + step * axis, time));
            (after - before) / (2.0 * step)
        };
        DMat3::from_cols(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z))
    }

    fn pose_at_start(&self, part: u16) -> Option<Pose> {
        match Wall::of_part(self, part) {
            Wall::Casing => self.casing_motion.as_ref().map(|motion| motion.pose(0.0)),
            Wall::Mover(index) => Some(self.movers[index].start),
        }
    }

    /// Returns true if a wall with a point of the output changes its place.
    pub fn has_moving_wall_points(&self) -> bool {
        self.output.walls.iter().flat_map(|output| &output.parts).any(|part| self.part_moves(*part))
    }

    /// Returns the interval between the samples of the means at the walls, s: the time in which the
    /// reference velocity passes half a spacing.
    pub fn wall_mean_interval(&self) -> f64 {
        let Some(output) = &self.output.walls else { return f64::INFINITY };
        output.mean_every.unwrap_or_else(|| self.sampling_interval(self.spacing))
    }

    /// Returns the friction of a wall part.
    pub fn friction_of(&self, part: u16) -> Slip {
        self.walls.parts[usize::from(part)].slip
    }
}

/// Returns the points of the curves of some walls in 2D.
fn curve_points(scene: &Scene, walls: &[Wall]) -> Vec<WallPoint> {
    let mut points = Vec::new();
    let mut number = 0;
    for wall in walls {
        let curves = surface_curves(scene, *wall).into_iter();
        let pieces = curves.flat_map(|curve| pieces_where(&curve, |point| is_at_fluid(scene, *wall, point)));
        for curve in pieces {
            let length: f64 = curve.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
            let places = spread(&curve, scene.spacing);
            let area = length / places.len().max(1) as f64;
            let point = |(index, place): (usize, &DVec3)| {
                let (position, normal, part) = surface_of(scene, *wall, *place);
                let arc_length = area * (index as f64 + 0.5);
                WallPoint { position, normal, area, part, curve: number, arc_length }
            };
            points.extend(places.iter().enumerate().map(point));
            number += 1;
        }
    }
    points
}

/// Returns the pieces of a wall part in 3D.
fn pieces(scene: &Scene, part: u16) -> Vec<WallPoint> {
    let wall = Wall::of_part(scene, part);
    let point = |piece: OutlinePoint| {
        let (position, normal, part) = surface_of(scene, wall, piece.point);
        WallPoint { position, normal, area: piece.area, part, curve: 0, arc_length: 0.0 }
    };
    outline(scene, part).into_par_iter().map(point).collect()
}

/// Steps of the search for the end of a piece of a curve.
const BISECTIONS: usize = 30;

/// Returns the pieces of a curve with the points that `is_wanted`, cut between its points. A closed
/// curve stays one if all of it is wanted.
fn pieces_where(curve: &[DVec3], is_wanted: impl Fn(DVec3) -> bool) -> Vec<Vec<DVec3>> {
    let wanted: Vec<bool> = curve.iter().map(|point| is_wanted(*point)).collect();
    // Between a wanted point and one that is not.
    let end = |mut inside: DVec3, mut outside: DVec3| {
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (inside + outside);
            if is_wanted(middle) {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        inside
    };
    let mut pieces: Vec<Vec<DVec3>> = Vec::new();
    for (index, point) in curve.iter().enumerate() {
        if !wanted[index] {
            continue;
        }
        let starts = index == 0 || !wanted[index - 1];
        if starts {
            pieces.push(if index == 0 { Vec::new() } else { vec![end(*point, curve[index - 1])] });
        }
        let Some(piece) = pieces.last_mut() else { continue };
        piece.push(*point);
        if wanted.get(index + 1) == Some(&false) {
            piece.push(end(*point, curve[index + 1]));
        }
    }
    let is_closed = curve.first() == curve.last();
    if is_closed && pieces.len() > 1 && wanted.first() == Some(&true) && wanted.last() == Some(&true) {
        // The curve is cut, but not where it happens to begin.
        let first = pieces.remove(0);
        if let Some(last) = pieces.last_mut() {
            last.extend_from_slice(&first[1..]);
        }
    }
    pieces
}

/// Returns true for a point of a mover, and for one of the casing that is no continuation of it
/// beyond an opening or a period.
fn is_at_fluid(scene: &Scene, wall: Wall, point: DVec3) -> bool {
    let is_inside = |(axis, bounds): (usize, &Option<(f64, f64)>)| {
        bounds.is_none_or(|(low, high)| (low..high).contains(&point[axis]))
    };
    match wall {
        Wall::Mover(_) => true,
        Wall::Casing => {
            let domain = &scene.layout.casing.domain;
            let distance = periodic_distance(domain, &scene.periodic, point);
            distance < OFF_THE_DOMAIN * scene.spacing && scene.periodic.iter().enumerate().all(is_inside)
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn scene(dimensions: usize, fields: &str) -> Scene {
        let text = format!(
            "Scene(title: \"t\", dimensions: {dimensions}, spacing: 0.05, smoke: 0.1,
                fluid: (density: 1000.0, viscosity: 1.0e-3, sound_speed: 15.0),
                time: (end: 1.0), {fields})"
        );
        Scene::from_text("walls", &text).load().unwrap_or_else(|faults| panic!("{faults:?}"))
    }

    /// Between inlet and outlet the walls of a channel are as long as it is; a cylinder in it has
    /// its circumference, and normals out of its centre.
    #[test]
    fn points_of_a_channel_end_at_its_openings() {
        let scene = scene(
            2,
            r#"domain: Difference([Box(min: (0.0, -0.5), max: (3.0, 0.5)), Circle(center: (1.0, 0.0), radius: 0.2)]),
            walls: (parts: [(name: "cylinder", region: Circle(center: (1.0, 0.0), radius: 0.25))]),
            inlets: [(at: (0.0, 0.0), towards: (1.0, 0.0), velocity: Normal(0.5))],
            outlets: [(at: (3.0, 0.0), towards: (1.0, 0.0))],
            reference: (velocity: 1.0, length: 1.0), output: (every: 1.0, walls: ())"#,
        );
        let points = scene.wall_points();
        let area = |part: u16| points.iter().filter(|point| point.part == part).map(|p| p.area).sum::<f64>();
        // The corners are cut by a quarter of a spacing at most.
        assert!((area(0) - 6.0).abs() < 1e-3, "{} m of 6 m", area(0));
        assert!((area(1) / (0.4 * PI) - 1.0).abs() < 1e-3, "{} m", area(1));
        for point in points.iter().filter(|point| point.part == 1) {
            let out = (point.position - DVec3::X) / 0.2;
            assert!((out - point.normal).length() < 1e-3, "{point:?}");
        }
        let curves: Vec<u32> = points.iter().map(|point| point.curve).collect();
        assert!(curves.is_sorted() && points.iter().all(|point| point.arc_length > 0.0));
    }

    /// The seam of a period is no wall, and each period has its walls once.
    #[test]
    fn points_of_a_periodic_channel_are_those_of_one_period() {
        let scene = scene(
            2,
            r#"domain: Box(min: (0.0, -0.5), max: (1.0, 0.5)), periodic: ["x"], initial: (velocity: (0.1, 0.0)),
            reference: (velocity: 1.0, length: 1.0), output: (every: 1.0, walls: ())"#,
        );
        let points = scene.wall_points();
        let area: f64 = points.iter().map(|point| point.area).sum();
        assert!((area - 2.0).abs() < 1e-3, "{area} m of 2 m");
        assert!(points.iter().all(|point| point.normal.y.abs() > 0.999), "{points:?}");
    }

    #[test]
    fn pieces_of_a_closed_curve_are_joined_at_its_beginning() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y, DVec3::ZERO];
        let pieces = pieces_where(&corners, |point| point.y < 0.25);
        assert_eq!(pieces.len(), 1, "{pieces:?}");
        let length: f64 = pieces[0].windows(2).map(|pair| pair[0].distance(pair[1])).sum();
        assert!((length - 1.5).abs() < 1e-6, "{pieces:?}");
        assert_eq!(pieces_where(&corners, |_| true), [corners.to_vec()]);
        assert!(pieces_where(&corners, |_| false).is_empty());
    }

    /// The pieces of a sphere have its area; those of the box around it are left out.
    #[test]
    fn points_of_one_part_in_3d_have_its_area() {
        let scene = scene(
            3,
            r#"domain: Difference([Box(min: (-0.6, -0.6, -0.6), max: (0.6, 0.6, 0.6)),
                Sphere(center: (0.0, 0.0, 0.0), radius: 0.3)]),
            walls: (parts: [(name: "ball", region: Sphere(center: (0.0, 0.0, 0.0), radius: 0.35))]),
            reference: (velocity: 1.0, length: 1.0), output: (every: 1.0, walls: (parts: ["ball"]))"#,
        );
        let points = scene.wall_points();
        let area: f64 = points.iter().map(|point| point.area).sum();
        // Of second order in Δ/R = 1/6.
        assert!((area / (0.36 * PI) - 1.0).abs() < 5e-3, "{area} m²");
        assert!(points.iter().all(|point| (point.position.length() - 0.3).abs() < 1e-6));
    }
}
