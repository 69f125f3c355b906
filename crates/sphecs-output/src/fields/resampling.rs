//! Gridded fields from the frames of a run, in place of its particles while it ran.
//!
//! The particles of a frame are sorted into cells and sampled as those of a run are. Density and
//! pressure are those of the frame, in single precision; a constant stays exact, a linear field is
//! exact to 1e-6 of its size.

use std::path::Path;

use super::FieldNodes;
use super::averages::{FieldAverages, FieldMeans};
use super::snapshot::FieldSnapshot;
use crate::error::OutputError;
use crate::frame::Frame;
use crate::header::{FieldsHeader, Header};
use crate::netcdf::grids;
use crate::results::Results;
use sphecs_core::format::significant;
use sphecs_core::math::grid::CellGrid;
use sphecs_core::particles::arrays::{ParticleArrays, SpareColumns};
use sphecs_core::particles::rows::ParticleRow;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::grid_rows::{NodeFields, NodeRow, RowSampler, RowSink};
use sphecs_core::pass::settings::PairSettings;
use sphecs_scene::field_grid::FieldOutput;
use sphecs_scene::memory_estimate::{bytes_of_fields, nodes_of_fields};
use sphecs_scene::model::Scene;

/// Options of an export onto a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridOptions {
    /// Distance of the nodes, m.
    pub spacing: f64,
    /// Interval of the means, s; None: no means.
    pub mean: Option<(f64, f64)>,
    /// Memory limit, B; None for no limit.
    pub memory: Option<f64>,
}

/// Writes the fields of all frames of a run on a grid of its whole domain, and on the planes of its
/// scene. Calls `done` with the number of frames written and of all.
///
/// # Errors
/// [`OutputError`] when the run has no frames, its scene cannot be read, or a file cannot be read
/// or written.
pub fn export_grid(
    results: &Results,
    target: &Path,
    options: &GridOptions,
    mut done: impl FnMut(usize, usize),
) -> Result<(), OutputError> {
    if results.is_empty() {
        return Err(results.no_frames());
    }
    let times = results.times();
    let last = times.last().copied().unwrap_or_default();
    if let Some((from, to)) = options.mean.filter(|(from, to)| !(*from < *to && *from < last)) {
        return Err(OutputError::Request(format!(
            "the mean from {} s to {} s: must rise and begin before the last frame, at {} s",
            significant(from),
            significant(to),
            significant(last)
        )));
    }
    let scene = scene_of(&results.header, options)?;
    let nodes = nodes_of_fields(&scene);
    let needed = nodes * bytes_of_fields(&scene);
    if let Some(free) = options.memory.filter(|free| needed > *free) {
        return Err(OutputError::Request(format!(
            "a grid with {} m between the nodes has {nodes:.2e} nodes, that is {:.1} GB; {:.1} GB are free: give a \
             larger spacing",
            significant(options.spacing),
            needed / 1e9,
            free / 1e9
        )));
    }
    let fields = FieldsHeader::of(&scene).unwrap_or_default();
    let header = Header { fields: Some(fields.clone()), ..results.header.clone() };
    let mut nodes = FieldNodes::new(&scene);
    // The means are in the file before the times, so that they are computed in a pass of their own.
    let means = match options.mean {
        None => None,
        Some(mean) => Some(averaged(results, &scene, &mut nodes, mean)?),
    };
    grids::write(target, (&header, &fields), times.len(), means.as_ref(), |index| {
        let frame = results.frame(index)?;
        let snapshot = snapshot(&scene, &mut nodes, &frame);
        done(index + 1, times.len());
        Ok(snapshot)
    })
}

/// Returns the scene of a run.
///
/// # Errors
/// [`OutputError::Request`] when this version cannot read it.
pub(crate) fn scene_of_run(header: &Header) -> Result<Scene, OutputError> {
    let loaded = Scene::from_text(&header.scene, &header.text)
        .tables(header.tables.clone())
        .meshes(header.meshes.clone())
        .sets(&header.changes)
        .load();
    loaded.map_err(|errors| {
        OutputError::Request(format!("the scene of the run cannot be read by this version:\n{errors}"))
    })
}

/// Returns the scene of a run with gridded fields.
fn scene_of(header: &Header, options: &GridOptions) -> Result<Scene, OutputError> {
    let mut scene = scene_of_run(header)?;
    let planes = scene.output.fields.take().map_or_else(Vec::new, |fields| fields.planes);
    scene.output.fields = Some(FieldOutput {
        spacing: options.spacing,
        every: scene.output.every,
        mean: options.mean,
        mean_every: None,
        volume: true,
        planes,
    });
    Ok(scene)
}

