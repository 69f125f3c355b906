//! Results of a run by name: columns of the monitor and of the forces, quantities of probes.

use std::path::{Path, PathBuf};

use super::units::written;
use crate::error::OutputError;
use crate::header::{Header, ProbeShape};
use crate::paths::{FORCES_CSV, MONITOR_CSV};
use crate::probes::history::ProbeHistory;
use crate::results::read_header;
use crate::table::Table;

/// Columns that every table has, over or beside which nothing is plotted.
const CLOCK: [&str; 2] = ["time", "step"];

/// Tables of a run folder.
pub(super) struct RunTables {
    pub(super) folder: PathBuf,
    pub(super) header: Header,
    /// Name of the table, and its columns.
    tables: Vec<(&'static str, Table)>,
    probes: Vec<(ProbeHistory, ProbeShape)>,
}

/// A result.
pub(super) enum Found<'a> {
    /// Column over time.
    Series { name: String, unit: String, times: Vec<f64>, values: Vec<f64> },
    /// Quantity at the points of a line.
    Profile { name: String, unit: String, probe: &'a ProbeHistory, values: &'a [f64] },
}

impl RunTables {
    /// Reads the tables of a run.
    ///
    /// # Errors
    /// [`OutputError`] when the folder is not a run or a table cannot be read.
    pub(super) fn read(folder: &Path) -> Result<Self, OutputError> {
        let header = read_header(folder)?;
        let mut tables = Vec::new();
        for (name, file) in [("monitor", MONITOR_CSV), ("forces", FORCES_CSV)] {
            let path = folder.join(file);
            if path.exists() {
                tables.push((name, Table::read(&path)?));
            }
        }
        let shapes = header.probes.iter().map(|probe| probe.kind);
        let probes = ProbeHistory::read_all(folder, &header)?.into_iter().zip(shapes).collect();
        Ok(Self { folder: folder.to_owned(), header, tables, probes })
    }

    /// Returns the result of a name.
    ///
    /// # Errors
    /// [`OutputError::Request`] with the names of all results when there is none.
    pub(super) fn find(&self, name: &str) -> Result<Found<'_>, OutputError> {
        let found = match name.split_once('.') {
            Some(("probes", rest)) => self.quantity(rest),
            Some((table, column)) => self.column(table, column),
            None => None,
        };
        found.ok_or_else(|| self.unknown(name))
    }

    fn column(&self, table: &str, name: &str) -> Option<Found<'_>> {
        let (_, table) = self.tables.iter().find(|(known, _)| *known == table)?;
        let is = |wanted: &str| table.columns.iter().position(|column| column.name == wanted);
        let (time, column) = (is("time")?, is(name).filter(|_| !CLOCK.contains(&name))?);
        let unit = table.columns[column].unit.as_deref().unwrap_or_default();
        Some(Found::Series {
            name: name.to_owned(),
            unit: written(unit),
            times: table.numbers(time),
            values: table.numbers(column),
        })
    }

    /// Returns a quantity of a probe, `NAME.QUANTITY`, in which the name may have points.
    fn quantity(&self, name: &str) -> Option<Found<'_>> {
        let (probe, quantity) = name.rsplit_once('.')?;
        let (probe, shape) = self.probes.iter().find(|(known, _)| known.name == probe)?;
        let (_, values) = probe.columns.iter().find(|(known, _)| *known == quantity)?;
        let unit = written(crate::probes::unit_of(*shape, quantity, self.header.dimensions));
        let name = name.to_owned();
        Some(match shape {
            ProbeShape::Line => Found::Profile { name, unit, probe, values },
            _ => Found::Series { name, unit, times: probe.times.clone(), values: values.clone() },
        })
    }

    fn names(&self) -> Vec<String> {
        let columns = self.tables.iter().flat_map(|(table, content)| {
            let names = content.columns.iter().map(|column| column.name.as_str());
            names.filter(|name| !CLOCK.contains(name)).map(move |name| format!("{table}.{name}"))
        });
        let quantities = self.probes.iter().flat_map(|(probe, _)| {
            probe.columns.iter().map(move |(quantity, _)| format!("probes.{}.{quantity}", probe.name))
        });
        columns.chain(quantities).collect()
    }

    /// Returns the names of all results, those of a table or a probe in a line.
    pub(super) fn list(&self) -> String {
        let names = self.names();
        let owner = |name: &String| name.rsplit_once('.').map(|(owner, _)| owner.to_owned());
        let groups = names.chunk_by(|a, b| owner(a) == owner(b));
        groups.map(|group| format!("  {}", group.join(" "))).collect::<Vec<_>>().join("\n")
    }

    fn unknown(&self, name: &str) -> OutputError {
        let names = self.names();
        let distance = |known: &&String| strsim::damerau_levenshtein(known, name);
        // The beginning of a name is what people type of a long one.
        let begun = || names.iter().find(|known| known.starts_with(name));
        let nearest =
            || names.iter().min_by_key(distance).filter(|known| distance(known) <= name.len() / 3 + 1);
        let near = begun().or_else(nearest);
        let near = near.map_or_else(String::new, |near| format!(", did you mean `{near}`?"));
        OutputError::Request(format!(
            "`{name}` is not a result of `{}`{near}{} Its results are\n{}",
            self.folder.display(),
            if near.is_empty() { "." } else { "" },
            self.list()
        ))
    }
}
