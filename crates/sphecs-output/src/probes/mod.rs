//! Probes of a scene: sample points and the results of the samples.
//!
//! The engine samples at [`ProbeSet::points`]; [`ProbeSet::reduce`] turns the samples into a
//! [`ProbeSample`]. The mass flow of a section is carried by its particles
//! ([`sphecs_core::pass::section`]). Its mean pressure follows from the sample points k with areas
//! A_k as Σ_k A_k p_k / Σ_k A_k, Pa. A point without fluid nearby has no pressure.

pub mod history;
pub mod results;
mod section;
mod series;
pub mod writer;

use glam::DVec3;

use super::header::ProbeShape;
use sphecs_core::particles::sample::Sample;
use sphecs_core::pass::section::Section;
use sphecs_scene::model::{Probe, ProbeKind, ProbeSight, Scene};

/// Sample points of one probe.
#[derive(Clone, Debug, PartialEq)]
pub struct ProbePoints {
    /// Name in the scene.
    pub name: String,
    /// Shape of its results.
    pub shape: ProbeShape,
    /// Position, m: the first point, or the point of the section given by the scene.
    pub at: DVec3,
    /// Sample points, m.
    pub points: Vec<DVec3>,
    /// Areas of a section's points, m² (lengths in m in 2D); empty for the others.
    pub areas: Vec<f64>,
    /// Part of the plane that belongs to a section; None for the others.
    pub section: Option<Section>,
    /// Particles whose fields are sampled.
    pub sees: ProbeSight,
}

/// Values of one probe at one time.
#[derive(Clone, Debug, PartialEq)]
pub enum ProbeValues {
    /// Fields at the points; None without fluid nearby.
    Fields(Vec<Option<Sample>>),
    /// Integrals of a section.
    Section {
        /// Mass flow along the normal, kg/s (per metre of depth in 2D).
        mass_flow: f64,
        /// Mean pressure, Pa; NaN without any fluid.
        mean_pressure: f64,
    },
}

/// Values of all probes at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct ProbeSample {
    /// Time, s.
    pub time: f64,
    /// Values in the order of the scene's probes; None for a probe that is not due.
    pub values: Vec<Option<ProbeValues>>,
}

/// Probes of a scene with their points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProbeSet {
    probes: Vec<ProbePoints>,
}

impl ProbeSet {
    /// Returns the probes of a scene.
    pub fn new(scene: &Scene) -> Self {
        let points = |probe| probe_points(probe, scene);
        Self { probes: scene.output.probes.iter().map(points).collect() }
    }

    /// Returns the probes in the order of the scene.
    pub fn probes(&self) -> &[ProbePoints] {
        &self.probes
    }

    /// Returns true if the scene has no probes.
    pub fn is_empty(&self) -> bool {
        self.probes.is_empty()
    }

    /// Returns the points of the point and line probes that are due, m, with the particles sampled
    /// there, in the order of [`Self::reduce`].
    pub fn points(&self, due: &[bool]) -> Vec<(DVec3, ProbeSight)> {
        self.points_of(due, |shape| shape != ProbeShape::Section)
    }

    /// Returns the points of the sections that are due, m, at which the pressure is sampled.
    pub fn section_points(&self, due: &[bool]) -> Vec<(DVec3, ProbeSight)> {
        self.points_of(due, |shape| shape == ProbeShape::Section)
    }

    fn points_of(&self, due: &[bool], is_meant: fn(ProbeShape) -> bool) -> Vec<(DVec3, ProbeSight)> {
        let of =
            |probe: &ProbePoints| probe.points.iter().map(|&point| (point, probe.sees)).collect::<Vec<_>>();
        self.due(due).filter(|probe| is_meant(probe.shape)).flat_map(of).collect()
    }

    /// Returns the sections that are due, in the order of the mass flows of [`Self::reduce`].
    pub fn sections<'a>(&'a self, due: &'a [bool]) -> Vec<&'a Section> {
        self.due(due).filter_map(|probe| probe.section.as_ref()).collect()
    }

    fn due<'a>(&'a self, due: &'a [bool]) -> impl Iterator<Item = &'a ProbePoints> + 'a {
        self.probes.iter().zip(due).filter(|&(_, &is_due)| is_due).map(|(probe, _)| probe)
    }

    /// Returns the results of samples at [`Self::points`], of pressures (Pa) at
    /// [`Self::section_points`] and of mass flows (kg/s) through [`Self::sections`] of the probes
    /// that are due.
    pub fn reduce(
        &self,
        due: &[bool],
        time: f64,
        samples: &[Option<Sample>],
        pressures: &[Option<f64>],
        mass_flows: &[f64],
    ) -> ProbeSample {
        let (mut samples, mut pressures, mut flows) = (samples.iter(), pressures.iter(), mass_flows.iter());
        let values = self
            .probes
            .iter()
            .zip(due)
            .map(|(probe, &is_due)| {
                if !is_due {
                    return None;
                }
                let count = probe.points.len();
                if probe.shape != ProbeShape::Section {
                    return Some(ProbeValues::Fields(samples.by_ref().take(count).copied().collect()));
                }
                let flow = probe.section.as_ref().and_then(|_| flows.next());
                let mean_pressure = probe.mean(pressures.by_ref().take(count));
                Some(ProbeValues::Section { mass_flow: flow.copied().unwrap_or(0.0), mean_pressure })
            })
            .collect();
        ProbeSample { time, values }
    }
}

