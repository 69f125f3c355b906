//! Weights that give the flow through an opening from the velocities in the whole domain.
//!
//! ```text
//! ∇²φ_i = 0     φ_i = 1 at opening i, 0 at the other outlets, ∂φ_i/∂n = 0 at walls and inlets
//! Q_i = ∫ v·∇φ_i dV + Σ_in ⟨φ_i⟩_in Q_in
//! ```
//!
//! For a velocity field without divergence this is the volume flow Q_i out of the opening: the
//! divergence theorem for φ_i v. Sound does not contribute. A standing wave v = ∇ψ between
//! openings of given pressure has ψ = 0 there, so that ∫ ∇ψ·∇φ_i dV = ∮ ψ ∂φ_i/∂n dS vanishes. In
//! a straight duct the integral is the area times the mean velocity over the length.
//!
//! Movers count as fluid here: what they displace is a term of its own,
//! [`displaced_flow`](super::displaced_flow).
//!
//! Laplace's equation is solved by conjugate gradients on cells with the size of a particle, or
//! larger ones in a large domain. Cells are in the domain or not, so that walls oblique to the axes
//! have stairs.

use glam::DVec3;

use super::model::{Patch, Scene};

/// Largest number of cells inside the bounding box: a solution takes less than a second.
const MOST_CELLS: f64 = 3e5;

/// Residual at which the solution is accepted, relative to that of φ = 0.
const RESIDUAL: f64 = 1e-8;

/// Least distance of a cell's centre from an opening, cells.
const LEAST_DISTANCE: f64 = 0.1;

/// No cell.
const NONE: u32 = u32::MAX;

/// Potential flow towards one opening: ∇φ_i as a function of the place.
#[derive(Clone, Debug, PartialEq)]
pub struct PotentialFlow {
    cells: Cells,
    /// ∇φ by cell, 1/m; 0 outside the domain.
    gradient: Vec<[f32; 3]>,
    /// ∫ |∇φ|² dV, m (dimensionless in 2D).
    pub square: f64,
    /// φ by cell; 0 outside the domain.
    potential: Vec<f32>,
    /// Mean of φ over the planes of all inlets, weighted by area; 0 without inlets.
    pub inlet_potential: f64,
    /// ∫ φ_i φ_j dV for each outlet j, m³ (m² in 2D); 0 for those without a potential flow.
    pub overlaps: Vec<f64>,
    /// ∫ ∇φ_i·∇φ_j dV for each outlet j, m (dimensionless in 2D); 0 as above. For j = i it is
    /// ∫ |∇φ_i|² dV.
    pub conductances: Vec<f64>,
}

impl PotentialFlow {
    /// Returns φ at a point (m).
    pub fn potential(&self, point: DVec3) -> f64 {
        f64::from(self.potential[self.cells.nearest(point)])
    }

    /// Returns ∇φ at a point (m), 1/m.
    pub fn gradient(&self, point: DVec3) -> [f32; 3] {
        self.gradient[self.cells.nearest(point)]
    }
}

/// Grid of cells over the bounding box of the domain.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Cells {
    low: DVec3,
    /// Size of a cell, m.
    pub(crate) size: f64,
    counts: [usize; 3],
}

impl Cells {
    /// Returns cells over the domain of a scene.
    pub(crate) fn over(scene: &Scene) -> Self {
        let (low, high) = scene.layout.casing.domain.bounds();
        let extent = (high - low).max(DVec3::ZERO);
        let dimensions = scene.dimensions;
        let lengths: f64 = (0..dimensions).map(|axis| extent[axis] / scene.spacing).product();
        let coarser = (lengths / MOST_CELLS).powf(1.0 / dimensions as f64).max(1.0);
        let size = scene.spacing * coarser;
        let counts = std::array::from_fn(|axis| {
            if axis < dimensions { ((extent[axis] / size - 1e-6).ceil() as usize).max(1) } else { 1 }
        });
        // The cells of an axis that does not divide into whole ones overlap both ends alike.
        let half = DVec3::from(std::array::from_fn(|axis| 0.5 * size * counts[axis] as f64));
        let middle = 0.5 * (low + high);
        let low = middle - half;
        Self { low: DVec3::new(low.x, low.y, if dimensions == 3 { low.z } else { 0.0 }), size, counts }
    }

    /// Returns the number of cells.
    pub(crate) fn len(&self) -> usize {
        self.counts.iter().product()
    }

    fn place(&self, index: usize) -> [usize; 3] {
        let [nx, ny, _] = self.counts;
        [index % nx, index / nx % ny, index / (nx * ny)]
    }

    fn index(&self, place: [usize; 3]) -> usize {
        (place[2] * self.counts[1] + place[1]) * self.counts[0] + place[0]
    }

    /// Returns the centre of a cell, m.
    pub(crate) fn centre(&self, index: usize, dimensions: usize) -> DVec3 {
        let place = self.place(index);
        let mut centre = DVec3::ZERO;
        for axis in 0..dimensions {
            centre[axis] = self.low[axis] + (place[axis] as f64 + 0.5) * self.size;
        }
        centre
    }

