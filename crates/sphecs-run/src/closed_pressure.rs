//! Note on a mean pressure that rises in a closed domain under `EdacTvf`.
//!
//! The pressure follows the divergence of the velocity and not the density. So nothing holds its
//! mean where no outlet does, unless the pressure relaxes to that of the density.

use serde::{Deserialize, Serialize};

use sphecs_core::format::{significant, with_digits};
use sphecs_engine::systems::monitor::MonitorRow;
use sphecs_scene::model::Scene;
use sphecs_scene::scheme::Scheme;

/// Largest change of the mean pressure, over ρ0 c0².
const LARGEST: f64 = 0.05;

/// Mean pressure of the first monitor row of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClosedPressure {
    /// Mean pressure, Pa; None before the first row.
    first: Option<f64>,
    is_noted: bool,
}

impl ClosedPressure {
    /// Records a row and returns a note, once in a run, when the mean pressure of a closed domain
    /// has changed by 5 % of ρ0 c0².
    pub fn record(&mut self, row: &MonitorRow, scene: &Scene) -> Option<String> {
        let first = *self.first.get_or_insert(row.mean_pressure);
        let share = (row.mean_pressure - first) / (scene.fluid.density * scene.fluid.sound_speed.powi(2));
        if self.is_noted || !is_free(scene) || share.abs() <= LARGEST {
            return None;
        }
        self.is_noted = true;
        Some(format!(
            "mean pressure, at t = {} s: it went from {} to {} Pa, by {} % of ρ0 c0²; nothing holds it in a closed domain \
             under `EdacTvf` without relaxation: `relaxation: 0.01`",
            significant(row.time),
            with_digits(first, 3),
            with_digits(row.mean_pressure, 3),
            with_digits(100.0 * share, 2)
        ))
    }
}

/// Returns true if nothing holds the mean pressure of a scene.
fn is_free(scene: &Scene) -> bool {
    let relaxes = match &scene.scheme {
        Scheme::EdacTvf(scheme) => scheme.terms.relaxation > 0.0,
        Scheme::Wcsph(_) => true,
    };
    !relaxes && scene.outlets.is_empty() && scene.source_count() == 0
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    /// Returns the notes on a mean pressure that rises by 1 % of ρ0 c0² from row to row.
    fn notes(scene: &str, scheme: &str) -> Vec<String> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(scene);
        let scene = Scene::from_file(&path).set("scheme", scheme).load().expect("a scene");
        let step = 0.01 * scene.fluid.density * scene.fluid.sound_speed.powi(2);
        let mut pressure = ClosedPressure::default();
        let row =
            |time: f64| MonitorRow { time, mean_pressure: (time - 2.0) * step, ..MonitorRow::default() };
        (0..20).filter_map(|time| pressure.record(&row(f64::from(time)), &scene)).collect()
    }

    #[test]
    fn rising_pressure_of_a_closed_domain_is_noted_once() {
        let found = notes("stirrer.ron", "EdacTvf()");
        let [note] = found.as_slice() else { panic!("one note, not {found:?}") };
        assert!(note.contains("at t = 6 s") && note.contains("from -320 to 640 Pa, by 6 % of"), "{note}");
        assert!(notes("stirrer.ron", "EdacTvf(relaxation: 0.01)").is_empty());
        assert!(notes("stirrer.ron", "Wcsph()").is_empty());
        assert!(notes("quickstart.ron", "EdacTvf()").is_empty(), "an outlet holds the pressure");
    }
}
