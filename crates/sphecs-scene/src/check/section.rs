//! Section of a patch: axes, size, outline, and the zone extruded from it.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DMat3, DVec3};
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::cut::{Cut, CutPart, CutPlane};
use super::patches::Site;
use crate::geometry::directions::Direction;
use crate::geometry::measure::exit_distance;
use crate::geometry::{Clip, Shape};
use crate::model::Patch;
use sphecs_core::boundary::patch::Extent;
use sphecs_core::boundary::section_raster::SectionRaster;

/// Returns the unit vectors that span the plane, y and z for a flow along x; the second is zero in
/// 2D.
pub fn across(domain: &Shape, towards: DVec3, dimensions: usize) -> [DVec3; 2] {
    if dimensions == 2 {
        return [DVec3::new(-towards.y, towards.x, 0.0), DVec3::ZERO];
    }
    // The axis with the smallest component along the flow, y before z before x, made perpendicular.
    let candidates = [DVec3::Y, DVec3::Z, DVec3::X];
    let least = candidates
        .into_iter()
        .min_by(|a, b| a.dot(towards).abs().total_cmp(&b.dot(towards).abs()))
        .unwrap_or(DVec3::Y);
    let first = (least - least.dot(towards) * towards).normalize();
    let first =
        if towards.abs().max_element() < 1.0 - ALONG { nearest_side(domain, towards, first) } else { first };
    [first, towards.cross(first)]
}

/// Largest cosine of perpendicular directions, and 1 − cosine of parallel ones.
const ALONG: f64 = 1e-9;

/// Returns the direction across a flow that is nearest to `first` and perpendicular to a plane of
/// the domain; `first` without such a plane. So the section of a tilted duct is a rectangle along
/// its walls.
fn nearest_side(domain: &Shape, towards: DVec3, first: DVec3) -> DVec3 {
    let mut directions = Vec::new();
    domain.directions(&mut directions);
    let normals = directions.into_iter().filter_map(|direction| match direction {
        Direction::Plane { normal, .. } => Some(normal),
        Direction::Side { .. } => None,
    });
    let sides = normals.filter(|normal| normal.dot(towards).abs() < ALONG);
    let nearest = sides.max_by(|a, b| a.dot(first).abs().total_cmp(&b.dot(first).abs()));
    // Perpendicular to the flow in spite of rounding.
    let straight = |side: DVec3| (side - side.dot(towards) * towards).normalize() * side.dot(first).signum();
    nearest.map_or(first, straight)
}

/// Returns the distance from a point inside to the surface along a direction, m, by steps and
/// bisection.
pub fn exit(domain: &Shape, from: DVec3, direction: DVec3, spacing: f64) -> Option<f64> {
    let (low, high) = domain.bounds();
    let height = high.z - low.z;
    let size = (high - low).truncate().length() + if height.is_finite() { height } else { 0.0 };
    let step = (0.25 * spacing).max(1e-5 * size);
    exit_distance(|distance| domain.contains(from + distance * direction, 0.0), step, 2.0 * size)
}

/// Centres the patch on its section and measures it, on a plane just inside the domain.
///
/// Returns the other parts of the domain's end at the plane, which stay walls.
pub fn measure(patch: &mut Patch, inwards: DVec3, extent: Extent, site: &Site<'_>) -> Vec<CutPart> {
    let plane = CutPlane { at: patch.at, inwards, across: patch.across, aside: 1e-3 * site.spacing };
    let cut = Cut::new(plane, extent, site);
    centre_on_chords(patch, plane, site);
    let is_single = cut.parts.iter().filter(|part| part.is_open).count() == 1;
    let outline = if is_single && chords_span(patch, plane, &cut) {
        outline(patch, covered(patch, plane, &cut, site))
    } else {
        centre_on_cut(patch, plane, &cut, site);
        Outline::Other
    };
    let [a, b] = patch.half_extent;
    (patch.area, patch.perimeter) = match outline {
        Outline::Rectangle if site.dimensions == 2 => (2.0 * a, wet_sides(patch, site)[0] * 2.0),
        Outline::Rectangle => {
            let [sides, ends] = wet_sides(patch, site);
            (4.0 * a * b, 4.0 * (b * sides + a * ends))
        }
        Outline::Disc => (PI * a * b, 2.0 * PI * a),
        Outline::Other => (0.0, 0.0),
    };
    if outline != Outline::Rectangle {
        let raster = raster(patch, plane, &cut, site);
        if outline == Outline::Other {
            (patch.area, patch.perimeter) = (raster.area, raster.perimeter);
        }
        patch.raster = Some(Arc::new(raster.raster));
    }
    cut.parts.into_iter().filter(|part| part.is_end && !part.is_open).collect()
}

