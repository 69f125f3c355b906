//! Packed files of the probes: `probes.nc` and `probes_mean.csv`, made from the CSV files.
//!
//! In the NetCDF file every probe is a group with its own `time` and the variables `u`, `pressure`,
//! … over it (and over `point` for a line), or `mass_flow` and `mean_pressure` for a section. Names
//! of probes and quantities cannot meet, whatever they are. Time means, named `u_mean`, …, follow
//! the trapezoidal rule over the part of the interval that the run has covered.

use std::path::Path;

use super::series::{Series, read, read_places, time_mean};
use super::writer::quantities;
use crate::error::OutputError;
use crate::header::{Header, ProbeShape};
use crate::mean_interval::{cells, covered, note};
use crate::netcdf::dataset::{Dataset, Group, Variable, over};
use crate::pack::Packed;
use crate::paths::{PROBES_MEAN_CSV, PROBES_NETCDF, PROBES_POINTS_CSV};
use crate::table::{TableColumn, TableWriter, number};

/// Number of columns of `probes_mean.csv` before the quantities.
const PLACE: usize = 7;

/// Writes `probes.nc` and, if means are declared, `probes_mean.csv`, and adds their paths to
/// `packed`, with a note on each mean that the run did not complete.
///
/// # Errors
/// [`OutputError`] with the path and the cause.
pub(crate) fn pack(folder: &Path, header: &Header, packed: &mut Packed) -> Result<(), OutputError> {
    if header.probes.is_empty() || !folder.join(PROBES_POINTS_CSV).exists() {
        return Ok(());
    }
    let mut means = Vec::new();
    let mut incomplete = Incomplete::default();
    let groups = header.probes.iter().zip(read_places(folder, header)?).map(|(probe, places)| {
        let series = read(folder, header, probe, places)?;
        let mut group = group(header, &series);
        if let Some(interval) = probe.mean {
            means.extend(add_means(&mut group, header, &series, interval));
            incomplete.record(&series, interval);
        }
        Ok(group)
    });
    let target = folder.join(PROBES_NETCDF);
    let dataset = Dataset { title: "probes".to_owned(), root: Group::default() };
    dataset.write_with(&target, header, groups)?;
    packed.files.push(target);
    if header.probes.iter().any(|probe| probe.mean.is_some()) {
        let path = folder.join(PROBES_MEAN_CSV);
        TableWriter::create(&path, &mean_columns(header.dimensions))?.append(means)?;
        packed.files.push(path);
    }
    packed.notes.extend(incomplete.notes());
    Ok(())
}

/// Returns the columns of `probes_mean.csv`.
fn mean_columns(dimensions: usize) -> Vec<TableColumn> {
    let mut columns = vec![TableColumn::new("from", "s"), TableColumn::new("to", "s")];
    columns.extend(["probe", "point"].map(TableColumn::of_text));
    columns.extend(["x", "y", "z"].map(|axis| TableColumn::new(axis, "m")));
    // Those of 3D, so that the file has the same columns in 2D, with w empty.
    let fields = quantities(ProbeShape::Line, 3);
    let of_all = fields.into_iter().chain(quantities(ProbeShape::Section, dimensions));
    columns.extend(of_all.map(|quantity| TableColumn::new(quantity.name, quantity.unit)));
    columns
}

/// Probes whose means have the same interval and the same last times, for one note on all.
#[derive(Default)]
struct Incomplete {
    found: Vec<(String, (f64, f64), Vec<f64>)>,
}

impl Incomplete {
    fn record(&mut self, series: &Series<'_>, interval: (f64, f64)) {
        // The note needs the ends only, and the largest step between them.
        if note(&[""], &series.times, interval).is_some() {
            self.found.push((series.probe.name.clone(), interval, series.times.clone()));
        }
    }

    fn notes(self) -> Vec<String> {
        let mut groups: Vec<(Vec<String>, (f64, f64), Vec<f64>)> = Vec::new();
        for (name, interval, times) in self.found {
            let same = |(_, other, of): &&mut (_, (f64, f64), Vec<f64>)| {
                *other == interval && of.last().map(|t| t.to_bits()) == times.last().map(|t| t.to_bits())
            };
            match groups.iter_mut().find(same) {
                Some((names, ..)) => names.push(name),
                None => groups.push((vec![name], interval, times)),
            }
        }
        let text = |(names, interval, times): &(Vec<String>, (f64, f64), Vec<f64>)| {
            note(&names.iter().map(String::as_str).collect::<Vec<_>>(), times, *interval)
        };
        groups.iter().filter_map(text).collect()
    }
}

