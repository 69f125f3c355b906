//! Checks of the meshes of a scene file, which make them shapes.

use std::sync::Arc;

use super::checker::Checker;
use crate::faults::Fault;
use crate::geometry::Shape;
use crate::meshes::{LengthUnit, MeshFile, MeshReport};
use crate::notation::tree::Span;
use crate::schema::Text;
use sphecs_core::format::{point, significant};
use sphecs_mesh::{OpenLoop, Part, Report, Surface};

/// Smallest of the largest extents of a mesh along the axes, in spacings: a thin plate is a shape,
/// too.
const SMALLEST: f64 = 3.0;

/// Largest extent of a mesh along an axis, in spacings.
const LARGEST: f64 = 2e4;

/// A surface with the paths of its files and its unit.
pub struct ReadSurface {
    paths: Vec<String>,
    unit: LengthUnit,
    surface: Arc<Surface>,
}

/// Returns the shape of a mesh at the place of its first file, or of its unit without one; None if
/// it has a fault.
pub fn mesh(
    (file, files): (Option<&Text>, Option<&Vec<Text>>),
    (unit, place): (LengthUnit, Span),
    check: &mut Checker<'_>,
) -> Option<Shape> {
    let paths: Vec<&Text> = file.into_iter().chain(files.into_iter().flatten()).collect();
    if file.is_some() == files.is_some() || paths.is_empty() {
        let label = "must be one `file`, or the list `files` of those that form the surface together";
        check.report(if paths.is_empty() {
            let label = "stands alone, must be beside the file: `file: \"pipe.stl\"`";
            Fault::new("a mesh has no file", place, label)
        } else {
            Fault::new("the files of a mesh are given twice", place, label)
        });
        return None;
    }
    let names: Vec<String> = paths.iter().map(|path| path.value.clone()).collect();
    if let Some(known) = check.surfaces.iter().find(|known| known.paths == names && known.unit == unit) {
        return Some(Shape::Mesh(known.surface.clone()));
    }
    let parts: Vec<Option<Part>> = paths.iter().map(|path| part(path, check)).collect();
    let parts: Vec<Part> = parts.into_iter().collect::<Option<_>>()?;
    let (surface, report) = match Surface::new(parts, unit.metres()) {
        Ok(made) => made,
        Err(fault) => {
            check.report(Fault::new("a mesh is no surface", paths[0].span, fault.to_string()));
            return None;
        }
    };
    let before = check.fault_count();
    let (low, high) = surface.bounds();
    extent("a mesh", &(high - low).to_array(), paths[0].span, check);
    openings(&report, paths[0].span, check);
    if check.fault_count() > before {
        return None;
    }
    let surface = Arc::new(surface);
    check.mesh_reports.push(mesh_report(&names, &surface, &report));
    check.surfaces.push(ReadSurface { paths: names, unit, surface: surface.clone() });
    Some(Shape::Mesh(surface))
}

/// Returns the bytes of a file, as saved with a run or else of the folder; `kind` is `mesh` or
/// `outline`.
pub fn file_bytes(path: &Text, kind: &str, check: &mut Checker<'_>) -> Option<Arc<[u8]>> {
    if let Some(known) = check.meshes.iter().find(|known| known.path == path.value) {
        return Some(known.bytes.clone());
    }
    match std::fs::read(check.folder.join(&path.value)) {
        Ok(bytes) => {
            let bytes: Arc<[u8]> = bytes.into();
            check.meshes.push(MeshFile { path: path.value.clone(), bytes: bytes.clone() });
            Some(bytes)
        }
        Err(error) => {
            let title = format!("{kind} `{}` cannot be read", path.value);
            check.report(
                Fault::new(title, path.span, error.to_string())
                    .help("the path is relative to the scene's folder"),
            );
            None
        }
    }
}

/// Returns the facets of a file.
fn part(path: &Text, check: &mut Checker<'_>) -> Option<Part> {
    if path.is_placeholder() {
        check.note_placeholder(path.span);
        return None;
    }
    let bytes = file_bytes(path, "mesh", check)?;
    let name = path.value.rsplit(['/', '\\']).next().unwrap_or_default();
    match sphecs_mesh::read(&bytes, name) {
        Ok(facets) => {
            let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
            Some(Part { name: stem.to_owned(), facets })
        }
        Err(fault) => {
            check.report(Fault::new("a mesh file has a fault", path.span, fault.to_string()));
            None
        }
    }
}

/// Reports a size (m along each axis, before a `Scaled` around it) that tells of a wrong unit;
/// `kind` is `a mesh` or `an outline`. Returns None for such a size.
pub fn extent(kind: &str, size: &[f64], place: Span, check: &mut Checker<'_>) -> Option<()> {
    let size: Vec<f64> = size.iter().map(|length| length * check.scale).collect();
    let longest = size.iter().copied().fold(0.0, f64::max) / check.spacing;
    if (SMALLEST..=LARGEST).contains(&longest) {
        return Some(());
    }
    let by = |unit: f64| {
        let lengths: Vec<String> = size.iter().map(|length| significant(length / unit)).collect();
        lengths.join(" by ")
    };
    let label = format!("is {} m, or {} spacings", by(1.0), by(check.spacing));
    check.report(
        Fault::new(format!("the size of {kind} does not fit the spacing"), place, label)
            .help(format!("must be {SMALLEST} to {LARGEST:.0e} spacings long: is the `unit` right?")),
    );
    None
}

/// Reports openings through which fluid particles would leave.
fn openings(report: &Report, place: Span, check: &mut Checker<'_>) {
    let is_wide = |opening: &&OpenLoop| !opening.is_seam() && opening.length > check.spacing;
    let wide: Vec<&OpenLoop> = report.open_loops.iter().filter(is_wide).collect();
    let Some(first) = wide.first() else { return };
    let label = format!(
        "is open along {} m near {} m, where {} edges have one facet{}",
        significant(first.length),
        point(&first.centre.to_array(), check.spacing),
        first.edges,
        match wide.len() {
            1 => String::new(),
            count => format!("; {} openings in all", count),
        }
    );
    check.report(
        Fault::new("a mesh is not closed", place, label)
            .help("close it in the CAD program, or give the file of the missing part in `files`"),
    );
}

fn mesh_report(names: &[String], surface: &Surface, report: &Report) -> MeshReport {
    let mut lines = report.lines();
    let (low, high) = surface.bounds();
    let size = high - low;
    let crossing = surface.intersections().line();
    let twice = if crossing.is_some() { ", in which parts that overlap count twice" } else { "" };
    lines.push(format!(
        "is {} by {} by {} m, with an area of {} m² and a volume of {} m³{twice}",
        significant(size.x),
        significant(size.y),
        significant(size.z),
        significant(surface.area()),
        significant(surface.volume())
    ));
    let small = report.open_loops.iter().find(|opening| !opening.is_seam()).map(OpenLoop::line);
    let notes = crossing.into_iter().chain(small).collect();
    MeshReport { name: names.join(", "), lines, notes }
}
