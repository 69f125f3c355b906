//! Region that the columns of an emitter do not leave while their wall moves.

use glam::DVec3;

use super::Emitter;
use crate::model::Scene;
use crate::motion::Motion;
use crate::movers::Wall;

/// Region that contains the columns of an emitter at any time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SweptRegion {
    /// Ball around the columns on a wall at rest.
    Ball {
        /// Centre, m.
        centre: DVec3,
        /// Radius, m.
        radius: f64,
    },
    /// Shell around the axis of a rotation.
    Shell {
        /// A point of the axis, m.
        about: DVec3,
        /// Unit vector along the axis.
        axis: DVec3,
        /// Least and largest distance from the axis, m.
        across: [f64; 2],
        /// Least and largest distance from the point along the axis, m.
        along: [f64; 2],
    },
    /// Everything: nothing is known of the motion at all times.
    Everywhere,
}

impl Emitter {
    /// Returns the region that the columns do not leave in a scene.
    pub fn swept_region(&self, scene: &Scene) -> SweptRegion {
        match self.wall {
            Wall::Casing => {
                let (centre, radius) = self.ball();
                SweptRegion::Ball { centre, radius }
            }
            // A shell may overlap its periodic images.
            Wall::Mover(_) if scene.periodic.iter().any(Option::is_some) => SweptRegion::Everywhere,
            Wall::Mover(index) => match scene.movers[index].motion {
                Motion::Rotation { about, axis, .. } => self.shell(about, axis),
                Motion::Translation(_) | Motion::Chain(_) => SweptRegion::Everywhere,
            },
        }
    }

    /// Returns the shell that the columns sweep about an axis.
    fn shell(&self, about: DVec3, axis: DVec3) -> SweptRegion {
        let ends = self.columns.iter().flat_map(|column| [column.foot, column.point(self.depth)]);
        let places = ends.map(|end| cylindrical(end, about, axis));
        let mut bounds = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for place in places {
            for (bounds, place) in bounds.iter_mut().zip(place) {
                *bounds = [bounds[0].min(place), bounds[1].max(place)];
            }
        }
        // The middle of a column may be closer to the axis than its ends.
        let [across, along] = bounds.map(|[low, high]| [low - 0.5 * self.depth, high + 0.5 * self.depth]);
        SweptRegion::Shell { about, axis, across, along }
    }
}

/// Returns the distances of a point from an axis and along it, m.
fn cylindrical(point: DVec3, about: DVec3, axis: DVec3) -> [f64; 2] {
    let arm = point - about;
    let along = arm.dot(axis);
    [(arm - along * axis).length(), along]
}

impl SweptRegion {
    /// Returns the distance of a point from the region, m; 0 in it.
    pub fn distance(&self, scene: &Scene, point: DVec3) -> f64 {
        match *self {
            Self::Ball { centre, radius } => {
                (point.distance(scene.nearest_image(centre, point)) - radius).max(0.0)
            }
            Self::Shell { about, axis, across, along } => {
                let outside = |place: f64, [low, high]: [f64; 2]| (low - place).max(place - high).max(0.0);
                let [from_axis, along_it] = cylindrical(point, about, axis);
                outside(from_axis, across).hypot(outside(along_it, along))
            }
            Self::Everywhere => 0.0,
        }
    }
}
