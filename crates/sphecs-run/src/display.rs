//! Progress while a run goes on: a bar on a terminal, lines elsewhere.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::console::Console;

/// Between two lines of a log: rare enough for a run of days, often enough to see that it lives.
const LINES: Duration = Duration::from_secs(30);

/// Between two drawings of the bar.
const DRAWINGS: Duration = Duration::from_millis(100);

/// Steps of the bar: finer than any terminal is wide.
const BAR: u64 = 10_000;

/// Shows how far the run has come.
#[derive(Debug)]
pub struct Display {
    console: Console,
    bar: Option<ProgressBar>,
    last: Instant,
    /// Whether lines stand between the opening and the close.
    spoken: bool,
}

impl Display {
    /// A bar if standard error is a terminal, else lines on standard output; nothing when quiet.
    pub fn new(console: Console) -> Self {
        let on_terminal = console != Console::Quiet && std::io::stderr().is_terminal();
        let bar = on_terminal.then(|| {
            // The template is a constant and valid; the plain style is as good an answer as a panic is a bad one.
            let style = ProgressStyle::with_template("{bar:24} {msg}")
                .unwrap_or_else(|_| ProgressStyle::default_bar());
            ProgressBar::new(BAR).with_style(style)
        });
        Self { console, bar, last: Instant::now(), spoken: false }
    }

    /// Shows the part done, 0 to 1, and a text, if it is time to. The text is made only then.
    pub fn update(&mut self, fraction: f64, text: impl FnOnce() -> String) {
        let pause = if self.bar.is_some() { DRAWINGS } else { LINES };
        if self.console == Console::Quiet || self.last.elapsed() < pause {
            return;
        }
        self.last = Instant::now();
        match &self.bar {
            Some(bar) => {
                bar.set_position((fraction * BAR as f64) as u64);
                bar.set_message(text());
            }
            None => self.say(&format!("{:5.1} %  {}", 100.0 * fraction, text())),
        }
    }

    /// A line of its own beside the progress.
    pub fn say(&mut self, text: &str) {
        self.spoken = true;
        match &self.bar {
            Some(bar) => bar.suspend(|| self.console.say(text)),
            None => self.console.say(text),
        }
    }

    /// Takes the bar away and leaves an empty line behind what was said.
    pub fn clear(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
        if self.spoken {
            self.console.say("");
        }
    }
}
