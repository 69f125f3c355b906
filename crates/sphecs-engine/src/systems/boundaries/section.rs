//! Points that stand for the section of an opening: about a spacing apart, with their neighbours.

use glam::DVec3;

use sphecs_scene::model::{Patch, Scene};

/// Points of a section.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SectionPoints {
    /// Offsets of the points from the middle of the section, m.
    pub offsets: Vec<DVec3>,
    /// The points before and behind each one along both directions; a point at a wall is its own.
    pub neighbours: Vec<[u32; 4]>,
    /// From one point to the next along both directions, m; infinite in the second in 2D.
    pub spacing: [f64; 2],
    /// Whether the section is as wide as a period, in both directions.
    periodic: [bool; 2],
    /// Points of the bounding rectangle along both directions.
    counts: [usize; 2],
    /// The nearest point of the section to each point of the rectangle.
    nearest: Vec<u32>,
}

impl SectionPoints {
    /// The points of a patch of a scene.
    pub fn new(scene: &Scene, patch: &Patch) -> Self {
        let axes = scene.dimensions - 1;
        let mut section = Self { spacing: [f64::INFINITY; 2], counts: [1; 2], ..Self::default() };
        for axis in 0..axes {
            let width = 2.0 * patch.half_extent[axis];
            let count = (width / scene.spacing).round().max(1.0);
            section.counts[axis] = count as usize;
            section.spacing[axis] = width / count;
            section.periodic[axis] = (0..3).any(|direction| {
                let period = scene.periodic[direction].map_or(0.0, |(low, high)| high - low);
                patch.across[axis][direction].abs() > 1.0 - 1e-9 && (period - width).abs() < 1e-6 * width
            });
        }
        let rectangle: Vec<DVec3> = (0..section.counts[0] * section.counts[1])
            .map(|cell| {
                let [i, j] = [cell % section.counts[0], cell / section.counts[0]];
                let place = |index: usize, axis: usize| {
                    (index as f64 + 0.5) * section.spacing[axis] - patch.half_extent[axis]
                };
                let second = if axes == 2 { place(j, 1) } else { 0.0 };
                place(i, 0) * patch.across[0] + second * patch.across[1]
            })
            .collect();
        let inside = |offset: DVec3| {
            let before = patch.at - 1e-3 * scene.spacing * patch.towards;
            scene.domain.contains(before + offset, 0.0)
        };
        let cells: Vec<usize> = (0..rectangle.len()).filter(|&cell| inside(rectangle[cell])).collect();
        section.offsets = cells.iter().map(|&cell| rectangle[cell]).collect();
        section.nearest = (0..rectangle.len())
            .map(|cell| {
                if let Ok(point) = cells.binary_search(&cell) {
                    return point as u32;
                }
                let place = &rectangle[cell];
                let distance = |point: &usize| section.offsets[*point].distance_squared(*place);
                let points = 0..section.offsets.len();
                points.min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0) as u32
            })
            .collect();
        section.neighbours = (0..cells.len()).map(|point| section.around(&cells, point)).collect();
        section
    }

    /// The neighbours of a point.
    fn around(&self, cells: &[usize], point: usize) -> [u32; 4] {
        let cell = cells[point];
        let place = [cell % self.counts[0], cell / self.counts[0]];
        std::array::from_fn(|side| {
            let axis = side / 2;
            let step = if side % 2 == 0 { -1 } else { 1 };
            let mut next = place;
            next[axis] = self.index(place[axis] as i64 + step, axis);
            let next = next[0] + self.counts[0] * next[1];
            cells.binary_search(&next).unwrap_or(point) as u32
        })
    }

    /// Index along an axis: gone round where the section is periodic, else the last.
    fn index(&self, index: i64, axis: usize) -> usize {
        let count = self.counts[axis] as i64;
        let inside = if self.periodic[axis] { index.rem_euclid(count) } else { index.clamp(0, count - 1) };
        inside as usize
    }

    /// Where an offset from the middle of the section (m) is among the points.
    pub fn place(&self, patch: &Patch, offset: DVec3) -> PlaceAmongPoints {
        let mut low = [[0; 2]; 2];
        let mut share = [0.0; 2];
        for axis in 0..2 {
            if self.spacing[axis].is_infinite() {
                continue;
            }
            let place = (offset.dot(patch.across[axis]) + patch.half_extent[axis]) / self.spacing[axis] - 0.5;
            let below = place.floor();
            share[axis] = place - below;
            low[axis] = [self.index(below as i64, axis), self.index(below as i64 + 1, axis)];
        }
        let point = |i: usize, j: usize| self.nearest[low[0][i] + self.counts[0] * low[1][j]];
        PlaceAmongPoints { points: [[point(0, 0), point(1, 0)], [point(0, 1), point(1, 1)]], share }
    }
}

