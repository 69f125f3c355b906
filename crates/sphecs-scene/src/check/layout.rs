//! Checks of the periodic directions and the fill.

use glam::{DMat3, DVec3};

use super::checker::Checker;
use super::patches::Site;
use super::shapes;
use crate::faults::{Fault, advice};
use crate::geometry::Shape;
use crate::lattice::Lattice;
use crate::lattice_rotation::rotation_to_walls;
use crate::model::{Fill, Patch};
use crate::notation::typed::Spanned;
use crate::schema::{FillFile, Number, Text, Vector};
use sphecs_core::format::point;

const AXES: [&str; 3] = ["x", "y", "z"];

/// Relative tolerance of a period that must be a whole number of spacings.
const WHOLE: f64 = 1e-6;

/// Largest jitter, in spacings, which keeps neighbours more than half a spacing apart.
const MOST_JITTER: f64 = 0.2;

/// Returns the bounds of the periodic directions, m.
pub fn periodic(
    names: &[Text],
    (domain, spacing): (&Shape, f64),
    is_valid: bool,
    check: &mut Checker<'_>,
) -> [Option<(f64, f64)>; 3] {
    let mut periodic = [None; 3];
    let (low, high) = domain.bounds();
    for name in names {
        let axes = &AXES[..check.dimensions];
        let Some(axis) = axes.iter().position(|axis| *axis == name.value) else {
            check.report(
                Fault::new(
                    format!("`{}` is not an axis of the scene", name.value),
                    name.span,
                    "must be the name of an axis in quotes",
                )
                .help(advice(&name.value, axes.iter().copied())),
            );
            continue;
        };
        if periodic[axis].is_some() {
            let label = "must be named once";
            check.report(Fault::new("a periodic axis is named twice", name.span, label));
        }
        periodic[axis] = Some((low[axis], high[axis]));
        if !is_valid {
            continue;
        }
        let period = high[axis] - low[axis];
        let cells = period / spacing;
        if (cells - cells.round()).abs() > WHOLE * cells.max(1.0) || cells < 1.0 {
            let whole = cells.round().max(1.0);
            check.report(
                Fault::new(
                    format!("the period along {} is not a whole number of spacings", name.value),
                    name.span,
                    format!("is `{period}` m, that is {cells:.3} spacings"),
                )
                .help(format!("`spacing: {:e}` fits {whole} times", period / whole)),
            );
        }
        if let Some(at) = mismatch(domain, axis, spacing, check.dimensions) {
            check.report(Fault::new(
                format!("the domain's two faces across {} do not match", name.value),
                name.span,
                format!(
                    "at {} m one side is open and the other is not",
                    point(&at.to_array()[..check.dimensions], spacing)
                ),
            ));
        }
    }
    periodic
}

/// Returns a point at which the faces of the domain across a periodic axis differ, m, from samples
/// just inside both.
fn mismatch(domain: &Shape, axis: usize, spacing: f64, dimensions: usize) -> Option<glam::DVec3> {
    let (low, high) = domain.bounds();
    let offset = 1e-3 * spacing;
    let others: Vec<usize> = (0..dimensions).filter(|other| *other != axis).collect();
    let count = if others.len() == 1 { 1000_usize } else { 50 };
    for index in 0..count.pow(others.len() as u32) {
        let mut point = glam::DVec3::ZERO;
        for (place, &other) in others.iter().enumerate() {
            let along = (index / count.pow(place as u32) % count) as f64 + 0.5;
            point[other] = low[other] + along * (high[other] - low[other]) / count as f64;
        }
        let (mut first, mut last) = (point, point);
        first[axis] = low[axis] + offset;
        last[axis] = high[axis] - offset;
        let (a, b) = (domain.signed_distance(first), domain.signed_distance(last));
        // Near an edge of the face the offset of the samples could make a difference.
        if (a <= 0.0) != (b <= 0.0) && a.abs().max(b.abs()) > 2.0 * offset {
            return Some(first);
        }
    }
    None
}

/// Reports a lattice that does not fit into a period, since its axes are turned from it.
fn keeps_periods(rotation: DMat3, file: &Spanned<FillFile>, site: &Site<'_>, check: &mut Checker<'_>) {
    for (axis, name) in AXES.iter().enumerate() {
        if site.periodic[axis].is_some() && rotation.col(axis) != DVec3::AXES[axis] {
            check.report(
                Fault::new(
                    format!("the lattice is turned away from the periodic axis {name}"),
                    file.head,
                    format!("must keep an axis along {name}, so that the rows meet across the period"),
                )
                .help("leave `angle` out"),
            );
        }
    }
}

