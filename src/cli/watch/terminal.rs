//! Dashboard of a run in a terminal.

use std::io;
use std::path::Path;
use std::time::{Duration, Instant};

use ratatui::crossterm::event::{self, Event, KeyCode, KeyModifiers};
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Style, Stylize};
use ratatui::symbols::Marker;
use ratatui::text::Line;
use ratatui::widgets::{Axis, Block, Chart, Dataset, Gauge, GraphType, Paragraph};
use ratatui::{DefaultTerminal, Frame};

use super::Pace;
use super::terminal_map::TerminalMap;
use super::text::figures;
use crate::cli::failure::Failure;
use sphecs_core::format::{duration, significant};
use sphecs_output::error::OutputError;
use sphecs_output::live::{LiveSeries, LiveState};

/// Least width at which the map is beside the curves; in narrower terminals one of both is shown.
const WIDE: u16 = 110;

/// A key that the dashboard knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Key {
    End,
    NextField,
    /// Curves or map, where there is space for one.
    Toggle,
}

/// Shows the run until the user ends it.
///
/// # Errors
/// [`Failure::Output`] for a folder without a run and a terminal that fails.
pub(super) fn show(run: &Path, every: Duration) -> Result<(), Failure> {
    let terminal = |cause| OutputError::Io { path: run.to_owned(), doing: "show in the terminal", cause };
    let mut screen = ratatui::try_init().map_err(terminal)?;
    let ended = until_ended(&mut screen, run, every);
    ratatui::restore();
    ended?.map_err(terminal)?;
    Ok(())
}

fn until_ended(
    screen: &mut DefaultTerminal,
    run: &Path,
    every: Duration,
) -> Result<io::Result<()>, OutputError> {
    let mut pace = Pace::new();
    let mut map = TerminalMap::new(run);
    let mut prefers_map = false;
    loop {
        let state = LiveState::read(run)?;
        let left = pace.left(&state, Instant::now());
        if let Err(error) = screen.draw(|frame| draw(frame, &state, left, (&mut map, prefers_map))) {
            return Ok(Err(error));
        }
        match next_key(every) {
            Ok(Some(Key::End)) => return Ok(Ok(())),
            Ok(Some(Key::NextField)) => map.next_field(),
            Ok(Some(Key::Toggle)) => prefers_map = !prefers_map,
            Ok(None) => {}
            Err(error) => return Ok(Err(error)),
        }
    }
}

/// Waits for a key that the dashboard knows; None when there is none for so long.
fn next_key(every: Duration) -> io::Result<Option<Key>> {
    let until = Instant::now() + every;
    while event::poll(until.saturating_duration_since(Instant::now()))? {
        if let Event::Key(key) = event::read()? {
            let is_interrupt = key.code == KeyCode::Char('c') && key.modifiers == KeyModifiers::CONTROL;
            match key.code {
                _ if is_interrupt => return Ok(Some(Key::End)),
                KeyCode::Char('q') | KeyCode::Esc => return Ok(Some(Key::End)),
                KeyCode::Char('f') => return Ok(Some(Key::NextField)),
                KeyCode::Char('m') => return Ok(Some(Key::Toggle)),
                _ => {}
            }
        }
    }
    Ok(None)
}

/// Draws the state of a run, the wall time left, s, and the map.
fn draw(
    frame: &mut Frame<'_>,
    state: &LiveState,
    left: Option<f64>,
    (map, prefers_map): (&mut TerminalMap, bool),
) {
    let figures = figures(state);
    let rows = [Constraint::Length(3), Constraint::Length(figures.len() as u16 + 2), Constraint::Min(6)];
    let [progress, table, curves] = Layout::vertical(rows).areas(frame.area());
    let label = match left {
        Some(left) => format!("{:.1} %, {} left", 100.0 * state.fraction(), duration(left)),
        None => format!("{:.1} %", 100.0 * state.fraction()),
    };
    let gauge = Gauge::default().ratio(state.fraction()).label(label).gauge_style(Color::Cyan);
    let title = format!(" {} ", state.title);
    frame.render_widget(gauge.block(Block::bordered().title(title.bold())), progress);
    let width = figures.iter().map(|(name, _)| name.len()).max().unwrap_or(0);
    let lines: Vec<Line<'_>> =
        figures.iter().map(|(name, value)| Line::from(format!("{name:<width$}  {value}"))).collect();
    let is_wide = curves.width >= WIDE;
    let keys = if is_wide { " q ends " } else { " q ends, m: map or curves " };
    frame.render_widget(Paragraph::new(lines).block(Block::bordered().title_bottom(keys)), table);
    let curves = if is_wide {
        let [curves, beside] = Layout::horizontal([Constraint::Fill(1); 2]).areas(curves);
        map.draw(frame, beside, state.frames);
        curves
    } else if prefers_map {
        return map.draw(frame, curves, state.frames);
    } else {
        curves
    };
    let [upper, lower] = Layout::vertical([Constraint::Fill(1); 2]).areas(curves);
    let [first, second] = Layout::horizontal([Constraint::Fill(1); 2]).areas(upper);
    let [third, fourth] = Layout::horizontal([Constraint::Fill(1); 2]).areas(lower);
    let has_openings = state.series("inflow").or(state.series("outflow")).is_some();
    chart(frame, first, state, if has_openings { &["inflow", "outflow"] } else { &["largest speed"] });
    chart(frame, second, state, &["mean pressure"]);
    chart(frame, third, state, &["kinetic energy"]);
    chart(frame, fourth, state, &["largest density deviation"]);
}

