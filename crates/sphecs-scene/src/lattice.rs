//! Lattice of the initial particles, and its fit to the walls.
//!
//! One lattice with equal spacing along all axes covers domain, zones and walls. Its kernel sums
//! are the same everywhere, so a fluid at rest is exactly uniform. Walls should lie midway between
//! two rows (Δ/2 from fluid and from wall particles). Along each axis the lattice is therefore
//! shifted to the circular mean of the phases of all plane walls across that axis, weighted by
//! their areas:
//!
//! ```text
//! φ = (Δ/2π) arg Σ A_k exp(2πi c_k/Δ),   c_k: coordinate of wall k, A_k: its area
//! ```
//!
//! A width that is not a multiple of Δ cannot fit on both sides. The geometry is kept, particles
//! are up to Δ/4 closer to or farther from the wall, and `sphecs check` reports the misfit. On a
//! periodic axis the spacing divides the period.
//!
//! The lattice may be turned: its axes, and the coordinates of all that this page says, are then
//! those of its [`rotation`](Lattice::rotation).

use std::f64::consts::TAU;

use glam::{DMat3, DVec3};

use super::geometry::Shape;
use super::model::Patch;

/// Largest 1 − |n·e| at which a direction n counts as parallel to an axis e.
const PARALLEL: f64 = 1e-9;

/// A square or cubic lattice of particles.
#[derive(Clone, Debug)]
pub struct Lattice {
    /// Directions of its axes, as columns; the identity for one along the axes of the scene.
    pub rotation: DMat3,
    /// A corner at which cells meet, m, in the coordinates of its axes.
    pub origin: DVec3,
    /// Distance of neighbours along each axis, m: Δ, or the nearest fraction of the period on
    /// periodic axes.
    pub spacing: DVec3,
    /// Fits of plane walls to the lattice.
    pub fits: Vec<WallFit>,
    /// Largest initial displacement of fluid particles along each axis, in spacings.
    pub jitter: f64,
}

/// Fit of a plane wall to the lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallFit {
    /// Axis across the wall: 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// Coordinate of the wall on that axis, m.
    pub coordinate: f64,
    /// Area of the wall, m² (length in m in 2D).
    pub area: f64,
    /// Distance to the nearest plane between cells, in spacings: 0 is perfect, 0.5 the worst.
    pub misfit: f64,
}

impl Lattice {
    /// Returns the centre of the cell with these indices, m.
    pub fn point(&self, cell: [i64; 3], dimensions: usize) -> DVec3 {
        let mut point = DVec3::ZERO;
        for axis in 0..dimensions {
            point[axis] = self.origin[axis] + (cell[axis] as f64 + 0.5) * self.spacing[axis];
        }
        self.turned(point)
    }

    /// Returns a vector of the lattice in the coordinates of the scene; bitwise identical unless it
    /// is turned.
    pub fn turned(&self, vector: DVec3) -> DVec3 {
        if self.is_turned() { self.rotation * vector } else { vector }
    }

    /// Returns true if its axes are not those of the scene.
    pub fn is_turned(&self) -> bool {
        self.rotation != DMat3::IDENTITY
    }

    /// Returns true if a direction lies along none of its axes.
    pub fn is_oblique(&self, direction: DVec3) -> bool {
        (self.rotation.transpose() * direction).abs().max_element() < 1.0 - PARALLEL
    }

    /// Returns the jitter of the particle of a cell, m from its centre: uniform random numbers that
    /// depend on the cell alone.
    pub fn offset(&self, cell: [i64; 3], dimensions: usize) -> DVec3 {
        let mut offset = DVec3::ZERO;
        let mut state = cell.into_iter().fold(0, |state, index| mixed(state ^ index as u64));
        for axis in 0..dimensions {
            state = mixed(state);
            // The upper 53 bits make a uniform f64 from 0 to 1.
            let even = (state >> 11) as f64 / (1_u64 << 53) as f64;
            offset[axis] = self.jitter * (2.0 * even - 1.0) * self.spacing[axis];
        }
        self.turned(offset)
    }

    /// Returns the range of cells along an axis that an interval (m) touches.
    pub fn range(&self, axis: usize, low: f64, high: f64) -> std::ops::Range<i64> {
        let index = |x: f64| (x - self.origin[axis]) / self.spacing[axis];
        (index(low) - 1e-9).floor() as i64..(index(high) + 1e-9).ceil() as i64
    }

    /// Returns the lattice of a domain with axes along the columns of `rotation`, shifted to
    /// `anchor` or else to the walls.
    pub fn turned_and_fitted(
        rotation: DMat3,
        domain: &Shape,
        patches: &[&Patch],
        periodic: &[Option<(f64, f64)>; 3],
        spacing: f64,
        anchor: Option<DVec3>,
        dimensions: usize,
    ) -> Self {
        if rotation == DMat3::IDENTITY {
            return Self::fitted(domain, patches, periodic, spacing, anchor, dimensions);
        }
        let back = rotation.transpose();
        let patches: Vec<Patch> = patches.iter().map(|patch| rotated_patch(patch, back)).collect();
        let patches: Vec<&Patch> = patches.iter().collect();
        let anchor = anchor.map(|anchor| back * anchor);
        let lattice = Self::fitted(&domain.rotated(back), &patches, periodic, spacing, anchor, dimensions);
        Self { rotation, ..lattice }
    }

