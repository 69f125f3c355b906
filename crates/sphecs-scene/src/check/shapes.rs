//! Checks of the shapes of a scene file, which make them signed distances.

use glam::{DMat3, DVec2, DVec3};

use super::checker::Checker;
use super::meshes;
use super::outlines;
use crate::faults::Fault;
use crate::geometry::Shape;
use crate::geometry::bend::{Bend, BendSection};
use crate::geometry::polygon;
use crate::meshes::LengthUnit;
use crate::notation::tree::Span;
use crate::notation::typed::Spanned;
use crate::schema::{BendSectionFile, Number, ShapeFile, Vector};

/// Returns a shape; None if a fault prevents it.
pub fn shape(file: &ShapeFile, check: &mut Checker<'_>) -> Option<Shape> {
    let before = check.fault_count();
    let shape = built(file, check);
    shape.filter(|_| check.fault_count() == before)
}

fn built(file: &ShapeFile, check: &mut Checker<'_>) -> Option<Shape> {
    match file {
        ShapeFile::Box { min, max } => cuboid(min, max, check),
        ShapeFile::Circle { center, radius } => {
            needs(2, "Circle", "`Sphere`, or `Cylinder` for a pipe", center.span, check)?;
            ball(center, radius, check)
        }
        ShapeFile::Sphere { center, radius } => {
            needs(3, "Sphere", "`Circle`", center.span, check)?;
            ball(center, radius, check)
        }
        ShapeFile::Cylinder { from, to, radius } => {
            needs(3, "Cylinder", "`Circle`", from.span, check)?;
            let (a, b) = (check.vector(from, "m"), check.vector(to, "m"));
            let radius = check.positive(radius, "m");
            if a == b {
                check.report(Fault::new("a cylinder has no length", to.span, "must differ from `from`"));
            }
            Some(Shape::Cylinder { from: a, to: b, radius })
        }
        ShapeFile::Polygon { points } => {
            needs(2, "Polygon", "`Extruded`", points.head, check)?;
            prism(points, f64::NEG_INFINITY, f64::INFINITY, check)
        }
        ShapeFile::Extruded { points, from, to } => {
            needs(3, "Extruded", "`Polygon`", points.head, check)?;
            let (low, high) = (check.finite(from, "m"), check.finite(to, "m"));
            if low >= high {
                check.report(Fault::new(
                    "an extruded polygon has no height",
                    to.span,
                    format!("is `{high}` m, must be greater than `from`, `{low}` m"),
                ));
            }
            prism(points, low, high, check)
        }
        ShapeFile::Mesh { file, files, unit } => {
            let first = file.iter().chain(files.iter().flatten()).next();
            let place = first.map_or(unit.span, |path| path.span);
            needs(3, "Mesh", "`Outline` for points in a file, or `Polygon`", place, check)?;
            meshes::mesh((file.as_ref(), files.as_ref()), (length_unit(unit, check)?, place), check)
        }
        ShapeFile::Outline { file, unit } => {
            needs(2, "Outline", "`Mesh`, or `Extruded`", file.span, check)?;
            outlines::outline(file, length_unit(unit, check)?, check)
        }
        ShapeFile::Bend { start, direction, center, angle, section } => {
            bend([start, direction, center], angle, section, check)
        }
        ShapeFile::Union(shapes) => Some(Shape::Union(all(shapes, check)?)),
        ShapeFile::Intersection(shapes) => Some(Shape::Intersection(all(shapes, check)?)),
        ShapeFile::Difference(shapes) => {
            let mut shapes = all(shapes, check)?;
            let first = shapes.remove(0);
            let holes = match shapes.len() {
                0 => return Some(first),
                1 => shapes.remove(0),
                _ => Shape::Union(shapes),
            };
            Some(Shape::Difference(Box::new(first), Box::new(holes)))
        }
        ShapeFile::Translated { by, shape } => {
            let by = check.vector(by, "m");
            placed(shape, DMat3::IDENTITY, 1.0, by, check)
        }
        ShapeFile::Rotated { angle, axis, about, shape } => {
            let rotation = rotation(angle, axis.as_ref(), check);
            let about = about.as_ref().map_or(DVec3::ZERO, |about| check.vector(about, "m"));
            placed(shape, rotation, 1.0, about - rotation * about, check)
        }
        ShapeFile::Scaled { factor, shape } => {
            let factor = check.positive(factor, "");
            let around = check.scale;
            check.scale *= factor;
            let shape = placed(shape, DMat3::IDENTITY, factor, DVec3::ZERO, check);
            check.scale = around;
            shape
        }
    }
}

/// Returns a rotation by an angle (°) about an axis, about z in 2D; quarter turns are exact.
pub fn rotation(angle: &Number, axis: Option<&Vector>, check: &mut Checker<'_>) -> DMat3 {
    let angle = check.finite(angle, "°").to_radians();
    let axis = check.axis(axis);
    let clean = |c: f64| {
        if (c - c.round()).abs() < 1e-15 { c.round() } else { c }
    };
    DMat3::from_cols_array(&DMat3::from_axis_angle(axis, angle).to_cols_array().map(clean))
}

/// Returns the unit of the coordinates in a file; None if it is missing.
fn length_unit(unit: &Spanned<LengthUnit>, check: &mut Checker<'_>) -> Option<LengthUnit> {
    check.note_placeholder(unit.span);
    (!unit.is_placeholder()).then_some(unit.value)
}

