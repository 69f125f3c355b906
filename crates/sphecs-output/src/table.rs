//! CSV tables with a header line of `name [unit]` that pandas reads and one flushed line per row.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use csv::StringRecord;

use super::error::OutputError;

/// Column with its name and its unit in UDUNITS notation; text columns have no unit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct TableColumn {
    pub name: String,
    pub unit: Option<String>,
}

impl TableColumn {
    pub(crate) fn new(name: impl Into<String>, unit: &str) -> Self {
        Self { name: name.into(), unit: Some(unit.to_owned()) }
    }

    pub(crate) fn of_text(name: &str) -> Self {
        Self { name: name.to_owned(), unit: None }
    }

    fn title(&self) -> String {
        match &self.unit {
            Some(unit) => format!("{} [{unit}]", self.name),
            None => self.name.clone(),
        }
    }

    fn from_title(title: &str) -> Self {
        match title.split_once(" [") {
            Some((name, unit)) => Self::new(name, unit.trim_end_matches(']')),
            None => Self::of_text(title),
        }
    }
}

/// Returns the shortest text that reads back as the same double, with an exponent for very small
/// and large numbers.
pub(crate) fn number(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-4..1e15).contains(&size) || !value.is_finite() {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}

/// Returns the number in a cell; NaN for an empty cell and for text.
pub(crate) fn parsed(cell: &str) -> f64 {
    cell.parse().unwrap_or(f64::NAN)
}

/// Appends rows to a CSV file.
#[derive(Debug)]
pub(crate) struct TableWriter {
    path: PathBuf,
    file: File,
    length: u64,
}

impl TableWriter {
    /// Creates a file with its header.
    pub(crate) fn create(path: &Path, columns: &[TableColumn]) -> Result<Self, OutputError> {
        let file = File::create(path).map_err(OutputError::io(path, "write"))?;
        let mut writer = Self { path: path.to_path_buf(), file, length: 0 };
        writer.append([columns.iter().map(TableColumn::title).collect::<Vec<_>>()])?;
        Ok(writer)
    }

    /// Opens a file and truncates it to its first `length` bytes.
    pub(crate) fn resume(path: &Path, length: u64) -> Result<Self, OutputError> {
        let refused = || OutputError::io(path, "cut back");
        let mut file = File::options().write(true).open(path).map_err(refused())?;
        file.set_len(length).map_err(refused())?;
        file.seek(SeekFrom::Start(length)).map_err(refused())?;
        Ok(Self { path: path.to_path_buf(), file, length })
    }

    /// Returns the number of bytes written.
    pub(crate) fn length(&self) -> u64 {
        self.length
    }

    /// Returns the path, for the thread that makes the file durable.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Appends rows in one write, so that a kill leaves at most one incomplete line at the end.
    pub(crate) fn append(&mut self, rows: impl IntoIterator<Item = Vec<String>>) -> Result<(), OutputError> {
        let lines: String = rows.into_iter().map(|row| line(&row) + "\n").collect();
        self.append_lines(&lines)
    }

    /// Appends complete lines in one write.
    pub(crate) fn append_lines(&mut self, lines: &str) -> Result<(), OutputError> {
        let written = self.file.write_all(lines.as_bytes());
        written.map_err(OutputError::io(&self.path, "write"))?;
        self.length += lines.len() as u64;
        Ok(())
    }
}

/// Returns the cells of a row as CSV, without an end of line.
pub(crate) fn line(cells: &[String]) -> String {
    let quoted = cells.iter().map(|cell| {
        if cell.contains([',', '"', '\n', '\r']) {
            format!("\"{}\"", cell.replace('"', "\"\""))
        } else {
            cell.clone()
        }
    });
    quoted.collect::<Vec<String>>().join(",")
}

