//! Particles to pixels: a filled field, grey walls, and white without particles.
//!
//! ```text
//! f(x) = Σ_b f_b w_b / Σ_b w_b,   w = (1 − (r/R)²)³ inside R = 1.5 Δ (2D), 1.75 Δ (3D)
//! ```
//!
//! A pixel is white if its nearest particle is farther away than in any disordered but connected
//! fluid, so that a hole of one missing particle is visible. It is wall if the Σ w³ of the walls is
//! the larger one.

use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::view::{Cells, View};
use crate::drawing::{Colour, PAPER};
use crate::frame::{ABSENT, Frame};
use sphecs_core::particles::zone::Zone;

/// Colour of walls.
pub(super) const WALL: Colour = [0x9a, 0x9f, 0xa6];

/// Colour of particles without a value.
pub(super) const NO_VALUE: Colour = [0xd8, 0xdb, 0xdf];

/// Samples of a pixel along each side, which smooth the edges of walls.
const SAMPLES: usize = 2;

/// Returns the colours of an area of pixels, row by row from the top, by the colours of points, m.
pub(super) fn paint(
    view: &View,
    [width, height]: [usize; 2],
    colour: impl Fn([f64; 2]) -> Colour + Sync,
) -> Vec<Colour> {
    let extent = view.extent();
    (0..width * height)
        .into_par_iter()
        .map(|pixel| {
            let mut sum = [0_u32; 3];
            for sample in 0..SAMPLES * SAMPLES {
                let offset = |k: usize| (k as f64 + 0.5) / SAMPLES as f64;
                let right = ((pixel % width) as f64 + offset(sample % SAMPLES)) / width as f64;
                let down = ((pixel / width) as f64 + offset(sample / SAMPLES)) / height as f64;
                let found = colour([view.low[0] + right * extent[0], view.high[1] - down * extent[1]]);
                sum.iter_mut().zip(found).for_each(|(sum, part)| *sum += u32::from(part));
            }
            sum.map(|sum| (sum / (SAMPLES * SAMPLES) as u32) as u8)
        })
        .collect()
}

/// Content of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Found {
    /// No particle is near.
    Nothing,
    /// Wall.
    Wall,
    /// Fluid with a value, NaN without one.
    Value(f64),
}

impl Found {
    /// Returns the colour of a point without a value.
    pub(super) fn colour(self) -> Colour {
        match self {
            Found::Nothing => PAPER,
            Found::Wall => WALL,
            Found::Value(_) => NO_VALUE,
        }
    }
}

/// Particles near the plane, sorted into cells.
pub(super) struct Particles {
    places: Vec<[f64; 3]>,
    values: Vec<f32>,
    wall: Vec<bool>,
    cells: Cells,
    reach: f64,
    farthest: f64,
}

impl Particles {
    /// Returns the particles of a frame that a view shows.
    pub(super) fn new(frame: &Frame, view: &View, values: &[f32]) -> Self {
        // Half the diagonal of a lattice cell is 0.71 Δ in 2D, 0.87 Δ in 3D; the rest allows for
        // disorder.
        let (reach, farthest) = if view.dimensions == 2 { (1.5, 1.0) } else { (1.75, 1.2) };
        let reach = reach * view.spacing;
        let slots: Vec<usize> = (0..frame.len())
            .filter(|&slot| frame.zone[slot] != ABSENT && frame.zone[slot] != Zone::Reservoir as u8)
            .filter(|&slot| {
                view.place(frame, slot)[2].abs() < reach && view.is_near(view.place(frame, slot), reach)
            })
            .collect();
        let places: Vec<[f64; 3]> = slots.iter().map(|&slot| view.place(frame, slot)).collect();
        Self {
            cells: Cells::new(view, reach, &places),
            places,
            values: slots.iter().map(|&slot| values[slot]).collect(),
            wall: slots.iter().map(|&slot| frame.zone[slot] == Zone::Wall as u8).collect(),
            reach,
            farthest: farthest * view.spacing,
        }
    }

