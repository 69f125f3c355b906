//! Column of inflow particles behind one point of an emitter.
//!
//! ```text
//! A(s) = A (1 − T s + K s²),   q(s) = ∫₀ˢ A ds' = A (s − T s²/2 + K s³/3)
//! particle n stands at q = (n + ½) V0 − Q,   Q = ∫ A v dt
//! ```
//!
//! s is the depth behind the surface, A the area of the surface that the column serves, T and K sum
//! and product of its two principal curvatures, positive where the surface is convex towards the
//! fluid. The section of the column follows the normals, so its particles have the volume V0 = Δ^D
//! at every depth. Q is the volume that was emitted: the place of each particle follows from it
//! alone, so the emitted mass is exact to half a particle at all times. Behind a concave surface
//! the column widens. In front of the surface s is negative.

use glam::DVec3;

/// Smallest share of its area to which a column may narrow.
pub const NARROWEST: f64 = 0.3;

/// A column; positions and directions in the coordinates of its wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EmitterColumn {
    /// Point of the surface, m.
    pub foot: DVec3,
    /// Unit normal into the fluid.
    pub normal: DVec3,
    /// Area of the surface that it serves, m² (m in 2D).
    pub area: f64,
    /// Sum of the principal curvatures, 1/m.
    pub curvature_sum: f64,
    /// Product of the principal curvatures, 1/m²; 0 in 2D.
    pub curvature_product: f64,
}

impl EmitterColumn {
    /// Returns the area of the section at a depth, m, over that at the surface.
    pub fn narrowing(&self, depth: f64) -> f64 {
        1.0 + depth * (-self.curvature_sum + self.curvature_product * depth)
    }

    /// Returns the volume between the surface and a depth, m³ (m² in 2D).
    pub fn volume(&self, depth: f64) -> f64 {
        let (half, third) = (self.curvature_sum / 2.0, self.curvature_product / 3.0);
        self.area * depth * (1.0 + depth * (-half + third * depth))
    }

    /// Returns the depth behind which the column has a volume, m; in front of the surface, where
    /// the volume is negative, without regard to the curvature.
    pub fn depth(&self, volume: f64) -> f64 {
        let straight = volume / self.area;
        if volume <= 0.0 || (self.curvature_sum == 0.0 && self.curvature_product == 0.0) {
            return straight;
        }
        let mut depth = straight;
        // Newton's method on a monotonic cubic; the number of steps is fixed for equal bits.
        for _ in 0..8 {
            let slope = self.area * self.narrowing(depth).max(NARROWEST);
            depth -= (self.volume(depth) - volume) / slope;
        }
        depth
    }

    /// Returns the point at a depth, m.
    pub fn point(&self, depth: f64) -> DVec3 {
        self.foot - depth * self.normal
    }

    /// Returns the number of particles of volume `particle` (m³) that stand in the column up to a
    /// depth, m, before it emits any.
    pub fn count(&self, depth: f64, particle: f64) -> usize {
        (self.volume(depth) / particle).round().max(1.0) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column(curvature_sum: f64, curvature_product: f64) -> EmitterColumn {
        EmitterColumn {
            foot: DVec3::new(1.0, 0.0, 0.0),
            normal: DVec3::X,
            area: 0.02,
            curvature_sum,
            curvature_product,
        }
    }

    #[test]
    fn a_column_behind_a_sphere_is_a_part_of_its_ball() {
        let radius = 0.5;
        let column = column(2.0 / radius, 1.0 / (radius * radius));
        for depth in [0.0, 0.05, 0.2, 0.24] {
            let inner: f64 = radius - depth;
            let expected = 0.02 * (radius.powi(3) - inner.powi(3)) / (3.0 * radius * radius);
            assert!((column.volume(depth) - expected).abs() < 1e-15);
            assert!((column.narrowing(depth) - (inner / radius).powi(2)).abs() < 1e-14);
        }
    }

    #[test]
    fn depth_is_the_inverse_of_the_volume() {
        for (sum, product) in [(0.0, 0.0), (3.0, 0.0), (-3.0, 0.0), (4.0, 4.0), (-2.0, 1.0), (0.5, -3.0)] {
            let column = column(sum, product);
            for step in 1..=20 {
                let depth = 0.01 * f64::from(step);
                if column.narrowing(depth) >= NARROWEST {
                    let found = column.depth(column.volume(depth));
                    assert!((found - depth).abs() < 1e-14, "{sum} {product}: {found} for {depth}");
                }
            }
        }
    }

    #[test]
    fn a_particle_in_front_of_the_surface_has_a_negative_depth() {
        let column = column(2.0, 1.0);
        assert_eq!(column.depth(-0.001), -0.05);
        assert_eq!(column.point(-0.05), DVec3::new(1.05, 0.0, 0.0));
        assert_eq!(column.count(0.1, column.volume(0.1) / 5.0), 5);
    }
}
