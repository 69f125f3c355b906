//! Emitters: surfaces of walls through which fluid enters along the normal, also of walls that
//! move.
//!
//! - [`along_curves`]: pieces of the surface in 2D
//! - [`over_surfaces`]: pieces of the surface in 3D
//! - [`contour`]: triangles of a surface that is no mesh
//! - [`swept_region`]: region that the columns do not leave
//!
//! ```text
//! flux through the surface: ρ0 v_n, v_n relative to it;  velocity in the fluid: v_wall + v_n n
//! ```
//!
//! Each piece has a column of inflow particles behind it, see [`EmitterColumn`]. The columns are in
//! the coordinates of their wall, which carries them along.

pub mod along_curves;
pub mod contour;
pub mod over_surfaces;
pub mod swept_region;

use glam::DVec3;

use super::fill::Place;
use super::model::{InletVelocity, Scene};
use super::movers::Wall;
use sphecs_core::boundary::inlet::emitter_column::EmitterColumn;
use sphecs_core::particles::zone::Zone;
use sphecs_core::physics::pose::Pose;

/// A piece of the surface of an emitter, at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Its middle, m.
    pub foot: DVec3,
    /// Unit normal into the fluid.
    pub normal: DVec3,
    /// Area, m² (m in 2D).
    pub area: f64,
    /// Sum of the principal curvatures, 1/m.
    pub curvature_sum: f64,
    /// Product of the principal curvatures, 1/m²; 0 in 2D.
    pub curvature_product: f64,
}

/// A surface through which fluid enters.
#[derive(Clone, Debug)]
pub struct Emitter {
    /// Name for outputs and messages.
    pub name: String,
    /// Wall whose surface it is part of.
    pub wall: Wall,
    /// Index of the wall part that it is on.
    pub part: u16,
    /// Speed along the normal, relative to the surface: one of the variants without components.
    pub velocity: InletVelocity,
    /// Columns in the reference coordinates of its wall.
    pub columns: Vec<EmitterColumn>,
    /// Depth of the columns, m.
    pub depth: f64,
}

/// A particle of an emitter before it emits any.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmitterParticle {
    /// Index of the column.
    pub column: usize,
    /// Number in the column, from the surface.
    pub number: usize,
    /// Depth behind the surface, m.
    pub depth: f64,
}

impl Emitter {
    /// Returns the area of its surface, m² (m in 2D).
    pub fn area(&self) -> f64 {
        self.columns.iter().map(|column| column.area).sum()
    }

    /// Returns the speed of the fluid along the normal relative to the surface at a column and a
    /// time (s), m/s.
    pub fn speed(&self, column: &EmitterColumn, time: f64) -> f64 {
        self.velocity.speed(column.foot, time).unwrap_or(0.0)
    }

    /// Returns the volume flow at a time (s), m³/s (m²/s in 2D).
    pub fn volume_flow(&self, time: f64) -> f64 {
        self.columns.iter().map(|column| column.area * self.speed(column, time)).sum()
    }

    /// Returns the number of particles of a column.
    pub fn column_count(&self, column: &EmitterColumn, scene: &Scene) -> usize {
        column.count(self.depth, scene.discretisation.cell_volume())
    }

    /// Returns its particles before it emits any, column by column.
    pub fn particles(&self, scene: &Scene) -> impl Iterator<Item = EmitterParticle> + '_ {
        let volume = scene.discretisation.cell_volume();
        let columns = self.columns.iter().enumerate();
        columns.flat_map(move |(index, column)| {
            let count = column.count(self.depth, volume);
            let particle = move |number: usize| EmitterParticle {
                column: index,
                number,
                depth: column.depth((number as f64 + 0.5) * volume),
            };
            (0..count).map(particle)
        })
    }

    /// Returns the velocity of a particle at a depth (m) of a column in a pose of its wall and at a
    /// time (s), m/s: that of the surface in front of it and, along the normal, the speed by which
    /// the column fills.
    pub fn velocity_in(&self, column: &EmitterColumn, depth: f64, pose: Option<&Pose>, time: f64) -> DVec3 {
        let speed = self.speed(column, time) / column.narrowing(depth);
        match pose {
            Some(pose) => pose.velocity_at(pose.place(column.foot)) + speed * pose.direction(column.normal),
            None => speed * column.normal,
        }
    }

    /// Returns centre and radius of a ball around its columns in reference coordinates, m.
    pub fn ball(&self) -> (DVec3, f64) {
        let ends = || self.columns.iter().flat_map(|column| [column.foot, column.point(self.depth)]);
        let low = ends().fold(DVec3::INFINITY, DVec3::min);
        let high = ends().fold(DVec3::NEG_INFINITY, DVec3::max);
        let centre = low.midpoint(high);
        (centre, ends().map(|end| end.distance(centre)).fold(0.0, f64::max))
    }
}

impl Scene {
    /// Returns the emitter whose inflow particles have an index of inlets and emitters: the
    /// emitters come behind the inlets.
    pub fn emitter(&self, patch: u16) -> Option<&Emitter> {
        usize::from(patch).checked_sub(self.inlets.len()).and_then(|index| self.emitters.get(index))
    }

