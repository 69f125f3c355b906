//! Results of a bench as a table.

use super::measure::{BenchResult, Timing};
use super::peak::Peaks;
use sphecs_core::format::{duration, grouped};
use sphecs_core::math::lanes::InstructionSet;

/// Smallest share of a step that is listed, %.
const MIN_SHARE: f64 = 0.05;

/// Returns version, machine and the head of the table.
pub fn head(peaks: &Peaks) -> String {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    format!(
        "sphecs {} on {} lanes, {cores} cores{}\n\
        measured peak of multiply-adds of one core: {:.0} GFLOP/s in f64, {:.0} in f32\n\n\
        {:<16}  {:>7}  {:>9}  {:>9}  {:>7}  {:>8}  {:>7}  {:>8}  {:>8}  {:>10}",
        env!("CARGO_PKG_VERSION"),
        InstructionSet::best().name(),
        load().map_or_else(String::new, |load| format!(", load average {load:.1} before")),
        peaks.double / 1e9,
        peaks.single / 1e9,
        "case",
        "threads",
        "particles",
        "ms/step",
        "M/s",
        "Mpair/s",
        "of peak",
        "x scalar",
        "speed-up",
        "B/particle",
    )
}

/// Returns the load average of the last minute; None if unknown.
///
/// Other load distorts the results, above all with many threads.
fn load() -> Option<f64> {
    std::fs::read_to_string("/proc/loadavg").ok()?.split_whitespace().next()?.parse().ok()
}

/// Returns one line for each number of threads; `peak` is the rate of one core, 1/s.
pub fn rows(name: &str, figures: &BenchResult, peak: f64) -> String {
    let row = |(at, timing): (usize, &Timing)| {
        let rate = figures.pair_rate(timing);
        // Properties of the flow are printed once.
        let once = |text: String| if at == 0 { text } else { String::new() };
        let memory =
            figures.memory.map_or("-".to_owned(), |bytes| grouped(bytes / figures.particles.max(1) as u64));
        let speed_up = figures.speed_up(timing).map_or("-".to_owned(), |factor| format!("{factor:.2}"));
        format!(
            "{:<16}  {:>7}  {:>9}  {:>9.2}  {:>7.2}  {:>8.0}  {:>5.1} %  {:>8.1}  {:>8}  {:>10}",
            once(name.to_owned()),
            threads(timing),
            once(grouped(figures.particles as u64)),
            1e3 * timing.step,
            figures.particles as f64 / timing.step / 1e6,
            rate / 1e6,
            100.0 * rate * figures.operations as f64 / peak,
            figures.gain(timing),
            speed_up,
            once(memory),
        )
        .trim_end()
        .to_owned()
    };
    figures.timings.iter().enumerate().map(row).collect::<Vec<_>>().join("\n")
}

/// Returns the number of threads, or that of ranks with the threads of each: `4×1`.
fn threads(timing: &Timing) -> String {
    match timing.ranks {
        1 => timing.threads.to_string(),
        ranks => format!("{ranks}×{}", timing.threads / ranks),
    }
}

/// Returns the shares of the sets, the legend of the columns and the total time.
pub fn summary(measured: &[(&str, BenchResult)], wall_time: f64) -> String {
    let mut text = String::from("\nshare of a step in %, on the smallest number of threads:\n");
    for (name, figures) in measured {
        if let Some(timing) = figures.timings.first() {
            let (operations, pace) = (figures.operations, timing.flow / timing.step);
            let shares = shares(&timing.sets);
            text += &format!(
                "{name:<16}  {shares}; {operations} FLOP per pair; {pace:.3e} s simulated per second\n"
            );
        }
    }
    for (name, figures) in measured {
        for timing in &figures.timings {
            if let Some(messages) = &timing.messages {
                text += &format!("{name:<16}  ranks {}\n", messages.text());
            }
        }
    }
    text += &format!(
        "\nthreads     of one rank, or ranks × threads of each\n\
        ms/step     fastest of several repetitions\n\
        M/s         million particle-steps per second\n\
        Mpair/s     million ordered pairs within the support per second and thread; all passes of a step count once\n\
        of peak     operations of those pairs over the peak of as many cores; an FMA counts two\n\
        x scalar    pair rate over that of plain f64 loops over equal cells with density, pressure and viscosity only\n\
        B/particle  growth of the largest resident memory (VmHWM)\n\
        measured in {}",
        duration(wall_time)
    );
    text
}

/// Returns name and share of each set of systems.
pub fn shares(sets: &[(&str, f64)]) -> String {
    let step: f64 = sets.iter().map(|(_, seconds)| seconds).sum();
    let share = |seconds: f64| 100.0 * seconds / step.max(f64::MIN_POSITIVE);
    let parts = sets.iter().filter(|(_, seconds)| share(*seconds) >= MIN_SHARE);
    parts.map(|(name, seconds)| format!("{name} {:.1}", share(*seconds))).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_aligned_with_their_names() {
        let timing = |threads: usize, step: f64| Timing {
            threads,
            ranks: threads,
            messages: None,
            step,
            flow: 1e-3 * step,
            sets: vec![("density", 0.25 * step), ("kick", 0.0), ("rates", 0.75 * step)],
        };
        let figures = BenchResult {
            particles: 262_144,
            pairs: 67_000_000,
            operations: 80,
            scalar_rate: 33.5e6,
            memory: Some(262_144 * 300),
            timings: vec![timing(1, 0.2), timing(2, 0.1)],
        };
        let heading = head(&Peaks { single: 250e9, double: 125e9 });
        let width = heading.lines().last().map_or(0, |line| line.chars().count());
        let text = rows("3d-f32", &figures, 268e9);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 2);
        assert_eq!(lines[0].chars().count(), width, "{heading}\n{text}");
        // 67 million pairs of 80 operations in 0.2 s are 26.8 GFLOP/s: a tenth of the peak.
        for word in ["3d-f32", "262 144", "200.00", "1.31", "335", "10.0 %", "10.0", "1.00", "300"] {
            assert!(lines[0].contains(word), "no `{word}` in {}", lines[0]);
        }
        assert!(
            lines[1].contains("2×1")
                && lines[1].contains("2.00")
                && lines[1].contains("10.0 %")
                && !lines[1].contains("3d-f32")
        );
        let summary = summary(&[("3d-f32", figures)], 3.0);
        assert!(
            summary.contains("density 25.0, rates 75.0; 80 FLOP per pair; 1.000e-3 s simulated per second"),
            "{summary}"
        );
        let timings = vec![timing(2, 0.1)];
        let unknown =
            BenchResult { particles: 1, pairs: 1, operations: 1, scalar_rate: 1.0, memory: None, timings };
        assert_eq!(rows("box", &unknown, 1.0).matches(" -").count(), 2, "neither speed-up nor memory");
    }
}
