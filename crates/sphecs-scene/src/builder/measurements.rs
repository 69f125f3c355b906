//! Output, probes and gridded fields of a scene description.

use serde::Serialize;

use super::description::description;
use super::numbers::{Interval, Number, Vector};
use crate::model::{ForcesEvery, ProbeSight};

description! {
    /// Output of a run and its times.
    pub struct Output {
        /// Sets the interval between frames, s.
        every: Number,
        /// Sets the interval between rows of the monitor, of points and of sections, s, default a
        /// tenth of that between frames.
        monitor_every: Number,
        /// Sets the interval at which the forces on bodies are written, default `Step`.
        forces: ForcesEvery,
        /// Sets the interval between checkpoints, s of wall time, default 600.
        checkpoint_every: Number,
        /// Sets the fields on a regular grid.
        fields: Fields,
        /// Sets the quantities at the walls.
        walls: WallQuantities,
    } lists {
        /// Adds a probe.
        probe -> probes: Probe,
    }
}

impl Output {
    /// Returns an output of frames at an interval, s.
    pub fn at_interval(every: impl Into<Number>) -> Self {
        Self::default().every(every)
    }
}

description! {
    /// Fields of the flow on a regular grid.
    pub struct Fields {
        /// Sets the distance of the nodes, m, default the particle spacing.
        spacing: Number,
        /// Sets the interval between the times that are written, s, default that of the frames.
        every: Number,
        /// Sets the interval of time means, variances and Reynolds stresses, s.
        mean: Interval,
        /// Sets the interval between the samples of the means, s, default the time in which the
        /// reference velocity passes half a cell.
        mean_every: Number,
        /// Sets if the whole domain is written, default true without planes.
        volume: bool,
    } lists {
        /// Adds a plane of a 3D scene with a grid of its own.
        plane -> planes: FieldPlane,
    }
}

description! {
    /// Pressure, wall shear stress and y⁺ at points of the walls.
    pub struct WallQuantities {
        /// Sets the interval between the times that are written, s, default that of the frames.
        every: Number,
        /// Sets the interval of time means and of the oscillatory shear index, s.
        mean: Interval,
        /// Sets the interval between the samples of the means, s, default the time in which the
        /// reference velocity passes half a spacing.
        mean_every: Number,
    } lists {
        /// Adds a wall part; all parts without any.
        part -> parts: String,
    }
}

description! {
    /// A plane with a grid.
    pub struct FieldPlane {
        /// Sets the name, unique among the planes.
        name: String,
        /// Sets a point of the plane, m.
        at: Vector,
        /// Sets the direction of its normal.
        normal: Vector,
    }
}

impl FieldPlane {
    /// Returns a plane of a name through a point, m, with a normal.
    pub fn new(name: impl Into<String>, at: impl Into<Vector>, normal: impl Into<Vector>) -> Self {
        Self::default().name(name).at(at).normal(normal)
    }
}

description! {
    /// A declared measurement.
    pub struct Probe {
        /// Sets the name, unique in the scene.
        name: String,
        /// Sets place and quantities.
        kind: ProbeKind,
        /// Sets the interval between samples, s, default that of the frames for lines and that of
        /// the monitor for points and sections.
        every: Number,
        /// Sets the interval of the time mean, s.
        mean: Interval,
        /// Sets the particles that it measures, default `Fluid`.
        sees: ProbeSight,
    }
}

/// Place and quantities of a probe.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum ProbeKind {
    /// At a point.
    Point {
        /// The point, m.
        at: Vector,
    },
    /// At points along a line, ends included.
    Line {
        /// First point, m.
        from: Vector,
        /// Last point, m.
        to: Vector,
        /// Number of points, at least 2.
        count: Number,
    },
    /// Mass flow and mean pressure through a plane section of the domain.
    Section {
        /// A point of the section, m.
        at: Vector,
        /// Direction of positive flow.
        normal: Vector,
    },
}

impl Probe {
    /// Returns a probe of a name at a point, m.
    pub fn point(name: impl Into<String>, at: impl Into<Vector>) -> Self {
        Self::default().name(name).kind(ProbeKind::Point { at: at.into() })
    }

    /// Returns a probe of a name along a line: first and last point, m, and number of points, at
    /// least 2.
    pub fn line(
        name: impl Into<String>,
        from: impl Into<Vector>,
        to: impl Into<Vector>,
        count: impl Into<Number>,
    ) -> Self {
        let kind = ProbeKind::Line { from: from.into(), to: to.into(), count: count.into() };
        Self::default().name(name).kind(kind)
    }

    /// Returns a probe of a name for mass flow and mean pressure through a plane section of the
    /// domain: a point of it, m, and the direction of positive flow.
    pub fn section(name: impl Into<String>, at: impl Into<Vector>, normal: impl Into<Vector>) -> Self {
        Self::default().name(name).kind(ProbeKind::Section { at: at.into(), normal: normal.into() })
    }
}
