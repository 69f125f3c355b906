//! Mass flow through plane sections of a flow.
//!
//! ```text
//! q = Σ_b m_b ((v_b + w_b) · n) M4((x_b − x_s) · n/Δ)/Δ,   M4: cubic B-spline, |x| < 2
//! ```
//!
//! in kg/s (kg/(s m), per metre of depth, in 2D). The drift w is the velocity by which shifting or
//! the transport velocity moved the particle beyond v. The sum q is the mass flow of the particles,
//! smoothed along the normal. With the density smoothed in the same way mass is conserved exactly.
//! A steady flow has the same q in every section, whatever the position of its walls on the
//! lattice. Without w it would not: next to sharp edges shifting moves the fluid as a whole
//! (docs/notebook/2026-11-23-noise.md). A sum of interpolated values over the section conserves
//! mass less well: between walls oblique to the lattice it was up to 4 % too large. Over layers of
//! particles that are Δ apart M4 sums to one wherever the plane lies.

use std::collections::HashSet;
use std::ops::Range;

use glam::DVec3;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use crate::math::exact_sum::ExactSum;
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;

/// A connected part of a plane through the flow.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    at: DVec3,
    normal: DVec3,
    /// Unit vectors in the plane.
    along: [DVec3; 2],
    spacing: f64,
    /// Squares of the plane, Δ wide, that belong to it, and those next to its rim.
    ///
    /// The foot point of a particle beside a curved wall may lie slightly outside.
    cells: HashSet<(i32, i32)>,
    /// Periods of the domain along the axes, m.
    periods: [Option<f64>; 3],
}

impl Section {
    /// Returns the part of the plane through `at`, m, that `points`, m, cover, with a unit normal.
    ///
    /// The points must be no farther from each other than the spacing Δ, m.
    pub fn new(
        at: DVec3,
        normal: DVec3,
        points: &[DVec3],
        spacing: f64,
        periods: [Option<f64>; 3],
        dimensions: usize,
    ) -> Self {
        let across = if dimensions == 2 { normal.cross(DVec3::Z) } else { normal.any_orthonormal_vector() };
        let along = [across, normal.cross(across)];
        let mut section = Self { at, normal, along, spacing, cells: HashSet::new(), periods };
        for point in points {
            let (i, j) = section.cell(*point - at);
            section.cells.extend((-1..=1).flat_map(|k| (-1..=1).map(move |l| (i + k, j + l))));
        }
        section
    }

    /// Appends the section as numbers, for a message to another rank.
    pub fn write(&self, to: &mut Vec<f64>) {
        for vector in [self.at, self.normal, self.along[0], self.along[1]] {
            to.extend(vector.to_array());
        }
        to.push(self.spacing);
        to.extend(self.periods.map(|period| period.unwrap_or(0.0)));
        to.push(self.cells.len() as f64);
        to.extend(self.cells.iter().flat_map(|&(i, j)| [f64::from(i), f64::from(j)]));
    }

    /// Returns the sections whose numbers were [written](Self::write).
    pub fn read_all(numbers: &[f64]) -> Vec<Self> {
        let mut numbers = numbers.iter().copied();
        let mut sections = Vec::new();
        while let Some(x) = numbers.next() {
            let mut next = || numbers.next().expect("a whole section");
            let at = DVec3::new(x, next(), next());
            let [normal, first, second] = std::array::from_fn(|_| DVec3::new(next(), next(), next()));
            let spacing = next();
            let periods = std::array::from_fn(|_| Some(next()).filter(|&period| period > 0.0));
            let cells = (0..next() as usize).map(|_| (next() as i32, next() as i32)).collect();
            sections.push(Self { at, normal, along: [first, second], spacing, cells, periods });
        }
        sections
    }

    fn cell(&self, offset: DVec3) -> (i32, i32) {
        let [i, j] = self.along.map(|unit| (offset.dot(unit) / self.spacing).round() as i32);
        (i, j)
    }

    /// Returns the vector from the point `at` of the section to the nearest image of a position, m.
    fn offset(&self, position: DVec3) -> DVec3 {
        let mut offset = position - self.at;
        for (axis, period) in self.periods.iter().enumerate() {
            if let Some(period) = period {
                offset[axis] -= period * (offset[axis] / period).round();
            }
        }
        offset
    }

    /// Returns the share of a particle's mass flow that belongs to the section, 1/m.
    fn weight(&self, position: DVec3) -> f64 {
        let offset = self.offset(position);
        let weight = cubic_spline(offset.dot(self.normal) / self.spacing);
        if weight > 0.0 && self.cells.contains(&self.cell(offset)) { weight / self.spacing } else { 0.0 }
    }
}

/// Returns the cubic B-spline on knots at distance one.
fn cubic_spline(x: f64) -> f64 {
    let x = x.abs();
    if x < 1.0 { 2.0 / 3.0 - x * x + 0.5 * x * x * x } else { (2.0 - x).max(0.0).powi(3) / 6.0 }
}

