//! Nonreflecting outlet pressure: acoustic waves in the zone and at its section.
//!
//! - [`oblique_waves`]: waves at any angle to the normal
//! - [`plane_waves`]: plane waves along the normal
//! - [`prescribed_flow`]: mean velocity that the prescribed inflow causes
//! - [`propagation`]: propagation of waves through the zone
//!
//! In each step the flow is sampled at points of the section. The outgoing waves there give the
//! pressure of the outlet, which then propagates through the zone.

pub mod oblique_waves;
pub mod plane_waves;
pub mod prescribed_flow;
pub mod propagation;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::convection::convective_velocity;
use super::outflow_zone::{OutflowZone, settling_time};
use super::pressure::Waves;
use crate::boundary::flow::FlowProperties;
use crate::boundary::patch::Patch;
use crate::boundary::section_points::SectionPoints;
use crate::pass::fits::PointFlow;
use crate::pass::pair_real::PairReal;
use oblique_waves::{ObliqueSetting, ObliqueWaves};
use plane_waves::{PlaneSetting, PlaneWaves};
use prescribed_flow::{InflowStep, Prescribed, PrescribedFlow};
use propagation::Propagation;

/// Travel times of sound along the section over which the velocity at its points is followed. A
/// longer time takes more of a vortex for sound, a shorter one less of the sound
/// (docs/notebook/2026-11-24-outlets.md).
const CROSSINGS: f64 = 1.0;

/// Layers upstream of the sampled points that their mean represents, since the outer part of the
/// support has no fluid.
const LAYERS_SEEN: f64 = 1.0;

/// State of a nonreflecting outlet, with the results of the present step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NonReflecting {
    /// Mean velocity that the prescribed inflow causes.
    pub prescribed: PrescribedFlow,
    /// Plane waves.
    pub plane: PlaneWaves,
    /// Oblique waves.
    pub oblique: ObliqueWaves,
    /// Waves that entered the zone before.
    pub propagation: Propagation,
    /// Mean acceleration of the zone along the normal by viscosity in the last step, m/s².
    pub friction: f64,
    /// Points of the section, from the scene.
    #[serde(skip)]
    section: Option<SectionPoints>,
    /// Pressure of the outlet at the points, Pa.
    #[serde(skip)]
    pressure: Vec<f64>,
    /// Convective velocity at the points, less that without sound, m/s.
    #[serde(skip)]
    velocity: Vec<f64>,
    /// Pressure (Pa) and normal velocity (m/s) of the fluid at the points, less their means.
    #[serde(skip)]
    deviation: [Vec<f64>; 2],
}

/// Distance inside the plane of the mean of the fluid, in spacings: one layer, and less than a
/// third of one since a kernel that the plane cuts sees further inwards.
const SAMPLED_LAYERS: f64 = 1.3;

impl NonReflecting {
    /// Returns the points at which the fluid must be known.
    pub fn section(&mut self, flow: &FlowProperties<'_>, patch: &Patch) -> &SectionPoints {
        self.section.get_or_insert_with(|| SectionPoints::new(flow, patch))
    }

    /// Advances the waves by a step, from the flow fitted at the points behind those of the zone's
    /// rows.
    ///
    /// `target` (Pa) and `time` (s) are those of
    /// [`OutletPressure::NonReflecting`](super::pressure::OutletPressure::NonReflecting).
    pub fn advance<R: PairReal<D>, const D: usize>(
        &mut self,
        zone: &OutflowZone<'_, R, D>,
        target: f64,
        time: Option<f64>,
        waves: Waves,
    ) {
        let (flow, patch, time_step) = (&zone.flow, zone.patch, zone.time_step);
        let (density, sound_speed) = (flow.density, flow.sound_speed);
        let inflow = zone.prescribed.filter(|_| time.is_none());
        let time = time.unwrap_or_else(|| settling_time(zone.extent, sound_speed));
        let setting = PlaneSetting { target, time, density, sound_speed };
        let mean = self.mean(zone);
        let prescribed = match inflow {
            Some(inflow) => self.prescribed.advance(&InflowStep {
                inflow,
                velocity: mean.velocity,
                area: patch.area,
                area_share: zone.area_share,
                passage: zone.extent / sound_speed,
                time_step,
            }),
            None => Prescribed::default(),
        };
        // The mean is that of the fluid inside the plane; the pressure falls towards the plane
        // while the flow accelerates or overcomes friction.
        let friction = if zone.is_balanced { 0.0 } else { self.friction };
        let fall = density * (prescribed.acceleration - friction) * SAMPLED_LAYERS * flow.spacing;
        let velocity = mean.velocity - prescribed.velocity;
        let plane = self.plane.advance(&setting, mean.pressure - fall, velocity, time_step);
        self.spread(zone, plane, prescribed.velocity, waves);
    }

    /// Returns the mean over the section of the flow fitted at its points.
    pub fn mean<R: PairReal<D>, const D: usize>(&mut self, zone: &OutflowZone<'_, R, D>) -> PointFlow {
        self.split(&zone.fitted()[zone.rows.len()..], zone.adjacent)
    }

