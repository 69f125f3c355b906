//! Map of the last frame in a terminal: two pixels in each cell, as the halves of a block.
//!
//! Every terminal with colours shows these. Protocols for images (Kitty, Sixel, iTerm2) would show
//! more pixels in some of them, for twenty more crates.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Color;
use ratatui::widgets::Block;

use sphecs_core::format::significant;
use sphecs_output::error::OutputError;
use sphecs_output::picture::Field;
use sphecs_output::picture::map::{FieldMap, last_map};
use sphecs_output::results::Results;

/// Fields in the order in which the key `f` shows them.
const FIELDS: [Field; 5] = [Field::Speed, Field::Pressure, Field::Vorticity, Field::Density, Field::Zone];

/// Field, frame and size that a map is drawn for.
#[derive(Clone, Copy, PartialEq)]
struct Wanted {
    field: Field,
    frames: u64,
    most: [usize; 2],
}

/// Map of the last frame, drawn on a thread of its own: a large frame takes seconds to read.
pub(super) struct TerminalMap {
    run: PathBuf,
    field: usize,
    /// Request that the thread works on, and the way back of its answer.
    pending: Option<(Wanted, Receiver<Result<FieldMap, OutputError>>)>,
    /// Map that was drawn last; a fault as text.
    drawn: Option<(Wanted, Result<FieldMap, String>)>,
}

impl TerminalMap {
    pub(super) fn new(run: &Path) -> Self {
        Self { run: run.to_owned(), field: 0, pending: None, drawn: None }
    }

    /// Shows the next field.
    pub(super) fn next_field(&mut self) {
        self.field = (self.field + 1) % FIELDS.len();
    }

    /// Draws the map into an area; one of the frame or field before stays until there is a new one.
    pub(super) fn draw(&mut self, frame: &mut Frame<'_>, area: Rect, frames: u64) {
        let field = FIELDS[self.field];
        let block = Block::bordered();
        let inner = block.inner(area);
        let most = [usize::from(inner.width), 2 * usize::from(inner.height)];
        self.refresh(Wanted { field, frames, most });
        let title = match &self.drawn {
            Some((_, Ok(map))) => title(map),
            Some((_, Err(fault))) => format!(" {fault} "),
            None if frames == 0 => " no frame yet ".to_owned(),
            None => format!(" {} … ", field.name()),
        };
        frame.render_widget(block.title(title).title_bottom(" f: next field "), area);
        if let Some((_, Ok(map))) = &self.drawn {
            paint(map, frame, inner);
        }
    }

    /// Takes a map that is complete, and requests one if the present one is out of date.
    fn refresh(&mut self, wanted: Wanted) {
        if let Some((of, answer)) = &self.pending {
            match answer.try_recv() {
                Ok(map) => {
                    self.drawn = Some((*of, map.map_err(|fault| fault.to_string())));
                    self.pending = None;
                }
                Err(TryRecvError::Empty) => return,
                Err(TryRecvError::Disconnected) => self.pending = None,
            }
        }
        let is_new = self.drawn.as_ref().is_none_or(|(of, _)| *of != wanted);
        if is_new && wanted.frames > 0 && wanted.most.iter().all(|&length| length > 0) {
            let (sender, answer) = channel();
            let run = self.run.clone();
            std::thread::spawn(move || answer_with(&sender, &run, wanted));
            self.pending = Some((wanted, answer));
        }
    }
}

fn answer_with(to: &Sender<Result<FieldMap, OutputError>>, run: &Path, wanted: Wanted) {
    let map = Results::open(run).and_then(|results| last_map(&results, wanted.field, wanted.most));
    // The dashboard may have ended meanwhile.
    let _gone = to.send(map);
}

/// Returns `speed, 0 to 0.31 m/s, t = 0.25 s`.
fn title(map: &FieldMap) -> String {
    let unit = map.field.unit();
    let range = map.range.map_or_else(String::new, |(low, high)| {
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        format!(", {} to {}{unit}", significant(low), significant(high))
    });
    format!(" {}{range}, t = {} s ", map.field.name(), significant(map.time))
}

/// Paints a map into the middle of an area.
fn paint(map: &FieldMap, frame: &mut Frame<'_>, area: Rect) {
    let [width, height] = map.size;
    let rows = height.div_ceil(2);
    let left = area.x + (area.width.saturating_sub(width as u16)) / 2;
    let top = area.y + (area.height.saturating_sub(rows as u16)) / 2;
    let colour = |column: usize, row: usize| {
        map.pixels.get(row * width + column).filter(|_| row < height).map(|[r, g, b]| Color::Rgb(*r, *g, *b))
    };
    let buffer = frame.buffer_mut();
    for row in 0..rows {
        for column in 0..width {
            let at = (left + column as u16, top + row as u16);
            // A map of the size before may be larger than the area.
            if let (true, Some(cell)) = (area.contains(at.into()), buffer.cell_mut(at)) {
                cell.set_symbol("▀").set_fg(colour(column, 2 * row).unwrap_or(Color::Reset));
                cell.set_bg(colour(column, 2 * row + 1).unwrap_or(Color::Reset));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use ratatui::Terminal;
    use ratatui::backend::TestBackend;
    use ratatui::buffer::Buffer;

    use super::*;

    fn map(size: [usize; 2]) -> FieldMap {
        let pixels = (0..size[0] * size[1]).map(|pixel| [pixel as u8, 0, 0]).collect();
        FieldMap { field: Field::Speed, frames: 1, time: 0.25, size, pixels, range: Some((0.0, 0.31)) }
    }

    /// Paints a map into a part of a screen of 4 by 4 letters.
    fn painted(map: &FieldMap, area: Rect) -> Buffer {
        let mut terminal = Terminal::new(TestBackend::new(4, 4)).expect("a terminal");
        terminal.draw(|frame| paint(map, frame, area)).expect("drawn");
        terminal.backend().buffer().clone()
    }

    #[test]
    fn pixels_are_the_halves_of_blocks() {
        let map = map([2, 3]);
        assert_eq!(title(&map), " speed, 0 to 0.31 m/s, t = 0.25 s ");
        let buffer = painted(&map, Rect::new(0, 0, 4, 4));
        let cell = |x, y| buffer.cell((x, y)).expect("a cell");
        let red = |value| Color::Rgb(value, 0, 0);
        // Columns 1 and 2, rows 1 and 2 of the area.
        assert_eq!((cell(1, 1).fg, cell(1, 1).bg), (red(0), red(2)));
        assert_eq!((cell(2, 1).fg, cell(2, 1).bg), (red(1), red(3)));
        assert_eq!((cell(2, 2).fg, cell(2, 2).bg), (red(5), Color::Reset));
        assert_eq!(cell(0, 1).symbol(), " ");
    }

    #[test]
    fn map_larger_than_its_area_is_cut() {
        let buffer = painted(&map([9, 9]), Rect::new(1, 1, 2, 2));
        assert_eq!(buffer.content().iter().filter(|cell| cell.symbol() == "▀").count(), 4);
    }
}
