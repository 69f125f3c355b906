//! Packed files of the probes: `probes.nc` and `probes_mean.csv`, made from `probes.csv`.
//!
//! In the NetCDF file a probe `p` has the variables `p_u`, `p_pressure`, … over `time` (and
//! `p_point` for a line), or `p_mass_flow` and `p_mean_pressure` for a section. Time means, named
//! `p_u_mean`, …, follow the trapezoidal rule over the part of the interval that the run has
//! covered.

use std::path::Path;

use super::series::{Series, read, time_mean};
use super::writer::{PLACE, columns, quantities};
use crate::error::OutputError;
use crate::header::{Header, ProbeShape};
use crate::mean_interval::{cells, covered, note};
use crate::netcdf::dataset::{Dataset, Variable};
use crate::pack::Packed;
use crate::paths::{PROBES_CSV, PROBES_MEAN_CSV, PROBES_NETCDF};
use crate::table::{TableColumn, TableWriter, number};

/// Writes `probes.nc` and, if means are declared, `probes_mean.csv`, and adds their paths to
/// `packed`, with a note on each mean that the run did not complete.
///
/// # Errors
/// [`OutputError`] with the path and the cause.
pub(crate) fn pack(folder: &Path, header: &Header, packed: &mut Packed) -> Result<(), OutputError> {
    let source = folder.join(PROBES_CSV);
    if !source.exists() {
        return Ok(());
    }
    let (times, all) = read(&source, header)?;
    let mut dataset = Dataset {
        title: "probes".to_owned(),
        dimensions: vec![("time".to_owned(), times.len())],
        variables: vec![Variable {
            name: "time".to_owned(),
            dimensions: vec!["time".to_owned()],
            values: times.clone(),
            attributes: vec![
                ("units", "s".to_owned()),
                ("long_name", "time since the start of the run".to_owned()),
            ],
        }],
    };
    let mut means = Vec::new();
    for series in &all {
        add_series(&mut dataset, header, series);
        if let Some(interval) = series.probe.mean {
            means.extend(add_means(&mut dataset, header, series, &times, interval));
        }
    }
    let target = folder.join(PROBES_NETCDF);
    dataset.write(&target, header)?;
    packed.files.push(target);
    if all.iter().any(|series| series.probe.mean.is_some()) {
        let path = folder.join(PROBES_MEAN_CSV);
        let mut columns = columns(header);
        columns.splice(0..1, [TableColumn::new("from", "s"), TableColumn::new("to", "s")]);
        TableWriter::create(&path, &columns)?.append(means)?;
        packed.files.push(path);
    }
    packed.notes.extend(notes(&all, &times));
    Ok(())
}

/// Returns a note on the probes of each interval that the run did not complete.
fn notes(all: &[Series], times: &[f64]) -> Vec<String> {
    let mut by_interval: Vec<((f64, f64), Vec<&str>)> = Vec::new();
    for series in all {
        let Some(interval) = series.probe.mean else { continue };
        match by_interval.iter_mut().find(|(other, _)| *other == interval) {
            Some((_, names)) => names.push(&series.probe.name),
            None => by_interval.push((interval, vec![&series.probe.name])),
        }
    }
    by_interval.iter().filter_map(|(interval, names)| note(names, times, *interval)).collect()
}

fn add_series(dataset: &mut Dataset, header: &Header, series: &Series) {
    let name = &series.name;
    let mut shape = vec!["time".to_owned()];
    let along = series.probe.kind == ProbeShape::Line;
    if along {
        let dimension = format!("{name}_point");
        dataset.dimensions.push((dimension.clone(), series.points().max(1)));
        shape.push(dimension);
    }
    for (axis, letter) in header.axes().iter().enumerate() {
        dataset.variables.push(Variable {
            name: format!("{name}_{letter}"),
            dimensions: shape[1..].to_vec(),
            values: series.places.iter().map(|place| place[axis]).collect(),
            attributes: vec![
                ("units", "m".to_owned()),
                ("long_name", format!("{letter} coordinate of the probe {}", series.probe.name)),
            ],
        });
    }
    for (quantity, (letter, unit, long_name)) in measured(header, series) {
        dataset.variables.push(Variable {
            name: format!("{name}_{letter}"),
            dimensions: shape.clone(),
            values: series.values[quantity].clone(),
            attributes: vec![
                ("units", unit.to_owned()),
                ("long_name", format!("{long_name}, probe {}", series.probe.name)),
                ("coordinates", coordinates(header, series)),
            ],
        });
    }
}

