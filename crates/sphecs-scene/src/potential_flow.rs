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
//! larger ones in a large domain. Walls cut cells: what is open of each face and of each cell
//! counts. With whole cells the section of a pipe of 16 cells would be 3 % too large, and so its
//! flow.

use glam::DVec3;
use rayon::iter::{IntoParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::domain_cells::{Cells, open_part};
use super::model::{Patch, Scene};

/// Residual at which the solution is accepted, relative to that of φ = 0.
const RESIDUAL: f64 = 1e-8;

/// Least distance of a cell's centre from an opening, cells.
const LEAST_DISTANCE: f64 = 0.1;

/// Least part of a cell that is solved for; smaller ones hardly carry any flow.
const LEAST_PART: f64 = 0.05;

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

/// Face of a cell: a neighbour, an outlet, or a wall. The last number is the open part.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Face {
    Cell(u32, f32),
    /// Outlet by number, at a distance in cells.
    Outlet(u16, f32, f32),
    Wall,
}

impl Face {
    /// Returns the conductance, in units of that of a whole face between two cells.
    fn conductance(self) -> f64 {
        match self {
            Self::Cell(_, open) => f64::from(open),
            Self::Outlet(_, distance, open) => f64::from(open / distance),
            Self::Wall => 0.0,
        }
    }

    /// Returns the flow through the face, of the gradient of a potential, times the distance of the
    /// face from the centre, in cells.
    fn moment(self, own: f64, potential: &[f64], outlet: u16) -> f64 {
        let (other, distance) = match self {
            Self::Cell(other, _) => (potential[other as usize], 0.5),
            Self::Outlet(number, distance, _) => (f64::from(u8::from(number == outlet)), distance.min(0.5)),
            Self::Wall => return 0.0,
        };
        self.conductance() * (other - own) * f64::from(distance)
    }
}

/// Laplace's equation on the cells of the domain.
struct Laplace {
    cells: Cells,
    dimensions: usize,
    /// Cells of the domain.
    inside: Vec<usize>,
    /// The part of each that is in the domain.
    parts: Vec<f64>,
    /// Faces of each: backward and forward along each axis.
    faces: Vec<[Face; 6]>,
}

impl Laplace {
    fn new(scene: &Scene) -> Self {
        let (cells, dimensions) = (Cells::over(scene), scene.dimensions);
        let domain = &scene.layout.casing.domain;
        let parts: Vec<f64> = (0..cells.len())
            .into_par_iter()
            .map(|cell| {
                let centre = cells.centre(cell, dimensions);
                let distance = domain.signed_distance(centre);
                if is_beyond(scene, &cells, centre) {
                    return 0.0;
                }
                if distance.abs() > cells.size * (dimensions as f64).sqrt() {
                    return f64::from(u8::from(distance < 0.0));
                }
                open_part(cells.samples(centre, None, dimensions), |point| domain.contains(point, 0.0))
            })
            .collect();
        let inside: Vec<usize> = (0..cells.len()).filter(|&cell| parts[cell] > LEAST_PART).collect();
        let mut numbers = vec![NONE; cells.len()];
        for (number, &cell) in inside.iter().enumerate() {
            numbers[cell] = number as u32;
        }
        let face = |cell: usize, axis: usize, forward: bool| {
            let centre = cells.centre(cell, dimensions);
            let mut step = DVec3::ZERO;
            step[axis] = if forward { cells.size } else { -cells.size };
            let is_near = domain.signed_distance(centre) > -cells.size * (dimensions as f64).sqrt();
            let samples = || cells.samples(centre, Some(axis), dimensions);
            if let Some(outlet) = outlet_face(scene, centre, step, samples) {
                return outlet;
            }
            let neighbour = cells.neighbour(cell, axis, forward, scene.periodic[axis].is_some());
            let Some(number) = neighbour.map(|neighbour| numbers[neighbour]).filter(|&number| number != NONE)
            else {
                return Face::Wall;
            };
            let is_open = |point: DVec3| domain.contains(point + 0.5 * step, 0.0);
            let open = if is_near { open_part(samples(), is_open) } else { 1.0 };
            if open > 0.0 { Face::Cell(number, open as f32) } else { Face::Wall }
        };
        let faces = inside
            .par_iter()
            .map(|&cell| {
                std::array::from_fn(|side| {
                    if side / 2 < dimensions { face(cell, side / 2, side % 2 == 1) } else { Face::Wall }
                })
            })
            .collect();
        let parts = inside.iter().map(|&cell| parts[cell]).collect();
        Self { cells, dimensions, inside, parts, faces }
    }

