//! Distance, normal and wall part of the surface in front of a wall particle.

use std::collections::BTreeMap;

use glam::DVec3;

use super::fill::confined_distance;
use super::model::{ParticleSeed, Scene, WallPart};
use super::movers::Wall;
use sphecs_core::particles::zone::Zone;

impl WallPart {
    /// Returns true if the surface moves along itself at any time.
    pub fn moves(&self) -> bool {
        self.velocity.iter().any(|component| component.constant() != Some(0.0))
    }

    /// Returns the velocity at a point of the surface (m) and time (s), m/s.
    pub fn velocity_at(&self, point: DVec3, time: f64) -> DVec3 {
        DVec3::from(self.velocity.each_ref().map(|c| c.value(point.x, point.y, point.z, time)))
    }

    /// Returns the convective acceleration v·∇v at a point of the surface (m) and time (s), m/s².
    /// For a rotating cylinder it is ω² R towards the axis. Computed by a central difference over a
    /// thousandth of `length` (m) to either side.
    pub fn convective_acceleration_at(&self, point: DVec3, time: f64, length: f64) -> DVec3 {
        let velocity = self.velocity_at(point, time);
        let speed = velocity.length();
        if speed == 0.0 {
            return DVec3::ZERO;
        }
        let way = velocity * (1e-3 * length / speed);
        let difference = self.velocity_at(point + way, time) - self.velocity_at(point - way, time);
        difference * (speed / (2e-3 * length))
    }
}

/// Surface in front of a wall particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Distance of the particle behind the surface, m, ≥ 0.
    pub distance: f64,
    /// Unit normal at the nearest point, into the fluid.
    pub normal: DVec3,
    /// Index of the wall part.
    pub part: u16,
}

/// Returns the surface of a wall in front of one of its particles, at the start.
///
/// A particle that the lattice puts up to Δ/4 in front of its surface has distance 0.
pub fn surface(scene: &Scene, wall: Wall, point: DVec3) -> Surface {
    let step = probing_step(scene);
    let side = Side::of(scene, wall);
    let nearest = side.nearest_point(point);
    let distance = if side.distance(point) > 0.0 { point.distance(nearest) } else { 0.0 };
    let direction = if distance > step { (nearest - point) / distance } else { -side.gradient(point) };
    Surface { distance, normal: snapped(direction), part: part(scene, wall, nearest) }
}

/// Returns the surface point nearest to a point on either side at the start, m, with its unit
/// normal into the fluid and its wall part.
pub fn surface_at(scene: &Scene, point: DVec3) -> (DVec3, DVec3, u16) {
    let side = Side { scene, wall: None };
    let nearest = side.nearest_point(point);
    let movers = (0..scene.movers.len()).map(Wall::Mover);
    let tolerance = 1e-3 * scene.spacing;
    let mover = movers.into_iter().find(|mover| mover.distance(scene, nearest).abs() < tolerance);
    let normal = snapped(-side.gradient(nearest));
    (nearest, normal, part(scene, mover.unwrap_or(Wall::Casing), nearest))
}

/// Returns the surface point of one wall nearest to a point on either side at the start, m, with
/// its unit normal into the fluid and its wall part.
pub fn surface_of(scene: &Scene, wall: Wall, point: DVec3) -> (DVec3, DVec3, u16) {
    let side = Side::of(scene, wall);
    let nearest = side.nearest_point(point);
    (nearest, snapped(-side.gradient(nearest)), part(scene, wall, nearest))
}

/// Returns the step of differences of the signed distance, m.
fn probing_step(scene: &Scene) -> f64 {
    1e-4 * scene.spacing
}

/// Distance behind one wall, or behind all walls, at the start.
struct Side<'a> {
    scene: &'a Scene,
    wall: Option<Wall>,
}

impl<'a> Side<'a> {
    fn of(scene: &'a Scene, wall: Wall) -> Self {
        Self { scene, wall: Some(wall) }
    }

    /// Returns the signed distance behind the surface, m: positive in the solid.
    fn distance(&self, point: DVec3) -> f64 {
        match self.wall {
            Some(wall) => wall.distance(self.scene, point),
            None => confined_distance(self.scene, point),
        }
    }

    /// Returns the nearest surface point, m, by steps along the gradient of the distance.
    fn nearest_point(&self, point: DVec3) -> DVec3 {
        let mut nearest = point;
        for _ in 0..8 {
            let distance = self.distance(nearest);
            if distance.abs() < 1e-3 * probing_step(self.scene) {
                break;
            }
            nearest -= distance * self.gradient(nearest);
        }
        nearest
    }

