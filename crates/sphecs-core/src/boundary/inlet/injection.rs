//! Where stored particles enter an inflow zone.
//!
//! ```text
//! along an axis    x − L n, x the particle that crossed: the lattice of the zone goes on as it is
//! slantwise        in rows along n, one row for each width w ≈ Δ of the section, Δ^D/w^(D−1) apart, as far as the zone reaches
//! ```
//!
//! Alvarado-Rodríguez et al. (2017), Fig. 1, for the first. A lattice that lies slantwise to a sheared inflow has no two
//! particles on one streamline: each has a speed of its own, and in a zone where nothing keeps them apart the faster
//! ones catch up with the slower ones until they clump (a channel turned by 20 degrees burst after 5 s). In rows
//! along the flow all have one speed. The lattice that a slantwise zone is filled with at the start flows off and rows follow.
//!
//! A zone that is filled once, Alvarado-Rodríguez et al. (2017), Sec. 5.3, takes none; it is drained when behind a particle
//! that crosses less than the support of the kernel is left, since the fluid would see the end of the zone.

use glam::DVec3;

use sphecs_scene::model::{Patch, Scene};

/// Whether a patch lies slantwise to the lattice.
pub fn is_slantwise(patch: &Patch) -> bool {
    patch.is_slantwise()
}

/// Whether too little is left behind a particle that crossed at a point (m) of an inlet that is filled once; `places` (m) are
/// those of the particles in its zone.
pub fn is_drained(patch: &Patch, scene: &Scene, crossed: DVec3, places: impl Iterator<Item = DVec3>) -> bool {
    let support = scene.scheme.support(scene.spacing);
    let aside = |at: DVec3| {
        let offset = at - crossed;
        patch.across.iter().map(|across| offset.dot(*across).abs()).fold(0.0, f64::max)
    };
    // Its own row and the halves of those beside it.
    let behind = places.filter(|at| aside(*at) <= scene.spacing).map(|at| patch.along(at));
    behind.fold(f64::INFINITY, f64::min) > -support
}

/// The row of a slantwise inflow zone that a point belongs to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InflowRow {
    /// Coordinates of its axis along `across`, m.
    axis: [f64; 2],
    /// Half widths about the axis, m.
    half_width: [f64; 2],
    /// From one particle to the next, m.
    pitch: f64,
}

impl InflowRow {
    /// The row of `patch` nearest to a point, for particles of an initial spacing (m).
    pub fn of(patch: &Patch, point: DVec3, spacing: f64) -> Self {
        let mut row = Self { axis: [0.0; 2], half_width: [f64::INFINITY; 2], pitch: spacing };
        for side in 0..2 {
            let extent = 2.0 * patch.half_extent[side];
            if patch.across[side] == DVec3::ZERO || extent <= 0.0 {
                continue;
            }
            let count = (extent / spacing).round().max(1.0);
            let width = extent / count;
            let offset = (point - patch.at).dot(patch.across[side]) + 0.5 * extent;
            let index = (offset / width).floor().clamp(0.0, count - 1.0);
            row.axis[side] = (index + 0.5) * width - 0.5 * extent;
            row.half_width[side] = 0.5 * width;
            row.pitch *= spacing / width;
        }
        row
    }

    /// Whether a point stands in the row, wherever along it.
    pub fn holds(&self, patch: &Patch, point: DVec3) -> bool {
        (0..2).all(|side| {
            ((point - patch.at).dot(patch.across[side]) - self.axis[side]).abs() <= self.half_width[side]
        })
    }

    /// The places upstream of the row's particles, the last of which stands at `last` along the patch's normal (m, < 0
    /// in the zone), that are to be taken so that the row reaches as far as the zone.
    pub fn vacancies(&self, patch: &Patch, last: f64) -> impl Iterator<Item = DVec3> {
        let foot = patch.at + patch.across[0] * self.axis[0] + patch.across[1] * self.axis[1];
        let (pitch, depth, towards) = (self.pitch, patch.depth, patch.towards);
        (1..)
            .map(move |step| last - f64::from(step) * pitch)
            .take_while(move |along| *along >= -depth)
            .map(move |along| foot + towards * along)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn patch(angle: f64) -> Patch {
        let (s, c) = angle.sin_cos();
        Patch {
            name: "inlet".to_owned(),
            at: DVec3::new(0.3, -0.2, 0.0),
            towards: DVec3::new(c, s, 0.0),
            across: [DVec3::new(-s, c, 0.0), DVec3::ZERO],
            half_extent: [0.081, 0.0],
            depth: 0.05,
            area: 0.162,
        }
    }

    #[test]
    fn only_slanted_patches_have_rows_of_their_own() {
        assert!(is_slantwise(&patch(0.3)));
        for quarter in 0..4 {
            assert!(!is_slantwise(&patch(f64::from(quarter) * std::f64::consts::FRAC_PI_2)));
        }
    }

    #[test]
    fn a_row_is_filled_as_far_as_its_zone_reaches() {
        let patch = patch(0.3);
        let point = patch.at + patch.across[0] * 0.023 + patch.towards * 0.001;
        let row = InflowRow::of(&patch, point, 0.01);
        assert!(row.holds(&patch, point) && !row.holds(&patch, point + patch.across[0] * 0.011));
        // 16 rows of 0.010125 m: a particle's volume is Δ².
        assert!((row.pitch * 2.0 * row.half_width[0] - 1e-4).abs() < 1e-15);
        assert_eq!(row.vacancies(&patch, -5.0 * row.pitch).count(), 0, "the zone is 5.06 pitches long");
        let places: Vec<DVec3> = row.vacancies(&patch, -2.0 * row.pitch + 0.001).collect();
        assert_eq!(places.len(), 3);
        for place in places {
            assert!(row.holds(&patch, place) && (-0.05..0.0).contains(&patch.along(place)));
            let lateral = (place - patch.at).dot(patch.across[0]);
            assert!((lateral - row.axis[0]).abs() < 1e-15);
        }
    }
}