/// Samples a frame on grids.
pub(crate) fn snapshot(scene: &Scene, nodes: &mut FieldNodes, frame: &Frame) -> FieldSnapshot {
    nodes.update(scene, frame.time);
    nodes.snapshot(frame.time, frame.step, &mut |rows, sinks| sample(scene, frame, rows, sinks))
}

/// Returns the means over an interval, s, in which a frame stands for the time since the one
/// before it.
fn averaged(
    results: &Results,
    scene: &Scene,
    nodes: &mut FieldNodes,
    (from, to): (f64, f64),
) -> Result<FieldMeans, OutputError> {
    let mut averages = FieldAverages::new(nodes);
    let mut sampled = from;
    for (index, time) in results.times().into_iter().enumerate() {
        let until = time.min(to);
        if until > sampled {
            let frame = results.frame(index)?;
            nodes.update(scene, frame.time);
            averages.add(nodes, until - sampled, &mut |rows, sinks| sample(scene, &frame, rows, sinks));
            sampled = until;
        }
    }
    Ok(averages.means((from, sampled)))
}

fn sample(scene: &Scene, frame: &Frame, rows: &[NodeRow], sinks: &mut [&mut dyn RowSink]) {
    match scene.dimensions {
        2 => sample_in::<2>(scene, frame, rows, sinks),
        _ => sample_in::<3>(scene, frame, rows, sinks),
    }
}

/// Distance of the particles from the bounds of the cell grid, in supports.
const MARGIN: f64 = 1.0;

fn sample_in<const D: usize>(scene: &Scene, frame: &Frame, rows: &[NodeRow], sinks: &mut [&mut dyn RowSink]) {
    let pair = PairSettings::new(&scene.discretisation, scene.fluid.tait());
    let (mut particles, tags) = particles::<D>(frame, scene.fluid.density);
    let Some([low, high]) = frame.bounds().filter(|_| !particles.is_empty()) else {
        // Without particles no row has fluid.
        return rows.iter().zip(sinks).for_each(|(row, sink)| {
            sink.take(&vec![NodeFields::ABSENT; row.wanted.len()]);
        });
    };
    let support = pair.discretisation.support;
    let bound = |d: usize, bounds: [f64; 3], sign: f64, periodic: fn((f64, f64)) -> f64| {
        scene.periodic[d].map_or(bounds[d] + sign * MARGIN * support, periodic)
    };
    let mut grid = CellGrid::<D>::new(
        std::array::from_fn(|d| bound(d, low, -1.0, |(from, _)| from)),
        std::array::from_fn(|d| bound(d, high, 1.0, |(_, to)| to)),
        std::array::from_fn(|d| scene.periodic[d].is_some()),
        support,
        pair.discretisation.cell_size(),
    );
    for row in 0..particles.len() {
        let wrapped = grid.wrap(std::array::from_fn(|d| particles.position[d][row]));
        (0..D).for_each(|d| particles.position[d][row] = wrapped[d]);
    }
    let Ok(order) = grid.build(&particles.position, &particles.id, |_| true) else { return };
    particles.reorder(order, &mut SpareColumns::default());
    let tags: Vec<f32> = particles.id.iter().map(|&id| tags[id as usize]).collect();
    let sampler = RowSampler { grid: &grid, particles: &particles, pair: &pair, tags: &tags, sides: None };
    sampler.sample(rows, sinks, |sink, fields| sink.take(fields));
}

/// Returns the particles of a frame that are not stored, and the tags by number.
fn particles<const D: usize>(frame: &Frame, density: f64) -> (ParticleArrays<f64, D>, &[f32]) {
    let mut particles = ParticleArrays::default();
    for slot in 0..frame.len() {
        let zone = Zone::from_number(frame.zone[slot]).filter(|&zone| zone != Zone::Reservoir);
        let Some(zone) = zone else { continue };
        let vector = |columns: [f64; 3]| glam::DVec3::from_array(columns);
        let is_wall = zone == Zone::Wall;
        // Of walls at rest only the places are in the file.
        let known = |value: f32| if is_wall { 0.0 } else { f64::from(value) };
        particles.push(&ParticleRow {
            id: slot as u32,
            zone,
            position: vector([0, 1, 2].map(|axis| frame.position[axis][slot])),
            velocity: vector([0, 1, 2].map(|axis| known(frame.velocity[axis][slot]))),
            pressure: known(frame.pressure[slot]),
            density: if is_wall { density } else { f64::from(frame.density[slot]) },
            ..ParticleRow::default()
        });
    }
    (particles, &frame.tag)
}
