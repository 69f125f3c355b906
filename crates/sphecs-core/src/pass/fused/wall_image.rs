//! Wall particles as the fused pair loops see them: images of the fluid particle.
//!
//! Everything but a wall particle has the image factor 1 and the distance 0, so that one formula
//! serves all neighbours of a vector.

use super::OwnParticle;
use crate::math::lanes::{Lanes, dot};
use crate::pass::pack::{Entry, Scalar, Vector};
use crate::pass::wall_sides::Behind;
use crate::physics::pair::PairGeometry;
use crate::physics::wall::image;

/// Images of a particle in a vector of its neighbours.
///
/// The columns decide which terms there are: they are the same for all neighbours, so that the
/// compiler can take the branches out of the loop.
#[derive(Clone, Copy, Debug)]
pub(in crate::pass) struct WallImage<L> {
    /// Factor by which the relative velocity is continued into a wall; 1 for other neighbours.
    pub factor: L,
    /// Distance of a wall particle behind its surface, m: negative at free-slip walls, 0 for other
    /// neighbours.
    distance: L,
    /// Column of the distance, only where there are walls.
    walls: Option<Scalar>,
    /// Column of the wall normals, only where a wall is free-slip.
    normal: Option<Vector>,
    /// Neighbours behind a thin wall, only where one is thin.
    behind: Option<Behind<L>>,
}

impl<L: Lanes> WallImage<L> {
    /// Returns the images by the columns of distance and normal, if the pack has them; `cap` is
    /// the largest image factor.
    #[inline(always)]
    pub(crate) fn new<const D: usize>(
        own: &OwnParticle<L, D>,
        neighbours: Entry<'_, L>,
        walls: Option<Scalar>,
        normal: Option<Vector>,
        behind: Option<Behind<L>>,
        cap: L,
    ) -> Self {
        let (mut factor, mut distance) = (L::constant(1.0), L::constant(0.0));
        if let Some(column) = walls {
            distance = neighbours.scalar(column);
            if let Some(behind) = &behind {
                distance = L::select(behind.mask(), behind.depth, distance);
            }
            factor = image::velocity_factor(distance.abs(), own.inverse_wall_distance, cap);
        }
        Self { factor, distance, walls, normal, behind }
    }

    /// Returns true if a neighbour belongs to a free-slip wall.
    #[inline(always)]
    fn slips(&self) -> L::Mask {
        self.distance.less(L::constant(0.0))
    }

    /// Returns true if a neighbour is a wall particle.
    #[inline(always)]
    fn is_wall(&self) -> L::Mask {
        L::constant(0.0).less(self.distance.abs())
    }

    /// Returns x_ab·v_ab/h, m/s, with the relative velocity continued into walls by the image
    /// factor; at free-slip walls only its component along the normal counts.
    #[inline(always)]
    pub(crate) fn product<const D: usize>(
        &self,
        product: L,
        pair: &PairGeometry<L, D>,
        neighbours: Entry<'_, L>,
    ) -> L {
        let continued = if self.walls.is_some() { self.factor * product } else { product };
        self.free_slip_product(continued, self.factor, pair, neighbours)
    }

    /// Returns the product `product` with that of free-slip walls, by an image factor, in its
    /// place.
    #[inline(always)]
    pub(crate) fn free_slip_product<const D: usize>(
        &self,
        product: L,
        factor: L,
        pair: &PairGeometry<L, D>,
        neighbours: Entry<'_, L>,
    ) -> L {
        if let Some(column) = self.normal {
            let normal = neighbours.vector_at(column);
            let slipping = image::free_slip_product(factor, normal, pair.x, pair.v);
            L::select(self.slips(), slipping, product)
        } else {
            product
        }
    }

    /// Returns the value of a viscous term: 0 at free-slip walls.
    #[inline(always)]
    pub(crate) fn without_free_slip(&self, value: L) -> L {
        if self.normal.is_some() { L::select(self.slips(), L::constant(0.0), value) } else { value }
    }

    /// Returns the value of a term that acts between fluid particles only: 0 at walls.
    #[inline(always)]
    pub(crate) fn without_walls(&self, value: L) -> L {
        if self.walls.is_some() { L::select(self.is_wall(), L::constant(0.0), value) } else { value }
    }

    /// Returns a viscous factor multiplied by the image factor, 0 at free-slip walls.
    #[inline(always)]
    pub(crate) fn viscous(&self, value: L) -> L {
        let value = if self.walls.is_some() { value * self.factor } else { value };
        self.without_free_slip(value)
    }

    /// Returns the pressure of the neighbours, Pa, with a mirrored one behind thin walls.
    #[inline(always)]
    pub(crate) fn mirrored_behind<const D: usize>(
        &self,
        pressure: L,
        own: &OwnParticle<L, D>,
        x: [L; D],
    ) -> L {
        match &self.behind {
            Some(behind) => L::select(behind.mask(), own.pressure + dot(own.hydrostatic, x), pressure),
            None => pressure,
        }
    }

    /// Returns the factor of the pairs that act on a body: 0 for neighbours of the flow that do not
    /// stand for a thin wall, 1 for all others.
    #[inline(always)]
    pub(crate) fn acts_on_body<const D: usize>(&self, neighbours: Entry<'_, L>, facing: Option<Vector>) -> L {
        match (&self.behind, facing) {
            (Some(behind), Some(facing)) => behind.of_wall::<D>(facing, neighbours, self.distance),
            _ => L::constant(1.0),
        }
    }

    /// Returns a tensor of the neighbours with that of the particle behind thin walls.
    #[inline(always)]
    pub(crate) fn own_behind(&self, own: [L; 6], mut other: [L; 6]) -> [L; 6] {
        if let Some(behind) = &self.behind {
            for (other, own) in other.iter_mut().zip(own) {
                *other = L::select(behind.mask(), own, *other);
            }
        }
        other
    }

    /// Returns a term of the neighbours that walls do not have: 0 behind thin walls.
    #[inline(always)]
    pub(crate) fn without_behind(&self, value: L) -> L {
        match &self.behind {
            Some(behind) => L::select(behind.mask(), L::constant(0.0), value),
            None => value,
        }
    }

    /// Returns the pressure of the neighbours, Pa, with that of walls mirrored from the particle's
    /// own: p_a + ρ_a g·(x_b − x_a).
    #[inline(always)]
    pub(crate) fn mirrored_pressure<const D: usize>(
        &self,
        pressure: L,
        own: &OwnParticle<L, D>,
        x: [L; D],
    ) -> L {
        if self.walls.is_some() {
            L::select(self.is_wall(), own.pressure + dot(own.hydrostatic, x), pressure)
        } else {
            pressure
        }
    }
}