    /// Returns the content of a point, m, or that of the nearest particle.
    pub(super) fn at(&self, x: f64, y: f64, nearest: bool) -> Found {
        let (mut fluid, mut wall, mut valued, mut sum) = (0.0, 0.0, 0.0, 0.0);
        let (mut closest, mut label) = (f64::INFINITY, f64::NAN);
        let mut closest_of_all = f64::INFINITY;
        for index in self.cells.near(x, y) {
            let place = self.places[index];
            let square = (place[0] - x).powi(2) + (place[1] - y).powi(2) + place[2] * place[2];
            let rest = 1.0 - square / (self.reach * self.reach);
            if rest <= 0.0 {
                continue;
            }
            let weight = rest * rest * rest;
            closest_of_all = closest_of_all.min(square);
            // Steeper than the weight of the mean: corners stay square, and disorder does not
            // roughen the edge.
            let presence = weight * weight * weight;
            if self.wall[index] {
                wall += presence;
                continue;
            }
            fluid += presence;
            let value = f64::from(self.values[index]);
            if value.is_finite() {
                valued += weight;
                sum += weight * value;
            }
            if square < closest {
                (closest, label) = (square, value);
            }
        }
        if closest_of_all > self.farthest * self.farthest {
            Found::Nothing
        } else if wall > fluid {
            Found::Wall
        } else if nearest {
            Found::Value(label)
        } else {
            Found::Value(sum / valued)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::header::Header;

    /// Returns a block of 20 × 20 particles on three layers of wall, with a hole where nine
    /// particles are missing.
    fn block() -> (Frame, View) {
        let mut frame = Frame::absent(20 * 23);
        for slot in 0..frame.len() {
            let (column, row) = (slot % 20, slot / 20);
            let hole = (9..12).contains(&column) && (12..15).contains(&row);
            frame.zone[slot] = if row < 3 {
                1
            } else if hole {
                4
            } else {
                0
            };
            if !hole {
                frame.position[0][slot] = column as f64;
                frame.position[1][slot] = row as f64;
                frame.position[2][slot] = 0.0;
            }
        }
        let bounds = frame.bounds().expect("particles");
        let header =
            Header { dimensions: 2, spacing: 1.0, smoothing_length: 1.5, bounds, ..Header::default() };
        (frame, View::new(&header, None).expect("a view"))
    }

    #[test]
    fn fluid_is_filled_walls_are_grey_and_a_hole_is_white() {
        let (frame, view) = block();
        let values: Vec<f32> = frame.position[0].iter().map(|&x| x as f32).collect();
        let particles = Particles::new(&frame, &view, &values);
        for row in 0..200 {
            for column in 0..200 {
                let (x, y) = (f64::from(column) * 0.095, 3.0 + f64::from(row) * 0.095);
                let from_hole = (x - 10.0).abs().max((y - 13.0).abs());
                match particles.at(x, y, false) {
                    // Where a hole cuts its support, the mean of a linear field is wrong by less
                    // than a spacing.
                    Found::Value(value) => assert!((value - x).abs() < 1.0, "{value} at {x}, {y}"),
                    other => assert!(from_hole < 2.0, "{other:?} at {x}, {y}"),
                }
            }
        }
        assert_eq!(particles.at(10.0, 13.0, false), Found::Nothing);
        assert_eq!(particles.at(5.0, 2.4, false), Found::Wall);
        assert!(matches!(particles.at(5.0, 2.6, false), Found::Value(_)));
    }

    #[test]
    fn label_is_taken_from_the_nearest_particle() {
        let (frame, view) = block();
        let values: Vec<f32> = (0..frame.len()).map(|slot| (slot % 2) as f32).collect();
        let particles = Particles::new(&frame, &view, &values);
        assert_eq!(particles.at(4.4, 6.0, true), Found::Value(0.0));
        assert_eq!(particles.at(4.6, 6.0, true), Found::Value(1.0));
    }
}
