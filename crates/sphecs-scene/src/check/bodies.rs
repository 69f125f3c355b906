//! Checks of the bodies of a scene file.

use glam::DVec3;

use super::checker::Checker;
use crate::faults::{Fault, advice};
use crate::fill::Place;
use crate::geometry::Shape;
use crate::model::{Body, BodyReference, Mover, Scene, Walls};
use crate::movers::Wall;
use crate::schema::{BodyFile, SceneFile};
use crate::wall_particles::surface;
use sphecs_core::particles::zone::Zone;

/// Returns all bodies without faults; `end` is the end of the run, s.
pub fn bodies(file: &SceneFile, places: &Places<'_>, end: f64, check: &mut Checker<'_>) -> Vec<Body> {
    let mut bodies: Vec<Body> = Vec::new();
    for file in &file.bodies {
        let name = &file.part;
        let Some(part) = places.walls.parts.iter().position(|part| part.name == name.value) else {
            let names = places.walls.parts.iter().map(|part| part.name.as_str());
            check.report(
                Fault::new(
                    format!("the walls have no part `{}`", name.value),
                    name.span,
                    "must be the name of a part of the walls",
                )
                .help(advice(&name.value, names)),
            );
            continue;
        };
        if bodies.iter().any(|body| body.name == name.value) {
            let label = "every part must be named once";
            check.report(Fault::new(format!("`{}` is a body twice", name.value), name.span, label));
        }
        let about = match &file.about {
            Some(about) => check.vector(about, "m"),
            None => places.middle(part),
        };
        bodies.push(Body {
            name: name.value.clone(),
            part: part as u16,
            about,
            reference: reference(file, check),
            mean: mean(file, end, check),
            five_point_mean: file.five_point_mean,
        });
    }
    bodies
}

/// Walls of a scene and their places.
pub struct Places<'a> {
    /// The walls.
    pub walls: &'a Walls,
    /// Regions of the parts from the second on.
    pub regions: &'a [Shape],
    /// Bodies that move.
    pub movers: &'a [Mover],
    /// Domain.
    pub domain: &'a Shape,
}

impl Places<'_> {
    /// Returns the middle of a part, m, in reference coordinates if it moves; that of the domain
    /// along an axis along which the region of the part has no end, and 0 where neither has one.
    fn middle(&self, part: usize) -> DVec3 {
        if let Some(mover) = self.walls.parts[part].mover {
            return self.movers[usize::from(mover)].centre;
        }
        let region = part.checked_sub(1).and_then(|index| self.regions.get(index));
        let middle = |shape: &Shape| {
            let (low, high) = shape.bounds();
            0.5 * (low + high)
        };
        let (own, of_domain) = (middle(region.unwrap_or(self.domain)), middle(self.domain));
        let first_finite = |axis: usize| {
            [own[axis], of_domain[axis]].into_iter().find(|along| along.is_finite()).unwrap_or_default()
        };
        DVec3::new(first_finite(0), first_finite(1), first_finite(2))
    }
}

/// Returns the reference of the coefficients; velocity and area must be given together.
fn reference(file: &BodyFile, check: &mut Checker<'_>) -> Option<BodyReference> {
    let positive = |number: &_, unit, check: &mut Checker<'_>| check.positive(number, unit);
    let velocity = file.velocity.as_ref().map(|number| positive(number, "m/s", check));
    let area = file
        .area
        .as_ref()
        .map(|number| positive(number, if check.dimensions == 2 { "m" } else { "m²" }, check));
    let length = file.length.as_ref().map(|number| positive(number, "m", check));
    let is_flat = check.dimensions == 2;
    let mut missing = |field: &str, what: &str| {
        check.report(
            Fault::new(
                format!("`{field}` of the body `{}` is missing", file.part.value),
                file.part.span,
                format!("must have `velocity` and `area` for its coefficients, lacks `{field}`"),
            )
            .help(format!("give `{field}`: {what}; or neither, then forces are written and no coefficients")),
        );
        None
    };
    match (velocity, area) {
        (None, None) if length.is_none() => None,
        (None, _) => missing("velocity", "the velocity of the undisturbed flow, m/s"),
        (_, None) => missing("area", "the frontal area of the body, m², in 2D its width across the flow, m"),
        (Some(velocity), Some(area)) => match length.or(is_flat.then_some(area)) {
            Some(length) => Some(BodyReference { velocity, area, length }),
            None => missing("length", "the length of the Strouhal number, m, which has no default in 3D"),
        },
    }
}

/// Returns the interval of the means, s, by default the second half of the run.
fn mean(file: &BodyFile, end: f64, check: &mut Checker<'_>) -> (f64, f64) {
    let Some(mean) = &file.mean else { return (0.5 * end, end) };
    let (from, to) = &mean.value;
    let interval = (check.not_negative(from, "s"), check.positive(to, "s"));
    if interval.0 >= interval.1 || interval.1 > end * (1.0 + 1e-9) {
        let label = format!("must rise and end by the end of the run, `{end}` s");
        check.report(Fault::new("the interval of a time mean is wrong", mean.span, label));
    }
    interval
}

/// Checks that every body and every wall part has wall particles.
pub fn have_particles(scene: &Scene, file: &SceneFile, places: &[Place], faults: &mut Vec<Fault>) {
    let has_particles = |part: u16| {
        let walls = places.iter().filter(|place| place.zone == Zone::Wall);
        let part_of = |place: &Place| surface(scene, Wall::numbered(place.patch), place.position).part;
        scene.emitters.iter().any(|emitter| emitter.part == part)
            || walls.map(part_of).any(|found| found == part)
    };
    let parts = file.walls.iter().flat_map(|walls| &walls.value.parts);
    for (part, written) in (1..).zip(parts) {
        if !scene.bodies.iter().any(|body| body.part == part) && !has_particles(part) {
            let title = format!("the wall part `{}` has no surface", written.name.value);
            let label = "must contain surface of the wall, which the parts before it do not contain";
            faults.push(Fault::new(title, written.region.head, label).help(ADVICE));
        }
    }
    for (body, written) in scene.bodies.iter().zip(&file.bodies) {
        if !has_particles(body.part) {
            faults.push(
                Fault::new(
                    format!("the body `{}` has no particles", body.name),
                    written.part.span,
                    "must be a part of the walls that has particles",
                )
                .help(ADVICE),
            );
        }
    }
}

const ADVICE: &str =
    "the region of a part must contain the surface of the wall; where two contain it, the first one counts";
