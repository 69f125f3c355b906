//! Repair of the facets of a surface. Every change is counted in the report.
//!
//! Order: degenerate facets, duplicates, orientation, openings. Holes are measured, not closed:
//! the winding number bridges short ones, and the caller refuses long ones.

pub(crate) mod duplicates;
pub(crate) mod edges;
mod nested;
pub(crate) mod openings;
pub(crate) mod orient;

use crate::report::Report;
use crate::triangulation::Triangulation;

/// Repairs welded triangles.
pub(crate) fn repair(mesh: &mut Triangulation, report: &mut Report) {
    duplicates::drop_degenerate(mesh, report);
    duplicates::drop_duplicates(mesh, report);
    mesh.drop_unused_vertices();
    orient::orient(mesh, report);
    openings::find_openings(mesh, report);
}
