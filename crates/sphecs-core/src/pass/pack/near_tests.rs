//! What is near, by walks of packs of many sizes.

use super::near::{BITS, Covered, Near, NearNotes, Windows, fewest};
use super::{Only, Pack, Source};
use crate::math::grid::CellGrid;
use crate::math::lanes::{InstructionSet, Lanes, MOST_LANES, Vectorised};
use crate::math::real::Real;

/// So many particles in a row of one cell, each 0.001 h from the next.
struct Walk(usize);

impl Vectorised<f64> for Walk {
    type Output = ();

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
        // In reach of a support of 0.0005 are they themselves alone, of one of 0.0305 some before and behind: in stretches every vector comes
        // once, and all are found however many there are.
        for (row, reach) in [0, count / 2, count - 1].into_iter().flat_map(|row| [(row, 0), (row, 30)]) {
            let point = pack.relative(&source, row).map(L::splat);
            let support = 0.001 * reach as f64 + 0.0005;
            let near_to = |x: L| (x * x, L::constant(support * support));
            let in_reach = (row.saturating_sub(reach)..count.min(row + reach + 1)).len() as u32;
            let (mut near, mut covered) = (Near::ALL, Covered::default());
            let (mut walked, mut found) = (0, 0);
            for stretch in pack.stretches::<L, 2>(2) {
                let mut notes = NearNotes::default();
                for vector in 0..stretch.len() {
                    walked += L::COUNT;
                    let (q2, limit) = near_to(point[0] - stretch.at(vector).column(0));
                    notes.take::<L, 2>(q2, limit);
                }
                for lane in stretch.near(notes, &mut covered) {
                    let (q2, limit) = near_to(point[0] - stretch.at_lane(lane).column(0));
                    found += L::bits(q2.less(limit)).count_ones();
                }
                stretch.note(notes, &mut near);
            }
            let expected = (count.next_multiple_of(L::COUNT), in_reach);
            assert_eq!((walked, found), expected, "row {row} of {count}, {} lanes", L::COUNT);
            // From what was noted of the pack, too, and one by itself in one vector where there is a bit for it.
            let vectors = |near: Near| {
                let entries = pack.entries_near::<L, 2>(2, near);
                let mut found = 0;
                let walked = entries
                    .inspect(|entry| {
                        let (q2, limit) = near_to(point[0] - entry.column(0));
                        found += L::bits(q2.less(limit)).count_ones();
                    })
                    .count();
                (walked, found)
            };
            let all = count.div_ceil(L::COUNT);
            assert_eq!(vectors(Near::ALL), (all, in_reach), "{} lanes, {count} particles", L::COUNT);
            assert_eq!(vectors(near).1, in_reach, "row {row} of {count}, {} lanes", L::COUNT);
            if reach == 0 {
                let beyond = all.saturating_sub(BITS);
                let of_bits = usize::from(row / L::COUNT < BITS);
                assert_eq!(vectors(near).0, of_bits + beyond, "row {row} of {count}, {} lanes", L::COUNT);
            }
        }
    }
}

/// Vectors that begin at what was noted have each lane that was noted exactly once.
struct Cover;

impl Vectorised<f64> for Cover {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes<Real = f64>>(self) {
        let unit = fewest::<L>();
        for bits in [0b1u64, 0b1000_0001, 0b1100_1111_0000_0000_1111_0101, u64::MAX, 1 << 63, 0] {
            let mut covered = [0; 2 * BITS + MOST_LANES];
            let mut last = None;
            for lane in Windows::new::<L>(bits, unit) {
                assert!(bits >> (lane / unit) & 1 != 0, "begins at what is near");
                assert!(last.is_none_or(|last| lane >= last + L::COUNT), "none twice");
                for covered in &mut covered[lane..lane + L::COUNT] {
                    *covered += 1;
                }
                last = Some(lane);
            }
            for pair in (0..BITS).filter(|pair| bits >> pair & 1 != 0) {
                assert_eq!(&covered[unit * pair..][..unit], &[1; 2][..unit], "all that is near");
            }
        }
    }
}

#[test]
fn vectors_have_all_that_is_near_once() {
    for set in InstructionSet::available() {
        <f64 as Real>::dispatch(set, Cover);
    }
}

#[test]
fn a_particle_is_found_and_where_bits_do_not_suffice_all_are_walked() {
    for set in InstructionSet::available() {
        for count in [1, 7, 64, 65, 128, 129, 200, 256, 257, 64 * 8, 64 * 8 + 1, 999] {
            <f64 as Real>::dispatch(set, Walk(count));
        }
    }
}
