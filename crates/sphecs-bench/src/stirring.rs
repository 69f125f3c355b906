//! Stirred boxes: particles as a flow leaves them, not on the lattice that it began with.
//!
//! What a step costs depends on how the particles lie: on a lattice those of a cell are close together and in order, so that
//! fewer candidates are in reach of them. A large box would have to be stirred for minutes. So a small one is, a tile, and the large
//! one is paved with it: positions and velocities of every particle are those of the tile's at the same place of the lattice.

use glam::{DVec3, IVec3};

use super::cases::{BoxTerms, StirredBox};
use sphecs_engine::components::{ParticleId, Position, Velocity};
use sphecs_engine::simulation::{Simulation, Stop};
use sphecs_scene::faults::SceneErrors;
use sphecs_scene::model::{ParticleSeed, Precision};

/// Edges of a tile, in spacings, from which the largest that divides a box is taken.
const EDGES: std::ops::RangeInclusive<usize> = 8..=20;

/// Steps that a tile is stirred for: some ten spacings in 3D, six in 2D at the fastest.
const STEPS: usize = 100;

/// Why there is no tile.
#[derive(Debug, thiserror::Error)]
pub enum TileError {
    /// Its scene has faults.
    #[error(transparent)]
    Scene(#[from] SceneErrors),
    /// Its flow blew up.
    #[error(transparent)]
    Flow(#[from] Stop),
}

/// A small periodic box after it has been stirred.
#[derive(Clone, Debug)]
pub struct Tile {
    /// Spacing Δ, m.
    spacing: f64,
    /// Edge, in spacings.
    edge: i32,
    /// Position in the tile, m, and velocity, m/s, by the place on the lattice at the start, x fastest.
    particles: Vec<(DVec3, DVec3)>,
}

impl Tile {
    /// Stirs a tile for a box.
    ///
    /// # Errors
    /// [`TileError`]: neither is to be expected of so small and tame a flow.
    pub fn of(stirred: StirredBox) -> Result<Self, TileError> {
        let edge = EDGES.rev().find(|edge| stirred.count.is_multiple_of(*edge)).unwrap_or(stirred.count);
        let tile = StirredBox { count: edge, precision: Precision::F32, terms: BoxTerms::Laminar, ..stirred };
        let mut simulation =
            Simulation::builder(tile.scene()?).build().expect("a scene without plugins can be built");
        let mut this = Self { spacing: simulation.scene().spacing, edge: edge as i32, particles: Vec::new() };
        let mut places = vec![0; edge.pow(stirred.dimensions as u32)];
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

    /// Puts the particles of a box, which are on their lattice, where those of the tiles are.
    pub fn pave(&self, seeds: &mut [ParticleSeed]) {
        for seed in seeds {
            let site = self.site(seed.position);
            let tile = site.div_euclid(IVec3::splat(self.edge)).as_dvec3();
            let (place, velocity) = self.particles[self.place(site)];
            seed.position = tile * (f64::from(self.edge) * self.spacing) + place;
            seed.velocity = velocity;
        }
    }

    /// Place on the lattice of a box along each axis.
    fn site(&self, position: DVec3) -> IVec3 {
        (position / self.spacing).floor().as_ivec3()
    }

    /// The particle of the tile at a place on the lattice of a box.
    fn place(&self, site: IVec3) -> usize {
        let IVec3 { x, y, z } = site.rem_euclid(IVec3::splat(self.edge));
        ((z * self.edge + y) * self.edge + x) as usize
    }
}

/// Number, position, m, and velocity, m/s, of every particle.
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
        let stirred = StirredBox {
            dimensions,
            count: count_along,
            precision: Precision::F64,
            terms: BoxTerms::Laminar,
        };
        let tile = Tile::of(stirred).expect("a tile");
        assert_eq!(tile.edge * tiles, count_along as i32);
        let scene = stirred.scene().expect("a scene");
        let on_the_lattice = seeds(&scene);
        let mut paved = on_the_lattice.clone();
        tile.pave(&mut paved);
        let length = count_along as f64 * tile.spacing;
        for seed in &paved {
            let inside = seed.position.to_array()[..dimensions].iter().all(|x| (0.0..=length).contains(x));
            assert!(inside, "{} is not in the box", seed.position);
        }
        // Every tile is the same.
        let edge = f64::from(tile.edge) * tile.spacing;
        let copies = tiles.pow(dimensions as u32) as usize;
        for seed in paved.iter().filter(|seed| seed.position.max_element() < edge) {
            // What is half a period of the vortices away may have the same velocity to the last bit.
            let is_copy = |other: &&ParticleSeed| {
                let tiles_away = (other.position - seed.position) / edge;
                other.velocity == seed.velocity && (tiles_away - tiles_away.round()).length() < 1e-9
            };
            assert_eq!(paved.iter().filter(is_copy).count(), copies);
        }
        // The particles are no longer on their lattice, and none is where another is: the flow goes on.
        let moved =
            |(a, b): &(&ParticleSeed, &ParticleSeed)| a.position.distance(b.position) > 0.1 * tile.spacing;
        assert!(on_the_lattice.iter().zip(&paved).filter(moved).count() > paved.len() * 9 / 10);
        let mut simulation = Simulation::builder(scene).particles(paved).build().expect("a simulation");
        for _ in 0..5 {
            simulation.step().expect("a tame flow");
        }
        let (particles, pairs) = count(&mut simulation);
        let neighbours = pairs as f64 / particles as f64;
        let expected = if dimensions == 2 { 20.0..23.0 } else { 250.0..280.0 };
        assert!(expected.contains(&neighbours), "{neighbours} neighbours");
    }

    #[test]
    fn a_box_is_paved_with_tiles_of_a_flow() {
        check(2, 40, 2);
        check(3, 16, 1);
    }
}
