//! Regular grids onto which a run resamples the flow: the domain as a whole, and planes.
//!
//! ```text
//! x_i = x_low + (i + 1/2) Δ_x,   Δ_x = L_x/n_x,   n_x = L_x/spacing, rounded
//! ```
//!
//! Nodes are centres of cells that fill the box around the domain exactly. So no node lies on a
//! flat wall or twice in a period, and a sum over nodes times the volume of a cell is an integral.

use glam::DVec3;

use super::model::Scene;

/// Gridded fields of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldOutput {
    /// Wanted distance of the nodes, m.
    pub spacing: f64,
    /// Interval between the times that are written, s.
    pub every: f64,
    /// Interval of means and Reynolds stresses, s; None: no means.
    pub mean: Option<(f64, f64)>,
    /// Interval between the samples of the means, s; None: that of [`Scene::mean_interval`].
    pub mean_every: Option<f64>,
    /// True if the grid of the whole domain is written.
    pub volume: bool,
    /// Planes with grids of their own.
    pub planes: Vec<FieldPlane>,
}

/// Plane of a 3D scene with a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldPlane {
    /// Name, unique among the planes.
    pub name: String,
    /// A point of the plane, m.
    pub at: DVec3,
    /// Unit normal.
    pub normal: DVec3,
}

/// Axis of a grid.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct GridAxis {
    /// Name of its dimension: `x`, `y` or `z` along an axis of space; else `a` or `b`.
    pub name: String,
    /// Coordinate of the first node, m.
    pub first: f64,
    /// Distance of two nodes, m.
    pub spacing: f64,
    /// Number of nodes.
    pub count: usize,
    /// Unit vector along it.
    pub direction: DVec3,
}

impl GridAxis {
    /// Returns the coordinates of the nodes, m.
    pub fn coordinates(&self) -> Vec<f64> {
        (0..self.count).map(|node| self.first + node as f64 * self.spacing).collect()
    }

    /// Returns the axis whose cells fill the interval from `low` to `high`, m.
    fn over(name: &str, (low, high): (f64, f64), spacing: f64, direction: DVec3) -> Self {
        let cells = ((high - low) / spacing).round().max(1.0);
        let spacing = (high - low) / cells;
        Self { name: name.to_owned(), first: low + 0.5 * spacing, spacing, count: cells as usize, direction }
    }
}

/// Regular grid in the plane or in space.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct FieldGrid {
    /// Name of the plane; empty for the whole domain.
    pub name: String,
    /// Two or three axes, that along which the rows lie first.
    pub axes: Vec<GridAxis>,
    /// Point whose coordinates along all axes are 0, m.
    pub origin: DVec3,
}

impl FieldGrid {
    /// Returns the number of nodes.
    pub fn len(&self) -> usize {
        self.axes.iter().map(|axis| axis.count).product()
    }

    /// Returns true without nodes, which never happens.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the number of rows of nodes along the first axis.
    pub fn rows(&self) -> usize {
        self.axes[1..].iter().map(|axis| axis.count).product()
    }

    /// Returns the first node of a row, m.
    pub fn row_start(&self, mut row: usize) -> DVec3 {
        let mut point = self.origin + self.axes[0].first * self.axes[0].direction;
        for axis in &self.axes[1..] {
            let node = row % axis.count;
            row /= axis.count;
            point += (axis.first + node as f64 * axis.spacing) * axis.direction;
        }
        point
    }

    /// Returns the vector from a node to the next of its row, m.
    pub fn row_step(&self) -> DVec3 {
        self.axes[0].spacing * self.axes[0].direction
    }

    /// Returns the points of a row, m.
    pub fn row_points(&self, row: usize) -> impl Iterator<Item = DVec3> + '_ {
        let (start, step) = (self.row_start(row), self.row_step());
        (0..self.axes[0].count).map(move |node| start + node as f64 * step)
    }

    /// Returns true if all axes are axes of space.
    pub fn is_aligned(&self) -> bool {
        self.axes.iter().all(|axis| AXES.contains(&axis.name.as_str()))
    }
}

/// Names of the axes of space.
const AXES: [&str; 3] = ["x", "y", "z"];

/// Component of a normal above which the plane is across an axis of space.
const ALIGNED: f64 = 1.0 - 1e-9;

impl Scene {
    /// Returns true if the tags of the particles may differ.
    pub fn has_tags(&self) -> bool {
        self.initial.tag.constant().is_none()
    }

    /// Returns the grids of the gridded fields, that of the whole domain first.
    pub fn field_grids(&self) -> Vec<FieldGrid> {
        let Some(output) = &self.output.fields else { return Vec::new() };
        let whole = output.volume.then(|| self.whole_grid(output.spacing));
        whole
            .into_iter()
            .chain(output.planes.iter().filter_map(|plane| self.plane_grid(output, plane)))
            .collect()
    }

    /// Returns the grid of the whole domain with a distance of the nodes, m.
    pub fn whole_grid(&self, spacing: f64) -> FieldGrid {
        let (low, high) = self.field_box();
        let axis = |d: usize| GridAxis::over(AXES[d], (low[d], high[d]), spacing, DVec3::AXES[d]);
        FieldGrid { name: String::new(), axes: (0..self.dimensions).map(axis).collect(), origin: DVec3::ZERO }
    }

