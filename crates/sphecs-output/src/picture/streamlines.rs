//! Streamlines of a plane velocity field at an even distance.
//!
//! ```text
//! dx/ds = v/|v|,   by the Runge–Kutta scheme of fourth order, in both directions from a seed
//! ```
//!
//! Jobard & Lefer (1997): seeds are a distance d beside the points of the lines before; a line ends
//! where it is nearer than d/2 to another one, or where the fluid ends. A line that returns to its
//! seed is closed. Seeds on a regular grid begin the parts of the flow that no line has reached.

use std::collections::{HashMap, VecDeque};

/// Steps of a line in the distance of two lines.
const STEPS: f64 = 12.0;

/// Distance at which a line ends beside another one, over that of seeds.
const NEAREST: f64 = 0.5;

/// Length below which a line is left out, distances.
const SHORTEST: f64 = 2.0;

/// Length at which a line ends, distances.
const LONGEST: f64 = 2000.0;

/// Speed below which there is no direction, over the largest one.
const LEAST_SPEED: f64 = 1e-4;

/// Streamlines and what they are traced in.
struct Tracer<F> {
    velocity: F,
    distance: f64,
    slowest: f64,
    lines: Vec<Vec<[f64; 2]>>,
    /// Points of all lines by square cells of the distance. It is searched by cell only, so that
    /// the order of a hash table has no effect.
    taken: HashMap<[i64; 2], Vec<[f64; 2]>>,
}

/// Returns the streamlines between two corners at a distance in m; `fastest` is the place of the
/// largest speed in m/s, from which the first line is traced. `velocity` is None outside the fluid.
pub(super) fn streamlines(
    velocity: impl Fn([f64; 2]) -> Option<[f64; 2]>,
    [low, high]: [[f64; 2]; 2],
    (fastest, largest_speed): ([f64; 2], f64),
    distance: f64,
) -> Vec<Vec<[f64; 2]>> {
    let slowest = LEAST_SPEED * largest_speed;
    let mut tracer = Tracer { velocity, distance, slowest, lines: Vec::new(), taken: HashMap::new() };
    let count = [0, 1].map(|k| ((high[k] - low[k]) / distance).ceil().max(1.0) as usize);
    let centre = |index: usize| -> [f64; 2] {
        let cell = [index % count[0], index / count[0]];
        std::array::from_fn(|k| low[k] + (cell[k] as f64 + 0.5) * (high[k] - low[k]) / count[k] as f64)
    };
    let mut waiting = VecDeque::new();
    for seed in std::iter::once(fastest).chain((0..count[0] * count[1]).map(centre)) {
        tracer.add(seed, &mut waiting);
        while let Some(line) = waiting.pop_front() {
            for seed in tracer.seeds_beside(line) {
                tracer.add(seed, &mut waiting);
            }
        }
    }
    tracer.lines
}

impl<F: Fn([f64; 2]) -> Option<[f64; 2]>> Tracer<F> {
    /// Traces the line of a seed and keeps it if it is long enough.
    fn add(&mut self, seed: [f64; 2], waiting: &mut VecDeque<usize>) {
        if self.is_near(seed, self.distance) || self.direction(seed).is_none() {
            return;
        }
        let (forwards, is_closed) = self.half(seed, 1.0);
        let mut line = forwards;
        if !is_closed {
            let (mut backwards, _) = self.half(seed, -1.0);
            backwards.reverse();
            backwards.pop();
            backwards.append(&mut line);
            line = backwards;
        }
        if (line.len() as f64) < SHORTEST * STEPS {
            return;
        }
        for &point in &line {
            self.taken.entry(self.cell(point)).or_default().push(point);
        }
        waiting.push_back(self.lines.len());
        self.lines.push(line);
    }

    /// Returns the line in one direction from a seed, and true if it returned to it.
    fn half(&self, seed: [f64; 2], sign: f64) -> (Vec<[f64; 2]>, bool) {
        let step = self.distance / STEPS;
        let mut line = vec![seed];
        let mut point = seed;
        let mut has_left = false;
        while (line.len() as f64) < LONGEST * STEPS {
            let Some(next) = self.step(point, sign * step) else { break };
            if self.is_near(next, NEAREST * self.distance) {
                break;
            }
            point = next;
            line.push(point);
            let from_seed = (point[0] - seed[0]).hypot(point[1] - seed[1]);
            has_left |= from_seed > 2.0 * step;
            if has_left && from_seed < step {
                line.push(seed);
                return (line, true);
            }
            // A spiral would fill the plane with one line.
            if self.is_beside_itself(&line) {
                break;
            }
        }
        (line, false)
    }