/// A place between points of a section: found once, it serves all fields.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaceAmongPoints {
    /// The points around it: of the lower and the higher row, the lower and the higher of each.
    points: [[u32; 2]; 2],
    /// How far it is from the lower ones to the higher, within the rows and from row to row.
    share: [f64; 2],
}

impl PlaceAmongPoints {
    /// The value of a field there, linear between the points.
    pub fn interpolate(&self, values: &[f64]) -> f64 {
        let along = |[low, high]: [u32; 2]| {
            let low = values[low as usize];
            low + self.share[0] * (values[high as usize] - low)
        };
        let lower = along(self.points[0]);
        if self.share[1] == 0.0 { lower } else { lower + self.share[1] * (along(self.points[1]) - lower) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(extra: &str) -> (SectionPoints, Patch) {
        let text = format!(
            "Scene(title: \"t\", spacing: 0.1, smoke: 0.2, fluid: (density: 1000.0, viscosity: 1.0e-3, sound_speed: 10.0),
                {extra} time: (end: 1.0), output: (every: 0.1))"
        );
        match Scene::from_text("openings", &text).load() {
            Ok(scene) => {
                let patch = scene.outlets[0].patch.clone();
                (SectionPoints::new(&scene, &patch), patch)
            }
            Err(faults) => panic!("{:?}", miette::Report::new(faults)),
        }
    }

    const CHANNEL: &str = "dimensions: 2, domain: Box(min: (0.0, -0.5), max: (2.0, 0.5)),
        outlets: [(at: (2.0, 0.0), towards: (1.0, 0.0), condition: WaveEquation())],
        inlets: [(at: (0.0, 0.0), towards: (1.0, 0.0), velocity: Normal(1.0))],";

    #[test]
    fn a_section_ends_at_walls_and_goes_round_a_period() {
        let (walled, patch) = points(CHANNEL);
        assert_eq!(walled.offsets.len(), 10);
        assert_eq!(walled.neighbours[0], [0, 1, 0, 0]);
        assert_eq!(walled.neighbours[9], [8, 9, 9, 9]);
        let heights: Vec<f64> = walled.offsets.iter().map(|offset| offset.y).collect();
        let middle = walled.place(&patch, DVec3::Y * 0.123).interpolate(&heights);
        assert!((middle - 0.123).abs() < 1e-12, "{middle}");
        assert!((walled.place(&patch, DVec3::Y * 0.49).interpolate(&heights) - 0.45).abs() < 1e-12);
        let (round, patch) = points(&format!("{CHANNEL} periodic: [\"y\"], walls: None,"));
        assert_eq!(round.neighbours[0], [9, 1, 0, 0]);
        let between = round.place(&patch, DVec3::Y * 0.5).interpolate(&heights);
        assert!((between - 0.5 * (heights[0] + heights[9])).abs() < 1e-12, "{between}");
    }

    #[test]
    fn the_section_of_a_pipe_is_a_disc() {
        let (disc, patch) = points(
            "dimensions: 3, domain: Cylinder(from: (0.0, 0.0, 0.0), to: (2.0, 0.0, 0.0), radius: 0.5),
            outlets: [(at: (2.0, 0.0, 0.0), towards: (1.0, 0.0, 0.0), condition: WaveEquation())],
            inlets: [(at: (0.0, 0.0, 0.0), towards: (1.0, 0.0, 0.0), velocity: Normal(1.0))],",
        );
        assert!(disc.offsets.iter().all(|offset| offset.length() < 0.5 && offset.x.abs() < 1e-12));
        let area = disc.offsets.len() as f64 * disc.spacing[0] * disc.spacing[1];
        assert!((area / (0.25 * std::f64::consts::PI) - 1.0).abs() < 0.05, "{area} m²");
        // Neighbours know each other, and a linear field comes back where four points surround the place.
        for (point, around) in disc.neighbours.iter().enumerate() {
            for (side, &other) in around.iter().enumerate() {
                let back = disc.neighbours[other as usize][side ^ 1];
                assert!(other as usize == point || back as usize == point);
            }
        }
        let field: Vec<f64> =
            disc.offsets.iter().map(|offset| 1.0 + 2.0 * offset.y - 3.0 * offset.z).collect();
        let place = DVec3::new(0.0, 0.11, -0.07);
        let found = disc.place(&patch, place).interpolate(&field);
        assert!((found - 1.0 - 2.0 * place.y + 3.0 * place.z).abs() < 1e-12, "{found}");
        assert!(disc.place(&patch, DVec3::new(0.0, 0.45, 0.45)).interpolate(&field).is_finite());
    }
}