    fn nearest(&self, point: DVec3) -> usize {
        let place = std::array::from_fn(|axis| {
            let at = ((point[axis] - self.low[axis]) / self.size).max(0.0) as usize;
            at.min(self.counts[axis] - 1)
        });
        self.index(place)
    }

    /// Returns the neighbour of a cell along an axis; None at the end of the grid.
    pub(crate) fn neighbour(
        &self,
        index: usize,
        axis: usize,
        forward: bool,
        is_periodic: bool,
    ) -> Option<usize> {
        let mut place = self.place(index);
        let last = self.counts[axis] - 1;
        place[axis] = match (forward, place[axis]) {
            (true, at) if at == last => is_periodic.then_some(0)?,
            (true, at) => at + 1,
            (false, 0) => is_periodic.then_some(last)?,
            (false, at) => at - 1,
        };
        Some(self.index(place))
    }
}

/// Face of a cell: a neighbour, an outlet, or a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Face {
    Cell(u32),
    /// Outlet by number, at a distance in cells.
    Outlet(u16, f32),
    Wall,
}

/// Laplace's equation on the cells of the domain.
struct Laplace {
    cells: Cells,
    dimensions: usize,
    /// Cells of the domain.
    inside: Vec<usize>,
    /// Faces of each: backward and forward along each axis.
    faces: Vec<[Face; 6]>,
}

impl Laplace {
    fn new(scene: &Scene) -> Self {
        let (cells, dimensions) = (Cells::over(scene), scene.dimensions);
        let inside: Vec<usize> = (0..cells.len())
            .filter(|&cell| scene.layout.casing.domain.contains(cells.centre(cell, dimensions), 0.0))
            .collect();
        let mut numbers = vec![NONE; cells.len()];
        for (number, &cell) in inside.iter().enumerate() {
            numbers[cell] = number as u32;
        }
        let face = |cell: usize, axis: usize, forward: bool| {
            let centre = cells.centre(cell, dimensions);
            let mut step = DVec3::ZERO;
            step[axis] = if forward { cells.size } else { -cells.size };
            if let Some((outlet, distance)) = crossed(scene, centre, step) {
                return Face::Outlet(outlet, distance);
            }
            match cells.neighbour(cell, axis, forward, scene.periodic[axis].is_some()) {
                Some(neighbour) if numbers[neighbour] != NONE => Face::Cell(numbers[neighbour]),
                _ => Face::Wall,
            }
        };
        let faces = inside
            .iter()
            .map(|&cell| {
                std::array::from_fn(|side| {
                    if side / 2 < dimensions { face(cell, side / 2, side % 2 == 1) } else { Face::Wall }
                })
            })
            .collect();
        Self { cells, dimensions, inside, faces }
    }

    /// Returns Σ conductance × (φ_a − φ_b) over the faces of a cell, outlets at potential 0.
    fn flow(&self, cell: usize, potential: &[f64]) -> f64 {
        let own = potential[cell];
        self.faces[cell]
            .iter()
            .map(|face| match *face {
                Face::Cell(other) => own - potential[other as usize],
                Face::Outlet(_, distance) => own / f64::from(distance),
                Face::Wall => 0.0,
            })
            .sum()
    }

    /// Returns the potential that is 1 at an outlet and 0 at the others, by conjugate gradients
    /// with the diagonal as preconditioner.
    fn solve(&self, outlet: u16) -> Vec<f64> {
        let count = self.inside.len();
        let of_faces =
            |cell: usize, value: &dyn Fn(&Face) -> f64| self.faces[cell].iter().map(value).sum::<f64>();
        let diagonal: Vec<f64> = (0..count)
            .map(|cell| {
                let conductance = |face: &Face| match *face {
                    Face::Cell(_) => 1.0,
                    Face::Outlet(_, distance) => 1.0 / f64::from(distance),
                    Face::Wall => 0.0,
                };
                of_faces(cell, &conductance).max(f64::MIN_POSITIVE)
            })
            .collect();
        let mut residual: Vec<f64> = (0..count)
            .map(|cell| {
                of_faces(cell, &|face| match *face {
                    Face::Outlet(number, distance) if number == outlet => 1.0 / f64::from(distance),
                    _ => 0.0,
                })
            })
            .collect();
        let mut potential = vec![0.0; count];
        let mut direction: Vec<f64> = residual.iter().zip(&diagonal).map(|(r, d)| r / d).collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let weighted = |r: &[f64]| r.iter().zip(&diagonal).map(|(r, d)| r * r / d).sum::<f64>();
        let mut square = weighted(&residual);
        let enough = RESIDUAL * RESIDUAL * square;
        let mut image = vec![0.0; count];
        // More steps than cells cannot help; a domain without outlets has nothing to solve.
        for _ in 0..count {
            if square <= enough {
                break;
            }
            for (cell, image) in image.iter_mut().enumerate() {
                *image = self.flow(cell, &direction);
            }
            let length = square / dot(&direction, &image);
            for cell in 0..count {
                potential[cell] += length * direction[cell];
                residual[cell] -= length * image[cell];
            }
            let next = weighted(&residual);
            for cell in 0..count {
                direction[cell] = residual[cell] / diagonal[cell] + next / square * direction[cell];
            }
            square = next;
        }
        potential
    }

