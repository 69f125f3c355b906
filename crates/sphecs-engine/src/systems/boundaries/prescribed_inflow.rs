//! Volume flow that inlets, emitters and movers of a scene prescribe, as its outlets see it.

use glam::DVec3;

use sphecs_core::boundary::outlet::non_reflecting::prescribed_flow::Inflow;
use sphecs_core::boundary::slow_part::SlowPart;
use sphecs_scene::displaced_flow::DisplacedFlow;
use sphecs_scene::model::{Inlet, Scene};

/// Inflow of a scene with its slow part for each outlet: a function of time, which a checkpoint
/// need not save.
#[derive(Debug, Default)]
pub struct PrescribedInflow {
    /// Points of the section of each inlet, a spacing apart, m. They do not move: a mean over the
    /// inflow particles would vary as rows of different speeds enter at different times.
    points: Vec<Vec<DVec3>>,
    /// Flow that the movers displace; None without movers.
    displaced: Option<DisplacedFlow>,
    /// Filter of each outlet, for the passage of sound along its normal; none if nothing
    /// prescribes a flow.
    filters: Vec<SlowPart>,
    /// Filters of the flow of emitters and that which movers displace, of each outlet; none without
    /// both.
    other_filters: Vec<SlowPart>,
    /// Results of the present step.
    found: Vec<Inflow>,
    /// Slow part of the flow of the inlets alone for each outlet, m³/s (m²/s in 2D).
    of_inlets: Vec<f64>,
    /// Volume flow in the present step, m³/s (m²/s in 2D); None if nothing prescribes a flow.
    rate: Option<f64>,
    /// Rate of change of the volume flow in the present step, m³/s² (m²/s² in 2D); None without
    /// inlets and movers.
    acceleration: Option<f64>,
}

impl PrescribedInflow {
    /// Returns the inflow of a scene.
    pub fn new(scene: &Scene) -> Self {
        let points = scene.inlets.iter().map(|inlet| inlet.section_points(scene, 1)).collect();
        let displaced = DisplacedFlow::new(scene, |_| 1.0);
        let prescribes = scene.source_count() > 0 || displaced.is_some();
        let outlets = scene.outlets.iter().filter(|_| prescribes);
        let passage = |towards: DVec3| scene.extent_along(towards) / scene.fluid.sound_speed;
        let filters: Vec<SlowPart> =
            outlets.map(|outlet| SlowPart::new(passage(outlet.patch.towards))).collect();
        let has_others = displaced.is_some() || !scene.emitters.is_empty();
        let other_filters = if has_others { filters.clone() } else { Vec::new() };
        Self { points, displaced, filters, other_filters, ..Self::default() }
    }

    /// Finds the inflow at a time, s.
    pub fn find(&mut self, scene: &Scene, time: f64) {
        let Self { points, displaced, filters, other_filters, found, of_inlets, rate: present, acceleration } =
            self;
        let others = |time: f64| {
            let moved = displaced.as_ref().map_or(0.0, |displaced| displaced.rate(scene, time));
            moved + scene.emitted_flow(time, |_| 1.0)
        };
        let flow = |time: f64| -> f64 {
            let of_inlet = |(inlet, points): (&Inlet, &Vec<DVec3>)| {
                inlet.volume_flow(scene.fluid.viscosity, points, time)
            };
            let inlets: f64 = scene.inlets.iter().zip(&*points).map(of_inlet).sum();
            inlets + others(time)
        };
        // Short against any start.
        let moment = 1e-3 * scene.spacing / scene.fluid.sound_speed;
        let (before, after) = ((time - moment).max(0.0), time + moment);
        let rate = || (flow(after) - flow(before)) / (after - before);
        let prescribes = !filters.is_empty();
        *present = prescribes.then(|| flow(time));
        *acceleration = prescribes.then(rate);
        found.clear();
        found.extend(filters.iter_mut().map(|filter| {
            let (rate, acceleration) = filter.at(time, flow);
            Inflow { rate, acceleration }
        }));
        of_inlets.clear();
        of_inlets.extend(found.iter().map(|inflow| inflow.rate));
        for (rate, filter) in of_inlets.iter_mut().zip(other_filters) {
            *rate -= filter.at(time, others).0;
        }
    }

    /// Returns the volume flow of the present step, m³/s (m²/s in 2D); None if nothing
    /// prescribes a flow.
    pub fn rate(&self) -> Option<f64> {
        self.rate
    }

    /// Returns the rate of change of the volume flow, m³/s² (m²/s² in 2D); None if nothing
    /// prescribes a flow.
    pub fn acceleration(&self) -> Option<f64> {
        self.acceleration
    }

    /// Returns the slow part of the flow of the inlets alone for an outlet, m³/s (m²/s in 2D).
    pub fn of_inlets(&self, outlet: usize) -> f64 {
        self.of_inlets.get(outlet).copied().unwrap_or(0.0)
    }

    /// Returns the inflow for an outlet; None if nothing prescribes a flow.
    pub fn at_outlet(&self, outlet: usize) -> Option<Inflow> {
        self.found.get(outlet).copied()
    }
}
