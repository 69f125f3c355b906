//! Particles of a 3D flow in perspective, as shaded balls.
//!
//! ```text
//! x' = D/(D − x·n) (x·e_right, x·e_up),   x from the middle of the flow, n towards the viewer
//! ```
//!
//! The viewer is at the distance D at which the flow fills 30°. A depth buffer keeps the nearest
//! ball of each point. Fluid that is farther away is paler. Walls in front of it are nearly
//! transparent, else they would hide the flow of every closed duct.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::DVec3;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::raster::{NO_VALUE, WALL};
use super::view::Slice;
use crate::drawing::{Colour, PAPER};
use crate::frame::{ABSENT, Frame};
use crate::header::Header;
use sphecs_core::particles::zone::Zone;

/// Angle of view of the whole flow, rad.
const ANGLE: f64 = 0.52;

/// Radius of a ball over the particle spacing, at which neighbours leave no gap.
const RADIUS: f64 = 0.6;

/// Points of a pixel along each side.
const SAMPLES: usize = 2;

/// Share of a wall that is in front of fluid, and of one without fluid behind it.
const WALL_SHARES: [f64; 2] = [0.13, 0.4];

/// Share of white in the farthest fluid.
const HAZE: f64 = 0.35;

/// A flow, and the direction from which it is seen.
#[derive(Clone, Copy, Debug)]
pub(super) struct View3<'a> {
    /// Header of the run.
    pub(super) header: &'a Header,
    /// Direction towards the viewer.
    pub(super) towards: [f64; 3],
    /// Plane in front of which the flow is left out.
    pub(super) cut: Option<Slice>,
}

/// Projection onto a picture.
#[derive(Clone, Copy, Debug)]
struct Camera {
    middle: DVec3,
    right: DVec3,
    up: DVec3,
    normal: DVec3,
    distance: f64,
}

impl Camera {
    fn new(header: &Header, towards: [f64; 3]) -> Self {
        let [low, high] = header.bounds.map(DVec3::from_array);
        let [right, up, normal] = basis(towards);
        let half = 0.5 * (high - low).length() + header.spacing;
        let distance = half / (0.5 * ANGLE).tan();
        Self { middle: 0.5 * (low + high), right, up, normal, distance }
    }

    /// Returns the place on the picture, m, the depth towards the viewer, m, and the magnification.
    fn project(&self, point: DVec3) -> ([f64; 2], f64, f64) {
        let from_middle = point - self.middle;
        let depth = from_middle.dot(self.normal);
        let scale = self.distance / (self.distance - depth);
        ([scale * from_middle.dot(self.right), scale * from_middle.dot(self.up)], depth, scale)
    }

    /// Returns the corners of the picture of the flow, m.
    fn corners(&self, header: &Header) -> [[f64; 2]; 2] {
        let [low, high] = header.bounds.map(DVec3::from_array);
        let (mut least, mut most) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for corner in 0..8 {
            let side = |axis: usize| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] };
            let (place, _, scale) = self.project(DVec3::from_array([0, 1, 2].map(side)));
            for axis in 0..2 {
                least[axis] = least[axis].min(place[axis] - scale * header.spacing);
                most[axis] = most[axis].max(place[axis] + scale * header.spacing);
            }
        }
        [least, most]
    }
}

/// Returns the directions to the right, upwards and towards the viewer; y is upwards as in a slice,
/// z if the viewer is above or below.
fn basis(towards: [f64; 3]) -> [DVec3; 3] {
    let normal = DVec3::from_array(towards).normalize_or(DVec3::Z);
    let upright = if normal.y.abs() > 0.999 { DVec3::Z } else { DVec3::Y };
    let right = upright.cross(normal).normalize();
    [right, normal.cross(right), normal]
}

/// Returns the directions of the axes of space in the picture.
pub(super) fn axes(towards: [f64; 3]) -> [[f64; 2]; 3] {
    let [right, up, _] = basis(towards);
    [0, 1, 2].map(|axis| [right[axis], up[axis]])
}

/// Returns width and height of the picture of a flow, m.
pub(super) fn extent(header: &Header, towards: [f64; 3]) -> [f64; 2] {
    let [low, high] = Camera::new(header, towards).corners(header);
    [high[0] - low[0], high[1] - low[1]]
}

