//! The zone of an absorbing outlet: which pressure and which velocity a wave of sound has where in it.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::section::SectionPoints;
use sphecs_core::pass::fits::PointFlow;
use sphecs_core::physics::outlet::absorbing::{Absorbing, AbsorbingSetting};
use sphecs_core::physics::outlet::continuation::Continuation;
use sphecs_core::physics::outlet::convection::convective_velocity;
use sphecs_core::physics::outlet::oblique::{Oblique, ObliqueSetting};
use sphecs_core::physics::outlet::{OutletPressure, Waves};
use sphecs_scene::model::{Outlet, Scene};

/// Passages of sound through the domain in which an absorbing pressure follows the mean flow, where a scene says nothing. Shorter, and
/// the resonance of an inlet with a throat is hardly damped; longer, and the start takes longer to settle.
const PASSAGES: f64 = 4.0;

/// Time in which sound that an outlet lets go has left, s.
pub fn settling_time(scene: &Scene, outlet: &Outlet) -> f64 {
    PASSAGES * scene.extent_along(outlet.patch.towards) / scene.fluid.sound_speed
}

/// Passages of sound along the section in which the velocity at its points is followed: of a vortex more is read as sound, the longer it
/// is, of sound less the shorter it is (docs/outlets.md).
const CROSSINGS: f64 = 1.0;

/// Layers from where the flow is seen to where it is sampled: the mean over a support whose outer part has no fluid is that of
/// a place further inside.
const LAYERS_SEEN: f64 = 1.0;

/// State of the zone of one absorbing outlet, and what the present step found.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AbsorbingZone {
    /// The plane wave.
    pub plane: Absorbing,
    /// The other waves.
    pub oblique: Oblique,
    /// What went into the zone before.
    pub continuation: Continuation,
    /// Points of the section; the scene gives them.
    #[serde(skip)]
    section: Option<SectionPoints>,
    /// Pressure of the outlet at the points, Pa.
    #[serde(skip)]
    pressure: Vec<f64>,
    /// Convective velocity at the points, m/s.
    #[serde(skip)]
    velocity: Vec<f64>,
    /// Of the fluid at the points, less its mean: pressure (Pa) and normal velocity (m/s).
    #[serde(skip)]
    deviation: [Vec<f64>; 2],
}

impl AbsorbingZone {
    /// The points at which the fluid must be known.
    pub fn section(&mut self, scene: &Scene, outlet: &Outlet) -> &SectionPoints {
        self.section.get_or_insert_with(|| SectionPoints::new(scene, &outlet.patch))
    }

    /// Takes up one step (s), from the flow at the points; `near` is its mean over the particles near the plane, for points without fluid.
    pub fn advance(
        &mut self,
        scene: &Scene,
        outlet: &Outlet,
        found: &[Option<PointFlow>],
        near: PointFlow,
        time_step: f64,
    ) {
        let Some(OutletPressure::Absorbing { target, time, waves }) =
            outlet.condition.wave().map(|wave| wave.pressure)
        else {
            return;
        };
        let (density, sound_speed) = (scene.fluid.density, scene.fluid.sound_speed);
        let time = time.unwrap_or_else(|| settling_time(scene, outlet));
        let setting = AbsorbingSetting { target, time, density, sound_speed };
        let mean = self.take_apart(found, near);
        let plane = self.plane.advance(&setting, mean.pressure, mean.velocity, time_step);
        self.pressure.clear();
        self.pressure.resize(found.len(), plane);
        if waves == Waves::All {
            self.add_oblique(scene, outlet, time_step);
        }
        self.velocity.clear();
        self.velocity.extend(found.iter().zip(&self.pressure).map(|(flow, &own)| {
            let flow = flow.unwrap_or(near);
            convective_velocity(flow.velocity, flow.pressure, own, density * sound_speed)
        }));
        let layers = (outlet.patch.depth / scene.spacing + LAYERS_SEEN).ceil() as usize + 1;
        let courant = sound_speed * time_step / scene.spacing;
        self.continuation.advance(layers, &self.pressure, &self.velocity, courant);
    }

    /// Splits the flow at the points into its mean over the section, which is returned, and what each of them has over it.
    ///
    /// A mean over the particles near the plane, which are not even and lie behind each other, takes crowding and depth for a wave: it threw back
    /// 2.4 % of a pulse head on where this throws back 1 %, and drew with up to 25 Pa at a vortex that left.
    fn take_apart(&mut self, found: &[Option<PointFlow>], near: PointFlow) -> PointFlow {
        let fields = [|flow: PointFlow| flow.pressure, |flow: PointFlow| flow.velocity];
        let mut means = [near.pressure, near.velocity];
        for ((deviation, field), mean) in self.deviation.iter_mut().zip(fields).zip(&mut means) {
            deviation.clear();
            deviation.extend(found.iter().map(|flow| field(flow.unwrap_or(near))));
            if !deviation.is_empty() {
                *mean = deviation.iter().sum::<f64>() / deviation.len() as f64;
            }
            deviation.iter_mut().for_each(|value| *value -= *mean);
        }
        let [pressure, velocity] = means;
        PointFlow { pressure, velocity, ..near }
    }

    /// Adds the pressure of the waves that are not plane.
    fn add_oblique(&mut self, scene: &Scene, outlet: &Outlet, time_step: f64) {
        let Some(section) = &self.section else {
            return;
        };
        let width = 2.0 * outlet.patch.half_extent[0].max(outlet.patch.half_extent[1]);
        let setting = ObliqueSetting {
            time: CROSSINGS * width / scene.fluid.sound_speed,
            density: scene.fluid.density,
            sound_speed: scene.fluid.sound_speed,
            spacing: section.spacing,
        };
        let [pressure, velocity] = &mut self.deviation;
        self.oblique.advance(&setting, &section.neighbours, velocity, pressure, time_step);
        for (all, oblique) in self.pressure.iter_mut().zip(pressure) {
            *all += *oblique;
        }
    }

    /// Pressure (Pa) and convective velocity (m/s) of a particle of the zone, from the flow at its foot on the plane.
    pub fn at(&self, scene: &Scene, outlet: &Outlet, position: DVec3, foot: PointFlow) -> (f64, f64) {
        let Some(section) = &self.section else {
            return (0.0, foot.velocity);
        };
        let patch = &outlet.patch;
        let offset = position - patch.at;
        let place = section.place(patch, offset);
        let depth = patch.along(position) / scene.spacing + LAYERS_SEEN;
        let then = |field: &[f64]| {
            let points = self.pressure.len();
            let last = field.len() / points - 1;
            let depth = depth.clamp(0.0, last as f64);
            let before = depth as usize;
            let behind = (before + 1).min(last);
            let low = place.interpolate(&field[before * points..][..points]);
            let high = place.interpolate(&field[behind * points..][..points]);
            low + (depth - before as f64) * (high - low)
        };
        let impedance = scene.fluid.density * scene.fluid.sound_speed;
        let present = place.interpolate(&self.pressure);
        let velocity = convective_velocity(foot.velocity, foot.pressure, present, impedance);
        // The fit at the foot knows the profile better than the points do; they know how it was before.
        let change = then(&self.continuation.velocity) - place.interpolate(&self.velocity);
        (then(&self.continuation.pressure), velocity + change)
    }
}