    /// Returns a potential by cell of the grid.
    fn by_cell(&self, potential: &[f64]) -> Vec<f32> {
        let mut all = vec![0.0; self.cells.len()];
        for (&cell, &value) in self.inside.iter().zip(potential) {
            all[cell] = value as f32;
        }
        all
    }

    /// Returns the gradient of a potential by cell of the grid, 1/m.
    fn gradient(&self, potential: &[f64], outlet: u16) -> Vec<[f32; 3]> {
        let mut gradient = vec![[0.0; 3]; self.cells.len()];
        for (cell, (&at, faces)) in self.inside.iter().zip(&self.faces).enumerate() {
            let slope = |face: &Face| match *face {
                Face::Cell(other) => potential[other as usize] - potential[cell],
                Face::Outlet(number, distance) => {
                    (f64::from(u8::from(number == outlet)) - potential[cell]) / f64::from(distance)
                }
                Face::Wall => 0.0,
            };
            for axis in 0..self.dimensions {
                let both = slope(&faces[2 * axis + 1]) - slope(&faces[2 * axis]);
                gradient[at][axis] = (0.5 * both / self.cells.size) as f32;
            }
        }
        gradient
    }
}

/// Returns the outlet whose section a step (m) from a centre (m) crosses, with the distance of its
/// plane in steps.
fn crossed(scene: &Scene, centre: DVec3, step: DVec3) -> Option<(u16, f32)> {
    scene.outlets.iter().enumerate().find_map(|(number, outlet)| {
        let patch: &Patch = &outlet.patch;
        let (here, there) = (patch.along(centre), patch.along(centre + step));
        let share = here / (here - there);
        let crosses = here < 0.0 && there >= 0.0 && patch.covers(centre + share * step, 0.0);
        crosses.then_some((number as u16, share.max(LEAST_DISTANCE) as f32))
    })
}

/// Returns the potential flow of each outlet for which `is_wanted` is true, None for the others.
pub fn potential_flows(scene: &Scene, is_wanted: impl Fn(usize) -> bool) -> Vec<Option<PotentialFlow>> {
    let count = scene.outlets.len();
    if !(0..count).any(&is_wanted) {
        return vec![None; count];
    }
    let laplace = Laplace::new(scene);
    let volume = laplace.cells.size.powi(laplace.dimensions as i32);
    let solved: Vec<Option<(Vec<f64>, Vec<[f32; 3]>)>> = (0..count)
        .map(|outlet| {
            is_wanted(outlet).then(|| {
                let potential = laplace.solve(outlet as u16);
                let gradient = laplace.gradient(&potential, outlet as u16);
                (potential, gradient)
            })
        })
        .collect();
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() * volume;
    let dot = |a: &[[f32; 3]], b: &[[f32; 3]]| {
        let pairs = a.iter().flatten().zip(b.iter().flatten());
        pairs.map(|(a, b)| f64::from(*a) * f64::from(*b)).sum::<f64>() * volume
    };
    let over_all = |value: &dyn Fn(&(Vec<f64>, Vec<[f32; 3]>)) -> f64| {
        solved.iter().map(|other| other.as_ref().map_or(0.0, value)).collect::<Vec<f64>>()
    };
    let flow_of = |(potential, gradient): &(Vec<f64>, Vec<[f32; 3]>)| PotentialFlow {
        cells: laplace.cells.clone(),
        square: dot(gradient, gradient),
        inlet_potential: inlet_potential(scene, &laplace, potential),
        overlaps: over_all(&|other| product(potential, &other.0)),
        conductances: over_all(&|other| dot(gradient, &other.1)),
        gradient: gradient.clone(),
        potential: laplace.by_cell(potential),
    };
    solved.iter().map(|of_outlet| of_outlet.as_ref().map(flow_of)).collect()
}

/// Returns the mean of a potential over the cells next to the planes of the inlets.
fn inlet_potential(scene: &Scene, laplace: &Laplace, potential: &[f64]) -> f64 {
    let is_next = |centre: DVec3| {
        scene.inlets.iter().any(|inlet| {
            let along = inlet.patch.along(centre);
            along > 0.0 && along < laplace.cells.size && inlet.patch.covers(centre, 0.0)
        })
    };
    let (mut sum, mut number) = (0.0, 0);
    for (&cell, value) in laplace.inside.iter().zip(potential) {
        if is_next(laplace.cells.centre(cell, laplace.dimensions)) {
            sum += value;
            number += 1;
        }
    }
    if number > 0 { sum / f64::from(number) } else { 0.0 }
}
