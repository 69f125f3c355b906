//! Roles of the points of the lattice (or of wall-fitted rows): fluid, wall, inflow or outflow.
//!
//! A point counts as inside if it and all points Δ/4 around it are. So a wall that misses the
//! middle between two rows by less than Δ/4 still has one row on each side. Before layers of wall
//! particles a point counts by itself, so that the fluid has its mass. Inside points beyond
//! the plane of a patch belong to its zone, up to its depth. Outside points within the support plus
//! half a spacing are wall, except behind the far end of a zone. `jitter` then displaces the fluid
//! points; zones and walls stay on the lattice.

use glam::DVec3;
use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};
use rayon::slice::{ParallelSlice, ParallelSliceMut};

use super::geometry::Shape;
use super::lattice::Lattice;
use super::model::{Fill, Patch, Scene, Scheme};
use super::movers::Wall;
use super::{emitters, layers, mover_places, packing, rings, wall_particles};
use sphecs_core::particles::zone::Zone;

/// Tolerance of comparisons with planes and surfaces, in spacings: lattice points on a plane count
/// as fluid.
pub const TOLERANCE: f64 = 1e-9;

/// Position and role of a particle to be created.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Position, m.
    pub position: DVec3,
    /// Fluid, wall, inflow or outflow.
    pub zone: Zone,
    /// Index of the inlet or outlet; for a wall its [number](super::movers::Wall::number), 0 for
    /// the casing; 0 for fluid.
    pub patch: u16,
}

/// Returns all places, in the order of the lattice.
pub fn places(scene: &Scene) -> Vec<Place> {
    let filler = Filler::new(scene);
    let mut places = match &scene.layout.fill {
        Fill::Lattice(lattice) => on_lattice(scene, &filler, lattice),
        Fill::Packed(lattice) => {
            let mut places = on_lattice(scene, &filler, lattice);
            packing::pack(scene, lattice, &mut places);
            places
        }
        Fill::WallFitted { lower, upper, rows } => {
            super::rows::points(scene, lower, upper, *rows, filler.reach)
                .into_iter()
                .filter_map(|point| filler.classify(point))
                .collect()
        }
    };
    emitters::place(scene, &mut places);
    places
}

/// Returns the places on a lattice, wall particles on rings and layers where the scene has them.
fn on_lattice(scene: &Scene, filler: &Filler<'_>, lattice: &Lattice) -> Vec<Place> {
    let mut places = filler.lattice(lattice);
    if !scene.movers.is_empty() {
        mover_places::place(scene, lattice, &mut places);
    }
    if !scene.layout.rings.is_empty() {
        rings::replace(scene, &mut places);
    }
    if !scene.layout.layered.is_empty() {
        let is_covered = mover_places::covered(scene);
        let is_wall = |point| {
            filler.classify(point).is_some_and(|place| place.zone == Zone::Wall) && !is_covered(point)
        };
        layers::replace(scene, Wall::Casing, &mut places, is_wall);
    }
    for (index, mover) in scene.movers.iter().enumerate() {
        if scene.layout.layered.contains(&mover.part) {
            layers::replace(scene, Wall::Mover(index), &mut places, |_| true);
        }
    }
    places
}

/// Thickness of the walls: the kernel's support and half a spacing, m.
pub fn wall_thickness(scene: &Scene) -> f64 {
    layers(&scene.scheme) * scene.spacing
}

/// Returns the thickness of the walls in spacings.
pub fn layers(scheme: &Scheme) -> f64 {
    scheme.kernel().support_ratio() * scheme.smoothing_ratio() + 0.5
}

/// Zone of a place, and index of its inlet or outlet.
type Role = (Zone, u16);

/// Memory of a lattice point while the scene is filled, B.
pub const BYTES_PER_PLACE: usize = std::mem::size_of::<Option<Role>>();

/// Classifies points by their role.
struct Filler<'a> {
    scene: &'a Scene,
    reach: f64,
    probes: Vec<DVec3>,
}

