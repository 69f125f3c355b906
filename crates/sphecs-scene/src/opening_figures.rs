//! Figures of the openings of a scene before a run: section, mean velocity and flow.

use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::model::{Patch, Scene};
use super::sampled_times::sampled_times;

/// Figures of an opening.
#[derive(Clone, Debug, PartialEq)]
pub struct OpeningFigures {
    /// Name of the opening.
    pub name: String,
    /// Area, m² (width, m, in 2D).
    pub area: f64,
    /// Wetted perimeter, m (number of edges at walls in 2D), and hydraulic diameter, m; None of an
    /// emitter.
    pub section: Option<[f64; 2]>,
    /// Number of columns of an emitter and their depth, m; None of inlets and outlets.
    pub columns: Option<(usize, f64)>,
    /// Times, s, and mean velocities along the flow, m/s; none at one of several outlets, whose
    /// shares of the flow are not known.
    pub velocities: Vec<(f64, f64)>,
}

/// Least number of points along each side of an opening at which its velocity is evaluated.
const POINTS: usize = 40;

/// Returns the figures of the inlets, of the emitters, then of the outlets, at the beginning of a
/// run to `until`, s, and when all inlets and emitters together bring in least and most.
///
/// What they bring in leaves by a single outlet, as the fluid is nearly incompressible.
pub fn opening_figures(scene: &Scene, until: f64) -> Vec<OpeningFigures> {
    let points: Vec<_> = scene.inlets.iter().map(|inlet| inlet.section_points(scene, POINTS)).collect();
    let inflow = |number: usize, time: f64| {
        scene.inlets[number].volume_flow(scene.fluid.viscosity, &points[number], time)
    };
    let total = |time: f64| -> f64 {
        let inlets: f64 = (0..points.len()).map(|number| inflow(number, time)).sum();
        inlets + scene.emitters.iter().map(|emitter| emitter.volume_flow(time)).sum::<f64>()
    };
    let times = extreme_times(until, total);
    let figures = |patch: &Patch, flow: &dyn Fn(f64) -> Option<f64>| OpeningFigures {
        name: patch.name.clone(),
        area: patch.area,
        section: Some([patch.perimeter, patch.hydraulic_diameter()]),
        columns: None,
        velocities: times.iter().filter_map(|&time| Some((time, flow(time)? / patch.area))).collect(),
    };
    let inlets = scene
        .inlets
        .iter()
        .enumerate()
        .map(|(number, inlet)| figures(&inlet.patch, &|time| Some(inflow(number, time))));
    let emitters = scene.emitters.iter().map(|emitter| OpeningFigures {
        name: emitter.name.clone(),
        area: emitter.area(),
        section: None,
        columns: Some((emitter.columns.len(), emitter.depth)),
        velocities: times.iter().map(|&time| (time, emitter.volume_flow(time) / emitter.area())).collect(),
    });
    let is_only = scene.outlets.len() == 1 && scene.source_count() > 0;
    let through = |time: f64| is_only.then(|| total(time));
    let outlets = scene.outlets.iter().map(|outlet| figures(&outlet.patch, &through));
    inlets.chain(emitters).chain(outlets).collect()
}

/// Returns the times, s, of the beginning, of the smallest and of the largest value, each once.
fn extreme_times(until: f64, value: impl Fn(f64) -> f64 + Sync) -> Vec<f64> {
    let times: Vec<f64> = sampled_times(until).collect();
    let values: Vec<(f64, f64)> = times.into_par_iter().map(|time| (time, value(time))).collect();
    let mut found = [(0.0, value(0.0)); 2];
    for (time, value) in values {
        // Rounding must not move the time of a steady flow.
        let slack = 1e-9 * value.abs();
        if value < found[0].1 - slack {
            found[0] = (time, value);
        }
        if value > found[1].1 + slack {
            found[1] = (time, value);
        }
    }
    let mut times = vec![0.0];
    for (time, _) in found {
        if !times.contains(&time) {
            times.push(time);
        }
    }
    times
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extreme_times_are_given_once() {
        assert_eq!(extreme_times(1.0, |_| 2.0), [0.0]);
        assert_eq!(extreme_times(1.0, |time| time.min(0.5)).len(), 2);
        assert_eq!(extreme_times(1.0, |time| 1.0 - time).len(), 2);
        let wave = extreme_times(1.0, |time| (std::f64::consts::TAU * time).sin());
        assert!((wave[1] - 0.75).abs() < 0.01 && (wave[2] - 0.25).abs() < 0.01, "{wave:?}");
    }
}