/// Draws curves over time.
fn chart(frame: &mut Frame<'_>, area: Rect, state: &LiveState, names: &[&str]) {
    const COLOURS: [Color; 2] = [Color::Cyan, Color::Yellow];
    let series: Vec<&LiveSeries> = names.iter().filter_map(|name| state.series(name)).collect();
    let points: Vec<Vec<(f64, f64)>> = series
        .iter()
        .map(|series| state.times.iter().copied().zip(series.values.iter().copied()).collect())
        .collect();
    let values = || points.iter().flatten().map(|(_, value)| *value).filter(|value| value.is_finite());
    let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
    let title = series.iter().map(|series| series.name.as_str()).collect::<Vec<_>>().join(", ");
    let unit = series.first().map_or("", |series| series.unit.as_str());
    let unit = if matches!(unit, "" | "1") { String::new() } else { format!(", {unit}") };
    let block = Block::bordered().title(format!(" {title}{unit} "));
    if low > high {
        return frame.render_widget(block, area);
    }
    // A constant is a line in the middle.
    let margin = if low == high { low.abs().max(1e-12) * 0.1 } else { 0.0 };
    let (low, high) = (low - margin, high + margin);
    let last = state.times.last().copied().unwrap_or(1.0).max(f64::MIN_POSITIVE);
    let sets = points.iter().zip(COLOURS).map(|(points, colour)| {
        let style = Style::default().fg(colour);
        Dataset::default().marker(Marker::Braille).graph_type(GraphType::Line).style(style).data(points)
    });
    let label = |value: f64| significant(value).to_string();
    let across = Axis::default().bounds([0.0, last]).labels(["0".to_owned(), format!("{} s", label(last))]);
    let upward = Axis::default().bounds([low, high]).labels([label(low), label(high)]);
    frame.render_widget(Chart::new(sets.collect()).block(block).x_axis(across).y_axis(upward), area);
}

#[cfg(test)]
mod tests {
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;

    use super::*;

    fn screen(state: &LiveState, left: Option<f64>, (width, prefers_map): (u16, bool)) -> String {
        let mut map = TerminalMap::new(Path::new("no run"));
        let mut terminal = Terminal::new(TestBackend::new(width, 40)).expect("a terminal");
        terminal.draw(|frame| draw(frame, state, left, (&mut map, prefers_map))).expect("drawn");
        let buffer = terminal.backend().buffer().clone();
        let rows = buffer.content().chunks(usize::from(width));
        rows.map(|row| row.iter().map(|cell| cell.symbol()).collect::<String>() + "\n").collect()
    }

    #[test]
    fn dashboard_has_progress_figures_and_curves() {
        let series = |name: &str, unit: &str, values: [f64; 3]| LiveSeries {
            name: name.to_owned(),
            unit: unit.to_owned(),
            values: values.to_vec(),
        };
        let state = LiveState {
            title: "Channel".to_owned(),
            status: "running".to_owned(),
            time: 2.5,
            end: 10.0,
            step: 12_345,
            times: vec![0.0, 1.0, 2.5],
            series: vec![
                series("inflow", "kg m-1 s-1", [0.0, 1.0, 2.0]),
                series("outflow", "kg m-1 s-1", [0.0, 0.5, 1.9]),
                series("mean pressure", "Pa", [3.0, 3.0, 3.0]),
            ],
            ..LiveState::default()
        };
        let text = screen(&state, Some(90.0), (100, false));
        for part in
            ["Channel", "25.0 %", "left", "12 345", "inflow, outflow, kg m-1 s-1", "mean pressure, Pa"]
        {
            assert!(text.contains(part), "no `{part}` in\n{text}");
        }
        let braille = text.chars().filter(|letter| ('\u{2801}'..='\u{28ff}').contains(letter)).count();
        assert!(braille > 40, "{braille} parts of curves in\n{text}");
    }

    #[test]
    fn run_without_rows_is_drawn() {
        assert!(screen(&LiveState::default(), None, (100, false)).contains("0.0 %"));
    }

    #[test]
    fn map_is_beside_the_curves_or_in_their_place() {
        let state = LiveState::default();
        let has_map = |screen: String| screen.contains("no frame yet");
        assert!(has_map(screen(&state, None, (WIDE, false))));
        assert!(!has_map(screen(&state, None, (WIDE - 1, false))));
        assert!(has_map(screen(&state, None, (WIDE - 1, true))));
    }
}
