//! The ends of as many rows as there are lanes, a lane being a row: one by one they would be a sixth of the pass in 2D.

use super::RatesSummary;
use super::ends::RowSums;
use super::row::PairLoop;
use crate::math::lanes::{Lanes, MOST_LANES};
use crate::math::real::Real;

/// Sums of a row at most: acceleration and shift in 3D, divergence, damping.
const SUMS: usize = 2 * 3 + 2;

/// Rows that have been walked and wait for their end.
pub(super) struct Batch<L: Lanes, const D: usize> {
    /// By sum: the vectors of all rows. Acceleration first, then shift, divergence and damping.
    sums: [[L; MOST_LANES]; SUMS],
    rows: [usize; MOST_LANES],
    density: [L::Real; MOST_LANES],
    velocity: [[L::Real; MOST_LANES]; D],
    /// 1 for rows with a wall in their support, 0 for the others.
    at_wall: [L::Real; MOST_LANES],
    count: usize,
    extremes: Extremes<L>,
}

/// The largest so far, lane by lane: as in [`RatesSummary`], the squares of acceleration and speed.
struct Extremes<L> {
    acceleration: L,
    signal_speed: L,
    speed: L,
    divergence: L,
    damping: L,
    damping_at_walls: L,
    /// 0, or no number once one of the rates has been none: a maximum would forget it.
    poison: L,
}

/// A row that a batch takes up.
pub(super) struct Taken<R, const D: usize> {
    pub row: usize,
    /// Its velocity as the pass sees it, m/s.
    pub velocity: [R; D],
    /// Whether a wall is in its support.
    pub at_wall: bool,
}

/// Acceleration, shifting vector, and divergence and damping rate of consecutive rows from `first` on.
pub(super) struct Columns<'a, 'b, R, const D: usize> {
    pub first: usize,
    pub acceleration: &'a mut [&'b mut [R]; D],
    pub shift: &'a mut [&'b mut [R]; D],
    pub divergence: &'a mut [R],
    pub damping: &'a mut [R],
}

impl<L: Lanes, const D: usize> Batch<L, D> {
    #[inline(always)]
    pub fn new() -> Self {
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

    /// Takes up a row; returns whether there is room for no more.
    #[inline(always)]
    pub fn take(&mut self, pair_loop: &PairLoop<L, D>, sums: RowSums<L, D>, of: Taken<L::Real, D>) -> bool {
        let slot = self.count % MOST_LANES;
        let along_x_scale = L::constant(-pair_loop.gradient_scale / sums.density);
        let along_v_scale = L::constant(pair_loop.viscous_scale);
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
        let sound_speed = L::constant(pair_loop.pair.tait.sound_speed_at(sums.density));
        self.extremes.signal_speed = self.extremes.signal_speed.max(sums.signal + sound_speed);
        self.count += 1;
        self.count == L::COUNT
    }

    /// Ends the rows that were taken up.
    #[inline(always)]
    pub fn finish(&mut self, pair_loop: &PairLoop<L, D>, columns: &mut Columns<'_, '_, L::Real, D>) {
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
        let (zero, scale) = (L::constant(0.0), L::constant(pair_loop.gradient_scale));
        let put = |column: &mut [L::Real], values: L| put(column, columns.first, rows, values);

        let (mut squared, mut speed) = (zero, zero);
        for d in 0..D {
            let (a, v) = (sum(d), L::first_of(&self.velocity[d]));
            put(columns.acceleration[d], a);
            put(columns.shift[d], scale * sum(D + d));
            squared = a.mul_add(a, squared);
            speed = v.mul_add(v, speed);
        }
        let divergence = -(scale * sum(2 * D));
        put(columns.divergence, divergence);
        let own = L::constant(pair_loop.own_damping) / L::first_of(&self.density);
        let damping = -(L::constant(pair_loop.viscous_scale).mul_add(sum(2 * D + 1), own));
        put(columns.damping, damping);

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

    /// The largest of all rows that were ended; the squares of acceleration and speed.
    #[inline(always)]
    pub fn summary(&self) -> RatesSummary {
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

/// Writes the values of rows into a column that begins with the row `first`; nothing into one that is not in use.
#[inline(always)]
fn put<L: Lanes>(column: &mut [L::Real], first: usize, rows: &[usize], values: L) {
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
