//! Particles around a point as columns of doubles, for vectorised fits, and sums over the lanes.

use crate::math::lanes::{Lanes, MOST_LANES};

/// Fields that are fitted at once: velocity, pressure, density.
pub(super) const FIELDS: usize = 5;

/// Particles in the support of a point as columns, padded by particles without volume to whole
/// vectors.
#[derive(Debug)]
pub(super) struct NearColumns<const D: usize> {
    /// (x_b − x)/h.
    pub(super) offset: [Vec<f64>; D],
    /// Volume, m³ (m² in 2D); after the fit the volume times w(q).
    pub(super) volume: Vec<f64>,
    /// Velocity, m/s, pressure, Pa, and density, kg/m³.
    pub(super) fields: [Vec<f64>; FIELDS],
}

impl<const D: usize> NearColumns<D> {
    pub(super) fn new() -> Self {
        Self {
            offset: std::array::from_fn(|_| Vec::new()),
            volume: Vec::new(),
            fields: std::array::from_fn(|_| Vec::new()),
        }
    }

    pub(super) fn clear(&mut self) {
        let Self { offset, volume, fields } = self;
        offset.iter_mut().chain([volume]).chain(fields).for_each(Vec::clear);
    }

    /// Pads the columns and returns the number of particles.
    pub(super) fn pad(&mut self) -> usize {
        let count = self.volume.len();
        let padded = count.next_multiple_of(MOST_LANES);
        let Self { offset, volume, fields } = self;
        offset.iter_mut().chain([volume]).chain(fields).for_each(|column| column.resize(padded, 0.0));
        count
    }

    /// Returns 1, the coordinates and their products for the particles of a vector.
    #[inline(always)]
    pub(super) fn basis<L: Lanes<Real = f64>, const N: usize>(&self, at: usize) -> [L; N] {
        let mut basis = [L::constant(1.0); N];
        for d in 0..D {
            basis[1 + d] = L::read(&self.offset[d][at..]);
        }
        let mut next = D + 1;
        for i in 0..D {
            for j in i..D {
                if next < N {
                    basis[next] = basis[1 + i] * basis[1 + j];
                }
                next += 1;
            }
        }
        basis
    }

    /// Returns Σ_b (V_b W_b Σ_i a_i φ_i / Σ V W)² of a fit with the shares a.
    #[inline(always)]
    pub(super) fn gain<L: Lanes<Real = f64>, const N: usize>(
        &self,
        count: usize,
        total: f64,
        shares: &[f64; N],
    ) -> f64 {
        let mut gain = L::constant(0.0);
        for at in (0..count).step_by(L::COUNT) {
            let basis = self.basis::<L, N>(at);
            let mut share = L::constant(0.0);
            for i in 0..N {
                share = basis[i].mul_add(L::splat(shares[i]), share);
            }
            let part = L::read(&self.volume[at..]) * share;
            gain = part.mul_add(part, gain);
        }
        gain.sum() / (total * total)
    }
}

/// Returns the sums over the lanes of the upper triangle, as a whole symmetric matrix.
#[inline(always)]
pub(super) fn whole<L: Lanes<Real = f64>, const N: usize>(moments: [[L; N]; N]) -> [[f64; N]; N] {
    let mut all = [[0.0; N]; N];
    for i in 0..N {
        let row = sums_of(&moments[i]);
        for j in i..N {
            all[i][j] = row[j];
            all[j][i] = row[j];
        }
    }
    all
}

/// Returns the sum over the lanes of each vector, of as many vectors at once as there are lanes;
/// one by one the sums took longer than the loop over the neighbours.
#[inline(always)]
pub(super) fn sums_of<L: Lanes<Real = f64>, const N: usize>(vectors: &[L; N]) -> [f64; N] {
    let mut sums = [0.0; N];
    for at in (0..N).step_by(L::COUNT) {
        let count = L::COUNT.min(N - at);
        let mut group = [L::constant(0.0); MOST_LANES];
        group[..count].copy_from_slice(&vectors[at..at + count]);
        let found = L::sum_each(&group).to_array();
        sums[at..at + count].copy_from_slice(&found[..count]);
    }
    sums
}
