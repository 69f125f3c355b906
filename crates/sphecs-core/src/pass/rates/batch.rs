//! Rates of several rows at once, one row per SIMD lane; one by one they took a sixth of the pass
//! in 2D.

use super::RatesSummary;
use super::wcsph_sums::WcsphSums;
use super::wcsph_terms::WcsphSettings;
use crate::math::lanes::{Lanes, MOST_LANES};
use crate::math::real::Real;
use crate::pass::fused::OutputColumns;

/// Most sums of a row: acceleration and shift in 3D, divergence, damping.
const SUMS: usize = 2 * 3 + 2;

/// Rows whose neighbours are summed and whose rates are not written yet.
pub(super) struct Batch<L: Lanes, const D: usize> {
    /// By sum and row: acceleration first, then shift, divergence and damping.
    sums: [[L; MOST_LANES]; SUMS],
    rows: [usize; MOST_LANES],
    density: [L::Real; MOST_LANES],
    velocity: [[L::Real; MOST_LANES]; D],
    /// 1 for rows with a wall in their support, 0 for the others.
    at_wall: [L::Real; MOST_LANES],
    count: usize,
    extremes: Extremes<L>,
}

/// Largest values so far, one per lane: those of [`RatesSummary`], but the squares of acceleration
/// and speed.
struct Extremes<L> {
    acceleration: L,
    signal_speed: L,
    speed: L,
    divergence: L,
    damping: L,
    damping_at_walls: L,
    /// 0, or NaN once one of the rates has been NaN: a maximum would lose it.
    poison: L,
}

/// A row of a batch beside its sums.
pub(super) struct BatchedRow<R, const D: usize> {
    pub row: usize,
    /// Velocity as the pass takes it, m/s.
    pub velocity: [R; D],
    /// True if a wall is in its support.
    pub at_wall: bool,
}

impl<L: Lanes, const D: usize> Batch<L, D> {
    #[inline(always)]
    pub(super) fn new() -> Self {
        let (zero, none) = (L::constant(0.0), [L::Real::default(); MOST_LANES]);
        Self {
            sums: [[zero; MOST_LANES]; SUMS],
            rows: [0; MOST_LANES],
            density: none,
            velocity: [none; D],
            at_wall: none,
            count: 0,
            extremes: Extremes {
                acceleration: zero,
                signal_speed: zero,
                speed: zero,
                divergence: zero,
                damping: zero,
                damping_at_walls: zero,
                poison: zero,
            },
        }
    }

    /// Adds a row; returns whether the batch is full.
    #[inline(always)]
    pub(super) fn add(
        &mut self,
        settings: &WcsphSettings<'_, L, D>,
        sums: &WcsphSums<L, D>,
        of: BatchedRow<L::Real, D>,
    ) -> bool {
        let slot = self.count % MOST_LANES;
        let along_x_scale = L::constant(-settings.gradient_scale / sums.density);
        let along_v_scale = L::constant(settings.viscous_scale);
        for d in 0..D {
            self.sums[d][slot] = sums.along_x[d].mul_add(along_x_scale, sums.along_v[d] * along_v_scale);
            self.sums[D + d][slot] = sums.shift[d];
            self.velocity[d][slot] = of.velocity[d];
        }
        self.sums[2 * D][slot] = sums.divergence;
        self.sums[2 * D + 1][slot] = sums.damping;
        self.rows[slot] = of.row;
        self.density[slot] = L::Real::from_f64(sums.density);
        self.at_wall[slot] = L::Real::from_f64(f64::from(u8::from(of.at_wall)));
        let sound_speed = L::constant(settings.pair().tait.sound_speed_at(sums.density));
        self.extremes.signal_speed = self.extremes.signal_speed.max(sums.signal + sound_speed);
        self.count += 1;
        self.count == L::COUNT
    }

    /// Writes the rates of the rows and empties the batch.
    #[inline(always)]
    pub(super) fn finish(
        &mut self,
        settings: &WcsphSettings<'_, L, D>,
        columns: &mut OutputColumns<'_, L::Real, D>,
    ) {
        if self.count == 0 {
            return;
        }
        // Lanes without a row repeat the first.
        for slot in self.count..L::COUNT {
            for of_rows in &mut self.sums {
                of_rows[slot] = of_rows[0];
            }
            for of_rows in self.velocity.iter_mut().chain([&mut self.density, &mut self.at_wall]) {
                of_rows[slot] = of_rows[0];
            }
        }
        let sum = |at: usize| L::sum_each(&self.sums[at]);
        let rows = &self.rows[..self.count.min(MOST_LANES)];
        let (zero, scale) = (L::constant(0.0), L::constant(settings.gradient_scale));
        let OutputColumns { first, acceleration, shift, scalars: [of_divergence, of_damping] } = columns;

        let (mut squared, mut speed) = (zero, zero);
        for d in 0..D {
            let (a, v) = (sum(d), L::first_of(&self.velocity[d]));
            write(acceleration[d], *first, rows, a);
            write(shift[d], *first, rows, scale * sum(D + d));
            squared = a.mul_add(a, squared);
            speed = v.mul_add(v, speed);
        }
        let divergence = -(scale * sum(2 * D));
        write(of_divergence, *first, rows, divergence);
        let own = L::constant(settings.own_damping) / L::first_of(&self.density);
        let damping = -(L::constant(settings.viscous_scale).mul_add(sum(2 * D + 1), own));
        write(of_damping, *first, rows, damping);

        let extremes = &mut self.extremes;
        let at_wall = zero.less(L::first_of(&self.at_wall));
        let of_walls = L::keep(at_wall, damping);
        extremes.acceleration = extremes.acceleration.max(squared);
        extremes.speed = extremes.speed.max(speed);
        extremes.divergence = extremes.divergence.max(divergence.abs());
        extremes.damping = extremes.damping.max(damping - of_walls);
        extremes.damping_at_walls = extremes.damping_at_walls.max(of_walls);
        extremes.poison = (squared + speed + divergence.abs() + damping.abs()).mul_add(zero, extremes.poison);
        self.count = 0;
    }

    /// Returns the extremes of all rows that were written; the squares of acceleration and speed.
    #[inline(always)]
    pub(super) fn summary(&self) -> RatesSummary {
        let poison = self.extremes.poison.sum().to_f64();
        let largest = |lanes: L| lanes.largest().to_f64() + poison;
        RatesSummary {
            acceleration: largest(self.extremes.acceleration),
            signal_speed: largest(self.extremes.signal_speed),
            speed: largest(self.extremes.speed),
            divergence: largest(self.extremes.divergence),
            eddy_viscosity: 0.0,
            damping: largest(self.extremes.damping),
            damping_at_walls: largest(self.extremes.damping_at_walls),
        }
    }
}

/// Writes the values of rows into a column that begins with the row `first`; a column that is not
/// in use is empty and stays so.
#[inline(always)]
fn write<L: Lanes>(column: &mut [L::Real], first: usize, rows: &[usize], values: L) {
    if column.is_empty() {
        return;
    }
    let of_rows = values.to_array();
    let start = rows[0] - first;
    match column.get_mut(start..start + L::COUNT) {
        Some(whole) if rows.len() == L::COUNT && rows[L::COUNT - 1] - rows[0] == L::COUNT - 1 => {
            whole.copy_from_slice(&of_rows[..L::COUNT]);
        }
        _ => {
            for (&row, value) in rows.iter().zip(of_rows) {
                column[row - first] = value;
            }
        }
    }
}
