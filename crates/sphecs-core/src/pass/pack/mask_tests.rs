//! Masks and tiles of packs of many sizes.

use super::mask::{BITS, CoveredLanes, MaskBuilder, NeighbourMask, StartLanes, least_lanes_per_bit};
use super::{Only, Pack, Source};
use crate::math::grid::CellGrid;
use crate::math::lanes::{InstructionSet, Lanes, MOST_LANES, Vectorised};
use crate::math::real::Real;

/// Number of particles on a line in one cell, each 0.001 h from the next.
struct Line(usize);

impl Vectorised<f64> for Line {
    type Output = ();
    type Module = Self;

    #[inline(always)]
    fn run<L: Lanes<Real = f64>>(self) {
        let count = self.0;
        let position = [(0..count).map(|row| 0.001 * row as f64).collect(), vec![0.5; count]];
        let mut grid = CellGrid::new([0.0; 2], [1.0; 2], [false; 2], 1.0, 1.0);
        let ids: Vec<u32> = (0..count as u32).collect();
        grid.build(&position, &ids, |_| true).expect("all are inside");
        let (inverse_h, support_ratio) = (1.0, 1.0);
        let source = Source {
            grid: &grid,
            position: &position,
            columns: &[],
            inverse_h,
            support_ratio,
            only: Only::All,
        };
        let mut pack = Pack::default();
        assert!(pack.fill::<L, 2>(&source, 0, |_| true));
        // A support of 0.0005 contains the particle alone, one of 0.0305 some before and behind it.
        // By tiles every vector is read once and all neighbours are found, for any number of them.
        for (row, reach) in [0, count / 2, count - 1].into_iter().flat_map(|row| [(row, 0), (row, 30)]) {
            let point = pack.relative(&source, row).map(L::splat);
            let support = 0.001 * reach as f64 + 0.0005;
            let squares = |x: L| (x * x, L::constant(support * support));
            let in_reach = (row.saturating_sub(reach)..count.min(row + reach + 1)).len() as u32;
            let (mut mask, mut covered) = (NeighbourMask::ALL, CoveredLanes::default());
            let (mut read, mut found) = (0, 0);
            for tile in pack.tiles::<L, 2>(2) {
                let mut builder = MaskBuilder::default();
                for vector in 0..tile.len() {
                    read += L::COUNT;
                    let (q2, limit) = squares(point[0] - tile.at(vector).column(0));
                    builder.add::<L, 2>(q2, limit);
                }
                for lane in tile.start_lanes(builder, &mut covered) {
                    let (q2, limit) = squares(point[0] - tile.at_lane(lane).column(0));
                    found += L::bits(q2.less(limit)).count_ones();
                }
                tile.store_mask(builder, &mut mask);
            }
            let expected = (count.next_multiple_of(L::COUNT), in_reach);
            assert_eq!((read, found), expected, "row {row} of {count}, {} lanes", L::COUNT);
            // By the mask of the pack as well, where a single particle with a bit takes one vector.
            let vectors = |mask: NeighbourMask| {
                let entries = pack.masked_entries::<L, 2>(2, mask);
                let mut found = 0;
                let read = entries
                    .inspect(|entry| {
                        let (q2, limit) = squares(point[0] - entry.column(0));
                        found += L::bits(q2.less(limit)).count_ones();
                    })
                    .count();
                (read, found)
            };
            let all = count.div_ceil(L::COUNT);
            assert_eq!(vectors(NeighbourMask::ALL), (all, in_reach), "{} lanes, {count} particles", L::COUNT);
            assert_eq!(vectors(mask).1, in_reach, "row {row} of {count}, {} lanes", L::COUNT);
            if reach == 0 {
                let beyond = all.saturating_sub(BITS);
                let of_bits = usize::from(row / L::COUNT < BITS);
                assert_eq!(vectors(mask).0, of_bits + beyond, "row {row} of {count}, {} lanes", L::COUNT);
            }
        }
    }
}

/// Vectors that start at the bits of a mask cover each lane of the mask exactly once.
struct Cover;

impl Vectorised<f64> for Cover {
    type Output = ();
    type Module = Self;

    #[inline(always)]
    fn run<L: Lanes<Real = f64>>(self) {
        let unit = least_lanes_per_bit::<L>();
        for bits in [0b1u64, 0b1000_0001, 0b1100_1111_0000_0000_1111_0101, u64::MAX, 1 << 63, 0] {
            let mut covered = [0; 2 * BITS + MOST_LANES];
            let mut last = None;
            for lane in StartLanes::new::<L>(bits, unit) {
                assert!(bits >> (lane / unit) & 1 != 0, "starts at a neighbour");
                assert!(last.is_none_or(|last| lane >= last + L::COUNT), "covers no lane twice");
                for covered in &mut covered[lane..lane + L::COUNT] {
                    *covered += 1;
                }
                last = Some(lane);
            }
            for pair in (0..BITS).filter(|pair| bits >> pair & 1 != 0) {
                assert_eq!(&covered[unit * pair..][..unit], &[1; 2][..unit], "covers all neighbours");
            }
        }
    }
}

#[test]
fn vectors_cover_every_neighbour_once() {
    for set in InstructionSet::available() {
        <f64 as Real>::dispatch(set, Cover);
    }
}

#[test]
fn neighbours_are_found_in_packs_of_more_vectors_than_bits() {
    for set in InstructionSet::available() {
        for count in [1, 7, 64, 65, 128, 129, 200, 256, 257, 64 * 8, 64 * 8 + 1, 999] {
            <f64 as Real>::dispatch(set, Line(count));
        }
    }
}
