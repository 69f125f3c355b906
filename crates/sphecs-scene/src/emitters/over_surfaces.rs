//! Columns of an emitter in 3D: pieces of its surface of about Δ² each.
//!
//! ```text
//! N = A/Δ² rounded;   piece i: the samples nearest to its centre;   centre: their mean
//! ```
//!
//! The facets of a mesh from CAD are slivers of any size, so the pieces are not facets. The surface
//! is sampled, the samples begin in the cells of a lattice on it, and N centres move to the means
//! of their samples in turns: the algorithm of Lloyd (1982). On a plane of whole spacings the
//! lattice stays as it is. The areas of the pieces add up to that of the surface exactly.

use std::collections::BTreeMap;

use glam::{DMat2, DVec2, DVec3};

use super::Piece;
use crate::model::Scene;
use crate::movers::Wall;
use crate::sheets::around;
use crate::wall_particles::surface_of;

/// Samples of the surface per Δ², at least.
const SAMPLES: f64 = 64.0;

/// Turns in which the centres move to the means of their samples. A random start is even after 20.
const TURNS: usize = 30;

/// Largest relative difference of the areas of cells of the lattice that are taken as they are.
const EVEN: f64 = 0.12;

/// Radius within which the normals of other pieces tell the curvature, in spacings.
const NEIGHBOURS: f64 = 2.5;

/// Cosine of the largest angle between the normals of a sample and of its piece: the two sides of a
/// plate are two surfaces.
const SAME_SIDE: f64 = 0.3;

/// A sample of the surface.
struct Sample {
    place: DVec3,
    normal: DVec3,
    area: f64,
}

/// A centre and what its samples add up to.
#[derive(Clone, Copy, Default)]
struct Centre {
    place: DVec3,
    normal: DVec3,
    area: f64,
}

/// Returns the pieces of a surface of triangles, m, that is part of a wall.
pub fn pieces(scene: &Scene, wall: Wall, triangles: &[[DVec3; 3]]) -> Vec<Piece> {
    let samples = samples(scene, wall, triangles);
    let total: f64 = samples.iter().map(|sample| sample.area).sum();
    let count = (total / scene.spacing.powi(2)).round().max(1.0) as usize;
    if samples.is_empty() {
        return Vec::new();
    }
    let mut centres = of_lattice(triangles, &samples, scene.spacing);
    let mean = total / count as f64;
    if centres.len() == count && centres.iter().all(|centre| (centre.area / mean - 1.0).abs() < EVEN) {
        // Cells of one size, which the samples measure only roughly.
        centres.iter_mut().for_each(|centre| centre.set_area(mean));
    } else {
        let mut nearest = vec![0; samples.len()];
        for _ in 0..TURNS {
            adjust(&mut centres, count, scene.spacing);
            assign(&samples, &centres, scene.spacing, &mut nearest);
            centres = gathered(&samples, &nearest, centres.len());
        }
    }
    let places: Vec<(DVec3, DVec3)> = centres
        .iter()
        .map(|centre| {
            let (foot, normal, _) = surface_of(scene, wall, centre.place);
            (foot, centre.normal.try_normalize().unwrap_or(normal))
        })
        .collect();
    let piece = |index: usize| {
        let (foot, normal) = places[index];
        let [curvature_sum, curvature_product] = curvature(index, &places, scene.spacing);
        Piece { foot, normal, area: centres[index].area, curvature_sum, curvature_product }
    };
    (0..places.len()).map(piece).collect()
}

/// Returns the samples: middles of equal parts of the triangles.
fn samples(scene: &Scene, wall: Wall, triangles: &[[DVec3; 3]]) -> Vec<Sample> {
    let finest = scene.spacing.powi(2) / SAMPLES;
    let mut samples = Vec::new();
    for [a, b, c] in triangles {
        let vector = 0.5 * (*b - *a).cross(*c - *a);
        let area = vector.length();
        if area <= 0.0 {
            continue;
        }
        let mut normal = vector / area;
        let middle = (*a + *b + *c) / 3.0;
        // The corners may be in either order.
        if wall.gradient(scene, middle - 1e-3 * scene.spacing * normal).dot(normal) > 0.0 {
            normal = -normal;
        }
        let sides = (area / finest).sqrt().ceil().clamp(1.0, 1000.0) as usize;
        let step = 1.0 / sides as f64;
        let at = |u: f64, v: f64| *a + (*b - *a) * (u * step) + (*c - *a) * (v * step);
        let mut add = |place: DVec3| samples.push(Sample { place, normal, area: area * step * step });
        for i in 0..sides {
            for j in 0..sides - i {
                let (u, v) = (i as f64, j as f64);
                add(at(u + 1.0 / 3.0, v + 1.0 / 3.0));
                if i + j + 1 < sides {
                    add(at(u + 2.0 / 3.0, v + 2.0 / 3.0));
                }
            }
        }
    }
    samples
}