    /// Returns the normalised gradient of the distance: exact for meshes, else by central
    /// differences.
    fn gradient(&self, point: DVec3) -> DVec3 {
        let is_periodic = self.scene.periodic.iter().any(Option::is_some);
        let confines = &self.scene.layout.confines;
        match self.wall {
            // A distance to a mesh takes long.
            Some(wall) if !is_periodic && wall.has_mesh(self.scene) => {
                return wall.gradient(self.scene, point);
            }
            None if !is_periodic && confines.has_mesh() => {
                return confines.gradient(point, probing_step(self.scene), self.scene.dimensions);
            }
            _ => {}
        }
        let step = probing_step(self.scene);
        let mut gradient = DVec3::ZERO;
        for (axis, unit) in DVec3::AXES.iter().enumerate().take(self.scene.dimensions) {
            gradient[axis] = self.distance(point + step * *unit) - self.distance(point - step * *unit);
        }
        gradient.normalize_or_zero()
    }
}

/// Returns a normal without the rounding errors of differences if it is along an axis.
fn snapped(normal: DVec3) -> DVec3 {
    let clean = normal.map(|component| if component.abs() < 1e-9 { 0.0 } else { component });
    clean.normalize_or_zero()
}

/// Returns the part of a surface point of a wall: that of the mover, or the first part whose region
/// contains the point, or 0.
fn part(scene: &Scene, wall: Wall, surface: DVec3) -> u16 {
    match wall {
        Wall::Casing => parts_at(scene, surface).next().unwrap_or(0),
        Wall::Mover(index) => scene.movers[index].part,
    }
}

/// Returns the indices of all parts whose regions contain the surface point.
fn parts_at(scene: &Scene, surface: DVec3) -> impl Iterator<Item = u16> + '_ {
    let tolerance = 1e-3 * scene.spacing;
    let regions = scene.layout.wall_regions.iter().enumerate();
    let within = regions.filter(move |(_, region)| region.contains(surface, tolerance));
    within.map(|(index, _)| index as u16 + 1)
}

/// Returns pairs of parts whose regions share surface, with the number of wall particles there, in
/// the order of the parts. These particles belong to the first part of a pair.
pub fn overlapping_parts(scene: &Scene, seeds: &[ParticleSeed]) -> Vec<([u16; 2], usize)> {
    let mut pairs = BTreeMap::new();
    if scene.layout.wall_regions.len() > 1 {
        let of_casing = |seed: &&ParticleSeed| {
            seed.zone == Zone::Wall && Wall::of_part(scene, seed.patch) == Wall::Casing
        };
        for seed in seeds.iter().filter(of_casing) {
            let mut parts = parts_at(scene, seed.position + seed.wall_distance * seed.wall_normal);
            if let (Some(first), Some(second)) = (parts.next(), parts.next()) {
                *pairs.entry([first, second]).or_insert(0) += 1;
            }
        }
    }
    pairs.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use crate::model::Scene;
    use glam::DVec3;

    /// The acceleration of a cylinder that spins up from 2 rad/s is ω² R towards the axis; its
    /// angular acceleration does not contribute.
    #[test]
    fn rotating_surface_has_centripetal_acceleration() {
        let text = r#"Scene(
            title: "Drum", dimensions: 2, spacing: 0.05, smoke: 0.05,
            fluid: (density: 1000.0, viscosity: 0.1, sound_speed: 10.0),
            domain: Circle(center: (0.0, 0.0), radius: 0.5),
            walls: (parts: [(
                name: "drum", region: Circle(center: (0.0, 0.0), radius: 1.0), velocity: ("-2*(1 + t)*y", "2*(1 + t)*x"),
            )]),
            reference: (velocity: 1.0), time: (end: 1.0), output: (every: 1.0),
        )"#;
        let scene = Scene::from_text("drum", text).load().unwrap_or_else(|faults| panic!("{faults:?}"));
        let drum = scene.walls.parts.iter().find(|part| part.moves()).expect("a part that moves");
        let point = DVec3::new(0.3, -0.4, 0.0);
        for (time, rate) in [(0.0, 2.0), (0.5, 3.0)] {
            let found = drum.convective_acceleration_at(point, time, scene.spacing);
            assert!((found + point * rate * rate).length() < 1e-9, "{found} m/s² at {time} s");
        }
        assert_eq!(drum.convective_acceleration_at(DVec3::ZERO, 0.0, scene.spacing), DVec3::ZERO);
    }
}