impl<'a> Filler<'a> {
    fn new(scene: &'a Scene) -> Self {
        let probes = surroundings(scene);
        Self { scene, reach: wall_thickness(scene), probes }
    }

    fn lattice(&self, lattice: &Lattice) -> Vec<Place> {
        let dimensions = self.scene.dimensions;
        let ranges = lattice_ranges(self.scene, lattice, &self.scene.layout.casing.confines, self.reach);
        let counts = ranges.each_ref().map(|range| (range.end - range.start).max(0) as usize);
        let cell = |index: usize| -> [i64; 3] {
            let along = [index / counts[2] / counts[1], index / counts[2] % counts[1], index % counts[2]];
            std::array::from_fn(|axis| ranges[axis].start + along[axis] as i64)
        };
        let point = |index: usize| lattice.point(cell(index), dimensions);
        // All roles share one allocation and all places another: the allocator would keep many
        // small ones for the whole run.
        let mut roles = vec![None; counts.iter().product()];
        let axis = dimensions - 1;
        roles.par_chunks_mut(counts[axis].max(1)).enumerate().for_each(|(row, roles)| {
            let first = row * roles.len();
            self.row(roles, |at| point(first + at), lattice.spacing[axis]);
        });
        let mut places = placed(&roles, &point);
        if lattice.jitter > 0.0 {
            let cells =
                roles.iter().enumerate().filter(|(_, role)| role.is_some()).map(|(index, _)| cell(index));
            for (place, cell) in places.iter_mut().zip(cells).filter(|(place, _)| place.zone == Zone::Fluid) {
                place.position = self.jittered(place.position, lattice.offset(cell, dimensions));
            }
        }
        places
    }

    /// Classifies equidistant points along a line; `roles` is None for all of them. The signed
    /// distance changes by at most the spacing from point to point, so points far outside or deep
    /// inside need no evaluation of their own.
    fn row(&self, roles: &mut [Option<Role>], point: impl Fn(usize) -> DVec3, spacing: f64) {
        let tolerance = TOLERANCE * self.scene.spacing;
        // Upper bound of the signed distance, from the last point where it was evaluated.
        let mut most = f64::INFINITY;
        let mut at = 0;
        while let Some(role) = roles.get_mut(at) {
            let here = point(at);
            most += spacing;
            if most >= -self.margin() - tolerance {
                most = Wall::Casing.distance(self.scene, here);
            }
            let outside = most - self.reach - tolerance;
            if outside > 0.0 {
                // No point up to this distance has a role.
                at = at.saturating_add(((outside / spacing) as usize).max(1));
                most = f64::INFINITY;
                continue;
            }
            *role = self.role(here, most).map(|place| (place.zone, place.patch));
            at += 1;
        }
    }

    /// Returns the displaced position of a fluid particle; unchanged if it would leave the fluid.
    fn jittered(&self, point: DVec3, offset: DVec3) -> DVec3 {
        let mut moved = point + offset;
        for (axis, bounds) in self.scene.periodic.iter().enumerate() {
            if let Some((low, high)) = bounds {
                moved[axis] = low + (moved[axis] - low).rem_euclid(high - low);
            }
        }
        match self.classify(moved) {
            Some(Place { zone: Zone::Fluid, .. }) => moved,
            _ => point,
        }
    }

    fn classify(&self, point: DVec3) -> Option<Place> {
        self.role(point, Wall::Casing.distance(self.scene, point))
    }

    /// Returns the role of a point from its distance to the confines, m; beyond the walls and
    /// deeper than the margin a bound suffices.
    fn role(&self, point: DVec3, distance: f64) -> Option<Place> {
        // No fluid particle reaches a layer exactly at the thickness.
        if distance > self.reach - TOLERANCE * self.scene.spacing {
            return None;
        }
        let place = |zone, patch| Some(Place { position: point, zone, patch });
        let tolerance = TOLERANCE * self.scene.spacing;
        if !self.inside(point, distance) {
            let walled = self.scene.layout.walled && !self.behind_a_zone(point);
            return walled.then(|| place(Zone::Wall, 0)).flatten();
        }
        for (index, (patch, is_inlet)) in patches(self.scene).enumerate() {
            let beyond = beyond(patch, is_inlet, point);
            if beyond > tolerance && self.scene.layout.zones[index].contains(point, tolerance) {
                let number = if is_inlet { index } else { index - self.scene.inlets.len() };
                let zone = if is_inlet { Zone::Inflow } else { Zone::Outflow };
                let within = beyond <= patch.depth + tolerance;
                return within.then(|| place(zone, number as u16)).flatten();
            }
        }
        place(Zone::Fluid, 0)
    }