/// Moves the patch to the middles of chords, and measures it along them.
fn centre_on_chords(patch: &mut Patch, plane: CutPlane, site: &Site<'_>) {
    let aside = plane.aside * plane.inwards;
    let axes = site.dimensions - 1;
    // A chord of a circle is a diameter only after the second axis has been centred.
    for round in 0..3 * axes {
        let axis = round % axes;
        let across = patch.across[axis];
        let reach = |direction: DVec3| exit(site.domain, patch.at + aside, direction, site.spacing);
        let (Some(up), Some(down)) = (reach(across), reach(-across)) else {
            continue;
        };
        // Rounding must not move a centred patch.
        let shift = 0.5 * (up - down);
        if shift.abs() > 1e-9 * (up + down) {
            patch.at += shift * across;
        }
        patch.half_extent[axis] = 0.5 * (up + down);
    }
}

/// Returns true if the rectangle of the chords is the bounding rectangle of the section.
fn chords_span(patch: &Patch, plane: CutPlane, cut: &Cut<'_>) -> bool {
    let [low, high] = cut.open_bounds();
    let centre = patch.at - plane.at;
    (0..2).filter(|&axis| patch.across[axis] != DVec3::ZERO).all(|axis| {
        let middle = centre.dot(patch.across[axis]);
        let [from, to] = [middle - patch.half_extent[axis], middle + patch.half_extent[axis]];
        (from - low[axis]).abs() < 1.5 * cut.cell() && (to - high[axis]).abs() < 1.5 * cut.cell()
    })
}

/// Moves the patch to the middle of the bounding rectangle of the cut, and takes its size.
fn centre_on_cut(patch: &mut Patch, plane: CutPlane, cut: &Cut<'_>, site: &Site<'_>) {
    let [low, high] = cut.open_bounds();
    patch.at = plane.at;
    for axis in 0..site.dimensions - 1 {
        let edge = |from: f64, direction: f64| edge(cut, [low, high], axis, from, direction);
        let (from, to) = (edge(low[axis], -1.0), edge(high[axis], 1.0));
        patch.at += 0.5 * (from + to) * patch.across[axis];
        patch.half_extent[axis] = 0.5 * (to - from);
    }
}

/// Returns the offset of the edge of the open parts beyond their outermost cells along an axis, m.
fn edge(cut: &Cut<'_>, [low, high]: [[f64; 2]; 2], axis: usize, from: f64, direction: f64) -> f64 {
    let other = 1 - axis;
    let count = ((high[other] - low[other]) / cut.cell()).round() as usize;
    let is_open = |place: f64, across: usize| {
        let mut offset = [0.0; 2];
        offset[axis] = place;
        offset[other] = low[other] + across as f64 * cut.cell();
        cut.is_open(offset)
    };
    let exits = (0..=count).filter(|&across| is_open(from, across)).map(|across| {
        let step = 0.25 * cut.cell();
        let inside = |distance: f64| is_open(from + direction * distance, across);
        exit_distance(inside, step, 4.0 * cut.cell()).unwrap_or(0.0)
    });
    from + direction * exits.fold(0.0, f64::max)
}

