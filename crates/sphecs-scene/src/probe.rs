//! Probes: points, lines and sections at which a scene measures.

use glam::DVec3;

use sphecs_core::particles::zone::Zone;

/// Particles that a probe sees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum ProbeSight {
    /// Fluid particles only, none beyond the plane of an inlet or outlet. Take it for measurements
    /// of the flow.
    #[default]
    Fluid,
    /// Fluid and the particles of the zones behind inlets and outlets. Take it for points next to
    /// the plane of an inlet or outlet.
    Flow,
}

impl ProbeSight {
    /// Returns true if the particles of a zone are seen.
    pub fn sees(self, zone: Zone) -> bool {
        match self {
            ProbeSight::Fluid => zone == Zone::Fluid,
            ProbeSight::Flow => matches!(zone, Zone::Fluid | Zone::Inflow | Zone::Outflow),
        }
    }
}

/// A declared measurement.
#[derive(Clone, Debug)]
pub struct Probe {
    /// Name, unique in the scene.
    pub name: String,
    /// Measured quantity.
    pub kind: ProbeKind,
    /// Interval between samples, s.
    pub every: f64,
    /// Interval of the time mean in the results, s; None: no mean.
    pub mean: Option<(f64, f64)>,
    /// Particles whose velocity, pressure and density it measures.
    pub sees: ProbeSight,
}

/// Place and quantities of a probe: velocity, pressure and density.
#[derive(Clone, Debug)]
pub enum ProbeKind {
    /// At one point, m.
    Point(DVec3),
    /// At `count` ≥ 2 points evenly from `from` to `to`, ends included, m.
    Line {
        /// First point, m.
        from: DVec3,
        /// Last point, m.
        to: DVec3,
        /// Number of points.
        count: usize,
    },
    /// Mass flow (kg/s, per metre of depth in 2D) and mean pressure through a plane section of the
    /// domain.
    Section {
        /// A point of the section, m.
        at: DVec3,
        /// Unit normal.
        normal: DVec3,
    },
}
