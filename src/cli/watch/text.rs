//! State of a run as lines of text.

use sphecs_core::format::{grouped, significant};
use sphecs_output::live::LiveState;

/// Curves whose last values are shown, in the order of the lines.
pub(super) const SHOWN: [&str; 6] =
    ["inflow", "outflow", "mean pressure", "kinetic energy", "largest speed", "largest density deviation"];

/// Returns name, value and unit of the present state.
pub(super) fn figures(state: &LiveState) -> Vec<(String, String)> {
    let mut figures = vec![
        ("status".to_owned(), status(state)),
        ("time".to_owned(), format!("{} of {} s", significant(state.time), significant(state.end))),
        ("steps".to_owned(), grouped(state.step)),
        ("time step".to_owned(), format!("{} s", significant(state.time_step))),
        ("particles".to_owned(), grouped(state.particles)),
        ("frames".to_owned(), grouped(state.frames)),
    ];
    for series in SHOWN.iter().filter_map(|name| state.series(name)) {
        let unit = if series.unit == "1" { String::new() } else { format!(" {}", series.unit) };
        let last = series.values.last().copied().unwrap_or_default();
        figures.push((series.name.clone(), format!("{}{unit}", significant(last))));
    }
    if let Some(unsteadiness) = state.unsteadiness {
        let value = format!("{} % of its mean in the last tenth", significant(100.0 * unsteadiness));
        figures.push(("range of the kinetic energy".to_owned(), value));
    }
    figures
}

fn status(state: &LiveState) -> String {
    match state.row_age {
        Some(age) => format!("{}, last row {} s ago", state.status, significant(age)),
        None => state.status.clone(),
    }
}

/// Returns the title, the figures and the notes.
pub(super) fn lines(state: &LiveState) -> Vec<String> {
    let figures = figures(state);
    let width = figures.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    let mut lines = vec![state.title.clone()];
    lines.extend(figures.into_iter().map(|(name, value)| format!("  {name:<width$}  {value}")));
    lines.extend(state.notes.iter().map(|note| format!("note: {note}")));
    lines
}
