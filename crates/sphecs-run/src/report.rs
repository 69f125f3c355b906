//! Text of a run: summary at the start, summary at the end, and the report on a flow that stopped.

use std::fs::DirEntry;
use std::path::Path;

use glam::DVec3;

use super::RunOptions;
use super::rank_messages::RankMessages;
use sphecs_core::format::{bytes, duration, grouped, significant, two_columns};
use sphecs_core::math::lanes::InstructionSet;
use sphecs_core::particles::zone::Zone;
use sphecs_engine::resources::clock::Clock;
use sphecs_engine::resources::ledger::Ledger;
use sphecs_engine::simulation::Stop;
use sphecs_engine::systems::divergence::DivergedParticle;
use sphecs_engine::systems::divergence::NearbyParticle;
use sphecs_output::divergence;
use sphecs_output::error::OutputError;
use sphecs_output::header::Header;
use sphecs_output::pack::Packed;
use sphecs_output::summary::Status;
use sphecs_scene::model::{Patch, Scene};
use sphecs_scene::summary::{SceneSummary, summary};

/// Returns the summary of a run to `until`, s, printed before its first step.
pub fn start_summary(scene: &Scene, ledger: &Ledger, until: f64, options: &RunOptions) -> String {
    // The counts come from the ledger, since placing the particles again would take as long as
    // filling the domain.
    let figures = summary(scene, &[]);
    let mut rows = scene_rows(scene, &figures, ledger.by_zone, until, options.max_steps);
    let threads = rayon::current_num_threads();
    let ranks = match options.ranks.count() {
        0 | 1 => String::new(),
        count => format!("{count} ranks of "),
    };
    let machine = format!(
        "{ranks}{threads} thread{}, {:?} on {} lanes",
        if threads == 1 { "" } else { "s" },
        scene.precision,
        InstructionSet::best().name()
    );
    rows.extend([("machine", machine), ("results", options.folder.display().to_string())]);
    scene_table(scene, &figures, &rows) + "\n"
}

/// Returns particles, resolution, flow and steps of a run to `until`, s, as rows of a table.
pub fn scene_rows(
    scene: &Scene,
    figures: &SceneSummary,
    by_zone: [u64; 5],
    until: f64,
    max_steps: Option<u64>,
) -> Vec<(&'static str, String)> {
    let step = figures.courant_step.min(figures.viscous_step);
    let limit = if figures.viscous_step < figures.courant_step { "viscosity" } else { "sound speed" };
    let steps = ((until / step).ceil() as u64).min(max_steps.unwrap_or(u64::MAX));
    vec![
        ("particles", counts(by_zone)),
        ("spacing", resolution(scene)),
        ("flow", format!("Re = {}, Mach = {}", significant(figures.reynolds), significant(figures.mach))),
        (
            "time",
            format!(
                "{} s in about {} steps of {} s, limited by the {limit}",
                significant(until),
                grouped(steps),
                significant(step)
            ),
        ),
    ]
}

/// Returns a table of rows below the title of the scene, followed by the notes on the scene.
pub fn scene_table(scene: &Scene, figures: &SceneSummary, rows: &[(&str, String)]) -> String {
    let notes: String = figures.notes.iter().map(|note| format!("\n  note: {note}")).collect();
    format!("{} ({}D)\n{}{notes}", scene.title, scene.dimensions, two_columns(rows))
}

/// Returns the counts of all zones that have particles: `35 112 fluid, 4 020 wall`.
fn counts(by_zone: [u64; 5]) -> String {
    Zone::ALL
        .iter()
        .zip(by_zone)
        .filter(|(_, count)| *count > 0)
        .map(|(zone, count)| format!("{} {}", grouped(count), zone.name()))
        .collect::<Vec<_>>()
        .join(", ")
}

