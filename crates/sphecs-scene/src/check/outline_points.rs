//! Points of an outline in a text file: two columns x and y, blank lines between closed polylines.
//!
//! Columns are separated by semicolons, commas or white space, in this order of precedence, so that
//! `x; y` and `x, y` are read as well. `#` begins a comment, and the first line may be a heading.

use glam::DVec2;

/// Most faults that are listed one by one.
const MOST_LISTED: usize = 10;

/// Points of the closed polylines of a file.
#[derive(Debug, Default)]
pub struct OutlinePoints {
    /// Polylines, of which none repeats a point of its own in a row.
    pub loops: Vec<PointLoop>,
    /// First line, if it is a heading.
    pub heading: Option<String>,
    /// Number of points left out because they repeat the one before.
    pub repeated: usize,
}

/// A closed polyline of a file.
#[derive(Debug, Default)]
pub struct PointLoop {
    /// Points in the unit of the file.
    pub points: Vec<DVec2>,
    /// Their lines in the file, from 1.
    pub lines: Vec<usize>,
}

/// A fault of a file.
#[derive(Debug, PartialEq, Eq)]
pub struct PointFault {
    /// Line and column, from 1, counted in characters.
    pub place: (usize, usize),
    /// The value found and the values allowed.
    pub text: String,
}

impl PointFault {
    /// Returns a fault at a line and column.
    pub fn new(line: usize, column: usize, text: impl Into<String>) -> Self {
        Self { place: (line, column), text: text.into() }
    }

    /// Returns the fault with the path of its file.
    pub fn in_file(&self, path: &str) -> String {
        let (line, column) = self.place;
        format!("{path}:{line}:{column}: {}", self.text)
    }
}

/// A part of a line with its column, from 1.
type Cell<'a> = (usize, &'a str);

/// Returns the points of a text.
///
/// # Errors
/// All faults of its lines; of many the first and their number.
pub fn read(text: &str) -> Result<OutlinePoints, Vec<PointFault>> {
    let mut read = OutlinePoints::default();
    let mut faults: Vec<PointFault> = Vec::new();
    let (mut open, mut is_first, mut unlisted) = (PointLoop::default(), true, 0);
    for (index, line) in text.lines().enumerate() {
        let content = line.split('#').next().unwrap_or_default();
        let is_separator = |c: char| c.is_whitespace() || c == ',' || c == ';';
        if content.trim_matches(is_separator).is_empty() {
            if !line.contains('#') {
                close(std::mem::take(&mut open), &mut read);
            }
            continue;
        }
        let cells = cells(content);
        if std::mem::take(&mut is_first) && is_heading(&cells) {
            read.heading = Some(content.trim().to_owned());
            continue;
        }
        match point(index + 1, &cells) {
            Ok(point) => {
                open.points.push(point);
                open.lines.push(index + 1);
            }
            Err(found) if faults.len() < MOST_LISTED => faults.extend(found),
            Err(found) => unlisted += found.len(),
        }
    }
    close(open, &mut read);
    if unlisted > 0 {
        let last = faults.last_mut().expect("faults are listed first");
        last.text += &format!("; {unlisted} more faults follow");
    }
    if !faults.is_empty() {
        return Err(faults);
    }
    let short = read.loops.iter().filter(|polyline| polyline.points.len() < 3).map(|polyline| {
        let count = polyline.points.len();
        let points = if count == 1 { "point" } else { "points" };
        let text = format!(
            "the polyline that begins here has {count} {points}, must have at least 3: \
             a blank line ends a polyline"
        );
        PointFault::new(polyline.lines[0], 1, text)
    });
    let short: Vec<PointFault> = short.take(MOST_LISTED).collect();
    if read.loops.is_empty() {
        return Err(vec![PointFault::new(1, 1, "has no points, must have lines of x and y")]);
    }
    if short.is_empty() { Ok(read) } else { Err(short) }
}

/// Splits a line into its columns.
fn cells(content: &str) -> Vec<Cell<'_>> {
    let separator = [';', ','].into_iter().find(|separator| content.contains(*separator));
    let parts: Vec<&str> = match separator {
        Some(separator) => content.split(separator).map(str::trim).collect(),
        None => content.split_whitespace().collect(),
    };
    let column = |part: &str| {
        let before = part.as_ptr() as usize - content.as_ptr() as usize;
        content[..before].chars().count() + 1
    };
    parts.into_iter().map(|part| (column(part), part)).collect()
}