/// Returns the lattice with a rotation and an anchor, or those that serve the walls if there are
/// any.
fn lattice(
    (rotation, anchor): (Option<DMat3>, Option<DVec3>),
    site: &Site<'_>,
    patches: &[&Patch],
    walled: bool,
) -> Lattice {
    let &Site { domain, periodic, spacing, dimensions, .. } = site;
    let fitted = |rotation| {
        Lattice::turned_and_fitted(rotation, domain, patches, periodic, spacing, anchor, dimensions)
    };
    let lattice = fitted(rotation.unwrap_or(DMat3::IDENTITY));
    // The tangents of round walls count as planes of less than a spacing or two.
    let least = 4.0 * spacing.powi(dimensions as i32 - 1);
    let lies_along_axes = lattice.fits.iter().any(|wall| wall.area > least);
    if rotation.is_some() || !walled || lies_along_axes {
        return lattice;
    }
    let rotation = rotation_to_walls(domain, patches, periodic, spacing, dimensions);
    if rotation == DMat3::IDENTITY { lattice } else { fitted(rotation) }
}

/// Returns the rotation and the anchor of a lattice, where they are given.
fn axes(
    (angle, axis, anchor): (&Option<Number>, &Option<Vector>, &Option<Vector>),
    file: &Spanned<FillFile>,
    site: &Site<'_>,
    check: &mut Checker<'_>,
) -> (Option<DMat3>, Option<DVec3>) {
    let rotation = angle.as_ref().map(|angle| shapes::rotation(angle, axis.as_ref(), check));
    if let Some(rotation) = rotation {
        keeps_periods(rotation, file, site, check);
    } else if let Some(axis) = axis {
        let label = "must come with an `angle`";
        check.report(Fault::new("the lattice has an axis but no angle", axis.span, label));
    }
    (rotation, anchor.as_ref().map(|anchor| check.vector(anchor, "m")))
}

/// Returns the arrangement of particles, its lattice turned to the walls if there are any; None if
/// it has a fault.
pub fn fill(
    (file, walled): (Option<&Spanned<FillFile>>, bool),
    site: &Site<'_>,
    patches: &[&Patch],
    check: &mut Checker<'_>,
) -> Option<Fill> {
    let lattice = |rotation, anchor| lattice((rotation, anchor), site, patches, walled);
    let Some(file) = file else {
        return Some(Fill::Lattice(lattice(None, None)));
    };
    match &file.value {
        FillFile::Packed { angle, axis, anchor } => {
            let before = check.fault_count();
            let (rotation, anchor) = axes((angle, axis, anchor), file, site, check);
            (check.fault_count() == before).then(|| Fill::Packed(lattice(rotation, anchor)))
        }
        FillFile::Lattice { angle, axis, anchor, jitter } => {
            let before = check.fault_count();
            let (rotation, anchor) = axes((angle, axis, anchor), file, site, check);
            let jitter = jitter.as_ref().map_or(0.0, |jitter| {
                if !(0.0..=MOST_JITTER).contains(&jitter.value) {
                    let label = format!("is `{}` spacings, must be from 0 to {MOST_JITTER}", jitter.value);
                    check.report(Fault::new("the jitter of the lattice is out of range", jitter.span, label));
                }
                jitter.value
            });
            (check.fault_count() == before)
                .then(|| Fill::Lattice(Lattice { jitter, ..lattice(rotation, anchor) }))
        }
        FillFile::WallFitted { lower, upper } => {
            let (low, high) = (check.formula(lower), check.formula(upper));
            if site.dimensions != 2 || site.periodic.iter().any(Option::is_some) {
                check.report(
                    Fault::new(
                        "`WallFitted` is for open channels in 2D",
                        file.head,
                        "must be `Lattice()` in 3D and with periodic directions",
                    )
                    .help("leave `fill` out"),
                );
                return None;
            }
            let (from, to) = site.domain.bounds();
            let samples = 200;
            let mut mean = 0.0;
            for index in 0..=samples {
                let x = from.x + (to.x - from.x) * f64::from(index) / f64::from(samples);
                let width = high.value(x, 0.0, 0.0, 0.0) - low.value(x, 0.0, 0.0, 0.0);
                if width.is_nan() || width < site.spacing {
                    check.report(Fault::new(
                        "the channel of `WallFitted` is narrower than a spacing",
                        file.head,
                        format!("at x = `{x}` m it is `{width}` m wide"),
                    ));
                    return None;
                }
                mean += width / f64::from(samples + 1);
            }
            Some(Fill::WallFitted {
                lower: low,
                upper: high,
                rows: (mean / site.spacing).round().max(1.0) as usize,
            })
        }
    }
}