/// Returns spacing, smoothing length and kernel.
fn resolution(scene: &Scene) -> String {
    let h = scene.discretisation.smoothing_length;
    format!("Δ = {} m, h = {} m ({:?})", significant(scene.spacing), significant(h), scene.scheme.kernel())
}

/// State of a run at its end.
#[derive(Clone, Debug)]
pub struct EndState<'a> {
    /// Reason of the end.
    pub status: Status,
    /// Time and steps reached.
    pub clock: Clock,
    /// Wall time of the run, s.
    pub wall_time: f64,
    /// Steps × particles, reservoir not counted.
    pub particle_steps: f64,
    /// Wall time by stage, s, in the order of the step.
    pub stages: &'a [(&'a str, f64)],
    /// Particle counts.
    pub ledger: &'a Ledger,
    /// Messages between the ranks; None for one rank alone.
    pub messages: Option<RankMessages>,
}

/// Returns the summary printed at the end of a run.
pub fn end_summary(end: &EndState<'_>, header: &Header, folder: &Path, packed: &Packed) -> String {
    let speed = end.particle_steps / end.wall_time.max(f64::MIN_POSITIVE);
    let mut text = format!(
        "{}: {}, {} particle-steps/s\n\n{}\n\n{}{}\n\n{}",
        end.status.word(),
        reached(&end.clock, end.wall_time),
        significant(speed),
        stages(end.stages, end.wall_time),
        end.messages
            .as_ref()
            .map_or_else(String::new, |messages| two_columns(&[("ranks", messages.text())]) + "\n\n"),
        ledger(end.ledger, &header.inlets, &header.outlets),
        results(folder, packed),
    );
    if end.status != Status::Completed {
        text += &format!("\n\nto continue: sphecs resume {}", folder.display());
    }
    text
}

/// Returns the time and the steps reached: `t = 6 s after 123 456 steps in 12 min 03 s`.
fn reached(clock: &Clock, wall_time: f64) -> String {
    let plural = if clock.step == 1 { "" } else { "s" };
    format!(
        "t = {} s after {} step{plural} in {}",
        significant(clock.time),
        grouped(clock.step),
        duration(wall_time)
    )
}

/// Returns the wall time by stage in the order of the step, with its share of the total.
fn stages(times: &[(&str, f64)], total: f64) -> String {
    let rows: Vec<(&str, String)> = times
        .iter()
        .map(|(name, seconds)| {
            (*name, format!("{seconds:>10.2} s  {:>5.1} %", 100.0 * seconds / total.max(f64::MIN_POSITIVE)))
        })
        .collect();
    two_columns(&rows)
}

/// Returns the balance of particles as a table.
fn ledger(ledger: &Ledger, inlets: &[String], outlets: &[String]) -> String {
    let balance = format!(
        "{} = {} at the start + {} grown + {} created − {} deleted{}",
        grouped(ledger.total()),
        grouped(ledger.initial),
        grouped(ledger.grown),
        grouped(ledger.created),
        grouped(ledger.deleted),
        if ledger.balances() { "" } else { "  DOES NOT BALANCE" },
    );
    let mut rows = vec![("particles", balance), ("now", counts(ledger.by_zone))];
    let crossings = |through: &[u64], back: &[u64], at: usize| {
        let count = |counts: &[u64]| counts.get(at).copied().unwrap_or(0);
        format!("{} through, {} back", grouped(count(through)), grouped(count(back)))
    };
    for (at, name) in inlets.iter().enumerate() {
        rows.push((name, crossings(&ledger.entered, &ledger.entered_back, at)));
    }
    for (at, name) in outlets.iter().enumerate() {
        rows.push((name, crossings(&ledger.left, &ledger.left_back, at)));
    }
    two_columns(&rows)
}