/// Returns the quantities of a probe; no w in 2D.
fn measured<'a>(
    header: &'a Header,
    series: &'a Series,
) -> impl Iterator<Item = (usize, (&'static str, &'static str, &'static str))> + 'a {
    let all = quantities(header).into_iter().enumerate();
    all.filter(|&(index, (name, ..))| {
        series.measured().contains(&index) && (header.dimensions == 3 || name != "w")
    })
}

fn coordinates(header: &Header, series: &Series) -> String {
    let names: Vec<String> = header.axes().iter().map(|axis| format!("{}_{axis}", series.name)).collect();
    names.join(" ")
}

/// Adds the means as variables and returns their rows for the CSV file.
fn add_means(
    dataset: &mut Dataset,
    header: &Header,
    series: &Series,
    times: &[f64],
    interval: (f64, f64),
) -> Vec<Vec<String>> {
    let covered = covered(times, interval);
    let comment = match covered {
        Some((from, to)) => format!("mean from {} s to {} s", number(from), number(to)),
        None => format!("NaN: the run ended before {} s", number(interval.0)),
    };
    let points = series.points();
    let mut rows: Vec<Vec<String>> = (0..points)
        .map(|point| {
            let mut row = cells(covered).to_vec();
            row.extend([series.probe.name.clone(), point.to_string()]);
            row.extend(series.places[point].map(number));
            row.extend([const { String::new() }; 7]);
            row
        })
        .collect();
    for (quantity, (letter, unit, long_name)) in measured(header, series) {
        let mean_at = |point: usize| {
            let history: Vec<f64> =
                series.values[quantity].iter().skip(point).step_by(points).copied().collect();
            covered.map_or(f64::NAN, |(begin, end)| time_mean(times, &history, begin, end))
        };
        let values: Vec<f64> = (0..points).map(mean_at).collect();
        for (row, &value) in rows.iter_mut().zip(&values) {
            row[PLACE + 1 + quantity] = number(value);
        }
        let along = series.probe.kind == ProbeShape::Line;
        dataset.variables.push(Variable {
            name: format!("{}_{letter}_mean", series.name),
            dimensions: if along { vec![format!("{}_point", series.name)] } else { Vec::new() },
            values,
            attributes: vec![
                ("units", unit.to_owned()),
                ("long_name", format!("time mean of {long_name}, probe {}", series.probe.name)),
                ("cell_methods", "time: mean".to_owned()),
                ("comment", comment.clone()),
                ("coordinates", coordinates(header, series)),
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
        let samples: Vec<Option<Sample>> = set
            .points()
            .iter()
            .map(|(point, _)| Sample {
                velocity: DVec3::X * (time + point.x),
                pressure: 10.0 * time,
                density: 1000.0,
            })
            .map(|sample| (sample.velocity.x < time + 1.5).then_some(sample))
            .collect();
        set.reduce(time, &samples, &[1000.0 * time + 500.0])
    }

    #[test]
    fn means_of_an_interval_that_the_run_has_not_reached_are_missing() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut header = header();
        header.probes.iter_mut().for_each(|probe| probe.mean = Some((4.0, 5.0)));
        let mut writer = ProbeWriter::create(folder.path(), &header, &probes()).expect("created");
        for time in [0.0, 2.0] {
            writer.append(&sample(time)).expect("written");
        }
        let mut packed = Packed::default();
        pack(folder.path(), &header, &mut packed).expect("packed");
        let means = Table::read(&folder.path().join(PROBES_MEAN_CSV)).expect("read");
        let filled = |column: usize| means.numbers(column).iter().any(|value| !value.is_nan());
        assert!(![0, 1].into_iter().chain(PLACE + 1..PLACE + 8).any(filled), "{:?}", means.rows);
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
        let mut writer = ProbeWriter::create(folder.path(), &header(), &probes()).expect("created");
        for time in [0.0, 0.5, 1.5, 2.5] {
            writer.append(&sample(time)).expect("written");
        }
        let header = header();
        let (times, all) = read(&folder.path().join(PROBES_CSV), &header).expect("read");
        assert_eq!(times, [0.0, 0.5, 1.5, 2.5]);
        assert_eq!(all.iter().map(Series::points).collect::<Vec<_>>(), [3, 1, 1]);
        assert_eq!(all[0].values[0][3..5], [0.5, 1.5]);
        assert!(all[0].values[0][5].is_nan());

        assert_eq!(all[1].values[5], [500.0, 1000.0, 2000.0, 3000.0]);

        let mut packed = Packed::default();
        pack(folder.path(), &header, &mut packed).expect("packed");
        assert!(packed.files.iter().all(|file| file.exists()) && packed.files.len() == 2);
        let means = Table::read(&folder.path().join(PROBES_MEAN_CSV)).expect("read");
        // The run ends at 2.5 s, half a second before the interval does.
        assert_eq!((means.numbers(0)[0], means.numbers(1)[0]), (1.0, 2.5));
        let u = means.numbers(PLACE + 1);
        assert!((u[0] - 1.75).abs() < 1e-12 && (u[1] - 2.75).abs() < 1e-12 && u[2].is_nan(), "{u:?}");
        assert!((means.numbers(PLACE + 6)[3] - 2250.0).abs() < 1e-9);
        assert_eq!(means.rows.len(), 4, "the point has no mean");
    }
}
