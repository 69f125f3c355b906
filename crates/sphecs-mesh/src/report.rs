//! Report of what was read, changed and found in a surface.

use glam::DVec3;

/// Most openings that a report describes one by one.
const DESCRIBED: usize = 3;

/// Width of a seam as a share of its length, up to which it has no gap: the tolerance of welding.
const SEAM: f64 = 1e-6;

/// Connected edges that have one facet only: the border of an opening, or a seam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpenLoop {
    /// Length, m.
    pub length: f64,
    /// Area that the edges enclose, m²; about 0 for a seam between edges that are divided in
    /// different ways.
    pub area: f64,
    /// Mean position of the edges, m.
    pub centre: DVec3,
    /// Number of edges.
    pub edges: usize,
}

/// Counts of what was changed and found while a surface was made.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Facets in the files.
    pub facets: usize,
    /// Triangles of the surface.
    pub triangles: usize,
    /// Vertices of the surface.
    pub vertices: usize,
    /// Vertices merged into another within 1e-6 of the diagonal, without those at the same place.
    pub welded: usize,
    /// Dropped facets with two corners at the same place.
    pub degenerate: usize,
    /// Dropped facets that were in the files once more.
    pub duplicates: usize,
    /// Dropped facets that were in the files once more with the opposite normal.
    pub opposite: usize,
    /// Facets turned to agree with their neighbours.
    pub flipped: usize,
    /// Connected parts of the surface.
    pub components: usize,
    /// Components turned as a whole, since their normals pointed inwards.
    pub turned_components: usize,
    /// Closed components inside another, taken as cavities.
    pub cavities: usize,
    /// Edges at which the two facets cannot agree in orientation, as on a Möbius strip.
    pub one_sided_edges: usize,
    /// Edges with more than two facets.
    pub non_manifold_edges: usize,
    /// Openings, the longest first.
    pub open_loops: Vec<OpenLoop>,
}

impl Report {
    /// Returns true if every edge has two facets or more.
    pub fn is_closed(&self) -> bool {
        self.open_loops.is_empty()
    }

    /// Returns a sentence for the size of the surface and one for each kind of change.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = vec![format!(
            "has {} in {}",
            counted(self.triangles, "triangle", "triangles"),
            counted(self.components, "connected part", "connected parts"),
        )];
        let changes = [
            (self.welded, "vertex was", "vertices were", "merged with another within 1e-6 of the diagonal"),
            (self.degenerate, "facet without extent was", "facets without extent were", "dropped"),
            (self.duplicates, "facet was", "facets were", "in the files once more and dropped"),
            (self.opposite, "facet was", "facets were", "dropped for an equal one with the opposite normal"),
            (self.flipped, "facet was", "facets were", "turned to agree with its neighbours"),
            (
                self.turned_components,
                "connected part was",
                "connected parts were",
                "turned: its normals pointed into the solid",
            ),
            (
                self.cavities,
                "closed part is",
                "closed parts are",
                "inside another and taken as a cavity: unite solids in the CAD if it is not",
            ),
            (
                self.one_sided_edges,
                "edge has",
                "edges have",
                "facets that cannot agree on inside and outside: close the surface in the CAD",
            ),
            (
                self.non_manifold_edges,
                "edge has",
                "edges have",
                "more than two facets: parts touch there, or a sheet ends at the surface",
            ),
        ];
        for (count, one, many, rest) in changes {
            if count > 0 {
                lines.push(format!("{} {rest}", counted(count, one, many)));
            }
        }
        lines.extend(self.open_loops.iter().take(DESCRIBED).map(OpenLoop::line));
        if self.open_loops.len() > DESCRIBED {
            lines.push(format!("is open at {} more places", self.open_loops.len() - DESCRIBED));
        }
        lines
    }
}

impl OpenLoop {
    /// Returns the mean width, m: the distance of the sides of a slit, the radius of a round hole.
    pub fn width(&self) -> f64 {
        2.0 * self.area / self.length
    }

    /// Returns true for a seam without a gap, which does not change inside and outside.
    pub fn is_seam(&self) -> bool {
        self.width() <= SEAM * self.length
    }

    /// Returns a sentence with length and place.
    pub fn line(&self) -> String {
        let [x, y, z] = self.centre.to_array();
        let near = format!("along {:.2e} m near ({x:.3e}, {y:.3e}, {z:.3e}) m", self.length);
        let edges = counted(self.edges, "edge has", "edges have");
        if self.is_seam() {
            format!("has a seam without a gap {near}: {edges} one facet only, join its sides in the CAD")
        } else {
            format!(
                "is open {near}: {edges} one facet only, close the surface in the CAD or give the missing file"
            )
        }
    }
}

/// Returns a number with its noun.
pub(crate) fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}
