//! Description of a run in one screen of text, for `sphecs info`.

use std::fmt::Write;

use super::error::OutputError;
use super::fields::packing;
use super::forces;
use super::frame::Frame;
use super::results::Results;
use super::summary::Status;
use super::walls::files;
use sphecs_core::format::{bytes, duration, grouped, significant};
use sphecs_core::particles::zone::Zone;
use sphecs_scene::field_grid::FieldGrid;

/// Returns scene, status, frames, particle counts, ledger, the ranges of the fields in the last
/// frame, gridded fields, quantities at the walls and forces on bodies.
///
/// # Errors
/// [`OutputError`] when the last frame cannot be read.
pub fn describe(results: &Results) -> Result<String, OutputError> {
    let mut text = String::new();
    // Writing to a String cannot fail.
    let mut line = |label: &str, value: String| {
        let _ = writeln!(text, "{label:<14}{value}");
    };
    let (header, summary) = (&results.header, &results.summary);
    line("run", results.folder.display().to_string());
    line("title", header.title.clone());
    line("scene", format!("{} (sha256 {}…)", header.scene, header.sha256.get(..12).unwrap_or_default()));
    let threads = if summary.threads > 0 {
        let ranks = if summary.ranks > 1 { format!("{} ranks of ", summary.ranks) } else { String::new() };
        format!(", {ranks}{} thread(s), {}", summary.threads, summary.lanes)
    } else {
        String::new()
    };
    line(
        "written by",
        format!("sphecs {}, {}D, {}{threads}", header.version, header.dimensions, header.precision),
    );
    line(
        "resolution",
        format!(
            "Δ = {} m, h = {} m, {}",
            significant(header.spacing),
            significant(header.smoothing_length),
            header.kernel
        ),
    );
    line(
        "fluid",
        format!(
            "ρ0 = {} kg/m³, ν = {} m²/s, c0 = {} m/s",
            significant(header.reference_density),
            significant(header.viscosity),
            significant(header.sound_speed)
        ),
    );
    line("status", status(results));
    if summary.status != Status::Running {
        let (time, end) = (significant(summary.time), significant(header.end));
        line("reached", format!("t = {time} s of {end} s in {} steps", grouped(summary.steps)));
        line("wall time", duration(summary.wall_time));
    }
    line("frames", frames(results));
    if let Some(last) = results.len().checked_sub(1) {
        let frame = results.frame(last)?;
        line("particles", counts(&frame));
        if summary.status != Status::Running {
            line("ledger", ledger(results));
        }
        for (name, values, unit) in fields(&frame) {
            if let Some((low, high)) = range(&frame, &values) {
                let (low, high) = (significant(low.into()), significant(high.into()));
                line(name, format!("{low} to {high} {unit}"));
            }
        }
    }
    let sampled = |times: u64, what: &str, mean: Option<(f64, f64)>| {
        let mean = mean.map_or_else(String::new, |(from, to)| {
            format!(", means from {} to {} s", significant(from), significant(to))
        });
        format!("{} times{what}{mean}", grouped(times))
    };
    if let Some(fields) = &header.fields {
        let times = packing::times(&results.folder, header)?;
        line("fields", sampled(times, &format!(" on {}", grids(&fields.grids)), fields.mean));
    }
    if let Some(walls) = &header.wall_quantities {
        line("at walls", sampled(files::times(&results.folder, header)?, "", walls.mean));
    }
    for (body, means) in forces::read_history(&results.folder, header)?.means {
        for (index, text) in forces::text::lines(&means).into_iter().enumerate() {
            let label = if index == 0 { format!("body {body}") } else { String::new() };
            line(&label, text);
        }
    }
    Ok(text)
}

/// Returns the grids by name and numbers of nodes: `80 × 48 nodes`.
fn grids(grids: &[FieldGrid]) -> String {
    let text = |grid: &FieldGrid| {
        let counts: Vec<String> = grid.axes.iter().map(|axis| grouped(axis.count as u64)).collect();
        let name = if grid.name.is_empty() { String::new() } else { format!("`{}` of ", grid.name) };
        format!("{name}{} nodes", counts.join(" × "))
    };
    grids.iter().map(text).collect::<Vec<_>>().join(", ")
}

fn status(results: &Results) -> String {
    let summary = &results.summary;
    match (&summary.message, summary.status) {
        (Some(message), status) => format!("{}: {message}", status.word()),
        (None, Status::Running) => {
            "running, or killed: `sphecs resume` continues a killed run, `sphecs pack` packs its frames"
                .to_owned()
        }
        (None, status) => status.word().to_owned(),
    }
}

fn frames(results: &Results) -> String {
    let times = results.times();
    let (Some(first), Some(last)) = (times.first(), times.last()) else {
        return "none".to_owned();
    };
    let place = if results.is_packed() { "particles.nc" } else { "journal" };
    format!(
        "{} from {} s to {} s, {} in {place}",
        times.len(),
        significant(*first),
        significant(*last),
        bytes(results.bytes())
    )
}

fn counts(frame: &Frame) -> String {
    let counts = frame.counts();
    let parts: Vec<String> =
        Zone::ALL.iter().map(|&zone| format!("{} {}", counts[zone as usize], zone.name())).collect();
    format!("{} in the last frame: {}", counts.iter().sum::<u64>(), parts.join(", "))
}

fn ledger(results: &Results) -> String {
    let ledger = &results.summary.ledger;
    let total = ledger.fluid + ledger.wall + ledger.inflow + ledger.outflow + ledger.reservoir;
    format!(
        "{} at the start + {} grown + {} created − {} deleted = {total}: {}",
        ledger.initial,
        ledger.grown,
        ledger.created,
        ledger.deleted,
        if ledger.balances { "balances" } else { "does NOT balance" }
    )
}

fn fields(frame: &Frame) -> [(&'static str, Vec<f32>, &'static str); 3] {
    let [u, v, w] = &frame.velocity;
    let speed = (0..frame.len()).map(|i| (u[i] * u[i] + v[i] * v[i] + w[i] * w[i]).sqrt()).collect();
    [
        ("speed", speed, "m/s"),
        ("pressure", frame.pressure.clone(), "Pa"),
        ("density", frame.density.clone(), "kg/m³"),
    ]
}

fn range(frame: &Frame, values: &[f32]) -> Option<(f32, f32)> {
    frame.slots_of(Zone::Fluid).map(|slot| values[slot]).filter(|value| value.is_finite()).fold(
        None,
        |range, value| {
            let (low, high) = range.unwrap_or((value, value));
            Some((low.min(value), high.max(value)))
        },
    )
}