/// Returns, for the sides across both directions, 1 if they are at walls and 0 if the section spans
/// a period between them.
fn wet_sides(patch: &Patch, site: &Site<'_>) -> [f64; 2] {
    std::array::from_fn(|axis| {
        let spans = (0..3).any(|direction| {
            let period = site.periodic[direction].map_or(0.0, |(low, high)| high - low);
            let width = 2.0 * patch.half_extent[axis];
            patch.across[axis][direction].abs() > 1.0 - 1e-9 && (period - width).abs() < 1e-6 * width
        });
        if spans { 0.0 } else { 1.0 }
    })
}

/// Shape of a section.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Outline {
    Rectangle,
    Disc,
    Other,
}

/// Returns the fraction of the bounding rectangle that belongs to the section, by 200 × 200
/// samples; 1 in 2D.
fn covered(patch: &Patch, plane: CutPlane, cut: &Cut<'_>, site: &Site<'_>) -> f64 {
    if site.dimensions == 2 {
        return 1.0;
    }
    let count = 200;
    let centre = [0, 1].map(|axis| (patch.at - plane.at).dot(patch.across[axis]));
    let mut inside = 0;
    for i in 0..count {
        for j in 0..count {
            let place = |index: i32| (f64::from(index) + 0.5) / f64::from(count) * 2.0 - 1.0;
            let offset =
                [centre[0] + place(i) * patch.half_extent[0], centre[1] + place(j) * patch.half_extent[1]];
            inside += i32::from(cut.is_open(offset));
        }
    }
    f64::from(inside) / f64::from(count * count)
}

fn outline(patch: &Patch, fraction: f64) -> Outline {
    let [a, b] = patch.half_extent;
    if fraction > 0.9999 {
        Outline::Rectangle
    } else if (fraction - std::f64::consts::FRAC_PI_4).abs() < 2e-3 && (a - b).abs() < 1e-3 * a {
        Outline::Disc
    } else {
        Outline::Other
    }
}

/// Raster of a section with its measures.
struct MeasuredRaster {
    raster: SectionRaster,
    /// Area, m² (length in m in 2D).
    area: f64,
    /// Perimeter, m (number of ends in 2D).
    perimeter: f64,
}

/// Width of a cell of a raster, in spacings, in 2D and 3D.
const RASTER_CELL: [f64; 2] = [1.0 / 64.0, 0.125];

/// Largest number of cells of a raster along a direction, in 2D and 3D.
const MOST_RASTER_CELLS: [f64; 2] = [1e6, 2000.0];

/// Number of samples along a direction of a cell at the edge of a section.
const EDGE_SAMPLES: usize = 8;