/// Returns Σ (v + w) · n M4/Δ, 1/s, through sections over rows of the particles; times the mass of
/// a particle it is the mass flow.
pub fn flow_sums<R: Real, const D: usize>(
    particles: &ParticleArrays<R, D>,
    rows: &[Range<usize>],
    sections: &[&Section],
) -> Vec<ExactSum> {
    let flow = |section: &&Section| {
        let mut flow = ExactSum::default();
        let rows = rows.iter().flat_map(Clone::clone);
        for row in rows.filter(|&row| particles.zone[row].flows()) {
            let weight = section.weight(particles.position_of(row));
            if weight > 0.0 {
                flow += weight * particles.carrying_velocity_of(row).dot(section.normal);
            }
        }
        flow
    };
    sections.par_iter().map(flow).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::kernel::Kernel;
    use crate::pass::samples::{SPACING, Sample, WATER, settings};

    /// Points of a line of length `length` through `at`.
    fn line(at: DVec3, along: DVec3, length: f64) -> Vec<DVec3> {
        let count = (length / (0.5 * SPACING)).ceil();
        (0..count as usize).map(|k| at + along * length * ((k as f64 + 0.5) / count - 0.5)).collect()
    }

    fn mass_flow<R: Real, const D: usize>(sample: &Sample<R, D>, section: &Section) -> f64 {
        let rows = 0..sample.particles.len();
        sample.pair.discretisation.mass * flow_sums(&sample.particles, &[rows], &[section])[0].value()
    }

    #[test]
    fn section_is_read_as_it_was_written() {
        let points = line(DVec3::new(0.3, 0.1, 0.0), DVec3::Y, 7.0 * SPACING);
        let periods = [None, Some(2.0), None];
        let section = Section::new(points[0], DVec3::X, &points, SPACING, periods, 2);
        let other = Section::new(points[1], DVec3::Y, &points, SPACING, [None; 3], 3);
        let mut numbers = Vec::new();
        [&section, &other].iter().for_each(|section| section.write(&mut numbers));
        assert_eq!(Section::read_all(&numbers), [section, other]);
    }

    #[test]
    fn mass_flow_on_the_lattice_is_exact_wherever_the_plane_lies() {
        let mut sample = Sample::<f64, 2>::lattice(settings(Kernel::WendlandC2, 2, 1.33), [40, 20], false);
        sample.particles.velocity[0].fill(0.3);
        let exact = WATER.reference_density * 0.3 * 20.0 * SPACING;
        for shift in [0.0, 0.13, 0.5, 0.77] {
            let at = DVec3::new(-0.1 + shift * SPACING, -0.2, 0.0);
            let points = line(at, DVec3::Y, 20.0 * SPACING);
            let section = Section::new(at, DVec3::X, &points, SPACING, [None; 3], 2);
            let found = mass_flow(&sample, &section);
            assert!((found / exact - 1.0).abs() < 1e-12, "{found} for {exact} at {shift}");
        }
    }

    #[test]
    fn mass_flow_includes_the_drift() {
        let mut sample = Sample::<f64, 2>::lattice(settings(Kernel::WendlandC2, 2, 1.33), [40, 20], false);
        sample.particles.velocity[0].fill(0.3);
        sample.particles.drifts = true;
        sample.particles.drift = [-0.02, 0.5].map(|w| vec![w; sample.particles.len()]);
        let at = DVec3::new(-0.1, -0.2, 0.0);
        let section = Section::new(at, DVec3::X, &line(at, DVec3::Y, 20.0 * SPACING), SPACING, [None; 3], 2);
        let found = mass_flow(&sample, &section);
        let exact = WATER.reference_density * 0.28 * 20.0 * SPACING;
        assert!((found / exact - 1.0).abs() < 1e-12, "{found} for {exact}");
    }

    /// A plane oblique to the lattice cuts layers at all distances; the error is that of the ends
    /// of the layers.
    #[test]
    fn an_oblique_plane_has_the_same_mass_flow() {
        let mut sample = Sample::<f64, 2>::lattice(settings(Kernel::WendlandC2, 2, 1.33), [60, 40], false);
        sample.particles.velocity[0].fill(0.3);
        let normal = DVec3::new(0.8, 0.6, 0.0);
        let (at, along) = (DVec3::new(0.0, -0.1, 0.0), DVec3::new(-0.6, 0.8, 0.0));
        let points = line(at, along, 0.5);
        let section = Section::new(at, normal, &points, SPACING, [None; 3], 2);
        let found = mass_flow(&sample, &section);
        let exact = WATER.reference_density * 0.3 * 40.0 * SPACING;
        assert!((found / exact - 1.0).abs() < 2e-3, "{found} for {exact}");
    }

    #[test]
    fn section_crosses_a_periodic_boundary_and_excludes_other_parts_of_its_plane() {
        let mut sample = Sample::<f32, 3>::lattice(settings(Kernel::WendlandC2, 3, 1.33), [20, 12, 12], true);
        sample.particles.velocity[0].fill(0.5);
        let periods = [Some(20.0 * SPACING), Some(12.0 * SPACING), Some(12.0 * SPACING)];
        // On the seam, and over a strip of 4 rows and one on each side of it.
        let at = DVec3::new(-0.3, -0.25, -0.25);
        let mut points = Vec::new();
        for k in -1..=1 {
            points.extend(line(at + DVec3::Z * f64::from(k) * SPACING, DVec3::Y, 3.0 * SPACING));
        }
        let section = Section::new(at, DVec3::X, &points, SPACING, periods, 3);
        let found = mass_flow(&sample, &section);
        let rows = sample.particles.position[1].iter().zip(&sample.particles.position[2]);
        let inside = rows
            .filter(|(y, z)| {
                let offset = DVec3::new(0.0, *y - at.y, *z - at.z);
                section.cells.contains(&section.cell(offset))
            })
            .count();
        let exact = WATER.reference_density * 0.5 * SPACING.powi(2) * inside as f64 / 20.0;
        assert!(inside > 0 && inside < 20 * 144, "{inside}");
        assert!((found / exact - 1.0).abs() < 1e-6, "{found} for {exact}");
    }
}