/// Returns true for a first line that names columns or the outline. A line whose first number is
/// misspelt, such as `o.1, 0.2`, is none.
fn is_heading(cells: &[Cell<'_>]) -> bool {
    let is_number = |cell: &Cell<'_>| cell.1.parse::<f64>().is_ok_and(f64::is_finite);
    let is_misspelt =
        cells.len() == 2 && is_number(&cells[1]) && cells[0].1.contains(|c: char| c.is_ascii_digit());
    !is_number(&cells[0]) && !is_misspelt
}

/// Returns the point of a line.
fn point(line: usize, cells: &[Cell<'_>]) -> Result<DVec2, Vec<PointFault>> {
    if cells.len() != 2 {
        let count = cells.len();
        let columns = if count == 1 { "column" } else { "columns" };
        let advice = match count {
            1 => ": separate them by a comma, a semicolon or a space",
            4 => ": decimals must have a point, not a comma",
            _ => "",
        };
        let text = format!("has {count} {columns}, must have 2, x and y{advice}");
        return Err(vec![PointFault::new(line, cells[0].0, text)]);
    }
    let (mut point, mut faults) = (DVec2::ZERO, Vec::new());
    for (axis, (column, cell)) in cells.iter().enumerate() {
        match cell.parse::<f64>() {
            Ok(value) if value.is_finite() => point[axis] = value,
            _ => {
                let advice = if cell.contains(',') { " with a point for its decimals" } else { "" };
                let text = format!("is `{cell}`, must be a finite number{advice}");
                faults.push(PointFault::new(line, *column, text));
            }
        }
    }
    if faults.is_empty() { Ok(point) } else { Err(faults) }
}

/// Adds a polyline, if it has points, without those that repeat the one before.
fn close(open: PointLoop, read: &mut OutlinePoints) {
    let mut polyline = PointLoop::default();
    for (point, line) in open.points.into_iter().zip(open.lines) {
        if polyline.points.last() == Some(&point) {
            read.repeated += 1;
        } else {
            polyline.points.push(point);
            polyline.lines.push(line);
        }
    }
    // The last point may repeat the first.
    if polyline.points.len() > 1 && polyline.points.first() == polyline.points.last() {
        polyline.points.pop();
        polyline.lines.pop();
    }
    if !polyline.points.is_empty() {
        read.loops.push(polyline);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

    fn faults(text: &str) -> Vec<String> {
        read(text).expect_err(text).iter().map(|fault| fault.in_file("o.csv")).collect()
    }

    #[test]
    fn points_are_read_with_any_separator() {
        for text in [
            "0,0\n1,0\n1,1\n0,1\n",
            "0;0\n1;0\n1;1\n0;1",
            "0 0\n1\t0\n  1   1\n0 1\n0 0\n",
            "x, y\n0.0, 0.0\n1.0, 0.0 # a corner\n1e0, 1\n# a comment\n0, 1\n0, 0\n\n\n",
            "\n,\n\"x\";\"y\"\n+0; 0\n1;0\n1;0\n1;1\n0;1\n;\n",
            "NACA 0012\n 0 -0\n1 0\n1 1\n0 1",
        ] {
            let found = read(text).unwrap_or_else(|faults| panic!("{text}: {faults:?}"));
            assert_eq!(found.loops.len(), 1, "{text}");
            assert_eq!(found.loops[0].points, SQUARE.map(DVec2::from), "{text}");
            assert_eq!(found.heading.is_some(), text.contains(['x', 'N']), "{text}");
            assert_eq!(found.repeated, usize::from(text.contains("1;0\n1;0")), "{text}");
        }
    }

    #[test]
    fn blank_lines_separate_polylines() {
        let found = read("0,0\n4,0\n0,4\n\n# a hole\n1,1\n2,1\n1,2\n").expect("two polylines");
        assert_eq!(found.loops.len(), 2);
        assert_eq!(found.loops[1].points, [[1.0, 1.0], [2.0, 1.0], [1.0, 2.0]].map(DVec2::from));
        assert_eq!(found.loops[1].lines, [6, 7, 8]);
    }

    #[test]
    fn all_faults_are_found_with_line_and_column() {
        let found = faults("x y\n0 0\n1 o.5\n1 nan # ½\n 1\n1 2 3\n");
        let expected = [
            "o.csv:3:3: is `o.5`, must be a finite number",
            "o.csv:4:3: is `nan`, must be a finite number",
            "o.csv:5:2: has 1 column, must have 2, x and y: separate them by a comma, a semicolon or a space",
            "o.csv:6:1: has 3 columns, must have 2, x and y",
        ];
        assert_eq!(found, expected);
        for (text, expected) in [
            ("", "o.csv:1:1: has no points"),
            ("x,y\n# none\n", "o.csv:1:1: has no points"),
            ("o.1, 0.2\n1, 0\n0, 1\n1, 1", "o.csv:1:1: is `o.1`"),
            ("0,5;0\n", "o.csv:1:1: is `0,5`, must be a finite number with a point"),
            ("0,5, 1,5\n", "decimals must have a point, not a comma"),
            (
                "0,0\n1,0\n0,0\n",
                "o.csv:1:1: the polyline that begins here has 2 points, must have at least 3",
            ),
            ("0,0\n1,0\n0,1\n\n3,3", "o.csv:5:1: the polyline that begins here has 1 point, must"),
            ("0,0,\n1,0\n0,1\n", "o.csv:1:1: has 3 columns"),
        ] {
            let found = faults(text);
            assert!(found.len() == 1 && found[0].contains(expected), "{text}: {found:?}");
        }
        let many = faults(&"x;\n".repeat(500));
        assert!(many.len() <= 11 && many.last().expect("a fault").contains("more faults"), "{many:?}");
    }
}
