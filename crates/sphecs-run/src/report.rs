//! What a run says at its opening and at its close.

use std::path::Path;

use super::words::{columns, duration, figure, grouped};
use sphecs_core::particles::zone::Zone;
use sphecs_engine::resources::clock::Clock;
use sphecs_engine::resources::ledger::Ledger;
use sphecs_output::disk::bytes;
use sphecs_output::pack::Packed;
use sphecs_scene::model::Scene;

/// Counts of all zones that hold particles: `35 112 fluid, 4 020 wall`.
pub fn counts(by_zone: [u64; 5]) -> String {
    Zone::ALL
        .iter()
        .zip(by_zone)
        .filter(|(_, count)| *count > 0)
        .map(|(zone, count)| format!("{} {}", grouped(count), zone.name()))
        .collect::<Vec<_>>()
        .join(", ")
}

/// Spacing, smoothing length and kernel.
pub fn resolution(scene: &Scene) -> String {
    let h = scene.discretisation.smoothing_length;
    format!("Δ = {} m, h = {} m ({:?})", figure(scene.spacing), figure(h), scene.scheme.kernel())
}

/// Wall time by stage in the order of the step, with its part of the whole.
pub fn stages(times: &[(&str, f64)], total: f64) -> String {
    let rows: Vec<(&str, String)> = times
        .iter()
        .map(|(name, seconds)| {
            (*name, format!("{seconds:>10.2} s  {:>5.1} %", 100.0 * seconds / total.max(f64::MIN_POSITIVE)))
        })
        .collect();
    columns(&rows)
}

/// The balance of particles as a table.
pub fn ledger(ledger: &Ledger, inlets: &[String], outlets: &[String]) -> String {
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
    columns(&rows)
}

/// Where the results lie and how large they are.
pub fn results(folder: &Path, packed: &Packed) -> String {
    let mut rows = vec![("results", format!("{} ({} frames)", folder.display(), packed.frames))];
    for file in &packed.files {
        let size = std::fs::metadata(file).map_or(0, |data| data.len());
        let name = file.strip_prefix(folder).unwrap_or(file);
        rows.push(("", format!("{}  {}", name.display(), bytes(size))));
    }
    columns(&rows)
}

/// How far a run came: `t = 6 s after 123 456 steps in 12 min 03 s`.
pub fn reached(clock: &Clock, wall_time: f64) -> String {
    let plural = if clock.step == 1 { "" } else { "s" };
    format!(
        "t = {} s after {} step{plural} in {}",
        figure(clock.time),
        grouped(clock.step),
        duration(wall_time)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ledger_that_does_not_balance_is_shouted() {
        let sound =
            Ledger { initial: 5, grown: 1, by_zone: [4, 0, 1, 0, 1], entered: vec![7], ..Ledger::default() };
        let text = ledger(&sound, &["left".to_owned()], &[]);
        assert!(text.contains("6 = 5 at the start + 1 grown + 0 created − 0 deleted"), "{text}");
        assert!(text.contains("7 through, 0 back"), "{text}");
        let lost = Ledger { by_zone: [3, 0, 1, 0, 1], ..sound };
        assert!(ledger(&lost, &[], &[]).contains("DOES NOT BALANCE"));
    }

    #[test]
    fn counts_name_what_is_there() {
        assert_eq!(counts([35_112, 4020, 0, 9, 0]), "35 112 fluid, 4 020 wall, 9 outflow");
    }
}