/// Returns the group of a probe without means.
fn group(header: &Header, series: &Series<'_>) -> Group {
    let mut group = over(series.times.len());
    group.name.clone_from(&series.name);
    group.attributes = vec![("long_name", series.probe.name.clone())];
    group.variables.push(Variable::time(&series.times));
    let mut shape = vec!["time".to_owned()];
    if series.probe.kind == ProbeShape::Line {
        group.dimensions.push(("point".to_owned(), series.points().max(1)));
        shape.push("point".to_owned());
    }
    for (axis, letter) in header.axes().iter().enumerate() {
        group.variables.push(Variable {
            name: (*letter).to_owned(),
            dimensions: shape[1..].to_vec(),
            values: series.places.iter().map(|place| place[axis]).collect(),
            attributes: vec![("units", "m".to_owned()), ("long_name", format!("{letter} coordinate"))],
        });
    }
    for (quantity, values) in &series.columns {
        group.variables.push(Variable {
            name: quantity.name.to_owned(),
            dimensions: shape.clone(),
            values: values.clone(),
            attributes: vec![
                ("units", quantity.unit.to_owned()),
                ("long_name", quantity.long_name.to_owned()),
                ("coordinates", header.axes().join(" ")),
            ],
        });
    }
    group
}

/// Adds the means as variables and returns their rows for the CSV file.
fn add_means(
    group: &mut Group,
    header: &Header,
    series: &Series<'_>,
    interval: (f64, f64),
) -> Vec<Vec<String>> {
    let covered = covered(&series.times, interval);
    let comment = match covered {
        Some((from, to)) => format!("mean from {} s to {} s", number(from), number(to)),
        None => format!("NaN: the run ended before {} s", number(interval.0)),
    };
    let points = series.points();
    let columns = mean_columns(header.dimensions);
    let mut rows: Vec<Vec<String>> = (0..points)
        .map(|point| {
            let mut row = cells(covered).to_vec();
            row.extend([series.probe.name.clone(), point.to_string()]);
            row.extend(series.places[point].map(number));
            row.resize(columns.len(), String::new());
            row
        })
        .collect();
    for (quantity, values) in &series.columns {
        let mean_at = |point: usize| {
            let history: Vec<f64> = values.iter().skip(point).step_by(points).copied().collect();
            covered.map_or(f64::NAN, |(begin, end)| time_mean(&series.times, &history, begin, end))
        };
        let values: Vec<f64> = (0..points).map(mean_at).collect();
        let column = columns.iter().skip(PLACE).position(|column| column.name == quantity.name);
        if let Some(column) = column {
            rows.iter_mut().zip(&values).for_each(|(row, &value)| row[PLACE + column] = number(value));
        }
        let along = series.probe.kind == ProbeShape::Line;
        group.variables.push(Variable {
            name: format!("{}_mean", quantity.name),
            dimensions: if along { vec!["point".to_owned()] } else { Vec::new() },
            values,
            attributes: vec![
                ("units", quantity.unit.to_owned()),
                ("long_name", format!("time mean of {}", quantity.long_name)),
                ("cell_methods", "time: mean".to_owned()),
                ("comment", comment.clone()),
                ("coordinates", header.axes().join(" ")),
            ],
        });
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    use super::super::writer::ProbeWriter;
    use super::super::{ProbePoints, ProbeSample, ProbeSet};
    use crate::header::ProbeHeader;
    use crate::table::Table;
    use glam::DVec3;
    use sphecs_core::particles::sample::Sample;
    use sphecs_core::pass::section::Section;
    use sphecs_scene::model::ProbeSight;

    const MEAN: Option<(f64, f64)> = Some((1.0, 3.0));

    fn header() -> Header {
        let probe = |name: &str, kind, mean| ProbeHeader { name: name.to_owned(), kind, mean };
        Header {
            dimensions: 2,
            probes: vec![
                probe("wake, behind", ProbeShape::Line, MEAN),
                probe("throat", ProbeShape::Section, MEAN),
                probe("tip", ProbeShape::Point, None),
            ],
            ..Header::default()
        }
    }

    fn probes() -> ProbeSet {
        let probe = |header: &ProbeHeader, count: usize| ProbePoints {
            name: header.name.clone(),
            shape: header.kind,
            at: DVec3::X,
            points: (0..count).map(|k| DVec3::new(k as f64, 0.5, 0.0)).collect(),
            areas: vec![0.5; count],
            section: (header.kind == ProbeShape::Section)
                .then(|| Section::new(DVec3::X, DVec3::X, &[DVec3::X], 1.0, [None; 3], 2)),
            sees: ProbeSight::Fluid,
        };
        let probes =
            header().probes.iter().zip([3, 2, 1]).map(|(header, count)| probe(header, count)).collect();
        ProbeSet { probes }
    }

    /// Returns u = time + x at every point but the last of the line, which has no fluid.
    fn sample(time: f64) -> ProbeSample {
        let set = probes();
        let due = [true; 3];
        let samples: Vec<Option<Sample>> = set
            .points(&due)
            .iter()
            .map(|(point, _)| Sample {
                velocity: DVec3::X * (time + point.x),
                pressure: 10.0 * time,
                density: 1000.0,
            })
            .map(|sample| (sample.velocity.x < time + 1.5).then_some(sample))
            .collect();
        let pressures = vec![Some(10.0 * time); set.section_points(&due).len()];
        set.reduce(&due, time, &samples, &pressures, &[1000.0 * time + 500.0])
    }

    #[test]
    fn means_of_an_interval_that_the_run_has_not_reached_are_missing() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut header = header();
        header.probes.iter_mut().for_each(|probe| probe.mean = Some((4.0, 5.0)));
        let mut writer = ProbeWriter::resume(folder.path(), &header, &probes(), &[]).expect("created");
        for time in [0.0, 2.0] {
            writer.append(&sample(time)).expect("written");
        }
        let mut packed = Packed::default();
        pack(folder.path(), &header, &mut packed).expect("packed");
        let means = Table::read(&folder.path().join(PROBES_MEAN_CSV)).expect("read");
        let filled = |column: usize| means.numbers(column).iter().any(|value| !value.is_nan());
        assert!(![0, 1].into_iter().chain(PLACE..PLACE + 7).any(filled), "{:?}", means.rows);
        assert_eq!(packed.notes.len(), 1, "{:?}", packed.notes);
        assert!(
            packed.notes[0].contains("`wake, behind`, `throat`, `tip` begin at 4 s"),
            "{:?}",
            packed.notes
        );
    }

    #[test]
    fn samples_are_sorted_by_probe_and_means_cover_the_interval() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut writer = ProbeWriter::resume(folder.path(), &header(), &probes(), &[]).expect("created");
        for time in [0.0, 0.5, 1.5, 2.5] {
            writer.append(&sample(time)).expect("written");
        }
        let header = header();
        let places = read_places(folder.path(), &header).expect("read");
        let all: Vec<Series<'_>> = header
            .probes
            .iter()
            .zip(places)
            .map(|(probe, places)| read(folder.path(), &header, probe, places).expect("read"))
            .collect();
        assert!(all.iter().all(|series| series.times == [0.0, 0.5, 1.5, 2.5]));
        assert_eq!(all.iter().map(Series::points).collect::<Vec<_>>(), [3, 1, 1]);
        assert_eq!(all[0].columns[0].1[3..5], [0.5, 1.5]);
        assert!(all[0].columns[0].1[5].is_nan());
        assert_eq!(all[1].columns[0].1, [500.0, 1000.0, 2000.0, 3000.0]);

        let mut packed = Packed::default();
        pack(folder.path(), &header, &mut packed).expect("packed");
        assert!(packed.files.iter().all(|file| file.exists()) && packed.files.len() == 2);
        let means = Table::read(&folder.path().join(PROBES_MEAN_CSV)).expect("read");
        // The run ends at 2.5 s, half a second before the interval does.
        assert_eq!((means.numbers(0)[0], means.numbers(1)[0]), (1.0, 2.5));
        let u = means.numbers(PLACE);
        assert!((u[0] - 1.75).abs() < 1e-12 && (u[1] - 2.75).abs() < 1e-12 && u[2].is_nan(), "{u:?}");
        assert!((means.numbers(PLACE + 5)[3] - 2250.0).abs() < 1e-9);
        assert_eq!(means.rows.len(), 4, "the point has no mean");
    }
}
