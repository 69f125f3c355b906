//! Positions at which particles enter an inflow zone.
//!
//! ```text
//! along an axis   x − L n, x the particle that crossed: the lattice of the zone continues
//! oblique         in lines along n over the length L of the zone, one line for each width w ≈ Δ
//!                 of the section, particles Δ^D/w^(D−1) apart
//! ```
//!
//! The first case is that of Alvarado-Rodríguez et al. (2017), Fig. 1. On a lattice oblique to a
//! sheared inflow no two particles share a streamline, so each has its own speed. No force in the
//! zone separates them, and the faster ones approach the slower ones until they clump (a channel
//! rotated by 20° diverged after 5 s). In lines along the flow all particles have one speed. The
//! lattice that fills an oblique zone at the start is advected out, and lines follow.
//!
//! A zone that is filled once, Alvarado-Rodríguez et al. (2017), Sec. 5.3, takes no particles. It
//! is drained when the zone behind a particle that crosses is shorter than the kernel's support,
//! since the fluid would then see its end.

use glam::DVec3;

use crate::boundary::patch::Patch;

/// Returns true if the zone of an inlet that is filled once is drained behind a particle that
/// crossed.
///
/// `crossed` is its position, `positions` are those of the particles in the zone, `spacing` is Δ
/// and `support` the radius of the kernel's support, all in m.
pub fn is_drained(
    patch: &Patch,
    (spacing, support): (f64, f64),
    crossed: DVec3,
    positions: impl Iterator<Item = DVec3>,
) -> bool {
    let aside = |at: DVec3| {
        let offset = at - crossed;
        patch.across.iter().map(|across| offset.dot(*across).abs()).fold(0.0, f64::max)
    };
    // Its own line and half of each adjacent line.
    let behind = positions.filter(|at| aside(*at) <= spacing).map(|at| patch.along(at));
    behind.fold(f64::INFINITY, f64::min) > -support
}

/// A line of particles in an oblique inflow zone, along the normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InflowLine {
    /// Coordinates of its axis along `across`, m.
    axis: [f64; 2],
    /// Half widths about the axis, m.
    half_width: [f64; 2],
    /// Distance of neighbouring particles, m.
    pitch: f64,
}

impl InflowLine {
    /// Returns the line of `patch` nearest to a point, for particles of an initial spacing (m).
    pub fn of(patch: &Patch, point: DVec3, spacing: f64) -> Self {
        let mut line = Self { axis: [0.0; 2], half_width: [f64::INFINITY; 2], pitch: spacing };
        for side in 0..2 {
            let extent = 2.0 * patch.half_extent[side];
            if patch.across[side] == DVec3::ZERO || extent <= 0.0 {
                continue;
            }
            let count = (extent / spacing).round().max(1.0);
            let width = extent / count;
            let offset = (point - patch.at).dot(patch.across[side]) + 0.5 * extent;
            let index = (offset / width).floor().clamp(0.0, count - 1.0);
            line.axis[side] = (index + 0.5) * width - 0.5 * extent;
            line.half_width[side] = 0.5 * width;
            line.pitch *= spacing / width;
        }
        line
    }

    /// Returns true if a point lies in the line, anywhere along it.
    pub fn holds(&self, patch: &Patch, point: DVec3) -> bool {
        (0..2).all(|side| {
            ((point - patch.at).dot(patch.across[side]) - self.axis[side]).abs() <= self.half_width[side]
        })
    }

    /// Returns the positions that fill the line up to the end of the zone. The last particle of the
    /// line is at `last` along the normal of the patch (m, < 0 in the zone), and the distances are
    /// multiplied by `stretch`.
    pub fn vacancies(&self, patch: &Patch, last: f64, stretch: f64) -> impl Iterator<Item = DVec3> {
        let foot = patch.at + patch.across[0] * self.axis[0] + patch.across[1] * self.axis[1];
        let (pitch, depth, towards) = (stretch * self.pitch, stretch * patch.depth, patch.towards);
        (1..)
            .map(move |step| last - f64::from(step) * pitch)
            .take_while(move |along| *along >= -depth)
            .map(move |along| foot + towards * along)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::boundary::patch::turned_patch;

    #[test]
    fn a_line_is_filled_up_to_the_end_of_its_zone() {
        let patch = turned_patch(0.3);
        let point = patch.at + patch.across[0] * 0.023 + patch.towards * 0.001;
        let line = InflowLine::of(&patch, point, 0.01);
        assert!(line.holds(&patch, point) && !line.holds(&patch, point + patch.across[0] * 0.011));
        // There are 16 lines of 0.010125 m; the volume of a particle is Δ².
        assert!((line.pitch * 2.0 * line.half_width[0] - 1e-4).abs() < 1e-15);
        assert_eq!(
            line.vacancies(&patch, -5.0 * line.pitch, 1.0).count(),
            0,
            "the zone is 5.06 pitches long"
        );
        let positions: Vec<DVec3> = line.vacancies(&patch, -2.0 * line.pitch + 0.001, 1.0).collect();
        assert_eq!(positions.len(), 3);
        for place in positions {
            assert!(line.holds(&patch, place) && (-0.05..0.0).contains(&patch.along(place)));
            let lateral = (place - patch.at).dot(patch.across[0]);
            assert!((lateral - line.axis[0]).abs() < 1e-15);
        }
    }
}