    /// Returns the mean over the section of values at its points.
    pub fn section_mean(&self, values: impl Iterator<Item = f64>) -> f64 {
        let shares = self.section.as_ref().map_or(&[][..], |section| &section.shares);
        values.zip(shares).map(|(value, share)| value * share).sum()
    }

    /// Sets the pressure at the points to that of the plane waves, Pa, and adds the oblique ones.
    /// The waves then propagate through the zone. [`mean`](Self::mean) comes first.
    ///
    /// `base` is the mean velocity that the flow has without sound, m/s. It reaches the whole zone
    /// at once: with the delay of sound the zone would brake a flow that accelerates, by a pressure
    /// of 3 to 4 ρ0 Δ dU/dt at the plane.
    pub fn spread<R: PairReal<D>, const D: usize>(
        &mut self,
        zone: &OutflowZone<'_, R, D>,
        plane: f64,
        base: f64,
        waves: Waves,
    ) {
        let (flow, patch, time_step) = (&zone.flow, zone.patch, zone.time_step);
        let (fitted, adjacent) = (&zone.fitted()[zone.rows.len()..], zone.adjacent);
        let (density, sound_speed) = (flow.density, flow.sound_speed);
        self.pressure.clear();
        self.pressure.resize(fitted.len(), plane);
        if waves == Waves::All {
            self.add_oblique(flow, patch, time_step);
        }
        self.velocity.clear();
        self.velocity.extend(fitted.iter().zip(&self.pressure).map(|(fluid, &own)| {
            let fluid = fluid.unwrap_or(adjacent);
            convective_velocity(fluid.velocity, fluid.pressure, own, density * sound_speed) - base
        }));
        let layers = (patch.depth / flow.spacing + LAYERS_SEEN).ceil() as usize + 1;
        let courant = sound_speed * time_step / flow.spacing;
        self.propagation.advance(layers, &self.pressure, &self.velocity, courant);
    }

    /// Splits the flow at the points into its mean over the section, which is returned, and
    /// deviations from it. Points without fluid count as the flow `adjacent` to the plane.
    ///
    /// A mean over the particles near the plane would take their disorder and different depths for
    /// a wave. It reflected 2.4 % of a plane pulse instead of 1 %, and exerted up to 25 Pa on a
    /// vortex that crossed the outlet.
    fn split(&mut self, fitted: &[Option<PointFlow>], adjacent: PointFlow) -> PointFlow {
        let fields = [|flow: PointFlow| flow.pressure, |flow: PointFlow| flow.velocity];
        let mut means = [adjacent.pressure, adjacent.velocity];
        for ((deviation, field), mean) in self.deviation.iter_mut().zip(fields).zip(&mut means) {
            deviation.clear();
            deviation.extend(fitted.iter().map(|flow| field(flow.unwrap_or(adjacent))));
            if let Some(section) = self.section.as_ref().filter(|_| !deviation.is_empty()) {
                *mean = deviation.iter().zip(&section.shares).map(|(value, share)| value * share).sum();
            }
            deviation.iter_mut().for_each(|value| *value -= *mean);
        }
        let [pressure, velocity] = means;
        PointFlow { pressure, velocity, ..adjacent }
    }

    /// Adds the pressure of the oblique waves.
    fn add_oblique(&mut self, flow: &FlowProperties<'_>, patch: &Patch, time_step: f64) {
        let Some(section) = &self.section else {
            return;
        };
        let width = 2.0 * patch.half_extent[0].max(patch.half_extent[1]);
        let setting = ObliqueSetting {
            time: CROSSINGS * width / flow.sound_speed,
            density: flow.density,
            sound_speed: flow.sound_speed,
            spacing: section.spacing,
        };
        let [pressure, velocity] = &mut self.deviation;
        self.oblique.advance(&setting, &section.neighbours, velocity, pressure, time_step);
        for (all, oblique) in self.pressure.iter_mut().zip(pressure) {
            *all += *oblique;
        }
    }

    /// Returns pressure (Pa) and convective velocity (m/s) of an outflow particle, from the flow
    /// fitted at its foot on the plane.
    pub fn at(
        &self,
        flow: &FlowProperties<'_>,
        patch: &Patch,
        position: DVec3,
        foot: PointFlow,
    ) -> (f64, f64) {
        let Some(section) = &self.section else {
            return (0.0, foot.velocity);
        };
        let location = section.locate(patch, position - patch.at);
        let depth = patch.along(position) / flow.spacing + LAYERS_SEEN;
        let propagated = |field: &[f64]| {
            let points = self.pressure.len();
            let last = field.len() / points - 1;
            let depth = depth.clamp(0.0, last as f64);
            let layer = depth as usize;
            let next = (layer + 1).min(last);
            let low = location.interpolate(&field[layer * points..][..points]);
            let high = location.interpolate(&field[next * points..][..points]);
            low + (depth - layer as f64) * (high - low)
        };
        let impedance = flow.density * flow.sound_speed;
        let present = location.interpolate(&self.pressure);
        let velocity = convective_velocity(foot.velocity, foot.pressure, present, impedance);
        // The fit at the foot resolves the profile better than the points, which supply the
        // history.
        let change = propagated(&self.propagation.velocity) - location.interpolate(&self.velocity);
        (propagated(&self.propagation.pressure), velocity + change)
    }
}