/// A CSV file in memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Table {
    pub columns: Vec<TableColumn>,
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// Reads a file; an incomplete last line, as after a kill, is omitted.
    pub(crate) fn read(path: &Path) -> Result<Self, OutputError> {
        let mut rows = Vec::new();
        let columns = for_each_row(path, |row| rows.push(row.iter().map(str::to_owned).collect()))?;
        Ok(Self { columns, rows })
    }

    /// Returns the numbers of a column; NaN for empty cells and text.
    pub(crate) fn numbers(&self, column: usize) -> Vec<f64> {
        self.rows.iter().map(|row| parsed(&row[column])).collect()
    }
}

/// Calls `visit` for each row of a file, which may be larger than the memory, and returns the
/// columns.
///
/// An incomplete last line, as after a kill, is omitted.
pub(crate) fn for_each_row(
    path: &Path,
    mut visit: impl FnMut(&StringRecord),
) -> Result<Vec<TableColumn>, OutputError> {
    let open = || {
        let mut file = File::open(path)?;
        let length = whole_lines(&mut file)?;
        file.rewind()?;
        Ok(file.take(length))
    };
    let damaged =
        |error: csv::Error| OutputError::Damaged { path: path.to_path_buf(), what: error.to_string() };
    let mut reader = csv::Reader::from_reader(open().map_err(OutputError::io(path, "read"))?);
    let columns = reader.headers().map_err(damaged)?.iter().map(TableColumn::from_title).collect();
    let mut row = StringRecord::new();
    while reader.read_record(&mut row).map_err(damaged)? {
        visit(&row);
    }
    Ok(columns)
}

/// Returns the number of bytes up to the end of the last complete line.
fn whole_lines(file: &mut File) -> std::io::Result<u64> {
    const BLOCK: u64 = 4096;
    let mut end = file.seek(SeekFrom::End(0))?;
    while end > 0 {
        let start = end.saturating_sub(BLOCK);
        file.seek(SeekFrom::Start(start))?;
        let mut block = vec![0; (end - start) as usize];
        file.read_exact(&mut block)?;
        if let Some(last) = block.iter().rposition(|&byte| byte == b'\n') {
            return Ok(start + last as u64 + 1);
        }
        end = start;
    }
    Ok(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_back_exactly() {
        for value in [0.0, -0.1, 1.0 / 3.0, 6.02e23, -2.5e-17, 123456.789, f64::MIN_POSITIVE] {
            assert_eq!(number(value).parse::<f64>().expect("a number"), value);
        }
        assert_eq!(number(1e-9), "1e-9");
        assert!(number(f64::NAN).parse::<f64>().expect("a number").is_nan());
    }

    #[test]
    fn incomplete_last_line_is_omitted() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("table.csv");
        let columns = vec![TableColumn::new("time", "s"), TableColumn::of_text("probe, or so")];
        let mut writer = TableWriter::create(&path, &columns).expect("created");
        writer.append([vec!["0.5".to_owned(), "a \"b\"".to_owned()]]).expect("written");
        writer.file.write_all(b"0.75,cut o").expect("written");
        let table = Table::read(&path).expect("read");
        assert_eq!(table.columns, columns);
        assert_eq!(table.rows, [["0.5", "a \"b\""]]);
        assert_eq!(table.numbers(0), [0.5]);
    }

    #[test]
    fn rows_beyond_the_length_are_cut_off_and_new_ones_follow() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("table.csv");
        let mut writer = TableWriter::create(&path, &[TableColumn::new("time", "s")]).expect("created");
        writer.append([vec!["0.5".to_owned()]]).expect("written");
        let length = writer.length();
        writer.append([vec!["0.75".to_owned()], vec!["1".to_owned()]]).expect("written");
        let mut writer = TableWriter::resume(&path, length).expect("opened");
        writer.append([vec!["0.625".to_owned()]]).expect("written");
        assert_eq!(Table::read(&path).expect("read").numbers(0), [0.5, 0.625]);
        assert_eq!(writer.length(), std::fs::metadata(&path).expect("its size").len());
    }
}
