//! Figures of the openings of a scene before a run: section, mean velocity and flow.

use super::flow_path::{section_points, volume_flow};
use super::model::{Patch, Scene};

/// Figures of an opening.
#[derive(Clone, Debug, PartialEq)]
pub struct OpeningFigures {
    /// Name of the opening.
    pub name: String,
    /// Area, m² (width, m, in 2D).
    pub area: f64,
    /// Wetted perimeter, m (number of edges at walls in 2D).
    pub perimeter: f64,
    /// Hydraulic diameter, m.
    pub hydraulic_diameter: f64,
    /// Times, s, and mean velocities along the flow, m/s; none at one of several outlets, whose
    /// shares of the flow are not known.
    pub velocities: Vec<(f64, f64)>,
}

/// Returns the figures of the inlets, then of the outlets, at the beginning, in the middle and at
/// the end of a run to `until`, s.
///
/// What all inlets bring in leaves by a single outlet, as the fluid is nearly incompressible.
pub fn opening_figures(scene: &Scene, until: f64) -> Vec<OpeningFigures> {
    let points: Vec<_> = scene.inlets.iter().map(|inlet| section_points(inlet, scene)).collect();
    let inflow = |number: usize, time: f64| volume_flow(&scene.inlets[number], &points[number], scene, time);
    let times = [0.0, 0.5 * until, until];
    let figures = |patch: &Patch, flow: &dyn Fn(f64) -> Option<f64>| OpeningFigures {
        name: patch.name.clone(),
        area: patch.area,
        perimeter: patch.perimeter,
        hydraulic_diameter: patch.hydraulic_diameter(),
        velocities: times.iter().filter_map(|&time| Some((time, flow(time)? / patch.area))).collect(),
    };
    let inlets = scene
        .inlets
        .iter()
        .enumerate()
        .map(|(number, inlet)| figures(&inlet.patch, &|time| Some(inflow(number, time))));
    let is_only = scene.outlets.len() == 1 && !scene.inlets.is_empty();
    let total = |time: f64| is_only.then(|| (0..scene.inlets.len()).map(|number| inflow(number, time)).sum());
    let outlets = scene.outlets.iter().map(|outlet| figures(&outlet.patch, &total));
    inlets.chain(outlets).collect()
}
