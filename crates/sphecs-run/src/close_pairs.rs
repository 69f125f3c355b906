//! Note on fluid particles that stay nearer than half a spacing.
//!
//! Near a stagnation point the lattice that arrives is compressed along the flow as the flow slows
//! down, to u/U of its spacing, and stretched across. A regular lattice has no concentration
//! gradient, however it is strained, so that pressure and weak shifting leave it as it is.

use serde::{Deserialize, Serialize};

use sphecs_core::format::{coordinate, grouped, significant, with_digits};
use sphecs_engine::systems::monitor::MonitorRow;
use sphecs_scene::model::Scene;
use sphecs_scene::scheme::Scheme;

/// Number of successive rows after which close pairs are noted: a pair that passes an edge is none.
const ROWS: u32 = 3;

/// Least number of pairs of a row that counts; single ones occur in edges.
const LEAST_PAIRS: u64 = 4;

/// Strength of the Fickian shifting that leaves no close pairs in front of a sphere.
const STRONG_SHIFTING: f64 = 16.0;

/// Number of successive monitor rows with close pairs, up to 3.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CloseRows(u32);

impl CloseRows {
    /// Records a row and returns a note, once in a run, when three successive rows have had four
    /// close pairs or more.
    pub fn record(&mut self, row: &MonitorRow, scene: &Scene) -> Option<String> {
        if self.0 >= ROWS {
            return None;
        }
        self.0 = if row.close_pairs >= LEAST_PAIRS { self.0 + 1 } else { 0 };
        let pair = row.closest_pair.filter(|_| self.0 == ROWS)?;
        let place = pair.position.to_array();
        let place = place.iter().take(scene.dimensions).map(|&x| coordinate(x, scene.spacing));
        Some(format!(
            "close pairs, at t = {} s: {} pairs of fluid particles are nearer than half a spacing, the closest with \
             {} Δ at ({}) m, 0 is wanted: {}; `close_pairs` of monitor.csv counts them",
            significant(row.time),
            grouped(row.close_pairs),
            with_digits(pair.distance / scene.spacing, 2),
            place.collect::<Vec<_>>().join(", "),
            cure(scene)
        ))
    }
}

/// Returns what to do about close pairs.
fn cure(scene: &Scene) -> String {
    let stronger = format!("`shifting: Fickian(coefficient: {STRONG_SHIFTING})`");
    match &scene.scheme {
        Scheme::Wcsph(scheme) if scheme.shifting.strength() >= STRONG_SHIFTING => {
            "a smaller spacing, with more particles across what is there".to_owned()
        }
        Scheme::Wcsph(_) => format!("{stronger} of `Wcsph`, or a smaller spacing"),
        Scheme::EdacTvf(scheme) if scheme.terms.relaxation == 0.0 => format!(
            "`EdacTvf(kernel: WendlandC2, smoothing_ratio: 1.7, relaxation: 0.01)`, which with `fill: Packed()` leaves a \
             tenth in front of a sphere, a smaller spacing, or `Wcsph` with {stronger}"
        ),
        Scheme::EdacTvf(_) => format!("a smaller spacing, or `Wcsph` with {stronger}"),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use glam::DVec3;
    use sphecs_engine::systems::monitor::ClosestPair;

    use super::*;

    fn scene(sets: &[(&str, &str)]) -> Scene {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/quickstart.ron");
        Scene::from_file(&path).sets(sets).load().expect("a scene")
    }

    fn row(scene: &Scene, time: f64, close_pairs: u64) -> MonitorRow {
        let position = DVec3::new(0.05, 0.01, 0.0);
        let closest_pair = Some(ClosestPair { distance: 0.43 * scene.spacing, position });
        MonitorRow { time, close_pairs, closest_pair, ..MonitorRow::default() }
    }

    #[test]
    fn lasting_close_pairs_are_noted_once() {
        let scene = scene(&[]);
        let mut rows = CloseRows::default();
        let mut notes = Vec::new();
        for (time, pairs) in [9, 3, 4, 5, 1, 6, 7, 12, 20, 20, 20, 0, 9, 9, 9].into_iter().enumerate() {
            notes.extend(rows.record(&row(&scene, time as f64, pairs), &scene));
        }
        let [note] = notes.as_slice() else { panic!("one note, not {notes:?}") };
        assert!(note.contains("at t = 7 s: 12 pairs") && note.contains("0.43 Δ at (0.05, 0.01) m"), "{note}");
        assert!(note.contains("`shifting: Fickian(coefficient: 16)` of `Wcsph`"), "{note}");
    }

    #[test]
    fn cure_is_not_what_the_scene_has() {
        let of = |set: &str| cure(&scene(&[("scheme", set)]));
        assert!(of("Wcsph(shifting: Off)").contains("Fickian"));
        assert!(of("Wcsph(shifting: Fickian(coefficient: 16.0))").starts_with("a smaller spacing, with"));
        assert!(of("EdacTvf()").starts_with("`EdacTvf(kernel: WendlandC2"));
        assert!(of("EdacTvf(relaxation: 0.01)").starts_with("a smaller spacing, or `Wcsph` with"));
    }
}
