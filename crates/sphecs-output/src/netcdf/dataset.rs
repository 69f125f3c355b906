//! Small datasets of monitors and probes, written from memory in a single call.

use std::path::Path;

use ::netcdf::AttributeValue;

use super::file::{add_variable, write_file};
use super::layout::put_header;
use crate::error::OutputError;
use crate::header::Header;
use crate::table::{Table, TableColumn};

/// Variable of doubles.
#[derive(Clone, Debug, Default)]
pub(crate) struct Variable {
    /// Name.
    pub(crate) name: String,
    /// Names of its dimensions, slowest first.
    pub(crate) dimensions: Vec<String>,
    /// Values in row-major order.
    pub(crate) values: Vec<f64>,
    /// Text attributes: units, long_name, …
    pub(crate) attributes: Vec<(&'static str, String)>,
}

/// Dimensions and variables of a file.
#[derive(Clone, Debug, Default)]
pub(crate) struct Dataset {
    /// Title of the file.
    pub(crate) title: String,
    /// Names and lengths; `time` is unlimited.
    pub(crate) dimensions: Vec<(String, usize)>,
    /// Variables in the order of the file.
    pub(crate) variables: Vec<Variable>,
}

impl Dataset {
    /// Returns the columns of a table as variables over time, with the long names of the `known`
    /// columns.
    pub(crate) fn over_time(title: &str, table: &Table, known: &[(TableColumn, String)]) -> Self {
        let variable = |(index, column): (usize, &TableColumn)| {
            let mut attributes = vec![("units", column.unit.clone().unwrap_or_default())];
            if let Some((_, long_name)) = known.iter().find(|(other, _)| other == column) {
                attributes.push(("long_name", long_name.clone()));
            }
            let (name, dimensions) = (column.name.clone(), vec!["time".to_owned()]);
            Variable { name, dimensions, values: table.numbers(index), attributes }
        };
        Self {
            title: title.to_owned(),
            dimensions: vec![("time".to_owned(), table.rows.len())],
            variables: table.columns.iter().enumerate().map(variable).collect(),
        }
    }

    /// Writes the file completely or not at all.
    ///
    /// # Errors
    /// [`OutputError`] with the path and the cause.
    pub(crate) fn write(&self, path: &Path, header: &Header) -> Result<(), OutputError> {
        write_file(path, |file| {
            for (name, length) in &self.dimensions {
                if name == "time" {
                    file.add_unlimited_dimension(name)?;
                } else {
                    file.add_dimension(name, *length)?;
                }
            }
            put_header(file, header, &self.title)?;
            let length = |name: &String| {
                self.dimensions.iter().find(|(other, _)| other == name).map_or(0, |(_, length)| *length)
            };
            for variable in &self.variables {
                let dimensions: Vec<&str> = variable.dimensions.iter().map(String::as_str).collect();
                let shape: Vec<usize> = variable.dimensions.iter().map(length).collect();
                let chunks: Vec<usize> = shape.iter().map(|&length| length.clamp(1, 4096)).collect();
                let attributes: Vec<(&str, AttributeValue)> = variable
                    .attributes
                    .iter()
                    .map(|(name, text)| (*name, AttributeValue::from(text.as_str())))
                    .collect();
                let mut stored =
                    add_variable::<f64>(file, &variable.name, &dimensions, &chunks, &attributes)?;
                if !variable.values.is_empty() {
                    stored.put_values(&variable.values, (vec![0; shape.len()], shape.clone()))?;
                }
            }
            Ok(())
        })
    }
}
