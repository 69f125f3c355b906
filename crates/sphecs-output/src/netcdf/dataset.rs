//! Small datasets of monitors, probes and forces, written from memory in a single call.

use std::path::Path;

use ::netcdf::{AttributeValue, GroupMut};

use super::file::{WriteError, add_to_group, write_file};
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

impl Variable {
    /// Returns the coordinate `time`.
    pub(crate) fn time(times: &[f64]) -> Self {
        Self {
            name: TIME.to_owned(),
            dimensions: vec![TIME.to_owned()],
            values: times.to_vec(),
            attributes: time_attributes("time since the start of the run"),
        }
    }
}

/// Name of the dimension and of the coordinate in time.
const TIME: &str = "time";

/// Returns the attributes of the coordinate `time`.
fn time_attributes(long_name: &str) -> Vec<(&'static str, String)> {
    let texts = super::layout::TIME_ATTRIBUTES.map(|(name, text)| (name, text.to_owned()));
    texts.into_iter().chain([("long_name", long_name.to_owned())]).collect()
}

/// Dimensions and variables of a file or of one of its groups.
#[derive(Clone, Debug, Default)]
pub(crate) struct Group {
    /// Name; unused for the root of a file.
    pub(crate) name: String,
    /// Text attributes.
    pub(crate) attributes: Vec<(&'static str, String)>,
    /// Names and lengths; `time` is unlimited.
    pub(crate) dimensions: Vec<(String, usize)>,
    /// Variables in the order of the file.
    pub(crate) variables: Vec<Variable>,
}

/// Content of a file.
#[derive(Clone, Debug, Default)]
pub(crate) struct Dataset {
    /// Title of the file.
    pub(crate) title: String,
    /// Dimensions and variables outside the groups.
    pub(crate) root: Group,
}

impl Dataset {
    /// Returns the columns of a table as variables over time, with the long names of the `known`
    /// columns.
    pub(crate) fn over_time(title: &str, table: &Table, known: &[(TableColumn, String)]) -> Self {
        let columns = table.columns.iter().enumerate();
        let variable = |(index, column): (usize, &TableColumn)| {
            let long_name = known.iter().find(|(other, _)| other == column).map(|(_, long_name)| long_name);
            over_time(column, &column.name, long_name, table.numbers(index))
        };
        let root = Group { variables: columns.map(variable).collect(), ..over(table.rows.len()) };
        Self { title: title.to_owned(), root }
    }

    /// Writes the file completely or not at all.
    ///
    /// # Errors
    /// [`OutputError`] with the path and the cause.
    pub(crate) fn write(&self, path: &Path, header: &Header) -> Result<(), OutputError> {
        self.write_with(path, header, std::iter::empty())
    }

    /// Writes the file with groups, of which only one is in memory at a time.
    ///
    /// # Errors
    /// [`OutputError`] of a group, or with the path and the cause.
    pub(crate) fn write_with(
        &self,
        path: &Path,
        header: &Header,
        groups: impl Iterator<Item = Result<Group, OutputError>>,
    ) -> Result<(), OutputError> {
        write_file(path, |file| {
            put_header(file, header, &self.title)?;
            let Some(mut root) = file.root_mut() else {
                return Err(::netcdf::Error::NotFound("/".to_owned()).into());
            };
            put(&mut root, &self.root)?;
            for group in groups {
                let group = group.map_err(WriteError::Source)?;
                put(&mut root.add_group(&group.name)?, &group)?;
            }
            Ok(())
        })
    }
}

/// Returns a group without variables over a number of times.
pub(crate) fn over(times: usize) -> Group {
    Group { dimensions: vec![(TIME.to_owned(), times)], ..Group::default() }
}

/// Returns a column of a table as a variable over time.
pub(crate) fn over_time(
    column: &TableColumn,
    name: &str,
    long_name: Option<&String>,
    values: Vec<f64>,
) -> Variable {
    let long_name = long_name.cloned().unwrap_or_else(|| column.name.clone());
    let attributes = match name {
        TIME => time_attributes(&long_name),
        _ => vec![("units", column.unit.clone().unwrap_or_default()), ("long_name", long_name)],
    };
    Variable { name: name.to_owned(), dimensions: vec![TIME.to_owned()], values, attributes }
}

fn put(to: &mut GroupMut<'_>, group: &Group) -> Result<(), ::netcdf::Error> {
    for (name, text) in &group.attributes {
        to.add_attribute(name, text.as_str())?;
    }
    for (name, length) in &group.dimensions {
        if name == TIME {
            to.add_unlimited_dimension(name)?;
        } else {
            to.add_dimension(name, *length)?;
        }
    }
    let length = |name: &String| {
        group.dimensions.iter().find(|(other, _)| other == name).map_or(0, |(_, length)| *length)
    };
    for variable in &group.variables {
        let dimensions: Vec<&str> = variable.dimensions.iter().map(String::as_str).collect();
        let shape: Vec<usize> = variable.dimensions.iter().map(length).collect();
        let chunks: Vec<usize> = shape.iter().map(|&length| length.clamp(1, 4096)).collect();
        let attributes: Vec<(&str, AttributeValue)> = variable
            .attributes
            .iter()
            .map(|(name, text)| (*name, AttributeValue::from(text.as_str())))
            .collect();
        let mut stored = add_to_group::<f64>(to, &variable.name, &dimensions, &chunks, &attributes)?;
        if !variable.values.is_empty() {
            stored.put_values(&variable.values, (vec![0; shape.len()], shape.clone()))?;
        }
    }
    Ok(())
}
