//! Tables of inlet velocities in CSV files of the folder of the scene; faults have line and column
//! of the table.

use std::path::Path;

use super::checker::Checker;
use crate::faults::Fault;
use crate::model::InletVelocity;
use crate::notation::tree::Span;
use crate::schema::Text;
use crate::text_file;

/// A number of a table and its position.
struct Cell {
    value: f64,
    span: Span,
}

/// Reads rows of numbers; `#` begins a comment, a first row without numbers is a heading.
fn read(path: &Text, folder: &Path, check: &mut Checker<'_>) -> Option<(String, Vec<Vec<Cell>>)> {
    if path.is_placeholder() {
        return None;
    }
    let text = match text_of(&path.value, folder, check) {
        Ok(text) => text,
        Err(error) => {
            let label = format!("{error}");
            check.report(
                Fault::new(format!("table `{}` cannot be read", path.value), path.span, label)
                    .help("the path is relative to the scene's folder"),
            );
            return None;
        }
    };
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .comment(Some(b'#'))
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let before = check.faults.len();
    let mut rows: Vec<Vec<Cell>> = Vec::new();
    for (index, record) in reader.records().enumerate() {
        let record = match record {
            Ok(record) => record,
            Err(error) => {
                let start = error.position().map_or(0, |p| p.byte() as usize);
                let fault = Fault::new("the table is not CSV", line(&text, start), error.to_string());
                check.report(fault.in_text(&path.value, &text));
                return None;
            }
        };
        let start = record.position().map_or(0, |position| position.byte() as usize);
        if index == 0 && record.iter().all(|cell| cell.parse::<f64>().is_err()) {
            continue;
        }
        let mut row = Vec::new();
        let mut from = start;
        for cell in &record {
            let at = text[from..].find(cell).map_or(from, |offset| from + offset);
            let span = Span::new(at, at + cell.len());
            from = span.end;
            match cell.parse::<f64>() {
                Ok(value) if value.is_finite() => row.push(Cell { value, span }),
                _ => {
                    let label = format!("is `{cell}`, must be a finite number");
                    let fault = Fault::new("a cell of a table is not a number", span, label);
                    check.report(fault.in_text(&path.value, &text));
                    row.push(Cell { value: 1.0, span });
                }
            }
        }
        rows.push(row);
    }
    if rows.is_empty() {
        check.report(Fault::new(format!("table `{}` is empty", path.value), path.span, "must have rows"));
    }
    (check.faults.len() == before).then_some((text, rows))
}

/// Returns the text of a table, as saved with a run or else of the file.
fn text_of(path: &str, folder: &Path, check: &mut Checker<'_>) -> std::io::Result<String> {
    if let Some((_, text)) = check.tables.iter().find(|(known, _)| known == path) {
        return Ok(text.clone());
    }
    let bytes = std::fs::read(folder.join(path))?;
    let invalid = |reason: String| std::io::Error::new(std::io::ErrorKind::InvalidData, reason);
    let text = text_file::decoded(bytes).map_err(invalid)?;
    check.tables.push((path.to_owned(), text.clone()));
    Ok(text)
}

/// Returns the span from a byte to the end of its line.
fn line(text: &str, start: usize) -> Span {
    let start = start.min(text.len());
    let length = text[start..].find('\n').unwrap_or(text.len() - start);
    Span::new(start, start + length)
}

fn rising(cells: &[&Cell], what: &str, path: &str, text: &str, check: &mut Checker<'_>) {
    for pair in cells.windows(2) {
        if pair[0].value >= pair[1].value {
            let label = format!("is `{}`, must be greater than `{}`", pair[1].value, pair[0].value);
            let fault = Fault::new(format!("the {what} of a table do not rise"), pair[1].span, label);
            check.report(fault.in_text(path, text));
        }
    }
}

fn widths(rows: &[Vec<Cell>], width: usize, path: &str, text: &str, check: &mut Checker<'_>) {
    for row in rows.iter().filter(|row| row.len() != width) {
        let (first, last) = (row.first(), row.last());
        let span = match (first, last) {
            (Some(first), Some(last)) => Span::new(first.span.start, last.span.end),
            _ => Span::new(0, 0),
        };
        let label = format!("has {}, must have {width}", row.len());
        let fault = Fault::new("a row of a table has the wrong number of columns", span, label);
        check.report(fault.in_text(path, text));
    }
}

/// Returns rows of time (s) and speed (m/s).
pub fn time_table(path: &Text, folder: &Path, check: &mut Checker<'_>) -> Option<Vec<(f64, f64)>> {
    let (text, rows) = read(path, folder, check)?;
    let before = check.faults.len();
    widths(&rows, 2, &path.value, &text, check);
    if check.faults.len() > before {
        return None;
    }
    let times: Vec<&Cell> = rows.iter().map(|row| &row[0]).collect();
    rising(&times, "times", &path.value, &text, check);
    let table = rows.iter().map(|row| (row[0].value, row[1].value)).collect();
    (check.faults.len() == before).then_some(table)
}

/// Returns the columns of a motion in time, `count` of them.
pub fn motion_table(
    path: &Text,
    count: usize,
    folder: &Path,
    check: &mut Checker<'_>,
) -> Option<MotionColumns> {
    let (text, rows) = read(path, folder, check)?;
    let before = check.faults.len();
    widths(&rows, count + 1, &path.value, &text, check);
    if rows.len() < 2 {
        let fault =
            Fault::new("a table of a motion is too small", line(&text, 0), "must have two rows or more");
        check.report(fault.in_text(&path.value, &text));
    }
    if check.faults.len() > before {
        return None;
    }
    let times: Vec<&Cell> = rows.iter().map(|row| &row[0]).collect();
    rising(&times, "times", &path.value, &text, check);
    let columns = (1..=count).map(|at| rows.iter().map(|row| (row[0].value, row[at].value)).collect());
    let columns = columns.collect();
    (check.faults.len() == before).then_some(columns)
}

/// Columns of the table of a motion: displacements (m) along the axes, or angles (rad), each with
/// the times (s).
pub type MotionColumns = Vec<Vec<(f64, f64)>>;

/// Returns a table of speeds (m/s): positions (m) in the first row, times (s) in the first column.
pub fn profile_table(path: &Text, folder: &Path, check: &mut Checker<'_>) -> Option<InletVelocity> {
    let (text, rows) = read(path, folder, check)?;
    let before = check.faults.len();
    let width = rows[0].len();
    widths(&rows, width, &path.value, &text, check);
    if width < 2 || rows.len() < 2 {
        let fault =
            Fault::new("a profile table is too small", line(&text, 0), "must have positions and times");
        check.report(fault.in_text(&path.value, &text));
    }
    if check.faults.len() > before {
        return None;
    }
    let positions: Vec<&Cell> = rows[0][1..].iter().collect();
    let times: Vec<&Cell> = rows[1..].iter().map(|row| &row[0]).collect();
    rising(&positions, "positions", &path.value, &text, check);
    rising(&times, "times", &path.value, &text, check);
    let values = |cells: &[&Cell]| cells.iter().map(|cell| cell.value).collect();
    let table = InletVelocity::ProfileTable {
        times: values(&times),
        positions: values(&positions),
        speeds: rows[1..].iter().map(|row| row[1..].iter().map(|cell| cell.value).collect()).collect(),
    };
    (check.faults.len() == before).then_some(table)
}
