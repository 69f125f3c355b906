//! Boxes filled with disordered particles of an advected flow instead of the initial lattice.
//!
//! The cost of a step depends on the particle disorder: on a lattice the particles of a cell are
//! ordered, so that fewer candidates are tested. Advecting a large box would take minutes, so a
//! small one, the tile, is advected and copied. Each particle of the large box has position and
//! velocity of the particle of the tile at its lattice site.

use glam::{DVec3, IVec3};

use super::cases::{BoxTerms, PeriodicBox};
use sphecs_engine::components::{ParticleId, Position, Velocity};
use sphecs_engine::simulation::{Simulation, Stop};
use sphecs_scene::faults::SceneErrors;
use sphecs_scene::model::{ParticleSeed, Precision};

/// Edges of a tile, in spacings; the largest that divides the box is used.
const EDGES: std::ops::RangeInclusive<usize> = 8..=20;

/// Steps of the advection, some ten spacings in 3D and six in 2D at the highest speed.
const STEPS: usize = 100;

/// Error that prevents a tile.
#[derive(Debug, thiserror::Error)]
pub enum TileError {
    /// The scene has faults.
    #[error(transparent)]
    Scene(#[from] SceneErrors),
    /// The flow diverged.
    #[error(transparent)]
    Flow(#[from] Stop),
}

/// Small periodic box after advection.
#[derive(Clone, Debug)]
pub struct Tile {
    /// Spacing Δ, m.
    spacing: f64,
    /// Edge, in spacings.
    edge: i32,
    /// Position in the tile, m, and velocity, m/s, by initial lattice site, x fastest.
    particles: Vec<(DVec3, DVec3)>,
}

impl Tile {
    /// Advects a tile for a box.
    ///
    /// # Errors
    /// [`TileError`], not expected for so small and stable a flow.
    pub fn of(periodic_box: PeriodicBox) -> Result<Self, TileError> {
        let edge =
            EDGES.rev().find(|edge| periodic_box.count.is_multiple_of(*edge)).unwrap_or(periodic_box.count);
        let tile =
            PeriodicBox { count: edge, precision: Precision::F32, terms: BoxTerms::Laminar, ..periodic_box };
        let mut simulation =
            Simulation::builder(tile.scene()?).build().expect("a scene without plugins can be built");
        let mut this = Self { spacing: simulation.scene().spacing, edge: edge as i32, particles: Vec::new() };
        let mut places = vec![0; edge.pow(periodic_box.dimensions as u32)];
        for (id, position, _) in states(&mut simulation) {
            places[id] = this.place(this.site(position));
        }
        for _ in 0..STEPS {
            simulation.step()?;
        }
        this.particles = vec![Default::default(); places.len()];
        let length = edge as f64 * this.spacing;
        for (id, position, velocity) in states(&mut simulation) {
            this.particles[places[id]] = (position - length * (position / length).floor(), velocity);
        }
        Ok(this)
    }

    /// Moves the particles of a box from their lattice to the positions of the tile.
    pub fn fill(&self, seeds: &mut [ParticleSeed]) {
        for seed in seeds {
            let site = self.site(seed.position);
            let tile = site.div_euclid(IVec3::splat(self.edge)).as_dvec3();
            let (place, velocity) = self.particles[self.place(site)];
            seed.position = tile * (f64::from(self.edge) * self.spacing) + place;
            seed.velocity = velocity;
        }
    }

    /// Returns the lattice site of a position in a box.
    fn site(&self, position: DVec3) -> IVec3 {
        (position / self.spacing).floor().as_ivec3()
    }

    /// Returns the index in the tile of a lattice site of a box.
    fn place(&self, site: IVec3) -> usize {
        let IVec3 { x, y, z } = site.rem_euclid(IVec3::splat(self.edge));
        ((z * self.edge + y) * self.edge + x) as usize
    }
}

/// Returns number, position, m, and velocity, m/s, of every particle.
fn states(simulation: &mut Simulation) -> Vec<(usize, DVec3, DVec3)> {
    let world = simulation.world_mut();
    let mut query = world.query::<(&ParticleId, &Position, &Velocity)>();
    query.iter(world).map(|(id, position, velocity)| (id.0 as usize, position.0, velocity.0)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::count;
    use sphecs_scene::seeds;

    fn check(dimensions: usize, count_along: usize, tiles: i32) {
        let periodic_box = PeriodicBox {
            dimensions,
            count: count_along,
            precision: Precision::F64,
            terms: BoxTerms::Laminar,
        };
        let tile = Tile::of(periodic_box).expect("a tile");
        assert_eq!(tile.edge * tiles, count_along as i32);
        let scene = periodic_box.scene().expect("a scene");
        let on_the_lattice = seeds(&scene);
        let mut filled = on_the_lattice.clone();
        tile.fill(&mut filled);
        let length = count_along as f64 * tile.spacing;
        for seed in &filled {
            let inside = seed.position.to_array()[..dimensions].iter().all(|x| (0.0..=length).contains(x));
            assert!(inside, "{} is not in the box", seed.position);
        }
        // All tiles are equal.
        let edge = f64::from(tile.edge) * tile.spacing;
        let copies = tiles.pow(dimensions as u32) as usize;
        for seed in filled.iter().filter(|seed| seed.position.max_element() < edge) {
            // Particles half a period of the vortices away may have a bitwise identical velocity.
            let is_copy = |other: &&ParticleSeed| {
                let tiles_away = (other.position - seed.position) / edge;
                other.velocity == seed.velocity && (tiles_away - tiles_away.round()).length() < 1e-9
            };
            assert_eq!(filled.iter().filter(is_copy).count(), copies);
        }
        // The particles have left their lattice, and no two coincide: the flow can be advanced.
        let moved =
            |(a, b): &(&ParticleSeed, &ParticleSeed)| a.position.distance(b.position) > 0.1 * tile.spacing;
        assert!(on_the_lattice.iter().zip(&filled).filter(moved).count() > filled.len() * 9 / 10);
        let mut simulation = Simulation::builder(scene).particles(filled).build().expect("a simulation");
        for _ in 0..5 {
            simulation.step().expect("a stable flow");
        }
        let (particles, pairs) = count(&mut simulation);
        let neighbours = pairs as f64 / particles as f64;
        let expected = if dimensions == 2 { 20.0..23.0 } else { 250.0..280.0 };
        assert!(expected.contains(&neighbours), "{neighbours} neighbours");
    }

    #[test]
    fn box_is_filled_with_tiles() {
        check(2, 40, 2);
        check(3, 16, 1);
    }
}
