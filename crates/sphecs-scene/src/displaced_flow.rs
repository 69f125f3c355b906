//! Volume flow that movers displace, as the outlets see it.
//!
//! ```text
//! Q = ∮ φ v·n dS = v_o·R A + ω·R M,   A = ∮ φ N dS,   M = ∮ φ X × N dS
//! ```
//!
//! The integrals are over the surface of a mover that wets fluid which can reach an outlet; n
//! points into the fluid. With φ = 1, Q is the volume flow out of the domain: a piston has one, a
//! body that fluid surrounds has none. With the potential of an outlet,
//! [`potential_flow`](super::potential_flow), it is the share of that outlet. A and M are those in
//! reference coordinates, found at some times of the run and linear between them. On a grid
//!
//! ```text
//! ∮ g n dS = −∫ g ∇f dV,   f = ½ − d/h between 0 and 1
//! ```
//!
//! f is the share of a cell of size h in the mover at the signed distance d. The sum is exact for
//! faces along the axes.

use glam::DVec3;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::domain_cells::{Cells, open_part};
use super::model::Scene;
use super::movers::WallPoses;

/// Number of intervals of the run at whose ends the integrals are found.
const INTERVALS: usize = 64;

/// Integrals over the wetted surface of a mover, in reference coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Integrals {
    /// A, m² (m in 2D).
    area: DVec3,
    /// M, m³ (m² in 2D).
    moment: DVec3,
}

/// Volume flow that the movers of a scene displace, as a function of time.
#[derive(Clone, Debug, PartialEq)]
pub struct DisplacedFlow {
    /// Interval between the times of the integrals, s.
    interval: f64,
    /// Integrals by time, of each mover.
    integrals: Vec<Vec<Integrals>>,
}

impl DisplacedFlow {
    /// Returns the flow with a weight φ at the places of the surface; None without movers or
    /// outlets.
    pub fn new(scene: &Scene, weight: impl Fn(DVec3) -> f64 + Sync) -> Option<Self> {
        if scene.movers.is_empty() || scene.outlets.is_empty() {
            return None;
        }
        let grid = CasingGrid::new(scene);
        let end = if scene.time.end.is_finite() { scene.time.end } else { 0.0 };
        let interval = end / INTERVALS as f64;
        let by_time: Vec<Vec<Integrals>> = (0..=INTERVALS)
            .into_par_iter()
            .map(|at| grid.integrals(&scene.wall_poses(interval * at as f64), &weight))
            .collect();
        let of_mover = |mover: usize| by_time.iter().map(|integrals| integrals[mover]).collect();
        Some(Self { interval, integrals: (0..scene.movers.len()).map(of_mover).collect() })
    }

    /// Returns the volume flow at a time (s), m³/s (m²/s in 2D).
    pub fn rate(&self, scene: &Scene, time: f64) -> f64 {
        let place =
            if self.interval > 0.0 { (time / self.interval).clamp(0.0, INTERVALS as f64) } else { 0.0 };
        let before = (place as usize).min(INTERVALS - 1);
        let share = place - before as f64;
        let of_mover = |(mover, integrals): (&super::model::Mover, &Vec<Integrals>)| {
            let pose = mover.motion.pose(time);
            let area = integrals[before].area.lerp(integrals[before + 1].area, share);
            let moment = integrals[before].moment.lerp(integrals[before + 1].moment, share);
            pose.velocity.dot(pose.direction(area)) + pose.spin.dot(pose.direction(moment))
        };
        scene.movers.iter().zip(&self.integrals).map(of_mover).sum()
    }
}

/// Cells over the casing, with those from which fluid can reach an outlet.
pub(crate) struct CasingGrid<'a> {
    scene: &'a Scene,
    cells: Cells,
    /// Share of each cell inside the casing.
    share: Vec<f64>,
}

impl<'a> CasingGrid<'a> {
    /// Returns the grid of a scene.
    pub(crate) fn new(scene: &'a Scene) -> Self {
        let cells = Cells::over(scene);
        let casing = &scene.layout.casing.domain;
        let share = |cell: usize| {
            let distance = casing.signed_distance(cells.centre(cell, scene.dimensions));
            (0.5 - distance / cells.size).clamp(0.0, 1.0)
        };
        let share = (0..cells.len()).into_par_iter().map(share).collect();
        Self { scene, cells, share }
    }