impl ProbePoints {
    /// Returns the mean over the areas of the points with fluid nearby; NaN without any.
    fn mean<'a>(&self, pressures: impl Iterator<Item = &'a Option<f64>>) -> f64 {
        let (mut sum, mut area) = (0.0, 0.0);
        for (pressure, &part) in pressures.zip(&self.areas) {
            if let Some(pressure) = pressure {
                sum += part * pressure;
                area += part;
            }
        }
        sum / area
    }
}

fn probe_points(probe: &Probe, scene: &Scene) -> ProbePoints {
    let mut result = ProbePoints {
        name: probe.name.clone(),
        shape: ProbeShape::of(&probe.kind),
        at: DVec3::ZERO,
        points: Vec::new(),
        areas: Vec::new(),
        section: None,
        sees: probe.sees,
    };
    match probe.kind {
        ProbeKind::Point(at) => result.points = vec![at],
        ProbeKind::Line { from, to, count } => {
            let last = count.saturating_sub(1).max(1) as f64;
            result.points = (0..count).map(|index| from.lerp(to, index as f64 / last)).collect();
        }
        ProbeKind::Section { at, normal } => {
            let inside = |point| scene.domain.signed_distance(point);
            // Half a spacing resolves the profile of the particles; finer points would add nothing.
            let step = 0.5 * scene.spacing;
            let normal = normal.normalize_or_zero();
            let parts = section::points(&inside, at, normal, scene.dimensions, step);
            (result.points, result.areas) = parts.into_iter().unzip();
            let periods = scene.periodic.map(|bounds| bounds.map(|(low, high)| high - low));
            let points = &result.points;
            result.section = Some(Section::new(at, normal, points, scene.spacing, periods, scene.dimensions));
        }
    }
    result.at = match probe.kind {
        ProbeKind::Section { at, .. } => at,
        _ => result.points.first().copied().unwrap_or_default(),
    };
    result
}

/// Returns the unit of a quantity in UDUNITS notation; empty for an unknown one.
pub(crate) fn unit_of(shape: ProbeShape, quantity: &str, dimensions: usize) -> &'static str {
    // The histories of a plane flow have w too.
    let dimensions = if quantity == "w" { 3 } else { dimensions };
    let known = writer::quantities(shape, dimensions);
    known.into_iter().find(|known| known.name == quantity).map_or("", |known| known.unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn section() -> ProbePoints {
        // Between y = 0 and 1, in cells of 0.1.
        let points: Vec<DVec3> = (0..10).map(|i| DVec3::new(0.0, 0.1 * f64::from(i) + 0.05, 0.0)).collect();
        let at = DVec3::new(0.0, 0.5, 0.0);
        ProbePoints {
            name: "throat".to_owned(),
            shape: ProbeShape::Section,
            at,
            areas: vec![0.1; points.len()],
            section: Some(Section::new(at, DVec3::X, &points, 0.1, [None; 3], 2)),
            sees: ProbeSight::Fluid,
            points,
        }
    }

    fn linear_pressure(point: &DVec3) -> Option<f64> {
        Some(20.0 * point.y)
    }

    #[test]
    fn section_has_its_mass_flow_and_mean_pressure() {
        let point =
            ProbePoints { shape: ProbeShape::Point, section: None, points: vec![DVec3::X], ..section() };
        let set = ProbeSet { probes: vec![point, section()] };
        let due = [true; 2];
        assert_eq!(set.sections(&due).len(), 1);
        assert!(set.sections(&[true, false]).is_empty());
        let pressures = set.section_points(&due).into_iter().map(|(point, _)| linear_pressure(&point));
        let fields = [Some(Sample::default())];
        let sample = set.reduce(&due, 0.25, &fields, &pressures.collect::<Vec<_>>(), &[1005.0]);
        assert_eq!(sample.values[0], Some(ProbeValues::Fields(fields.to_vec())));
        let Some(ProbeValues::Section { mass_flow, mean_pressure }) = sample.values[1] else {
            panic!("a section has integrals");
        };
        assert_eq!(mass_flow, 1005.0);
        assert!((mean_pressure - 10.0).abs() < 1e-12, "{mean_pressure} Pa");
    }

    #[test]
    fn point_without_fluid_has_no_pressure() {
        let set = ProbeSet { probes: vec![section()] };
        let pressure = |found: &[Option<f64>]| match set.reduce(&[true], 0.0, &[], found, &[0.0]).values[0] {
            Some(ProbeValues::Section { mean_pressure, .. }) => mean_pressure,
            _ => panic!("a section has integrals"),
        };
        let samples: Vec<_> = set
            .section_points(&[true])
            .iter()
            .map(|(p, _)| linear_pressure(p).filter(|_| p.y < 0.5))
            .collect();
        assert!((pressure(&samples) - 5.0).abs() < 1e-12);
        assert!(pressure(&[None; 10]).is_nan());
    }
}
