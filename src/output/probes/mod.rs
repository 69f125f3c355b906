//! Probes of a scene: where they sample, and what becomes of the samples.
//!
//! [`ProbeSet::points`] are handed to the engine; [`ProbeSet::reduce`] turns its samples into a [`ProbeSample`].
//! For a section with the sample points k and their areas A_k
//!
//! ```text
//! mass flow = Σ_k A_k ρ_k v_k · n,   mean pressure = Σ_k A_k p_k / Σ_k A_k
//! ```
//!
//! in kg/s (kg/(s m), per metre of depth, in 2D) and Pa. A point without fluid near it carries no mass and has no pressure.

pub mod history;
pub mod results;
mod section;
mod series;
pub mod writer;

use glam::DVec3;

use super::header::ProbeShape;
use crate::particles::sample::Sample;
use crate::scene::model::{Probe, ProbeKind, Scene};

/// The points of one probe.
#[derive(Clone, Debug, PartialEq)]
pub struct ProbePoints {
    /// Name in the scene.
    pub name: String,
    /// Shape of its results.
    pub shape: ProbeShape,
    /// Where it stands, m: its first point, or the point of the section that the scene gives.
    pub at: DVec3,
    /// Sample points, m.
    pub points: Vec<DVec3>,
    /// Areas of a section's points, m² (lengths in m in 2D); empty for the others.
    pub areas: Vec<f64>,
    /// Unit normal of a section.
    pub normal: DVec3,
}

/// What one probe measured.
#[derive(Clone, Debug, PartialEq)]
pub enum ProbeValues {
    /// Fields at its points; None where no fluid was near.
    Fields(Vec<Option<Sample>>),
    /// Integrals of a section.
    Section {
        /// Mass flow along the normal, kg/s (per metre of depth in 2D).
        mass_flow: f64,
        /// Mean pressure, Pa; NaN without any fluid.
        mean_pressure: f64,
    },
}

/// What all probes measured at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct ProbeSample {
    /// Time, s.
    pub time: f64,
    /// Values in the order of the scene's probes.
    pub values: Vec<ProbeValues>,
}

/// The probes of a scene with their points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProbeSet {
    probes: Vec<ProbePoints>,
}

impl ProbeSet {
    /// The probes of a scene.
    pub fn new(scene: &Scene) -> Self {
        let points = |probe| probe_points(probe, scene);
        Self { probes: scene.output.probes.iter().map(points).collect() }
    }

    /// The probes in the order of the scene.
    pub fn probes(&self) -> &[ProbePoints] {
        &self.probes
    }

    /// Whether the scene has no probes.
    pub fn is_empty(&self) -> bool {
        self.probes.is_empty()
    }

    /// All points of all probes, in the order that [`Self::reduce`] takes samples, m.
    pub fn points(&self) -> Vec<DVec3> {
        self.probes.iter().flat_map(|probe| probe.points.iter().copied()).collect()
    }

    /// The results of samples taken at [`Self::points`]; missing samples count as no fluid.
    pub fn reduce(&self, time: f64, samples: &[Option<Sample>]) -> ProbeSample {
        let mut rest = samples;
        let values = self
            .probes
            .iter()
            .map(|probe| {
                let (own, others) = rest.split_at(probe.points.len().min(rest.len()));
                rest = others;
                probe.reduce(own)
            })
            .collect();
        ProbeSample { time, values }
    }
}

impl ProbePoints {
    fn reduce(&self, samples: &[Option<Sample>]) -> ProbeValues {
        if self.shape != ProbeShape::Section {
            return ProbeValues::Fields(samples.to_vec());
        }
        let (mut mass_flow, mut pressure, mut area) = (0.0, 0.0, 0.0);
        for (sample, &part) in samples.iter().zip(&self.areas) {
            if let Some(sample) = sample {
                mass_flow += part * sample.density * sample.velocity.dot(self.normal);
                pressure += part * sample.pressure;
                area += part;
            }
        }
        ProbeValues::Section { mass_flow, mean_pressure: pressure / area }
    }
}

fn probe_points(probe: &Probe, scene: &Scene) -> ProbePoints {
    let mut result = ProbePoints {
        name: probe.name.clone(),
        shape: ProbeShape::of(&probe.kind),
        at: DVec3::ZERO,
        points: Vec::new(),
        areas: Vec::new(),
        normal: DVec3::ZERO,
    };
    match probe.kind {
        ProbeKind::Point(at) => result.points = vec![at],
        ProbeKind::Line { from, to, count } => {
            let last = count.saturating_sub(1).max(1) as f64;
            result.points = (0..count).map(|index| from.lerp(to, index as f64 / last)).collect();
        }
        ProbeKind::Section { at, normal } => {
            let inside = |point| scene.domain.signed_distance(point);
            // Half a spacing resolves the profile that the particles carry; finer points would only repeat it.
            let step = 0.5 * scene.spacing;
            result.normal = normal.normalize_or_zero();
            let parts = section::points(&inside, at, result.normal, scene.dimensions, step);
            (result.points, result.areas) = parts.into_iter().unzip();
        }
    }
    result.at = match probe.kind {
        ProbeKind::Section { at, .. } => at,
        _ => result.points.first().copied().unwrap_or_default(),
    };
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    fn section() -> ProbePoints {
        // Poiseuille between y = 0 and 1, in cells of 0.1.
        let points: Vec<DVec3> = (0..10).map(|i| DVec3::new(0.0, 0.1 * f64::from(i) + 0.05, 0.0)).collect();
        ProbePoints {
            name: "throat".to_owned(),
            shape: ProbeShape::Section,
            at: DVec3::new(0.0, 0.5, 0.0),
            areas: vec![0.1; points.len()],
            points,
            normal: DVec3::X,
        }
    }

    fn parabola(point: &DVec3) -> Option<Sample> {
        Some(Sample {
            velocity: DVec3::new(6.0 * point.y * (1.0 - point.y), 3.0, 0.0),
            pressure: 20.0 * point.y,
            density: 1000.0,
        })
    }

    #[test]
    fn section_integrates_flow_and_pressure() {
        let set = ProbeSet { probes: vec![section()] };
        let samples: Vec<_> = set.points().iter().map(parabola).collect();
        let sample = set.reduce(0.25, &samples);
        let ProbeValues::Section { mass_flow, mean_pressure } = sample.values[0] else {
            panic!("a section gives integrals");
        };
        // The midpoint rule on a parabola is off by f''h²/24 = 12 · 0.01/24 = 0.005.
        assert!((mass_flow - 1005.0).abs() < 1e-9, "{mass_flow} kg/s");
        assert!((mean_pressure - 10.0).abs() < 1e-12, "{mean_pressure} Pa");
    }

    #[test]
    fn point_without_fluid_carries_nothing() {
        let set = ProbeSet { probes: vec![section()] };
        let samples: Vec<_> = set.points().iter().map(|p| parabola(p).filter(|_| p.y < 0.5)).collect();
        let ProbeValues::Section { mass_flow, mean_pressure } = set.reduce(0.0, &samples).values[0] else {
            panic!("a section gives integrals");
        };
        assert!((mass_flow - 502.5).abs() < 1e-9 && (mean_pressure - 5.0).abs() < 1e-12);
        let ProbeValues::Section { mass_flow, mean_pressure } = set.reduce(0.0, &[None; 10]).values[0] else {
            panic!("a section gives integrals");
        };
        assert!(mass_flow == 0.0 && mean_pressure.is_nan());
    }
}