    /// Returns the lattice along the axes, shifted to `anchor` or else to the walls.
    fn fitted(
        domain: &Shape,
        patches: &[&Patch],
        periodic: &[Option<(f64, f64)>; 3],
        spacing: f64,
        anchor: Option<DVec3>,
        dimensions: usize,
    ) -> Self {
        let walls = plane_walls(domain, patches, periodic, spacing, dimensions);
        let mut lattice = Self {
            rotation: DMat3::IDENTITY,
            origin: domain.bounds().0.with_z(0.0),
            spacing: DVec3::splat(spacing),
            fits: Vec::new(),
            jitter: 0.0,
        };
        for axis in 0..dimensions {
            lattice.origin[axis] = match (periodic[axis], anchor) {
                (Some((low, high)), _) => {
                    let count = ((high - low) / spacing).round().max(1.0);
                    lattice.spacing[axis] = (high - low) / count;
                    low
                }
                (None, Some(anchor)) => anchor[axis],
                (None, None) => phase(walls.iter().filter(|wall| wall.axis == axis), spacing)
                    .unwrap_or(domain.bounds().0[axis]),
            };
        }
        lattice.fits = walls
            .into_iter()
            .filter(|wall| wall.area > 0.0 && periodic[wall.axis].is_none())
            .map(|wall| {
                let cells = (wall.coordinate - lattice.origin[wall.axis]) / spacing;
                let misfit = (cells - cells.round()).abs();
                WallFit { misfit, ..wall }
            })
            .collect();
        lattice
    }
}

/// Returns a hash of a number: SplitMix64 of Steele et al. (2014).
fn mixed(number: u64) -> u64 {
    let z = number.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Returns the shift for the best fit of the walls, m; None without walls or if their phases
/// cancel.
fn phase<'a>(walls: impl Iterator<Item = &'a WallFit>, spacing: f64) -> Option<f64> {
    let (mut cosine, mut sine, mut weight) = (0.0, 0.0, 0.0);
    let mut first = None;
    for wall in walls {
        // Phases of distances from the first wall lose no digits far from the origin.
        let first = *first.get_or_insert(wall.coordinate);
        let angle = TAU * ((wall.coordinate - first) / spacing).fract();
        // A plane without wall area (a patch, a tangent) counts only if no plane has any.
        let area = wall.area.max(1e-9 * spacing);
        cosine += area * angle.cos();
        sine += area * angle.sin();
        weight += area;
    }
    let first = first?;
    (cosine.hypot(sine) > 1e-6 * weight).then(|| {
        let angle = sine.atan2(cosine);
        // Rounding of a perfect fit must not shift the lattice.
        let angle = if angle.abs() < 1e-9 { 0.0 } else { angle };
        first + spacing * angle / TAU
    })
}

/// Returns all planes across the axes that touch the surface of the domain, with their wall area.
fn plane_walls(
    domain: &Shape,
    patches: &[&Patch],
    periodic: &[Option<(f64, f64)>; 3],
    spacing: f64,
    dimensions: usize,
) -> Vec<WallFit> {
    let mut planes = Vec::new();
    domain.planes(&mut planes);
    // Side walls of the zones: in channels with inclined walls only these are plane.
    for patch in patches {
        for (across, half) in patch.across.iter().zip(patch.half_extent) {
            let along_axis = (0..3).find(|axis| across[*axis].abs() > 1.0 - 1e-9);
            if let Some(axis) = along_axis {
                planes.extend([(axis, patch.at[axis] - half), (axis, patch.at[axis] + half)]);
            }
        }
    }
    planes.retain(|(axis, coordinate)| *axis < dimensions && coordinate.is_finite());
    planes.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    planes.dedup_by(|a, b| a.0 == b.0 && (a.1 - b.1).abs() < 1e-6 * spacing);
    planes
        .into_iter()
        .map(|(axis, coordinate)| WallFit {
            axis,
            coordinate,
            area: match periodic[axis] {
                Some(_) => 0.0,
                None => exposed_area(domain, patches, (axis, coordinate), spacing, dimensions, SAMPLES),
            },
            misfit: 0.0,
        })
        .collect()
}

/// Returns an opening rotated about the origin.
pub fn rotated_patch(patch: &Patch, by: DMat3) -> Patch {
    let straight = |vector: DVec3| {
        let clean = (by * vector).map(|c| if c.abs() < 1e-12 { 0.0 } else { c });
        clean.normalize_or_zero()
    };
    Patch {
        at: by * patch.at,
        towards: straight(patch.towards),
        across: patch.across.map(straight),
        ..patch.clone()
    }
}

/// Samples on a plane along each axis, in 2D and in 3D.
const SAMPLES: [usize; 2] = [2000, 64];

/// Returns the area of the wall in a plane across an axis at a coordinate, m² (m in 2D), from
/// samples along each other axis, in 2D and in 3D.
pub fn exposed_area(
    domain: &Shape,
    patches: &[&Patch],
    (axis, coordinate): (usize, f64),
    spacing: f64,
    dimensions: usize,
    samples: [usize; 2],
) -> f64 {
    let (low, high) = domain.bounds();
    let others: Vec<usize> = (0..dimensions).filter(|other| *other != axis).collect();
    let count = samples[others.len() - 1];
    let step: Vec<f64> = others.iter().map(|&other| (high[other] - low[other]) / count as f64).collect();
    let aside = 1e-3 * spacing * DVec3::AXES[axis];
    let mut exposed = 0_usize;
    for index in 0..count.pow(others.len() as u32) {
        let mut point = DVec3::ZERO;
        point[axis] = coordinate;
        for (place, &other) in others.iter().enumerate() {
            let along = (index / count.pow(place as u32) % count) as f64 + 0.5;
            point[other] = low[other] + along * step[place];
        }
        let below = domain.contains(point - aside, 0.0);
        let above = domain.contains(point + aside, 0.0);
        let open = || {
            patches.iter().any(|patch| patch.along(point).abs() < 0.01 * spacing && patch.covers(point, 0.0))
        };
        if below != above && !open() {
            exposed += 1;
        }
    }
    exposed as f64 * step.iter().product::<f64>()
}