    /// Returns Σ conductance × (φ_a − φ_b) over the faces of a cell, outlets at potential 0.
    fn flow(&self, cell: usize, potential: &[f64]) -> f64 {
        let own = potential[cell];
        let outwards = |face: &Face| match *face {
            Face::Cell(other, _) => face.conductance() * (own - potential[other as usize]),
            _ => face.conductance() * own,
        };
        self.faces[cell].iter().map(outwards).sum()
    }

    /// Returns the potential that is 1 at an outlet and 0 at the others, by conjugate gradients
    /// with the diagonal as preconditioner.
    fn solve(&self, outlet: u16) -> Vec<f64> {
        let count = self.inside.len();
        let of_faces =
            |cell: usize, value: &dyn Fn(&Face) -> f64| self.faces[cell].iter().map(value).sum::<f64>();
        let diagonal: Vec<f64> = (0..count)
            .map(|cell| of_faces(cell, &|face| face.conductance()).max(f64::MIN_POSITIVE))
            .collect();
        let mut residual: Vec<f64> = (0..count)
            .map(|cell| {
                of_faces(cell, &|face| match *face {
                    Face::Outlet(number, ..) if number == outlet => face.conductance(),
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
            // The mean of a field without divergence is the sum of its flows through the faces
            // times their places, over the volume. It holds where an oblique wall cuts the cell.
            let moment = |face: &Face| face.moment(potential[cell], potential, outlet);
            let volume = self.parts[cell] * self.cells.size;
            for axis in 0..self.dimensions {
                let both = moment(&faces[2 * axis + 1]) - moment(&faces[2 * axis]);
                gradient[at][axis] = (both / volume) as f32;
            }
        }
        gradient
    }
}

/// Returns true for the centre (m) of a cell just beyond the plane of an outlet. Its faces towards
/// the domain are those of the outlet. A margin takes the cells at the edge of an oblique section:
/// one that stayed would have a neighbour without it, and the equations would not be symmetric.
fn is_beyond(scene: &Scene, cells: &Cells, centre: DVec3) -> bool {
    scene.outlets.iter().any(|outlet| {
        let patch = &outlet.patch;
        let along = patch.along(centre);
        let is_near = along >= 0.0 && along < 2.0 * cells.size;
        is_near && patch.covers(centre, 1.5 * cells.size)
    })
}

/// Returns the face of a cell towards an outlet whose plane a step (m) from the centre (m) crosses
/// inside the section; `samples` are those of the cell's own section across the step.
fn outlet_face<I: Iterator<Item = DVec3>>(
    scene: &Scene,
    centre: DVec3,
    step: DVec3,
    samples: impl Fn() -> I,
) -> Option<Face> {
    scene.outlets.iter().enumerate().find_map(|(number, outlet)| {
        let patch: &Patch = &outlet.patch;
        let (here, there) = (patch.along(centre), patch.along(centre + step));
        if here >= 0.0 || there < 0.0 {
            return None;
        }
        let share = here / (here - there);
        let open = open_part(samples(), |point| patch.covers(point + share * step, 0.0)) as f32;
        (open > 0.0).then(|| Face::Outlet(number as u16, share.max(LEAST_DISTANCE) as f32, open))
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
    let product = |a: &[f64], b: &[f64]| {
        let parts = &laplace.parts;
        a.iter().zip(b).zip(parts).map(|((a, b), part)| a * b * part).sum::<f64>() * volume
    };
    let dot = |a: &[[f32; 3]], b: &[[f32; 3]]| {
        let of_cell = |(&cell, part): (&usize, &f64)| {
            let axes = a[cell].iter().zip(&b[cell]);
            axes.map(|(a, b)| f64::from(*a) * f64::from(*b)).sum::<f64>() * part
        };
        laplace.inside.iter().zip(&laplace.parts).map(of_cell).sum::<f64>() * volume
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
    let (mut sum, mut parts) = (0.0, 0.0);
    for ((&cell, part), value) in laplace.inside.iter().zip(&laplace.parts).zip(potential) {
        if is_next(laplace.cells.centre(cell, laplace.dimensions)) {
            sum += part * value;
            parts += part;
        }
    }
    if parts > 0.0 { sum / parts } else { 0.0 }
}