/// Returns the colours of a picture, row by row from the top.
pub(super) fn paint(
    frame: &Frame,
    view: &View3<'_>,
    values: &[f32],
    size: [usize; 2],
    colour: impl Fn(f64) -> Colour + Sync,
) -> Vec<Colour> {
    let camera = Camera::new(view.header, view.towards);
    let corners = camera.corners(view.header);
    let fine = size.map(|length| length * SAMPLES);
    let canvas = Canvas { camera, corners, size: fine, radius: RADIUS * view.header.spacing };
    let shown = |slot: &usize| frame.zone[*slot] != ABSENT && frame.zone[*slot] != Zone::Reservoir as u8;
    let shown: Vec<usize> =
        (0..frame.len()).filter(shown).filter(|&slot| is_kept(frame, slot, view)).collect();
    let (walls, fluid): (Vec<usize>, Vec<usize>) =
        shown.into_iter().partition(|&slot| frame.zone[slot] == Zone::Wall as u8);
    let buffers = [canvas.nearest(frame, &fluid), canvas.nearest(frame, &walls)];
    let depths = fluid.iter().map(|&slot| canvas.place(frame, slot).1);
    let (near, far) = depths
        .fold((f64::NEG_INFINITY, f64::INFINITY), |(near, far), depth| (near.max(depth), far.min(depth)));
    let point = |index: usize| -> [f64; 3] {
        let fluid = found(buffers[0][index]).map(|slot| {
            let value = f64::from(values[slot]);
            let own = if value.is_finite() { colour(value) } else { NO_VALUE };
            let (shade, depth) = canvas.light(frame, slot, index);
            let haze = HAZE * (near - depth) / (near - far).max(f64::MIN_POSITIVE);
            mix(own.map(|channel| shade * f64::from(channel)), PAPER, haze.clamp(0.0, HAZE))
        });
        let wall = found(buffers[1][index]).map(|slot| canvas.light(frame, slot, index));
        let below = fluid.unwrap_or(PAPER.map(f64::from));
        match wall {
            Some((shade, depth)) if fluid.is_none() || is_in_front(depth, buffers[0][index]) => {
                let share = WALL_SHARES[usize::from(fluid.is_none())];
                let wall = WALL.map(|channel| shade * f64::from(channel));
                std::array::from_fn(|k| below[k] + share * (wall[k] - below[k]))
            }
            _ => below,
        }
    };
    let pixel = |pixel: usize| {
        let (column, row) = (pixel % size[0], pixel / size[0]);
        let mut sum = [0.0; 3];
        for sample in 0..SAMPLES * SAMPLES {
            let (x, y) = (column * SAMPLES + sample % SAMPLES, row * SAMPLES + sample / SAMPLES);
            let found = point(y * fine[0] + x);
            sum.iter_mut().zip(found).for_each(|(sum, part)| *sum += part / (SAMPLES * SAMPLES) as f64);
        }
        sum.map(|channel| channel.round().clamp(0.0, 255.0) as u8)
    };
    (0..size[0] * size[1]).into_par_iter().map(pixel).collect()
}

/// Returns true for a particle that is not in front of the plane that cuts the flow.
fn is_kept(frame: &Frame, slot: usize, view: &View3<'_>) -> bool {
    let Some(Slice { axis, at }) = view.cut else { return true };
    let [low, high] = view.header.bounds;
    let at = at.unwrap_or(0.5 * (low[axis] + high[axis]));
    let beyond = frame.position[axis][slot] - at;
    if view.towards[axis] >= 0.0 { beyond <= 0.0 } else { beyond >= 0.0 }
}

fn mix(colour: [f64; 3], other: Colour, share: f64) -> [f64; 3] {
    std::array::from_fn(|k| colour[k] + share * (f64::from(other[k]) - colour[k]))
}

/// Entry of a depth buffer: depth in the upper half, so that the larger entry is nearer to the
/// viewer whatever the order of the particles, slot in the lower half; 0 without a ball.
fn entry(depth: f64, slot: usize) -> u64 {
    let bits = (depth as f32).to_bits();
    // Orders negative numbers below positive ones.
    let ordered = if bits >> 31 == 0 { bits | 1 << 31 } else { !bits };
    u64::from(ordered) << 32 | (slot as u64 + 1)
}

fn found(entry: u64) -> Option<usize> {
    (entry & 0xffff_ffff).checked_sub(1).map(|slot| slot as usize)
}

fn is_in_front(depth: f64, other: u64) -> bool {
    entry(depth, 0) >> 32 >= other >> 32
}

/// Points of a picture.
struct Canvas {
    camera: Camera,
    corners: [[f64; 2]; 2],
    /// Number of points to the right and down.
    size: [usize; 2],
    /// Radius of a ball, m.
    radius: f64,
}

impl Canvas {
    /// Returns the middle of a ball on the picture, points from the upper left corner, its depth,
    /// m, and its radius, points.
    fn place(&self, frame: &Frame, slot: usize) -> ([f64; 2], f64, f64) {
        let point = DVec3::from_array([0, 1, 2].map(|axis| frame.position[axis][slot]));
        let ([right, up], depth, scale) = self.camera.project(point);
        let [low, high] = self.corners;
        let points = self.size[0] as f64 / (high[0] - low[0]);
        let radius = (scale * self.radius * points).max(0.75);
        ([(right - low[0]) * points, (high[1] - up) * points], depth, radius)
    }