    /// Returns the integrals of all movers in some poses.
    fn integrals(&self, poses: &WallPoses, weight: &impl Fn(DVec3) -> f64) -> Vec<Integrals> {
        let inside: Vec<Vec<f64>> =
            (0..self.scene.movers.len()).map(|mover| self.shares(mover, poses)).collect();
        let is_open = |cell: usize| self.share[cell] > 0.5 && inside.iter().all(|shares| shares[cell] < 0.5);
        let wetted = self.near(&self.connected(&is_open));
        let of_mover = |(mover, shares): (usize, &Vec<f64>)| {
            let pose = &poses.movers[mover];
            let mut sums = Integrals::default();
            for cell in (0..self.cells.len()).filter(|&cell| wetted[cell] && self.share[cell] > 0.0) {
                let gradient = self.gradient(shares, cell);
                if gradient == DVec3::ZERO {
                    continue;
                }
                let centre = self.cells.centre(cell, self.scene.dimensions);
                let volume = self.cells.size.powi(self.scene.dimensions as i32);
                let outwards = -gradient * (weight(centre) * self.share[cell] * volume);
                sums.area += outwards;
                let near = self.scene.nearest_image(centre, pose.place(self.scene.movers[mover].centre));
                sums.moment += (near - pose.origin).cross(outwards);
            }
            Integrals {
                area: pose.reference_direction(sums.area),
                moment: pose.reference_direction(sums.moment),
            }
        };
        inside.iter().enumerate().map(of_mover).collect()
    }

    /// Returns the volume that movers in some poses leave to the fluid, m³ (m² in 2D), from the
    /// distance at the centre of each cell.
    pub(crate) fn free_volume(&self, poses: &WallPoses) -> f64 {
        let inside: Vec<Vec<f64>> =
            (0..self.scene.movers.len()).map(|mover| self.shares(mover, poses)).collect();
        let free = |cell: usize| {
            let covered: f64 = inside.iter().map(|shares| shares[cell]).sum();
            (self.share[cell] - covered).max(0.0)
        };
        (0..self.cells.len()).map(free).sum::<f64>() * self.cells.size.powi(self.scene.dimensions as i32)
    }

    /// Returns the volume that movers in some poses leave to the fluid, m³ (m² in 2D), by samples
    /// of the cells: slower, and right for a body as thin as a cell.
    pub(crate) fn sampled_free_volume(&self, poses: &WallPoses) -> f64 {
        let dimensions = self.scene.dimensions;
        let free = |cell: usize| {
            let centre = self.cells.centre(cell, dimensions);
            let covered: f64 =
                (0..self.scene.movers.len()).map(|mover| self.covered(mover, poses, centre)).sum();
            (self.share[cell] - covered).max(0.0)
        };
        (0..self.cells.len()).map(free).sum::<f64>() * self.cells.size.powi(dimensions as i32)
    }

    /// Returns the part of a cell inside a mover by samples.
    fn covered(&self, index: usize, poses: &WallPoses, centre: DVec3) -> f64 {
        let (scene, mover, pose) = (self.scene, &self.scene.movers[index], &poses.movers[index]);
        let middle = pose.place(mover.centre);
        let centre = scene.nearest_image(centre, middle);
        let half_diagonal = 0.5 * self.cells.size * (scene.dimensions as f64).sqrt();
        if centre.distance(middle) > mover.radius + half_diagonal {
            return 0.0;
        }
        let distance = mover.shape.signed_distance(pose.reference(centre));
        if distance.abs() > half_diagonal {
            return f64::from(u8::from(distance < 0.0));
        }
        let samples = self.cells.samples(centre, None, scene.dimensions);
        open_part(samples, |point| mover.shape.contains(pose.reference(point), 0.0))
    }

    /// Returns the share of each cell inside a mover.
    fn shares(&self, index: usize, poses: &WallPoses) -> Vec<f64> {
        let (scene, mover, pose) = (self.scene, &self.scene.movers[index], &poses.movers[index]);
        let middle = pose.place(mover.centre);
        let reach = mover.radius + self.cells.size;
        let share = |cell: usize| {
            let point = scene.nearest_image(self.cells.centre(cell, scene.dimensions), middle);
            if point.distance_squared(middle) > reach * reach {
                return 0.0;
            }
            let distance = mover.shape.signed_distance(pose.reference(point));
            (0.5 - distance / self.cells.size).clamp(0.0, 1.0)
        };
        (0..self.cells.len()).map(share).collect()
    }

    /// Returns the gradient of a share by central differences; beyond the grid it is that at its
    /// edge.
    fn gradient(&self, shares: &[f64], cell: usize) -> DVec3 {
        let mut gradient = DVec3::ZERO;
        for axis in 0..self.scene.dimensions {
            let value = |forward: bool| {
                let is_periodic = self.scene.periodic[axis].is_some();
                shares[self.cells.neighbour(cell, axis, forward, is_periodic).unwrap_or(cell)]
            };
            gradient[axis] = (value(true) - value(false)) / (2.0 * self.cells.size);
        }
        gradient
    }

