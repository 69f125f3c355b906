//! Places of the particles of bodies that move, at the start.
//!
//! They fill the body as far as the support reaches behind its surface, on the lattice of the
//! fluid. The rule for the surface is that of the [fill](super::fill): the fluid keeps Δ/4 away,
//! unless the body has layers of its own. Particles of the casing stay where a body covers them,
//! since the body moves on. Those that it covers at all times go: a rod may pass through a wall.

use glam::DVec3;
use rayon::iter::{IntoParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::emitters::is_before_emitter;
use super::fill::{Place, TOLERANCE, lattice_ranges, surroundings, wall_thickness};
use super::lattice::Lattice;
use super::model::Scene;
use super::movers::Wall;
use sphecs_core::particles::zone::Zone;

/// Times of a run at which a place of the casing must be covered to be left out.
const TIMES: u32 = 64;

/// Takes the movers of a scene out of the places of the fluid, and adds those of their particles.
pub fn place(scene: &Scene, lattice: &Lattice, places: &mut Vec<Place>) {
    let bodies = Bodies::new(scene);
    let kept: Vec<bool> = places
        .par_iter()
        .map(|place| match place.zone {
            Zone::Wall => !bodies.always_cover(place.position),
            _ => (0..scene.movers.len()).all(|mover| bodies.is_outside(mover, place.position)),
        })
        .collect();
    let mut kept = kept.into_iter();
    places.retain(|_| kept.next().unwrap_or(true));
    for mover in 0..scene.movers.len() {
        places.extend(bodies.places(mover, lattice));
    }
}

/// Returns a test for points of the casing that one mover or another covers at all times, as a rod
/// through a wall does.
pub fn covered(scene: &Scene) -> impl Fn(DVec3) -> bool + Sync + '_ {
    let bodies = Bodies::new(scene);
    move |point| bodies.always_cover(point)
}

/// The movers of a scene at the start.
struct Bodies<'a> {
    scene: &'a Scene,
    probes: Vec<DVec3>,
    /// Bounds of a box around each mover, m.
    boxes: Vec<(DVec3, DVec3)>,
    reach: f64,
    tolerance: f64,
}

impl<'a> Bodies<'a> {
    fn new(scene: &'a Scene) -> Self {
        let margin = DVec3::splat(scene.spacing);
        let boxes = (0..scene.movers.len()).map(|mover| Wall::Mover(mover).bounds(scene));
        Self {
            scene,
            probes: surroundings(scene),
            boxes: boxes.map(|(low, high)| (low - margin, high + margin)).collect(),
            reach: wall_thickness(scene),
            tolerance: TOLERANCE * scene.spacing,
        }
    }

    /// Returns true if fluid may be at a point in spite of a mover.
    fn is_outside(&self, mover: usize, point: DVec3) -> bool {
        let is_periodic = self.scene.periodic.iter().any(Option::is_some);
        let (low, high) = self.boxes[mover];
        if !is_periodic && (point.cmplt(low).any() || point.cmpgt(high).any()) {
            return true;
        }
        let wall = Wall::Mover(mover);
        let behind = wall.distance(self.scene, point);
        let is_before_layers = self.scene.layout.layered.contains(&self.scene.movers[mover].part);
        behind < -0.25 * self.scene.spacing
            || (behind <= self.tolerance
                && (is_before_layers
                    || is_before_emitter(self.scene, wall, point)
                    || self
                        .probes
                        .iter()
                        .all(|probe| wall.distance(self.scene, point + *probe) <= self.tolerance)))
    }

    /// Returns true if one mover or another covers a point of the casing at all times.
    fn always_cover(&self, point: DVec3) -> bool {
        let scene = self.scene;
        // At the start without a look at the motion: hardly any place is covered.
        let covers = |(index, (low, high)): (usize, &(DVec3, DVec3))| {
            let is_near = point.cmpge(*low).all() && point.cmple(*high).all();
            is_near && Wall::Mover(index).distance(scene, point) >= -self.tolerance
        };
        self.boxes.iter().enumerate().any(covers)
            && (0..=TIMES).all(|at| {
                let poses = scene.wall_poses(scene.time.end * f64::from(at) / f64::from(TIMES));
                scene.movers.iter().zip(&poses.movers).any(|(mover, pose)| {
                    let near = scene.nearest_image(point, pose.place(mover.centre));
                    mover.shape.signed_distance(pose.reference(near)) <= self.tolerance
                })
            })
    }

    /// Returns the places of the particles of a mover, in the order of the lattice.
    fn places(&self, mover: usize, lattice: &Lattice) -> Vec<Place> {
        let (scene, wall) = (self.scene, Wall::Mover(mover));
        let shape = scene.movers[mover].placed(&scene.movers[mover].start);
        let ranges = lattice_ranges(scene, lattice, &shape, scene.spacing);
        let counts = ranges.each_ref().map(|range| (range.end - range.start).max(0) as usize);
        let at = |index: usize| {
            let along = [index / counts[2] / counts[1], index / counts[2] % counts[1], index % counts[2]];
            let cell = std::array::from_fn(|axis| ranges[axis].start + along[axis] as i64);
            lattice.point(cell, scene.dimensions)
        };
        let place = |index: usize| {
            let position = at(index);
            let behind = wall.distance(scene, position);
            let is_body = (-0.3 * scene.spacing..=self.reach - self.tolerance).contains(&behind)
                && !self.is_outside(mover, position)
                // In front of its surface a place may be of the casing or of another mover.
                && (behind > -self.tolerance || self.is_free(mover, position));
            is_body.then_some(Place { position, zone: Zone::Wall, patch: wall.number() })
        };
        (0..counts.iter().product()).into_par_iter().filter_map(place).collect()
    }

    /// Returns true if a point is in no wall but a mover.
    fn is_free(&self, mover: usize, point: DVec3) -> bool {
        let others = (0..self.scene.movers.len()).filter(|other| *other != mover).map(Wall::Mover);
        std::iter::once(Wall::Casing)
            .chain(others)
            .all(|wall| wall.distance(self.scene, point) <= self.tolerance)
    }
}
