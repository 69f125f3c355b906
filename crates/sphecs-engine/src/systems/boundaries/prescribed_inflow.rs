//! Volume flow that the inlets of a scene prescribe, as its outlets see it.

use glam::DVec3;

use sphecs_core::boundary::outlet::non_reflecting::prescribed_flow::Inflow;
use sphecs_core::boundary::slow_part::SlowPart;
use sphecs_scene::model::{Inlet, Scene};

/// Inflow of a scene with its slow part for each outlet: a function of time, which a checkpoint
/// need not save.
#[derive(Debug, Default)]
pub struct PrescribedInflow {
    /// Points of the section of each inlet, a spacing apart, m. They do not move: a mean over the
    /// inflow particles would vary as rows of different speeds enter at different times.
    points: Vec<Vec<DVec3>>,
    /// Filter of each outlet, for the passage of sound along its normal; none without inlets.
    filters: Vec<SlowPart>,
    /// Results of the present step.
    found: Vec<Inflow>,
    /// Volume flow in the present step, m³/s (m²/s in 2D); None without inlets.
    rate: Option<f64>,
    /// Rate of change of the volume flow in the present step, m³/s² (m²/s² in 2D); None without
    /// inlets.
    acceleration: Option<f64>,
}

impl PrescribedInflow {
    /// Returns the inflow of a scene.
    pub fn new(scene: &Scene) -> Self {
        let points = scene.inlets.iter().map(|inlet| inlet.section_points(scene, 1)).collect();
        let outlets = scene.outlets.iter().filter(|_| !scene.inlets.is_empty());
        let passage = |towards: DVec3| scene.extent_along(towards) / scene.fluid.sound_speed;
        let filters = outlets.map(|outlet| SlowPart::new(passage(outlet.patch.towards))).collect();
        Self { points, filters, found: Vec::new(), rate: None, acceleration: None }
    }

    /// Finds the inflow at a time, s.
    pub fn find(&mut self, scene: &Scene, time: f64) {
        let Self { points, filters, found, rate: present, acceleration } = self;
        let flow = |time: f64| -> f64 {
            let of_inlet = |(inlet, points): (&Inlet, &Vec<DVec3>)| {
                inlet.volume_flow(scene.fluid.viscosity, points, time)
            };
            scene.inlets.iter().zip(&*points).map(of_inlet).sum()
        };
        // Short against any start.
        let moment = 1e-3 * scene.spacing / scene.fluid.sound_speed;
        let (before, after) = ((time - moment).max(0.0), time + moment);
        let rate = || (flow(after) - flow(before)) / (after - before);
        *present = (!scene.inlets.is_empty()).then(|| flow(time));
        *acceleration = (!scene.inlets.is_empty()).then(rate);
        found.clear();
        found.extend(filters.iter_mut().map(|filter| {
            let (rate, acceleration) = filter.at(time, flow);
            Inflow { rate, acceleration }
        }));
    }

    /// Returns the volume flow of the present step, m³/s (m²/s in 2D); None without inlets.
    pub fn rate(&self) -> Option<f64> {
        self.rate
    }

    /// Returns the rate of change of the volume flow, m³/s² (m²/s² in 2D); None without inlets.
    pub fn acceleration(&self) -> Option<f64> {
        self.acceleration
    }

    /// Returns the inflow for an outlet; None without inlets.
    pub fn at_outlet(&self, outlet: usize) -> Option<Inflow> {
        self.found.get(outlet).copied()
    }
}
