//! Wall particles on rings in a cylinder.
//!
//! ```text
//! r_k = R − (k + ½) Δ,   n_k = 2π r_k/Δ, rounded,   k = 0, 1, … within reach of the fluid
//! ```
//!
//! By default each ring lies in the middle of its shell, the first half a spacing behind the
//! surface as on a lattice. So the volume of the particles is that of the cylinder. Negi et al.
//! (2020), section 4.6, put the first ring on the circumference and the others Δ apart, “such that
//! the volume is consistent”. That is [`FirstRing::Circumference`], r_k = R − k Δ, with the volume
//! of a cylinder of radius R + Δ/2. In 2D.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::fill::{Place, wall_thickness};
use super::model::Scene;
use sphecs_core::particles::zone::Zone;

/// Place of the first ring of a cylinder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum FirstRing {
    /// Half a spacing behind the surface. Take it unless results are compared with theirs.
    #[default]
    HalfSpacing,
    /// On the surface, as in Negi et al. (2020). Take it to compare with them.
    Circumference,
}

impl FirstRing {
    /// Depth of the ring behind the surface, in spacings.
    fn depth(self) -> f64 {
        match self {
            FirstRing::HalfSpacing => 0.5,
            FirstRing::Circumference => 0.0,
        }
    }
}

/// A cylinder whose wall particles lie on rings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rings {
    /// Centre, m.
    pub centre: DVec3,
    /// Radius, m, > 0.
    pub radius: f64,
    /// Place of the first ring.
    pub first: FirstRing,
    /// [Number](super::movers::Wall::number) of the wall whose particles they are.
    pub wall: u16,
}

/// Replaces the wall particles of the lattice in the cylinders of a scene by rings.
pub fn replace(scene: &Scene, places: &mut Vec<Place>) {
    let spacing = scene.spacing;
    // Wall particles of the lattice may lie up to a quarter of a spacing in front of the surface.
    let reach = |rings: &Rings| rings.radius + 0.26 * spacing;
    let within = |place: &Place| {
        let inside =
            |rings: &Rings| place.patch == rings.wall && place.position.distance(rings.centre) < reach(rings);
        place.zone == Zone::Wall && scene.layout.rings.iter().any(inside)
    };
    places.retain(|place| !within(place));
    for rings in &scene.layout.rings {
        let deepest = wall_thickness(scene) - 1e-9 * spacing;
        let radii = (0..).map(|ring| (f64::from(ring) + rings.first.depth()) * spacing);
        for depth in radii.take_while(|depth| *depth < deepest.min(rings.radius + 1e-9 * spacing)) {
            let radius = (rings.radius - depth).max(0.0);
            let count = (std::f64::consts::TAU * radius / spacing).round().max(1.0) as u32;
            places.extend((0..count).map(|index| {
                let (sine, cosine) = (std::f64::consts::TAU * f64::from(index) / f64::from(count)).sin_cos();
                let position = rings.centre + radius * DVec3::new(cosine, sine, 0.0);
                Place { position, zone: Zone::Wall, patch: rings.wall }
            }));
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::model::Scene;
    use crate::spawn::seeds;
    use sphecs_core::particles::zone::Zone;

    const CYLINDER: &str = r#"Scene(
        title: "Cylinder", dimensions: 2, spacing: 0.1, smoke: 0.2,
        fluid: (density: 1000.0, viscosity: 0.1, sound_speed: 10.0),
        domain: Difference([Box(min: (-2.0, -2.0), max: (2.0, 2.0)), Circle(center: (0.1, 0.0), radius: 1.0)]),
        walls: (parts: [(
            name: "cylinder", region: Circle(center: (0.1, 0.0), radius: 1.5),
            fill: Concentric(center: (0.1, 0.0), radius: 1.0),
        )]),
        initial: (velocity: (0.1, 0.0)),
        time: (end: 1.0), output: (every: 1.0),
    )"#;

    #[test]
    fn rings_fill_the_cylinder_within_reach_of_the_fluid() {
        let scene =
            Scene::from_text("cylinder", CYLINDER).load().unwrap_or_else(|faults| panic!("{faults:?}"));
        let all = seeds(&scene);
        let ring = all.iter().filter(|seed| seed.zone == Zone::Wall && seed.patch == 1);
        let depths: Vec<(f64, f64)> = ring
            .map(|seed| (1.0 - seed.position.distance(glam::DVec3::X * 0.1), seed.wall_distance))
            .collect();
        for (depth, found) in &depths {
            assert!((depth - found).abs() < 1e-6, "{found} m behind the surface, not {depth} m");
            let layer = depth / 0.1 - 0.5;
            assert!((layer - layer.round()).abs() < 1e-9 && depth < &0.35, "{depth} m");
        }
        // The support of Wendland at h = 1.5 Δ holds three layers: 2π (0.95 + 0.85 + 0.75)/0.1.
        assert_eq!(depths.len(), 60 + 53 + 47);
    }

    #[test]
    fn first_ring_may_lie_on_the_circumference() {
        let on_it =
            CYLINDER.replace("radius: 1.0),\n        )]", "radius: 1.0, first: Circumference),\n        )]");
        assert_ne!(on_it, CYLINDER);
        let scene = Scene::from_text("cylinder", &on_it).load().unwrap_or_else(|faults| panic!("{faults:?}"));
        let all = seeds(&scene);
        let ring = all.iter().filter(|seed| seed.zone == Zone::Wall && seed.patch == 1);
        let radii: Vec<f64> = ring.map(|seed| seed.position.distance(glam::DVec3::X * 0.1)).collect();
        // The support holds one more layer: 2π (1.0 + 0.9 + 0.8 + 0.7)/0.1.
        assert_eq!(radii.len(), 63 + 57 + 50 + 44);
        assert_eq!(radii.iter().filter(|radius| (**radius - 1.0).abs() < 1e-12).count(), 63);
    }
}