/// Returns the force coefficients of the bodies, the folder of the results with the sizes of all
/// its files, and the notes of packing.
pub fn results(folder: &Path, packed: &Packed) -> String {
    let plural = if packed.frames == 1 { "" } else { "s" };
    let mut rows = vec![("results", format!("{} ({} frame{plural})", folder.display(), packed.frames))];
    rows.extend(contents(folder).into_iter().map(|text| ("", text)));
    let bodies = bodies(packed);
    let notes: String = packed.notes.iter().map(|note| format!("\n\nnote: {note}")).collect();
    bodies + &two_columns(&rows) + &notes
}

/// Returns a table of the force coefficients of the bodies, with an empty line behind it; empty
/// without bodies.
fn bodies(packed: &Packed) -> String {
    let mut rows = Vec::new();
    let names: Vec<String> = packed.forces.iter().map(|(name, _)| format!("body {name}")).collect();
    for (name, (_, lines)) in names.iter().zip(&packed.forces) {
        let labels = std::iter::once(name.as_str()).chain(std::iter::repeat(""));
        rows.extend(labels.zip(lines.iter().cloned()));
    }
    if rows.is_empty() { String::new() } else { two_columns(&rows) + "\n\n" }
}

/// Returns a line for each file of a folder with its size, and one for each folder in it.
fn contents(folder: &Path) -> Vec<String> {
    let entries = |folder: &Path| std::fs::read_dir(folder).into_iter().flatten().flatten();
    let size = |entry: &DirEntry| entry.metadata().map_or(0, |data| data.len());
    let line = |entry: DirEntry| {
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.starts_with('.') || name == "lost+found" {
            return None;
        }
        if !entry.path().is_dir() {
            return Some(format!("{name}  {}", bytes(size(&entry))));
        }
        let inner: Vec<u64> = entries(&entry.path()).map(|entry| size(&entry)).collect();
        let plural = if inner.len() == 1 { "" } else { "s" };
        let count = grouped(inner.len() as u64);
        Some(format!("{name}/  {count} file{plural}, {}", bytes(inner.iter().sum())))
    };
    let mut lines: Vec<String> = entries(folder).filter_map(line).collect();
    lines.sort();
    lines
}

/// Returns the status of a run that the flow stopped, and advice to the user.
pub fn status_and_cure(stop: &Stop) -> (Status, String) {
    match stop {
        Stop::Diverged { advice, .. } => (Status::Diverged, (*advice).to_owned()),
        Stop::Drained { .. } => {
            (Status::Failed, "lengthen its `depth`, lower `time.end`, or make it `Fed`".to_owned())
        }
        Stop::ReservoirEmpty { .. } => (
            Status::Failed,
            "raise `reservoir.particles`, or let the reservoir grow by `when_empty: Grow`".to_owned(),
        ),
        Stop::Requested { .. } => (Status::Failed, "see the plugin of the program".to_owned()),
    }
}

/// Writes the particles around the one that diverged and returns a report on it, one fact a line.
///
/// Called after the results are closed, since the last frame is read.
pub fn failure_report(
    folder: &Path,
    header: &Header,
    scene: &Scene,
    clock: &Clock,
    diverged: &DivergedParticle,
) -> String {
    let vector = |vector: DVec3| {
        let parts: Vec<String> =
            vector.to_array().into_iter().take(header.dimensions).map(significant).collect();
        format!("({})", parts.join(", "))
    };
    let mut text = String::new();
    if let Some(own) = diverged.neighbourhood.particle(diverged.id) {
        text += &format!(
            "\nin the step: density {} kg/m³, pressure {} Pa, acceleration {} m/s²; velocity {} m/s after it, {} m/s before",
            significant(own.density),
            significant(own.pressure),
            vector(own.acceleration),
            vector(own.velocity),
            vector(own.previous_velocity),
        );
    }
    // A frame that cannot be read is no reason to omit the other facts.
    if let Ok(Some((time, last))) = divergence::in_last_frame(folder, diverged.id) {
        text += &format!(
            "\nin the last frame, t = {} s: {} at {} m, velocity {} m/s, density {} kg/m³, pressure {} Pa",
            significant(time),
            last.zone.name(),
            vector(last.position),
            vector(last.velocity),
            significant(last.density),
            significant(last.pressure),
        );
    }
    text += &near_outlet(scene, diverged).unwrap_or_default();
    let nearest = |(near, distance): (&NearbyParticle, f64)| {
        format!(
            ", the nearest is {} particle {} at a distance of {} Δ",
            near.zone.name(),
            near.id,
            significant(distance / header.spacing)
        )
    };
    let (count, closest) = diverged.neighbourhood.neighbours(diverged.id);
    text += &format!("\n{} neighbours{}", grouped(count as u64), closest.map_or_else(String::new, nearest));
    text + &match divergence::write(folder, header, clock, diverged) {
        Ok([data, picture]) => {
            format!("\nthe particles around it are in `{}`, drawn in `{}`", data.display(), picture.display())
        }
        Err(error) => format!("\nthe particles around it could not be written: {error}"),
    }
}