/// Returns the raster of the open parts of a cut, about the centre of the patch.
///
/// The area is the sum of the shares φ of the cells in the section, which are sampled for cells at
/// its edge. The perimeter is the total variation of φ, Σ |∇φ| w² with the width w of a cell.
fn raster(patch: &Patch, plane: CutPlane, cut: &Cut<'_>, site: &Site<'_>) -> MeasuredRaster {
    let axes = site.dimensions - 1;
    let longest = patch.half_extent[0].max(patch.half_extent[1]);
    let cell = (RASTER_CELL[axes - 1] * site.spacing).max(2.0 * longest / MOST_RASTER_CELLS[axes - 1]);
    // With a margin for the edge.
    let counts = [0, 1]
        .map(|axis| if axis < axes { (2.0 * patch.half_extent[axis] / cell).ceil() as usize + 4 } else { 1 });
    let centre = [0, 1].map(|axis| (patch.at - plane.at).dot(patch.across[axis]));
    let offset = |index: usize| -> [f64; 2] {
        let place = [index % counts[0], index / counts[0]];
        std::array::from_fn(|axis| {
            centre[axis] + (place[axis] as f64 - 0.5 * (counts[axis] as f64 - 1.0)) * cell
        })
    };
    let cells: Vec<bool> =
        (0..counts[0] * counts[1]).into_par_iter().map(|at| cut.is_open(offset(at))).collect();
    // Cells are their own neighbours at the edge of the raster, outside the section.
    let next = |at: usize, axis: usize| {
        let (stride, place) = if axis == 0 { (1, at % counts[0]) } else { (counts[0], at / counts[0]) };
        [if place > 0 { at - stride } else { at }, if place + 1 < counts[axis] { at + stride } else { at }]
    };
    let is_edge = |at: usize| {
        let rows = next(at, 1);
        let around = [rows[0], at, rows[1]].map(|row| next(row, 0));
        let differs = |other: usize| cells[other] != cells[at];
        rows.into_iter().any(differs) || around.into_iter().flatten().any(differs)
    };
    let share = |at: usize| {
        if !is_edge(at) {
            return f64::from(u8::from(cells[at]));
        }
        let middle = offset(at);
        let count = if axes == 2 { EDGE_SAMPLES * EDGE_SAMPLES } else { EDGE_SAMPLES };
        let sample = |index: usize| {
            let place = [index % EDGE_SAMPLES, index / EDGE_SAMPLES];
            let aside = |axis: usize| ((place[axis] as f64 + 0.5) / EDGE_SAMPLES as f64 - 0.5) * cell;
            [middle[0] + aside(0), middle[1] + if axes == 2 { aside(1) } else { 0.0 }]
        };
        (0..count).filter(|&index| cut.is_open(sample(index))).count() as f64 / count as f64
    };
    let shares: Vec<f64> = (0..cells.len()).into_par_iter().map(share).collect();
    let size = cell.powi(axes as i32);
    let slope = |at: usize, axis: usize| {
        let [before, behind] = next(at, axis);
        (shares[behind] - shares[before]) / (2.0 * cell)
    };
    let area = shares.iter().sum::<f64>() * size;
    let perimeter = (0..cells.len()).map(|at| slope(at, 0).hypot(slope(at, 1))).sum::<f64>() * size;
    MeasuredRaster { raster: SectionRaster::new(cell, counts, &cells), area, perimeter }
}

/// Returns the section of the patch extruded out of the domain.
pub fn zone(
    domain: &Shape,
    patch: &Patch,
    outwards: DVec3,
    length: f64,
    spacing: f64,
    dimensions: usize,
) -> Shape {
    let [a, b] = patch.half_extent;
    let is_disc = (patch.area - PI * a * b).abs() < 1e-9 * patch.area;
    let outline = match &patch.raster {
        None => Outline::Rectangle,
        Some(_) if is_disc => Outline::Disc,
        Some(_) => Outline::Other,
    };
    match outline {
        Outline::Rectangle => {
            let [first, second] = patch.across;
            let third = if dimensions == 2 { DVec3::Z } else { second };
            let depth = if dimensions == 2 { f64::INFINITY } else { b };
            // The frame, x along `outwards`, is right-handed, so that the matrix is a rotation.
            let right_handed = outwards.cross(first).dot(third) > 0.0;
            let frame = DMat3::from_cols(outwards, if right_handed { first } else { -first }, third);
            Shape::Placed {
                shape: Box::new(Shape::Box {
                    min: DVec3::new(0.0, -a, -depth),
                    max: DVec3::new(length, a, depth),
                }),
                rotation: frame,
                scale: 1.0,
                origin: patch.at,
            }
        }
        Outline::Disc => {
            Shape::Cylinder { from: patch.at, to: patch.at + length * outwards, radius: 0.5 * (a + b) }
        }
        Outline::Other => Shape::Extension {
            shape: Box::new(domain.clone()),
            at: patch.at,
            outwards,
            length,
            inset: 2.0 * spacing,
            clip: patch.raster.clone().map(|raster| Clip { raster, across: patch.across }),
        },
    }
}
