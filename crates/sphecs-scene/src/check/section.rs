//! Section of a patch: axes, size, outline, and the zone extruded from it.

use glam::{DMat3, DVec3};

use super::patches::Site;
use crate::geometry::Shape;
use crate::geometry::measure::exit_distance;
use crate::model::Patch;

/// Returns the unit vectors that span the plane, y and z for a flow along x; the second is zero in
/// 2D.
pub fn across(towards: DVec3, dimensions: usize) -> [DVec3; 2] {
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
    [first, towards.cross(first)]
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
pub fn measure(patch: &mut Patch, inwards: DVec3, site: &Site<'_>) {
    let aside = 1e-3 * site.spacing * inwards;
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
    patch.area = match site.dimensions {
        2 => 2.0 * patch.half_extent[0],
        _ => area(patch, aside, site),
    };
}

/// Outline of a section in 3D.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Outline {
    Rectangle,
    Disc,
    Other,
}

/// Returns the fraction of the bounding rectangle that belongs to the section, by 200 × 200
/// samples.
fn covered(patch: &Patch, aside: DVec3, domain: &Shape) -> f64 {
    let count = 200;
    let mut inside = 0;
    for i in 0..count {
        for j in 0..count {
            let place = |index: i32| (f64::from(index) + 0.5) / f64::from(count) * 2.0 - 1.0;
            let point = patch.at
                + aside
                + place(i) * patch.half_extent[0] * patch.across[0]
                + place(j) * patch.half_extent[1] * patch.across[1];
            inside += i32::from(domain.contains(point, 0.0));
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

fn area(patch: &Patch, aside: DVec3, site: &Site<'_>) -> f64 {
    let [a, b] = patch.half_extent;
    let fraction = covered(patch, aside, site.domain);
    match outline(patch, fraction) {
        Outline::Rectangle => 4.0 * a * b,
        Outline::Disc => std::f64::consts::PI * a * b,
        Outline::Other => 4.0 * a * b * fraction,
    }
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
    let aside = -1e-3 * spacing * outwards;
    let outline = match dimensions {
        2 => Outline::Rectangle,
        _ => outline(patch, covered(patch, aside, domain)),
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
        },
    }
}