    fn step(&self, from: [f64; 2], step: f64) -> Option<[f64; 2]> {
        let after = |direction: [f64; 2], share: f64| [0, 1].map(|k| from[k] + share * step * direction[k]);
        let first = self.direction(from)?;
        let second = self.direction(after(first, 0.5))?;
        let third = self.direction(after(second, 0.5))?;
        let fourth = self.direction(after(third, 1.0))?;
        let mean = [0, 1].map(|k| (first[k] + 2.0 * second[k] + 2.0 * third[k] + fourth[k]) / 6.0);
        Some(after(mean, 1.0))
    }

    fn direction(&self, point: [f64; 2]) -> Option<[f64; 2]> {
        let [u, v] = (self.velocity)(point)?;
        let speed = u.hypot(v);
        (speed > self.slowest).then(|| [u / speed, v / speed])
    }

    /// Returns true if the end of a line is near to a part of itself that is more than a turn back.
    /// The points next to the seed do not count: a line that returns to it closes there.
    fn is_beside_itself(&self, line: &[[f64; 2]]) -> bool {
        let Some(&[x, y]) = line.last() else { return false };
        let limit = 0.25 * self.distance;
        let (first, recent) = ((0.5 * STEPS) as usize, (2.0 * STEPS) as usize);
        let before = line.len().saturating_sub(recent);
        // Points are a twelfth of the distance apart: every second one is enough.
        let older = line.get(first..before).unwrap_or_default();
        older.iter().step_by(2).any(|point| (point[0] - x).hypot(point[1] - y) < limit)
    }

    fn seeds_beside(&self, line: usize) -> Vec<[f64; 2]> {
        let points = self.lines[line].iter().step_by(STEPS as usize);
        let beside = points.filter_map(|&[x, y]| {
            let [u, v] = self.direction([x, y])?;
            // A little more than the distance, which rounding must not undercut.
            let d = 1.001 * self.distance;
            Some([[x - d * v, y + d * u], [x + d * v, y - d * u]])
        });
        beside.flatten().collect()
    }

    fn cell(&self, point: [f64; 2]) -> [i64; 2] {
        point.map(|coordinate| (coordinate / self.distance).floor() as i64)
    }

    /// Returns true if a point is within a distance, at most that of the cells, of another line.
    fn is_near(&self, point: [f64; 2], limit: f64) -> bool {
        let [i, j] = self.cell(point);
        let cells = (-1..=1).flat_map(|di| (-1..=1).map(move |dj| [i + di, j + dj]));
        let mut points = cells.filter_map(|cell| self.taken.get(&cell)).flatten();
        points.any(|other| (other[0] - point[0]).hypot(other[1] - point[1]) < limit)
    }
}

#[cfg(test)]
mod tests {
    use super::super::plane_grid::tests::grid;
    use super::*;

    #[test]
    fn solid_rotation_has_closed_circles() {
        // The velocity is linear, so that the grid is exact; a step is a hundredth of the radius.
        let grid = grid(21, |[x, y]| ([-y, x], 0.0));
        let lines =
            streamlines(|point| grid.velocity_at(point), [[-1.0; 2], [1.0; 2]], ([0.5, 0.0], 1.4), 0.2);
        let radius = |point: &[f64; 2]| point[0].hypot(point[1]);
        let mut closed = 0;
        for line in &lines {
            let first = radius(&line[0]);
            // Fourth order: an error of (h/r)⁴/120 a step, a step being 0.017 m, r from 0.1 m.
            let off = line.iter().map(|point| (radius(point) - first).abs()).fold(0.0, f64::max);
            assert!(off < 1e-4 * first, "{off} m off the circle of {first} m");
            closed += usize::from(line.len() > 2 && line[0] == line[line.len() - 1]);
        }
        assert!(closed >= 3, "{closed} closed lines of {}", lines.len());
    }

    #[test]
    fn lines_keep_their_distance_and_fill_the_plane() {
        let uniform = |[x, y]: [f64; 2]| (x.abs() <= 1.0 && y.abs() <= 1.0).then_some([1.0, 0.0]);
        let lines = streamlines(uniform, [[-1.0; 2], [1.0; 2]], ([0.0; 2], 1.0), 0.1);
        assert!((18..=21).contains(&lines.len()), "{} lines", lines.len());
        let mut heights: Vec<f64> = lines.iter().map(|line| line[0][1]).collect();
        heights.sort_by(f64::total_cmp);
        assert!(heights.windows(2).all(|pair| pair[1] - pair[0] > 0.0999), "{heights:?}");
        // From edge to edge, up to one step.
        let ends = |line: &Vec<[f64; 2]>| line[0][0] < -0.99 && line[line.len() - 1][0] > 0.99;
        assert!(lines.iter().all(ends));
    }

    #[test]
    fn fluid_at_rest_has_none() {
        let lines = streamlines(|_| Some([0.0, 0.0]), [[-1.0; 2], [1.0; 2]], ([0.0; 2], 0.0), 0.1);
        assert!(lines.is_empty());
    }
}