    /// Returns the names of the inlets, then of the emitters.
    pub fn source_names(&self) -> impl Iterator<Item = &str> {
        let inlets = self.inlets.iter().map(|inlet| inlet.patch.name.as_str());
        inlets.chain(self.emitters.iter().map(|emitter| emitter.name.as_str()))
    }

    /// Returns the number of inlets and emitters.
    pub fn source_count(&self) -> usize {
        self.inlets.len() + self.emitters.len()
    }

    /// Returns the volume flow of all emitters at a time (s) with a weight at the places of their
    /// surfaces, m³/s (m²/s in 2D).
    pub fn emitted_flow(&self, time: f64, weight: impl Fn(DVec3) -> f64) -> f64 {
        let of_emitter = |emitter: &Emitter| -> f64 {
            let pose = match emitter.wall {
                Wall::Casing => None,
                Wall::Mover(index) => Some(self.movers[index].motion.pose(time)),
            };
            let of_column = |column: &EmitterColumn| {
                let place = pose.as_ref().map_or(column.foot, |pose| pose.place(column.foot));
                weight(self.wrapped(place)) * column.area * emitter.speed(column, time)
            };
            emitter.columns.iter().map(of_column).sum()
        };
        self.emitters.iter().map(of_emitter).sum()
    }

    /// Returns the pose of a wall at the start; None if it is at rest.
    pub fn start_pose(&self, wall: Wall) -> Option<&Pose> {
        match wall {
            Wall::Casing => None,
            Wall::Mover(index) => Some(&self.movers[index].start),
        }
    }
}

/// Distance from the side of its solid from which a column is hidden from the fluid beside it, in
/// spacings.
const HIDDEN: f64 = 2.0;

/// Returns a point of an emitter whose column has fluid beside it, m: that fluid feels the inflow
/// through the side of the solid. None if there is no such point.
pub fn bare_side(scene: &Scene, emitter: &Emitter) -> Option<DVec3> {
    let pose = scene.start_pose(emitter.wall);
    let placed = |point: DVec3| pose.map_or(point, |pose| pose.place(point));
    let is_bare = |column: &&EmitterColumn| {
        let point = placed(column.point(0.5 * emitter.depth));
        let distance = emitter.wall.distance(scene, point);
        let beside = point - (distance + 0.5 * scene.spacing) * emitter.wall.gradient(scene, point);
        // Half the depth is as far from the surface of the emitter itself.
        distance < (HIDDEN * scene.spacing).min(0.4 * emitter.depth) && scene.domain.contains(beside, 0.0)
    };
    emitter.columns.iter().find(is_bare).map(|column| placed(column.foot))
}

/// Returns true if the surface of a wall next to a point in the fluid emits: the fluid reaches up
/// to its columns, as up to layers of wall particles.
pub fn is_before_emitter(scene: &Scene, wall: Wall, point: DVec3) -> bool {
    scene.emitters.iter().filter(|emitter| emitter.wall == wall).any(|emitter| {
        let pose = scene.start_pose(wall);
        let reference = pose.map_or(point, |pose| pose.reference(point));
        emitter.columns.iter().any(|column| column.foot.distance(reference) < 0.75 * scene.spacing)
    })
}

/// Smallest distance of wall particles from the columns, in spacings.
const APART: f64 = 0.7;

/// Adds the particles of the emitters to the places of a scene, and takes out the wall particles
/// where their columns are.
pub fn place(scene: &Scene, places: &mut Vec<Place>) {
    for (index, emitter) in scene.emitters.iter().enumerate() {
        let pose = scene.start_pose(emitter.wall);
        let placed = |point: DVec3| pose.map_or(point, |pose| pose.place(point));
        let ends: Vec<[DVec3; 2]> = emitter
            .columns
            .iter()
            .map(|column| [placed(column.foot), placed(column.point(emitter.depth))])
            .collect();
        let (centre, radius) = emitter.ball();
        let (centre, apart) = (placed(centre), APART * scene.spacing);
        let is_clear = |point: DVec3| {
            let near = scene.nearest_image(point, centre);
            near.distance(centre) > radius + apart
                || ends.iter().all(|[foot, end]| distance_to(near, *foot, *end) > apart)
        };
        places.retain(|place| place.zone != Zone::Wall || is_clear(place.position));
        let patch = (scene.inlets.len() + index) as u16;
        places.extend(emitter.particles(scene).map(|particle| {
            let point = placed(emitter.columns[particle.column].point(particle.depth));
            Place { position: scene.wrapped(point), zone: Zone::Inflow, patch }
        }));
    }
}

/// Returns the distance of a point from a straight line between two ends, m.
fn distance_to(point: DVec3, from: DVec3, to: DVec3) -> f64 {
    let way = to - from;
    let share = (point - from).dot(way) / way.length_squared().max(f64::MIN_POSITIVE);
    point.distance(from.lerp(to, share.clamp(0.0, 1.0)))
}
