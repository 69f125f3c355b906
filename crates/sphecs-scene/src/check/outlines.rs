//! Checks of the outlines of a scene file, which make them shapes.

use std::sync::Arc;

use super::checker::Checker;
use super::meshes::{extent, file_bytes};
use super::outline_points::{self, OutlinePoints, PointFault};
use crate::faults::Fault;
use crate::geometry::Shape;
use crate::geometry::outline::{Outline, is_flat};
use crate::meshes::{LengthUnit, MeshReport};
use crate::notation::tree::Span;
use crate::schema::Text;
use crate::text_file;
use sphecs_core::format::significant;

/// Most pairs of crossing edges that are listed.
const MOST_CROSSINGS: usize = 5;

/// An outline with the path of its file and its unit.
pub struct ReadOutline {
    path: String,
    unit: LengthUnit,
    /// None if its file has a fault, which was reported.
    outline: Option<Arc<Outline>>,
}

/// Returns the shape of an outline; None if it has a fault.
pub fn outline(file: &Text, unit: LengthUnit, check: &mut Checker<'_>) -> Option<Shape> {
    check.note_placeholder(file.span);
    if file.is_placeholder() {
        return None;
    }
    let is_known = |known: &&ReadOutline| known.path == file.value && known.unit == unit;
    let known = check.outlines.iter().find(is_known).map(|known| known.outline.clone());
    let outline = match known {
        Some(None) => {
            // Its fault was reported where the file was named first.
            check.note_placeholder(Span::PLACEHOLDER);
            None
        }
        Some(known) => known,
        None => {
            let outline = read(file, unit, check).map(Arc::new);
            check.outlines.push(ReadOutline { path: file.value.clone(), unit, outline: outline.clone() });
            outline
        }
    }?;
    let (low, high) = outline.bounds();
    extent("an outline", &(high - low).to_array(), file.span, check)?;
    Some(Shape::Outline(outline))
}

/// Returns the outline of a file.
fn read(file: &Text, unit: LengthUnit, check: &mut Checker<'_>) -> Option<Outline> {
    let bytes = file_bytes(file, "outline", check)?;
    let text = match text_file::decoded(bytes.to_vec()) {
        Ok(text) => text,
        Err(reason) => {
            let fault = Fault::new("an outline is not a text file", file.span, reason);
            check.report(fault.help("must have lines of x and y, as a CSV file has"));
            return None;
        }
    };
    let points = match outline_points::read(&text) {
        Ok(points) => points,
        Err(faults) => {
            for fault in faults {
                let label = fault.in_file(&file.value);
                check.report(Fault::new("the file of an outline has a fault", file.span, label));
            }
            return None;
        }
    };
    let scaled = points.loops.iter().map(|polyline| {
        let metres = |point: &glam::DVec2| *point * unit.metres();
        polyline.points.iter().map(metres).collect()
    });
    let outline = Outline::new(scaled.collect());
    let faults = faults_of(&outline, &points);
    for (title, fault) in &faults {
        check.report(Fault::new(*title, file.span, fault.in_file(&file.value)));
    }
    if !faults.is_empty() {
        return None;
    }
    check.mesh_reports.push(report(&file.value, &outline, &points));
    Some(outline)
}

/// Returns the faults of the polylines with their titles.
fn faults_of(outline: &Outline, read: &OutlinePoints) -> Vec<(&'static str, PointFault)> {
    let flat: Vec<_> = (outline.loops().iter().zip(&read.loops))
        .filter(|(points, _)| is_flat(points))
        .map(|(_, polyline)| {
            let text = "all points of the polyline that begins here are on a line, must enclose an area";
            ("an outline has no area", PointFault::new(polyline.lines[0], 1, text))
        })
        .collect();
    if !flat.is_empty() {
        return flat;
    }
    let crossings = outline.crossings(MOST_CROSSINGS).into_iter();
    crossings
        .map(|(one, other)| {
            let [(first, line), (second, _)] = [one, other].map(|edge| edge_text(outline, read, edge));
            let text = format!(
                "the edge {first} must not touch the edge {second}: put the points of each closed polyline \
                 in order around it, with a blank line between polylines"
            );
            ("an outline crosses itself", PointFault::new(line, 1, text))
        })
        .collect()
}

/// Returns the ends of an edge in the unit of the file with their lines, and the first line.
fn edge_text(outline: &Outline, read: &OutlinePoints, edge: usize) -> (String, usize) {
    let (polyline, index) = outline.place(edge);
    let polyline = &read.loops[polyline];
    let next = (index + 1) % polyline.points.len();
    let end = |index: usize| {
        let point = polyline.points[index];
        format!("({}, {}) in line {}", point.x, point.y, polyline.lines[index])
    };
    (format!("from {} to {}", end(index), end(next)), polyline.lines[index])
}

/// Returns the sentences on an outline.
fn report(path: &str, outline: &Outline, read: &OutlinePoints) -> MeshReport {
    let (low, high) = outline.bounds();
    let size = high - low;
    let count: usize = outline.loops().iter().map(Vec::len).sum();
    let (loops, holes) = (outline.loops().len(), outline.holes().iter().filter(|hole| **hole).count());
    let mut lines = vec![format!("has {count} points in {loops} closed polyline{}", plural(loops))];
    if holes > 0 {
        lines.push(format!("{holes} polyline{} inside another and taken as a hole", are(holes)));
    }
    if let Some(heading) = &read.heading {
        lines.push(format!("`{heading}` is taken as its heading"));
    }
    if read.repeated > 0 {
        lines.push(format!("{} point{} repeated and dropped", read.repeated, were(read.repeated)));
    }
    lines.push(format!(
        "is {} by {} m, with an area of {} m²",
        significant(size.x),
        significant(size.y),
        significant(outline.area())
    ));
    MeshReport { name: path.to_owned(), lines, notes: Vec::new() }
}

fn plural(count: usize) -> &'static str {
    if count == 1 { "" } else { "s" }
}

fn are(count: usize) -> &'static str {
    if count == 1 { " is" } else { "s are" }
}

fn were(count: usize) -> &'static str {
    if count == 1 { " was" } else { "s were" }
}