/// Returns a line on the outlet near a particle that diverged, whose condition is a likely cause.
///
/// The outlet counts as near if the particle is in its zone or within two kernel supports of it.
fn near_outlet(scene: &Scene, diverged: &DivergedParticle) -> Option<String> {
    let reach = 2.0 * scene.discretisation.support;
    let near = |patch: &Patch| {
        let along = patch.along(diverged.position);
        along > -reach && along < patch.depth + reach && patch.covers(diverged.position, reach)
    };
    let (number, outlet) = scene.outlets.iter().enumerate().find(|(_, outlet)| near(&outlet.patch))?;
    let along = outlet.patch.along(diverged.position) / scene.spacing;
    let side = if along < 0.0 { "upstream" } else { "downstream" };
    Some(format!(
        "\nit is {} Δ {side} of the plane of outlet {number}, `{}`, which may be the cause: see the guide \"Choosing an outlet\" of the manual",
        significant(along.abs()),
        outlet.condition.parameters().name()
    ))
}

/// Returns a line on the frames and the checkpoint that a stopped run left.
pub fn results_kept(folder: &Path, frames: u64, last_checkpoint: Option<u64>) -> String {
    let path = folder.display();
    let checkpoint = last_checkpoint
        .map_or_else(String::new, |step| format!("; the last checkpoint is of step {}", grouped(step)));
    format!("\n{frames} frames are in `{path}`, to draw them: `sphecs render {path} --all`{checkpoint}")
}

/// Returns a line on results that could not be closed.
pub fn results_not_closed(error: &OutputError) -> String {
    format!("\nthe results could not be closed: {error}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ledger_that_does_not_balance_is_marked() {
        let balanced =
            Ledger { initial: 5, grown: 1, by_zone: [4, 0, 1, 0, 1], entered: vec![7], ..Ledger::default() };
        let text = ledger(&balanced, &["left".to_owned()], &[]);
        assert!(text.contains("6 = 5 at the start + 1 grown + 0 created − 0 deleted"), "{text}");
        assert!(text.contains("7 through, 0 back"), "{text}");
        let lost = Ledger { by_zone: [3, 0, 1, 0, 1], ..balanced };
        assert!(ledger(&lost, &[], &[]).contains("DOES NOT BALANCE"));
    }

    #[test]
    fn coefficients_precede_the_files() {
        let forces = vec![("strut".to_owned(), vec!["c_d = 1.2".to_owned(), "no line".to_owned()])];
        let packed = Packed { forces, ..Packed::default() };
        let folder = tempfile::tempdir().expect("a folder");
        let text = results(folder.path(), &packed);
        assert!(text.starts_with("  body strut  c_d = 1.2\n              no line\n\n  results"), "{text}");
    }

    #[test]
    fn counts_omit_empty_zones() {
        assert_eq!(counts([35_112, 4020, 0, 9, 0]), "35 112 fluid, 4 020 wall, 9 outflow");
    }
}