    /// Returns the grid of a plane; None if it misses the box around the domain.
    pub fn plane_grid(&self, output: &FieldOutput, plane: &FieldPlane) -> Option<FieldGrid> {
        let (low, high) = self.field_box();
        let across = (0..3).find(|&d| plane.normal[d].abs() > ALIGNED);
        if let Some(across) = across {
            if !(low[across]..=high[across]).contains(&plane.at[across]) {
                return None;
            }
            let axis = |d: usize| GridAxis::over(AXES[d], (low[d], high[d]), output.spacing, DVec3::AXES[d]);
            let axes = (0..3).filter(|&d| d != across).map(axis).collect();
            let origin = plane.at[across] * DVec3::AXES[across];
            return Some(FieldGrid { name: plane.name.clone(), axes, origin });
        }
        // The first axis is as near to x as it can be.
        let first = (DVec3::X - plane.normal.x * plane.normal).normalize();
        let second = plane.normal.cross(first);
        let (mut least, mut most) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for point in box_section((low, high), plane) {
            for (along, direction) in [first, second].into_iter().enumerate() {
                let offset = (point - plane.at).dot(direction);
                (least[along], most[along]) = (least[along].min(offset), most[along].max(offset));
            }
        }
        let axis = |name, along: usize, direction| {
            GridAxis::over(name, (least[along], most[along]), output.spacing, direction)
        };
        let is_cut = least[0] < most[0] && least[1] < most[1];
        let axes = || vec![axis("a", 0, first), axis("b", 1, second)];
        is_cut.then(|| FieldGrid { name: plane.name.clone(), axes: axes(), origin: plane.at })
    }

    /// Returns the box that the grids fill, m: that around the domain, a period, or the way of a
    /// domain that moves.
    fn field_box(&self) -> (DVec3, DVec3) {
        let (mut low, mut high) = self.domain.bounds();
        if let (Some(_), Some(swept)) = (&self.casing_motion, self.swept_box(0.0)) {
            (low, high) = (low.min(swept.0), high.max(swept.1));
        }
        for (axis, period) in self.periodic.iter().enumerate() {
            if let Some((from, to)) = period {
                (low[axis], high[axis]) = (*from, *to);
            }
        }
        (low, high)
    }

    /// Returns the interval between the samples of means on grids, s.
    ///
    /// Its default is the time in which the reference velocity passes half a cell. Structures of
    /// the flow are at least three particle spacings long, so that six samples or more resolve
    /// their passage.
    pub fn mean_interval(&self) -> f64 {
        let Some(output) = &self.output.fields else { return f64::INFINITY };
        output.mean_every.unwrap_or_else(|| self.sampling_interval(output.spacing.max(self.spacing)))
    }

    /// Returns the time in which the reference velocity passes half of a length in m, s.
    pub(crate) fn sampling_interval(&self, length: f64) -> f64 {
        let speed = self.reference_velocity.max(SLOWEST * self.fluid.sound_speed);
        CELLS_BETWEEN_SAMPLES * length / speed
    }
}

/// Way of the reference velocity between two samples of a mean, in cells.
const CELLS_BETWEEN_SAMPLES: f64 = 0.5;

/// Least velocity for that way, over the sound speed: a scene may have no reference.
const SLOWEST: f64 = 0.01;

/// Returns the points at which a plane cuts the edges of a box, m.
fn box_section((low, high): (DVec3, DVec3), plane: &FieldPlane) -> Vec<DVec3> {
    let corner = |bits: usize| {
        DVec3::from_array(std::array::from_fn(|d| if bits >> d & 1 == 0 { low[d] } else { high[d] }))
    };
    let mut found = Vec::new();
    for from in 0..8 {
        for axis in (0..3).filter(|axis| from >> axis & 1 == 0) {
            let ends = [corner(from), corner(from | 1 << axis)];
            let [a, b] = ends.map(|end| (end - plane.at).dot(plane.normal));
            if a * b <= 0.0 && a != b {
                found.push(ends[0].lerp(ends[1], a / (a - b)));
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn scene(name: &str, fields: &str) -> Scene {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(name);
        Scene::from_file(&path).set("output.fields", fields).load().expect("a scene")
    }

    #[test]
    fn cells_fill_the_box_of_the_domain() {
        let scene = scene("quickstart.ron", "(spacing: 3e-3)");
        let grids = scene.field_grids();
        let [x, y] = &grids[0].axes[..] else { panic!("two axes") };
        assert_eq!((x.count, y.count, grids[0].len(), grids[0].rows()), (67, 13, 871, 13));
        assert!((x.first - 0.5 * x.spacing).abs() < 1e-15 && (67.0 * x.spacing - 0.2).abs() < 1e-15);
        let last = grids[0].row_points(12).last().expect("a node");
        assert!((last - DVec3::new(0.2 - 0.5 * x.spacing, 0.02 - 0.5 * y.spacing, 0.0)).length() < 1e-12);
    }

    #[test]
    fn planes_are_cut_out_of_the_box_of_the_domain() {
        let planes = "(volume: false, planes: [(name: \"mid\", at: (0, 0, 0.1), normal: (0, 0, 2)), \
                      (name: \"cut\", at: (0.0, 0.0, 0.0), normal: (1, 1, 0))])";
        let scene = scene("duct3d.ron", planes);
        let grids = scene.field_grids();
        let (low, high) = scene.domain.bounds();
        assert_eq!(grids[0].axes.iter().map(|axis| axis.name.as_str()).collect::<Vec<_>>(), ["x", "y"]);
        assert!(grids[0].is_aligned() && !grids[1].is_aligned());
        for grid in &grids {
            for point in (0..grid.rows()).flat_map(|row| grid.row_points(row)) {
                assert!((point - 1e-9).cmple(high).all() || !grid.is_aligned());
                assert!((point + 1e-9).cmpge(low).all() || !grid.is_aligned());
            }
        }
        let normal = DVec3::new(1.0, 1.0, 0.0);
        assert!(grids[1].row_points(1).all(|point| point.dot(normal).abs() < 1e-12));
    }
}
