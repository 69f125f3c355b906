//! Wall particles as the fused pair loops see them: images of the fluid particle.
//!
//! Everything but a wall particle has the image factor 1 and the distance 0, so that one formula
//! serves all neighbours of a vector.

use super::OwnParticle;
use crate::math::lanes::{Lanes, dot};
use crate::pass::pack::{Entry, Scalar, Vector};
use crate::physics::pair::PairGeometry;
use crate::physics::wall::image;

/// Images of a particle in a vector of its neighbours.
#[derive(Clone, Copy, Debug)]
pub(in crate::pass) struct WallImage<L, const D: usize> {
    /// Factor by which the relative velocity is continued into a wall; 1 for other neighbours.
    pub factor: L,
    /// Distance of a wall particle behind its surface, m: negative at free-slip walls, 0 for other
    /// neighbours. None if there are no walls.
    distance: Option<L>,
    /// Wall normals. None if no wall is free-slip.
    normal: Option<[L; D]>,
}

impl<L: Lanes, const D: usize> WallImage<L, D> {
    /// Returns the images by the columns of distance and normal, if the pack has them; `cap` is
    /// the largest image factor.
    #[inline(always)]
    pub fn new(
        own: &OwnParticle<L, D>,
        neighbours: Entry<'_, L>,
        distance: Option<Scalar>,
        normal: Option<Vector>,
        cap: L,
    ) -> Self {
        let mut image = Self { factor: L::constant(1.0), distance: None, normal: None };
        if let Some(column) = distance {
            let distance = neighbours.scalar(column);
            image.factor = image::velocity_factor(distance.abs(), own.inverse_wall_distance, cap);
            image.distance = Some(distance);
        }
        if let Some(column) = normal {
            image.normal = Some(neighbours.vector_at(column));
        }
        image
    }

    /// Whether a neighbour belongs to a free-slip wall.
    #[inline(always)]
    fn slips(&self) -> L::Mask {
        let zero = L::constant(0.0);
        match self.distance {
            Some(distance) => distance.less(zero),
            None => zero.less(zero),
        }
    }

    /// Returns x_ab·v_ab/h, m/s, with the relative velocity continued into walls by a factor;
    /// at free-slip walls only its component along the normal counts.
    #[inline(always)]
    pub fn product(&self, product: L, factor: L, pair: &PairGeometry<L, D>) -> L {
        let continued = if self.distance.is_some() { factor * product } else { product };
        self.free_slip_product(continued, factor, pair)
    }

    /// Returns the product `product` with that of free-slip walls in its place.
    #[inline(always)]
    pub fn free_slip_product(&self, product: L, factor: L, pair: &PairGeometry<L, D>) -> L {
        match self.normal {
            Some(normal) => {
                let slipping = image::free_slip_product(factor, normal, pair.x, pair.v);
                L::select(self.slips(), slipping, product)
            }
            None => product,
        }
    }

    /// Returns the value of a viscous term: 0 at free-slip walls.
    #[inline(always)]
    pub fn without_free_slip(&self, value: L) -> L {
        if self.normal.is_some() { L::select(self.slips(), L::constant(0.0), value) } else { value }
    }

    /// Returns the value of a term that acts between fluid particles only: 0 at walls.
    #[inline(always)]
    pub fn without_walls(&self, value: L) -> L {
        match self.distance {
            Some(distance) => {
                let zero = L::constant(0.0);
                L::select(zero.less(distance.abs()), zero, value)
            }
            None => value,
        }
    }

    /// Returns a viscous factor multiplied by the image factor, 0 at free-slip walls.
    #[inline(always)]
    pub fn viscous(&self, value: L) -> L {
        let value = if self.distance.is_some() { value * self.factor } else { value };
        self.without_free_slip(value)
    }

    /// Returns the pressure of the neighbours, Pa, with that of walls mirrored from the particle's
    /// own: p_a + ρ_a g·(x_b − x_a).
    #[inline(always)]
    pub fn mirrored_pressure(&self, pressure: L, own: &OwnParticle<L, D>, x: [L; D]) -> L {
        match self.distance {
            Some(distance) => {
                let is_wall = L::constant(0.0).less(distance.abs());
                L::select(is_wall, own.pressure + dot(own.hydrostatic, x), pressure)
            }
            None => pressure,
        }
    }
}
