//! `sphecs watch`: its arguments, and the state of a run in a terminal or on a page.
//!
//! - `terminal`: dashboard in a terminal; `terminal_map`: its map of the last frame
//! - `server`: page for a browser on this machine
//! - `text`: the state once, as lines

mod server;
mod terminal;
mod terminal_map;
mod text;

use std::io::IsTerminal;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::Args;

use super::failure::{DONE, Failure};
use super::values::positive;
use sphecs_output::live::LiveState;
use sphecs_run::console::Console;

/// `sphecs watch`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    sphecs watch runs/constricted_r2\n  \
    sphecs watch runs/constricted_r2 --serve\n  \
    sphecs watch runs/constricted_r2 --once\n\n\
    The run may be under way, stopped or complete; it is only read. `q` ends the dashboard, not the run.")]
pub struct WatchArguments {
    /// Run folder
    #[arg(value_name = "RUN")]
    pub run: PathBuf,
    /// Show the run on a page at http://127.0.0.1:PORT instead of in the terminal [default port:
    /// 8750]
    #[arg(long, value_name = "PORT", num_args = 0..=1, default_missing_value = "8750")]
    pub serve: Option<u16>,
    /// Print the state once, as lines
    #[arg(long, conflicts_with = "serve")]
    pub once: bool,
    /// Interval between two looks at the files, s
    #[arg(long, value_name = "T", value_parser = positive, default_value_t = 1.0)]
    pub every: f64,
}

/// Shows the state of a run until the user ends it.
///
/// # Errors
/// [`Failure::Output`] for a folder without a run, a port that is taken, and a terminal that fails.
pub fn watch(arguments: &WatchArguments) -> Result<u8, Failure> {
    let state = LiveState::read(&arguments.run)?;
    if let Some(port) = arguments.serve {
        server::serve(&arguments.run, port)?;
    } else if arguments.once || !std::io::stdout().is_terminal() {
        Console::Normal.print(&text::lines(&state).join("\n"));
    } else {
        terminal::show(&arguments.run, Duration::from_secs_f64(arguments.every))?;
    }
    Ok(DONE)
}

/// Speed of a run since it is watched.
#[derive(Debug)]
struct Pace {
    first: Option<(Instant, f64)>,
}

impl Pace {
    fn new() -> Self {
        Self { first: None }
    }

    /// Returns the wall time left, s, from the part that is done now; None while it is unknown.
    fn left(&mut self, state: &LiveState, now: Instant) -> Option<f64> {
        let fraction = state.fraction();
        let (since, before) = *self.first.get_or_insert((now, fraction));
        let elapsed = now.duration_since(since).as_secs_f64();
        let is_known = !state.has_ended && fraction > before && elapsed > 1.0;
        is_known.then(|| (1.0 - fraction) * elapsed / (fraction - before))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_left_follows_from_the_part_done_while_watched() {
        let mut pace = Pace::new();
        let start = Instant::now();
        let state = |time: f64| LiveState { time, end: 10.0, ..LiveState::default() };
        assert_eq!(pace.left(&state(2.0), start), None);
        let left = pace.left(&state(4.0), start + Duration::from_secs(10)).expect("known");
        assert!((left - 30.0).abs() < 1e-9, "{left} s");
        let ended = LiveState { has_ended: true, ..state(10.0) };
        assert_eq!(pace.left(&ended, start + Duration::from_secs(60)), None);
    }
}