fn needs(dimensions: usize, name: &str, other: &str, place: Span, check: &mut Checker<'_>) -> Option<()> {
    if check.dimensions == dimensions {
        return Some(());
    }
    check.report(
        Fault::new(
            format!("`{name}` needs {dimensions} dimensions"),
            place,
            format!("the scene has `dimensions: {}`", check.dimensions),
        )
        .help(format!("use {other}")),
    );
    None
}

fn all(files: &Spanned<Vec<ShapeFile>>, check: &mut Checker<'_>) -> Option<Vec<Shape>> {
    check.note_placeholder(files.span);
    if files.value.is_empty() {
        check.report(Fault::new("a shape is made of no shapes", files.span, "must hold at least one"));
    }
    let shapes: Vec<Option<Shape>> = files.value.iter().map(|file| built(file, check)).collect();
    let shapes: Option<Vec<Shape>> = shapes.into_iter().collect();
    shapes.filter(|shapes| !shapes.is_empty())
}

fn placed(
    file: &ShapeFile,
    rotation: DMat3,
    scale: f64,
    origin: DVec3,
    check: &mut Checker<'_>,
) -> Option<Shape> {
    Some(Shape::Placed { shape: Box::new(built(file, check)?), rotation, scale, origin })
}

fn cuboid(min: &Vector, max: &Vector, check: &mut Checker<'_>) -> Option<Shape> {
    let before = check.fault_count();
    let (mut low, mut high) = (check.vector(min, "m"), check.vector(max, "m"));
    if check.fault_count() > before {
        return None;
    }
    for axis in 0..check.dimensions {
        if low[axis] >= high[axis] {
            let name = ["x", "y", "z"][axis];
            check.report(Fault::new(
                format!("a box has no extent along {name}"),
                max.span,
                format!(
                    "{name} is `{}` m, must be greater than {name} of `min`, `{}` m",
                    high[axis], low[axis]
                ),
            ));
        }
    }
    if check.dimensions == 2 {
        low.z = f64::NEG_INFINITY;
        high.z = f64::INFINITY;
    }
    Some(Shape::Box { min: low, max: high })
}

fn ball(center: &Vector, radius: &Number, check: &mut Checker<'_>) -> Option<Shape> {
    Some(Shape::Ball { center: check.vector(center, "m"), radius: check.positive(radius, "m") })
}

fn prism(points: &Spanned<Vec<Vector>>, from: f64, to: f64, check: &mut Checker<'_>) -> Option<Shape> {
    check.note_placeholder(points.span);
    let before = check.fault_count();
    let corners: Vec<DVec2> =
        points.value.iter().map(|point| check.components_of(point, 2, "m").truncate()).collect();
    if check.fault_count() > before {
        return None;
    }
    if corners.len() < 3 {
        let label = format!("has {} corners, must have at least 3", corners.len());
        check.report(Fault::new("a polygon has no area", points.head, label));
        return None;
    }
    for (index, corner) in corners.iter().enumerate() {
        if *corner == corners[(index + 1) % corners.len()] {
            check.report(Fault::new(
                "a corner of a polygon is given twice in a row",
                points.value[index].span,
                "must differ from the next corner",
            ));
            return None;
        }
    }
    if let Some((a, b)) = polygon::crossing_edges(&corners) {
        check.report(Fault::new(
            "a polygon crosses itself",
            points.value[b].span,
            format!("the edges from corners {a} and {b} (counted from 0) must not touch"),
        ));
    } else if polygon::signed_area(&corners) == 0.0 {
        check.report(Fault::new("a polygon has no area", points.head, "all corners are on a line"));
    }
    Some(Shape::Prism { points: corners, from, to })
}

fn bend(
    [start, direction, center]: [&Vector; 3],
    angle: &Number,
    section: &BendSectionFile,
    check: &mut Checker<'_>,
) -> Option<Shape> {
    needs(3, "Bend", "`Polygon`", start.span, check)?;
    let (from, middle) = (check.vector(start, "m"), check.vector(center, "m"));
    let along = check.direction(direction);
    let degrees = check.fraction(angle, 180.0);
    let arm = from - middle;
    let radius = arm.length();
    if radius == 0.0 || arm.dot(along).abs() > 1e-6 * radius {
        check.report(Fault::new(
            "a bend does not begin along its arc",
            direction.span,
            "must be perpendicular to the line from `center` to `start`",
        ));
        return None;
    }
    let section = match section {
        BendSectionFile::Circular { radius } => BendSection::Circular(check.positive(radius, "m")),
        BendSectionFile::Rectangular { width, height } => {
            BendSection::Rectangular(check.positive(width, "m") / 2.0, check.positive(height, "m") / 2.0)
        }
    };
    if section.half_width() >= radius {
        check.report(Fault::new(
            "a bend is tighter than its section",
            center.span,
            format!(
                "is `{radius}` m from `start`, must be more than half the width, `{}` m",
                section.half_width()
            ),
        ));
    }
    Some(Shape::Bend(Bend {
        center: middle,
        outwards: arm / radius,
        direction: along,
        radius,
        angle: degrees.to_radians(),
        section,
    }))
}
