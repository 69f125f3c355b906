//! Checks of the gridded fields: settings, planes that miss the domain, and grids larger than the
//! memory.

use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::checker::Checker;
use super::names::{Named, names};
use super::settings::sampled_mean;
use crate::faults::Fault;
use crate::field_grid::FieldGrid;
use crate::fill;
use crate::memory_estimate::{bytes_of_fields, memory};
use crate::model::{FieldOutput, FieldPlane, Scene};
use crate::notation::tree::Span;
use crate::notation::typed::Spanned;
use crate::result_name::result_name;
use crate::schema::{FieldPlaneFile, FieldsFile, SceneFile};
use crate::summary::estimated_volume;

/// Largest number of nodes, even with `--allow-oversize`: indices of a file are 32 bits wide in
/// many programs.
const MOST_NODES: f64 = 4.0e9;

/// Returns the settings of gridded fields; `every` is the interval of the frames, s.
pub fn fields(
    written: &Spanned<FieldsFile>,
    every: f64,
    end: Option<f64>,
    check: &mut Checker<'_>,
) -> FieldOutput {
    let file = &written.value;
    let spacing = file.spacing.as_ref().map_or(check.spacing, |number| check.positive(number, "m"));
    let every = file.every.as_ref().map_or(every, |number| check.positive(number, "s"));
    let (mean, mean_every) = sampled_mean(file.mean.as_ref(), file.mean_every.as_ref(), end, check);
    let given: Vec<_> = file.planes.iter().map(|plane| Named::Given(&plane.name)).collect();
    names(&given, "planes", check);
    for plane in file.planes.iter().filter(|plane| is_taken(&result_name(&plane.name.value))) {
        let label = "is the name of a variable of the file";
        check.report(Fault::new("a plane needs another name", plane.name.span, label));
    }
    if check.dimensions == 2 {
        for plane in &file.planes {
            let label = "has no meaning in 2D, where the grid is a plane already";
            let fault = Fault::new("planes need three dimensions", plane.name.span, label);
            check.report(fault.help("leave out `planes`; values along a line are a probe, `Line`"));
        }
        let volume = file.volume.unwrap_or(true);
        if !volume {
            let label = "leaves out the domain, which is the only grid in 2D";
            let fault = Fault::new("the gridded fields have no grid", written.head, label);
            check.report(fault.help("leave out `volume: false`"));
        }
        return FieldOutput { spacing, every, mean, mean_every, volume, planes: Vec::new() };
    }
    if file.volume == Some(false) && file.planes.is_empty() {
        let label = "has neither the whole domain nor a plane";
        let fault = Fault::new("the gridded fields have no grid", written.head, label);
        check.report(fault.help("give `planes`, or leave out `volume: false`"));
    }
    let planes: Vec<FieldPlane> = file.planes.iter().map(|plane| field_plane(plane, check)).collect();
    let volume = file.volume.unwrap_or(planes.is_empty());
    FieldOutput { spacing, every, mean, mean_every, volume, planes }
}

/// Names of variables besides means and covariances, with which the groups of planes may not share
/// theirs.
const TAKEN: [&str; 20] = [
    "x",
    "y",
    "z",
    "time",
    "step",
    "u",
    "v",
    "w",
    "pressure",
    "density",
    "vorticity_x",
    "vorticity_y",
    "vorticity_z",
    "tag",
    "fluid_fraction",
    "solid",
    "fluid_time",
    "mean_time",
    "mean_start",
    "mean_end",
];

fn is_taken(name: &str) -> bool {
    let endings = ["_mean", "_covariance", "_variance"];
    TAKEN.contains(&name) || endings.iter().any(|ending| name.ends_with(ending))
}

fn field_plane(file: &FieldPlaneFile, check: &mut Checker<'_>) -> FieldPlane {
    FieldPlane {
        name: file.name.value.clone(),
        at: check.vector(&file.at, "m"),
        normal: check.direction(&file.normal),
    }
}

/// Adds the faults that only the complete scene shows.
pub fn check_scene(scene: &Scene, file: &SceneFile, memory: Option<f64>, faults: &mut Vec<Fault>) {
    let (Some(output), Some(written)) = (&scene.output.fields, &file.output.fields) else { return };
    let before = faults.len();
    faults.extend(too_many(scene, output, written, memory));
    if faults.len() > before {
        return;
    }
    for (plane, written) in output.planes.iter().zip(&written.value.planes) {
        let grid = scene.plane_grid(output, plane);
        if !grid.is_some_and(|grid| is_in_domain(scene, &grid)) {
            let at = plane.at;
            faults.push(
                Fault::new(
                    format!("the plane `{}` is outside the domain", plane.name),
                    written.at.span,
                    format!("is ({}, {}, {}) m: no node of the plane is in the domain", at.x, at.y, at.z),
                )
                .help("give a point of the domain, or a finer `spacing` of the fields"),
            );
        }
    }
}

fn is_in_domain(scene: &Scene, grid: &FieldGrid) -> bool {
    let inside = |point| fill::periodic_distance(&scene.domain, &scene.periodic, point) < 0.0;
    (0..grid.rows()).into_par_iter().any(|row| grid.row_points(row).any(inside))
}

/// Reports more nodes than memory allows beside the particles.
fn too_many(
    scene: &Scene,
    output: &FieldOutput,
    written: &Spanned<FieldsFile>,
    available: Option<f64>,
) -> Option<Fault> {
    let nodes = |spacing: f64| {
        let output = FieldOutput { spacing, ..output.clone() };
        let planes = output.planes.iter().filter_map(|plane| scene.plane_grid(&output, plane));
        let whole = output.volume.then(|| scene.whole_grid(spacing));
        // As numbers of 64 bits: the product of integers may overflow.
        let of = |grid: FieldGrid| grid.axes.iter().map(|axis| axis.count as f64).product::<f64>();
        planes.chain(whole).map(of).sum::<f64>()
    };
    let particles =
        estimated_volume(&scene.container, 0.0, scene.dimensions) / scene.discretisation.cell_volume();
    let bytes = bytes_of_fields(scene);
    let free = available.map_or(f64::INFINITY, |free| free - memory(scene, particles, 0.0));
    let limit = MOST_NODES.min((free / bytes).max(0.0));
    let count = nodes(output.spacing);
    if count <= limit {
        return None;
    }
    let mut least = output.spacing;
    while nodes(least) > limit && least < 1e3 * output.spacing {
        least *= 1.05;
    }
    let place: Span = written.value.spacing.as_ref().map_or(written.head, |number| number.span);
    let have = available.map_or(String::new(), |free| format!("; {:.1} GB are free", free / 1e9));
    Some(
        Fault::new(
            "the grid of the fields has too many nodes",
            place,
            format!(
                "gives {count:.2e} nodes, that is {:.1} GB beside the particles{have}",
                count * bytes / 1e9
            ),
        )
        .help(format!(
            "give the fields a `spacing` of at least `{least:.2e}`{}{}",
            if scene.dimensions == 3 { ", or `planes` in place of the whole domain" } else { "" },
            if available.is_some() { ", or run with `--allow-oversize`" } else { "" }
        )),
    )
}
