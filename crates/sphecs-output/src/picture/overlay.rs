//! Lines over the field of a picture: lines of equal value, streamlines and arrows.
//!
//! Each line is dark on a wider light one, so that it is visible on every colour of the scale.

use super::arrows::{Arrow, arrows, head};
use super::contours::contours;
use super::plane_grid::PlaneGrid;
use super::sheet::Sheet;
use super::streamlines::streamlines;
use super::view::View;
use crate::drawing::ticks::ticks;
use crate::drawing::{Colour, Drawing, INK, Pen};

/// Colour below the lines.
const BELOW: Colour = [0xff; 3];

/// Distance of the arrow heads on a streamline, distances of the lines.
const HEADS: f64 = 9.0;

/// A picture with what is needed to draw lines on it.
pub(super) struct Overlay<'a> {
    pub(super) drawing: &'a mut Drawing,
    pub(super) view: &'a View,
    pub(super) sheet: &'a Sheet,
    pub(super) grid: &'a PlaneGrid,
}

impl Overlay<'_> {
    fn corners(&self) -> [[f64; 2]; 2] {
        [self.view.low, self.view.high]
    }

    /// Returns the pixel of a point in the plane, m.
    fn pixel(&self, [right, up]: [f64; 2]) -> [f64; 2] {
        let scale = self.sheet.size[0] as f64 / self.view.extent()[0];
        let [x, y] = self.sheet.corner.map(|corner| corner as f64);
        [x + (right - self.view.low[0]) * scale, y + (self.view.high[1] - up) * scale]
    }

    fn thin(&self) -> f64 {
        f64::from(self.sheet.text) / 14.0
    }

    /// Draws a line of points, m.
    fn line(&mut self, points: &[[f64; 2]], width: f64) {
        let pixels: Vec<[f64; 2]> = points.iter().map(|&point| self.pixel(point)).collect();
        self.drawing.curve(pixels.clone(), Pen { width: 2.2 * width, colour: BELOW, dash: None });
        self.drawing.curve(pixels, Pen { width, colour: INK, dash: None });
    }

    /// Draws the head of an arrow at a tip, m, that points along a vector.
    fn head(&mut self, tip: [f64; 2], along: [f64; 2], length: f64) {
        let (tip, along) = (self.pixel(tip), [along[0], -along[1]]);
        let size = along[0].hypot(along[1]).max(f64::MIN_POSITIVE);
        // The light rim of a small head would be all that is seen of it.
        let rim = self.thin().min(0.12 * length);
        let ahead = [0, 1].map(|k| tip[k] + 1.5 * rim * along[k] / size);
        self.drawing.area(head(ahead, along, length + 3.0 * rim), BELOW);
        self.drawing.area(head(tip, along, length), INK);
    }

    /// Draws lines at round levels within a range, at most `count` of them.
    pub(super) fn contours(&mut self, (low, high): (f64, f64), count: u32) {
        let margin = 1e-6 * (high - low);
        let (low, high) = (low + margin, high - margin);
        for level in ticks(low, high, count as usize) {
            for line in contours(self.grid, level) {
                self.line(&line, self.thin());
            }
        }
    }

    /// Draws streamlines, as many across the picture at their distance.
    pub(super) fn streamlines(&mut self, across: u32) {
        let extent = self.view.extent();
        // A long channel would have few lines across its width by its length alone.
        let distance = (extent[0] * extent[1]).sqrt().min(extent[0]) / f64::from(across);
        let grid = self.grid;
        let velocity = |point: [f64; 2]| grid.velocity_at(point);
        let lines = streamlines(velocity, self.corners(), grid.fastest(), distance);
        let size = 0.55 * f64::from(self.sheet.text);
        for line in lines {
            self.line(&line, self.thin());
            let length = |pair: &[[f64; 2]]| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]);
            let whole: f64 = line.windows(2).map(length).sum();
            let heads = (whole / (HEADS * distance)).round().max(1.0);
            let (mut along, mut next) = (0.0, 0.5 * whole / heads);
            for pair in line.windows(2) {
                along += length(pair);
                if along >= next {
                    next += whole / heads;
                    self.head(pair[1], [pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]], size);
                }
            }
        }
    }

    /// Draws arrows, as many across the picture, and their scale.
    pub(super) fn arrows(&mut self, across: u32, largest_speed: f64) {
        let scale = self.sheet.size[0] as f64 / self.view.extent()[0];
        let found = arrows(self.grid, self.corners(), across, largest_speed);
        for Arrow { tail, tip } in found {
            let along = [tip[0] - tail[0], tip[1] - tail[1]];
            let length = along[0].hypot(along[1]) * scale;
            let size = (0.45 * length).min(0.6 * f64::from(self.sheet.text));
            // The shaft ends inside the head, whose tip it would blunt.
            let neck = [0, 1].map(|k| tip[k] - 0.6 * size / length * along[k]);
            self.line(&[tail, neck], self.thin());
            self.head(tip, along, size);
        }
        let step = self.view.extent()[0] / f64::from(across);
        self.sheet.arrow_key(self.drawing, largest_speed, super::arrows::LONGEST * step * scale);
    }
}