    /// Depth from which a point is inside without a look at its surroundings, m.
    fn margin(&self) -> f64 {
        0.25 * self.scene.spacing
    }

    fn inside(&self, point: DVec3, distance: f64) -> bool {
        // Where parts of a union touch, the distance is near zero even deep inside; the probes
        // decide.
        distance < -self.margin()
            || (distance <= TOLERANCE * self.scene.spacing
                && (self.is_before_layers(point)
                    || self.probes.iter().all(|probe| {
                        Wall::Casing.distance(self.scene, point + *probe) <= TOLERANCE * self.scene.spacing
                    })))
    }

    /// Returns true if the surface next to a point has layers of wall particles or emits.
    fn is_before_layers(&self, point: DVec3) -> bool {
        let layered = &self.scene.layout.layered;
        (!layered.is_empty()
            && layered.contains(&wall_particles::surface_of(self.scene, Wall::Casing, point).2))
            || emitters::is_before_emitter(self.scene, Wall::Casing, point)
    }

    /// Returns true if a point lies behind the far end of a zone, where no wall must stand.
    fn behind_a_zone(&self, point: DVec3) -> bool {
        let margin = self.reach + self.scene.spacing;
        patches(self.scene).any(|(patch, is_inlet)| {
            let behind = beyond(patch, is_inlet, point) - patch.depth;
            behind > TOLERANCE * self.scene.spacing
                && behind < 2.0 * (margin + self.scene.spacing)
                && patch.covers(point, margin)
        })
    }
}

/// Returns the ranges of the cells of a lattice in a box around a shape, `reach` (m) wider; all
/// cells in periodic directions.
pub fn lattice_ranges(
    scene: &Scene,
    lattice: &Lattice,
    shape: &Shape,
    reach: f64,
) -> [std::ops::Range<i64>; 3] {
    let (low, high) = match lattice.is_turned() {
        true => shape.rotated(lattice.rotation.transpose()).bounds(),
        false => shape.bounds(),
    };
    std::array::from_fn(|axis| {
        if axis >= scene.dimensions {
            return 0..1;
        }
        match scene.periodic[axis] {
            Some((from, to)) => 0..((to - from) / lattice.spacing[axis]).round() as i64,
            None => lattice.range(axis, low[axis] - reach, high[axis] + reach),
        }
    })
}

/// Returns displacements of a quarter of a spacing in all directions, m: a point is inside if it
/// and these points around it are.
pub fn surroundings(scene: &Scene) -> Vec<DVec3> {
    let mut probes = Vec::new();
    for index in 0..27 {
        let step = |place: i32| f64::from(index / place % 3 - 1);
        let direction = DVec3::new(step(1), step(3), step(9));
        if direction != DVec3::ZERO && (scene.dimensions == 3 || direction.z == 0.0) {
            let direction = scene.layout.fill.turned(direction.normalize());
            probes.push(direction * 0.25 * scene.spacing);
        }
    }
    probes
}

/// Points whose places a thread collects at a time.
const CHUNK: usize = 65_536;

