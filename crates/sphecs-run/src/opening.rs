//! What a run is, on one screen, before its first step.

use super::RunOptions;
use super::report;
use super::words::{columns, figure, grouped};
use sphecs_core::math::lanes::InstructionSet;
use sphecs_engine::resources::ledger::Ledger;
use sphecs_scene::model::Scene;
use sphecs_scene::summary::summary;

/// The summary of a run to `until`, s.
pub fn text(scene: &Scene, ledger: &Ledger, until: f64, options: &RunOptions) -> String {
    // The particles stand in the ledger already: laying them out once more would take as long as the fill.
    let figures = summary(scene, &[]);
    let step = figures.courant_step.min(figures.viscous_step);
    let steps = ((until / step).ceil() as u64).min(options.steps.unwrap_or(u64::MAX));
    let rows = [
        ("particles", report::counts(ledger.by_zone)),
        ("spacing", report::resolution(scene)),
        ("flow", format!("Re = {}, Mach = {}", figure(figures.reynolds), figure(figures.mach))),
        ("time", format!("{} s in about {} steps of {} s", figure(until), grouped(steps), figure(step))),
        (
            "machine",
            format!(
                "{} threads, {:?} on {} lanes",
                rayon::current_num_threads(),
                scene.precision,
                InstructionSet::best().name()
            ),
        ),
        ("results", options.folder.display().to_string()),
    ];
    let notes: String = figures.notes.iter().map(|note| format!("\n  note: {note}")).collect();
    format!("{} ({}D)\n{}{notes}\n", scene.title, scene.dimensions, columns(&rows))
}