    /// Returns the cells, open ones, from which an outlet can be reached.
    fn connected(&self, is_open: &impl Fn(usize) -> bool) -> Vec<bool> {
        let mut found = vec![false; self.cells.len()];
        let mut edge: Vec<usize> = (0..self.cells.len())
            .filter(|&cell| {
                let centre = self.cells.centre(cell, self.scene.dimensions);
                is_open(cell)
                    && self.scene.outlets.iter().any(|outlet| {
                        outlet.patch.along(centre).abs() <= 1.5 * self.cells.size
                            && outlet.patch.covers(centre, 0.0)
                    })
            })
            .collect();
        edge.iter().for_each(|&cell| found[cell] = true);
        while let Some(cell) = edge.pop() {
            for next in self.neighbours(cell) {
                if !found[next] && is_open(next) {
                    found[next] = true;
                    edge.push(next);
                }
            }
        }
        found
    }

    /// Returns the cells at most two cells from those given.
    fn near(&self, cells: &[bool]) -> Vec<bool> {
        let mut near = cells.to_vec();
        for _ in 0..2 {
            let before = near.clone();
            for cell in (0..before.len()).filter(|&cell| before[cell]) {
                self.neighbours(cell).for_each(|next| near[next] = true);
            }
        }
        near
    }

    fn neighbours(&self, cell: usize) -> impl Iterator<Item = usize> + '_ {
        (0..2 * self.scene.dimensions).filter_map(move |side| {
            let is_periodic = self.scene.periodic[side / 2].is_some();
            self.cells.neighbour(cell, side / 2, side % 2 == 1, is_periodic)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(movers: &str) -> Scene {
        let text = format!(
            r#"Scene(
                title: "Piston", dimensions: 2, spacing: 0.05, smoke: 0.05,
                fluid: (density: 1000.0, viscosity: 0.1, sound_speed: 20.0),
                domain: Box(min: (0.0, 0.0), max: (4.0, 1.0)), movers: [{movers}],
                outlets: [(at: (4.0, 0.5), towards: (1.0, 0.0))],
                time: (end: 2.0), output: (every: 1.0),
            )"#
        );
        Scene::from_text("piston", text).load().unwrap_or_else(|faults| panic!("{faults:?}"))
    }

    fn rates(movers: &str) -> [f64; 3] {
        let scene = scene(movers);
        let flow = DisplacedFlow::new(&scene, |_| 1.0).expect("a flow");
        [0.1, 0.777, 1.9].map(|time| flow.rate(&scene, time))
    }

    /// The rear is behind the end of the casing, or at it and leaves it.
    #[test]
    fn piston_displaces_its_area_times_its_speed() {
        for rear in [-0.6, 0.0] {
            let piston = format!(
                r#"(name: "piston", shape: Box(min: ({rear:?}, 0.0), max: (0.4, 1.0)),
                    motion: Translation(displacement: ("0.2*sin(3*t)", 0.0)))"#
            );
            for (found, time) in rates(&piston).into_iter().zip([0.1, 0.777, 1.9_f64]) {
                let speed = 0.6 * (3.0 * time).cos();
                assert!((found - speed).abs() < 1e-9, "{found}, not {speed} m²/s, rear at {rear} m");
            }
        }
    }

    #[test]
    fn body_in_the_fluid_displaces_nothing() {
        let body = r#"(name: "body", shape: Circle(center: (1.0, 0.5), radius: 0.2), motion: Chain([
            Rotation(about: (1.0, 0.4), radians: "t"), Translation(displacement: ("0.2*t", 0.0))]))"#;
        for rate in rates(body) {
            assert!(rate.abs() < 1e-4, "{rate} m²/s");
        }
    }

    /// A flap that is hinged in the wall sweeps half the square of its length per radian.
    #[test]
    fn flap_displaces_the_sector_that_it_sweeps() {
        let flap = r#"(name: "flap", shape: Box(min: (1.0, -0.5), max: (1.3, 0.6)),
            motion: Rotation(about: (1.0, 0.0), radians: "-0.1*t"))"#;
        let scene = scene(flap);
        let flow = DisplacedFlow::new(&scene, |point| f64::from(u8::from(point.x > 1.2))).expect("a flow");
        let rate = flow.rate(&scene, 1.0);
        // The front side alone, of which the weight lets the part in the casing through.
        assert!((0.01..0.03).contains(&rate), "{rate} m²/s");
    }
}