/// Returns the cells of a lattice on the surface as first centres. It is on the plane across the
/// axis to which a sample's normal is nearest, in the frame of the mean normal.
fn of_lattice(triangles: &[[DVec3; 3]], samples: &[Sample], spacing: f64) -> Vec<Centre> {
    let mean: DVec3 = samples.iter().map(|sample| sample.normal * sample.area).sum();
    let third = mean.try_normalize().unwrap_or(DVec3::Z);
    // Along the axes of the scene where the normal allows it.
    let axis = DVec3::AXES.into_iter().min_by(|a, b| a.dot(third).abs().total_cmp(&b.dot(third).abs()));
    let axis = axis.unwrap_or(DVec3::X);
    let first = (axis - third * axis.dot(third)).normalize();
    let frame = [first, third.cross(first), third];
    let local = |vector: DVec3| DVec3::from(frame.map(|axis| axis.dot(vector)));
    let corners = || triangles.iter().flatten().map(|corner| local(*corner));
    let low = corners().fold(DVec3::INFINITY, DVec3::min);
    let extent = corners().fold(DVec3::NEG_INFINITY, DVec3::max) - low;
    let widths = extent.map(|extent| (extent / (extent / spacing).round().max(1.0)).max(1e-9 * spacing));
    let mut cells: BTreeMap<(usize, bool, [i64; 2]), Centre> = BTreeMap::new();
    for sample in samples {
        let place = local(sample.place);
        let normal = local(sample.normal);
        let across = (0..3).max_by(|a, b| normal[*a].abs().total_cmp(&normal[*b].abs())).unwrap_or(2);
        let index = |axis: usize| ((place[axis] - low[axis]) / widths[axis]).floor() as i64;
        let cell = [index((across + 1) % 3), index((across + 2) % 3)];
        cells.entry((across, normal[across] > 0.0, cell)).or_default().add(sample);
    }
    cells.into_values().map(Centre::mean).collect()
}

impl Centre {
    fn add(&mut self, sample: &Sample) {
        self.place += sample.place * sample.area;
        self.normal += sample.normal * sample.area;
        self.area += sample.area;
    }

    /// Sets the area, and scales the sum of normals with it.
    fn set_area(&mut self, area: f64) {
        self.normal *= area / self.area;
        self.area = area;
    }

    /// Divides the sum of places by the area.
    fn mean(self) -> Self {
        Self { place: self.place / self.area, ..self }
    }
}

/// Leaves out the smallest centres or doubles the largest until there are `count`.
fn adjust(centres: &mut Vec<Centre>, count: usize, spacing: f64) {
    centres.retain(|centre| centre.area > 0.0);
    let by_area = |a: &(usize, &Centre), b: &(usize, &Centre)| a.1.area.total_cmp(&b.1.area);
    while centres.len() > count {
        let Some((smallest, _)) = centres.iter().enumerate().min_by(by_area) else { return };
        centres.remove(smallest);
    }
    while centres.len() < count {
        let Some((largest, _)) = centres.iter().enumerate().max_by(by_area) else { return };
        let aside = centres[largest].normal.any_orthogonal_vector().normalize_or_zero() * (0.25 * spacing);
        centres[largest].area *= 0.5;
        let mut other = centres[largest];
        other.place += aside;
        centres[largest].place -= aside;
        centres.push(other);
    }
}

/// Finds the centre nearest to each sample; the first of equal ones.
fn assign(samples: &[Sample], centres: &[Centre], spacing: f64, nearest: &mut [usize]) {
    let width = 2.0 * spacing;
    let cell = |place: DVec3| (place / width).floor().as_i64vec3().to_array();
    let mut cells: BTreeMap<[i64; 3], Vec<usize>> = BTreeMap::new();
    for (index, centre) in centres.iter().enumerate() {
        cells.entry(cell(centre.place)).or_default().push(index);
    }
    for (sample, nearest) in samples.iter().zip(nearest) {
        let distance = |index: usize| {
            let centre = &centres[index];
            let is_same = centre.normal.dot(sample.normal) >= SAME_SIDE * centre.normal.length();
            let beyond = if is_same { 0.0 } else { 100.0 * spacing * spacing };
            centre.place.distance_squared(sample.place) + beyond
        };
        let closest = |indices: &mut dyn Iterator<Item = usize>| {
            indices.min_by(|a, b| distance(*a).total_cmp(&distance(*b)).then(a.cmp(b)))
        };
        let near = around(cell(sample.place)).filter_map(|cell| cells.get(&cell)).flatten().copied();
        *nearest = closest(&mut near.into_iter()).or_else(|| closest(&mut (0..centres.len()))).unwrap_or(0);
    }
}

/// Returns the means of the samples of each centre.
fn gathered(samples: &[Sample], nearest: &[usize], count: usize) -> Vec<Centre> {
    let mut centres = vec![Centre::default(); count];
    for (sample, nearest) in samples.iter().zip(nearest) {
        centres[*nearest].add(sample);
    }
    centres.into_iter().filter(|centre| centre.area > 0.0).map(Centre::mean).collect()
}

/// Returns sum and product of the principal curvatures at a piece: the normals around it are n + S
/// d in its tangent plane, with S by least squares.
fn curvature(index: usize, places: &[(DVec3, DVec3)], spacing: f64) -> [f64; 2] {
    let (foot, normal) = places[index];
    let first = normal.any_orthonormal_vector();
    let second = normal.cross(first);
    let flat = |vector: DVec3| DVec2::new(vector.dot(first), vector.dot(second));
    let (mut squares, mut products) = (DMat2::ZERO, DMat2::ZERO);
    for (place, other) in places {
        let way = *place - foot;
        if way.length() < NEIGHBOURS * spacing && other.dot(normal) > SAME_SIDE {
            let (way, change) = (flat(way), flat(*other - normal));
            squares += DMat2::from_cols(way * way.x, way * way.y);
            products += DMat2::from_cols(change * way.x, change * way.y);
        }
    }
    // A single row of pieces does not tell the curvature across it.
    if squares.determinant() < 1e-3 * spacing.powi(4) {
        let length = squares.x_axis.x + squares.y_axis.y;
        let bend = products.x_axis.x + products.y_axis.y;
        return if length > 0.0 { [bend / length, 0.0] } else { [0.0; 2] };
    }
    let shape = products * squares.inverse();
    let off = 0.5 * (shape.x_axis.y + shape.y_axis.x);
    [shape.x_axis.x + shape.y_axis.y, shape.x_axis.x * shape.y_axis.y - off * off]
}