    /// Returns the depth buffer of particles.
    fn nearest(&self, frame: &Frame, slots: &[usize]) -> Vec<u64> {
        let buffer: Vec<AtomicU64> = (0..self.size[0] * self.size[1]).map(|_| AtomicU64::new(0)).collect();
        slots.into_par_iter().for_each(|&slot| {
            let ([x, y], depth, radius) = self.place(frame, slot);
            let range = |middle: f64, size: usize| {
                let low = (middle - radius).floor().max(0.0) as usize;
                low..((middle + radius).ceil().max(0.0) as usize).min(size)
            };
            for row in range(y, self.size[1]) {
                for column in range(x, self.size[0]) {
                    let offset = [column as f64 + 0.5 - x, row as f64 + 0.5 - y].map(|part| part / radius);
                    let square = offset[0] * offset[0] + offset[1] * offset[1];
                    if square < 1.0 {
                        let depth = depth + self.radius * (1.0 - square).sqrt();
                        // The largest of all is the same in every order.
                        buffer[row * self.size[0] + column].fetch_max(entry(depth, slot), Ordering::Relaxed);
                    }
                }
            }
        });
        buffer.into_iter().map(AtomicU64::into_inner).collect()
    }

    /// Returns brightness and depth, m, of a ball at a point of the picture. The light is above the
    /// viewer at the left.
    fn light(&self, frame: &Frame, slot: usize, index: usize) -> (f64, f64) {
        let ([x, y], depth, radius) = self.place(frame, slot);
        let point = [(index % self.size[0]) as f64 + 0.5 - x, (index / self.size[0]) as f64 + 0.5 - y];
        let [right, down] = point.map(|part| part / radius);
        let towards = (1.0 - right * right - down * down).max(0.0).sqrt();
        let lit = (-0.35 * right - 0.45 * down + 0.82 * towards).max(0.0);
        (0.45 + 0.6 * lit, depth + self.radius * towards)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(places: &[([f64; 3], u8)]) -> Frame {
        let mut frame = Frame::absent(places.len());
        for (slot, (place, zone)) in places.iter().enumerate() {
            (0..3).for_each(|axis| frame.position[axis][slot] = place[axis]);
            frame.zone[slot] = *zone;
        }
        frame
    }

    fn header() -> Header {
        Header { dimensions: 3, spacing: 0.4, bounds: [[-1.0; 3], [1.0; 3]], ..Header::default() }
    }

    fn middle(frame: &Frame, towards: [f64; 3], cut: Option<Slice>) -> Colour {
        let header = header();
        let view = View3 { header: &header, towards, cut };
        let values: Vec<f32> = (0..frame.len()).map(|slot| slot as f32).collect();
        let colour = |value: f64| if value == 0.0 { [250, 0, 0] } else { [0, 0, 250] };
        let pixels = paint(frame, &view, &values, [101, 101], colour);
        pixels[50 * 101 + 50]
    }

    #[test]
    fn nearer_particle_hides_the_one_behind_it() {
        let two = frame(&[([0.0, 0.0, 0.8], 0), ([0.0, 0.0, -0.8], 0)]);
        let red = |colour: Colour| colour[0] > 200 && colour[2] < 60;
        let front = middle(&two, [0.0, 0.0, 1.0], None);
        assert!(red(front), "{front:?}");
        let back = middle(&two, [0.0, 0.0, -1.0], None);
        assert!(back[2] > 200 && back[0] < 60, "{back:?}");
        // What is cut off shows the particle behind it, which is paler.
        let cut = middle(&two, [0.0, 0.0, 1.0], Some(Slice { axis: 2, at: None }));
        assert!(cut[2] > 200 && !red(cut), "{cut:?}");
    }

    #[test]
    fn walls_in_front_are_transparent_and_those_behind_hidden() {
        let fluid = ([0.0; 3], 0);
        let alone = middle(&frame(&[fluid]), [0.0, 0.0, 1.0], None);
        let behind = middle(&frame(&[fluid, ([0.0, 0.0, -0.8], 1)]), [0.0, 0.0, 1.0], None);
        assert_eq!(alone, behind);
        let before = middle(&frame(&[fluid, ([0.0, 0.0, 0.8], 1)]), [0.0, 0.0, 1.0], None);
        assert!(before != alone && before[0] > 180 && before[1] < 60, "{before:?}");
    }

    #[test]
    fn far_things_are_smaller_and_axes_keep_their_directions() {
        let camera = Camera::new(&header(), [0.0, 0.0, 2.0]);
        let (near, ..) = camera.project(DVec3::new(0.5, 0.5, 1.0));
        let (far, ..) = camera.project(DVec3::new(0.5, 0.5, -1.0));
        assert!(near[0] > 0.5 && far[0] < 0.5 && near[0] == near[1]);
        assert_eq!(axes([0.0, 0.0, 1.0]), [[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]);
        let from_above = axes([0.0, 1.0, 0.0]);
        assert!(from_above[2][1] == 1.0 && from_above[1] == [0.0, 0.0], "{from_above:?}");
    }
}