/// Returns the places of the points that have a role, in their order and in one allocation.
fn placed(roles: &[Option<Role>], point: &(impl Fn(usize) -> DVec3 + Sync)) -> Vec<Place> {
    let counts: Vec<usize> = roles.par_chunks(CHUNK).map(|roles| roles.iter().flatten().count()).collect();
    let nothing = Place { position: DVec3::ZERO, zone: Zone::Fluid, patch: 0 };
    let mut places = vec![nothing; counts.iter().sum()];
    let mut rest = places.as_mut_slice();
    let mut parts = Vec::with_capacity(counts.len());
    for (chunk, count) in counts.into_iter().enumerate() {
        let (part, others) = rest.split_at_mut(count);
        rest = others;
        parts.push((chunk * CHUNK, part));
    }
    parts.into_par_iter().for_each(|(first, part)| {
        let roles = roles[first..].iter().take(CHUNK).enumerate();
        let found = roles.filter_map(|(at, role)| role.map(|role| (first + at, role)));
        for (place, (index, (zone, patch))) in part.iter_mut().zip(found) {
            *place = Place { position: point(index), zone, patch };
        }
    });
    places
}

/// Returns true if a point lies behind the far end of the zone of an opening.
pub fn behind_far_end(scene: &Scene, point: DVec3) -> bool {
    patches(scene).any(|(patch, is_inlet)| {
        beyond(patch, is_inlet, point) > patch.depth && patch.covers(point, scene.spacing)
    })
}

/// Returns inlets, then outlets, with true for inlets.
pub fn patches(scene: &Scene) -> impl Iterator<Item = (&Patch, bool)> {
    let inlets = scene.inlets.iter().map(|inlet| (&inlet.patch, true));
    inlets.chain(scene.outlets.iter().map(|outlet| (&outlet.patch, false)))
}

/// Returns the distance of a point beyond the plane of a patch, m; negative inside the domain.
pub fn beyond(patch: &Patch, is_inlet: bool, point: DVec3) -> f64 {
    if is_inlet { -patch.along(point) } else { patch.along(point) }
}

/// Returns the signed distance to the confines and their periodic images, m.
pub fn confined_distance(scene: &Scene, point: DVec3) -> f64 {
    periodic_distance(&scene.layout.confines, &scene.periodic, point)
}

/// Returns the signed distance to a shape and its periodic images, m. Points of a seam are inside
/// within rounding.
pub fn periodic_distance(shape: &Shape, periodic: &[Option<(f64, f64)>; 3], point: DVec3) -> f64 {
    if periodic.iter().all(Option::is_none) {
        return shape.signed_distance(point);
    }
    let period = periodic.map(|bounds| bounds.map_or(0.0, |(low, high)| high - low));
    let images = period.map(|period| if period > 0.0 { -1..=1 } else { 0..=0 });
    let mut distance = f64::INFINITY;
    for i in images[0].clone() {
        for j in images[1].clone() {
            for k in images[2].clone() {
                let shift = DVec3::new(f64::from(i), f64::from(j), f64::from(k)) * DVec3::from(period);
                distance = distance.min(shape.signed_distance(point + shift));
            }
        }
    }
    distance
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// Filling by rows, which skips points, agrees with classifying every point.
    #[test]
    fn filling_by_rows_equals_filling_point_by_point() {
        for name in
            ["square_bend", "cylinder_re20", "constricted_r2", "kelvin_helmholtz_periodic", "inclined_plates"]
        {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../scenes/{name}.ron"));
            let scene = Scene::from_file(&path).smoke().load().unwrap();
            let filler = Filler::new(&scene);
            let (low, high) = scene.layout.confines.bounds();
            let spacing = 0.37 * scene.spacing;
            for along in 0..scene.dimensions {
                // Lines through the whole box, some of them on its edge.
                for share in [0.0, 0.03, 0.31, 0.5, 0.77, 1.0] {
                    let start = (low + share * (high - low)).with_z(0.0);
                    let point = |step: usize| {
                        let mut point = start;
                        point[along] = low[along] - scene.spacing + step as f64 * spacing;
                        point
                    };
                    let count = ((high[along] - low[along]) / spacing) as usize + 6;
                    let mut row = vec![None; count];
                    filler.row(&mut row, point, spacing);
                    let role = |place: Place| (place.zone, place.patch);
                    let single: Vec<_> =
                        (0..count).map(|step| filler.classify(point(step)).map(role)).collect();
                    assert_eq!(row, single, "{name}, axis {along} at {share}");
                }
            }
        }
    }
}
