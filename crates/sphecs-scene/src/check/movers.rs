//! Checks of the walls that move.

use std::path::Path;

use super::checker::Checker;
use super::walls::{WallLayout, concentric};
use super::{shapes, tables};
use crate::expression::Expression;
use crate::faults::Fault;
use crate::model::{Mover, Scene, WallPart, Walls};
use crate::motion::{Curve, Motion, MotionFault};
use crate::movers::Wall;
use crate::notation::tree::Span;
use crate::notation::typed::Spanned;
use crate::schema::{FillFile, MotionFile, MoverFile, SceneFile, Text, WallFillFile};
use sphecs_core::format::significant;
use sphecs_core::physics::wall::{Slip, WallPressure};

/// Conditions of the checks of a motion.
#[derive(Clone, Copy)]
pub struct Course<'a> {
    /// Folder of tables.
    pub folder: &'a Path,
    /// End of the run, s.
    pub end: f64,
}

/// Returns the movers, and adds their wall parts and the places of their particles.
pub fn movers(
    file: &SceneFile,
    (walls, layout): (&mut Walls, &mut WallLayout),
    (course, spacing): (Course<'_>, f64),
    check: &mut Checker<'_>,
) -> Vec<Mover> {
    let slip = file.walls.as_ref().map_or(Slip::NoSlip, |walls| walls.value.slip);
    let is_packed = file.fill.as_ref().is_some_and(|fill| matches!(fill.value, FillFile::Packed { .. }));
    let mut movers = Vec::new();
    for written in &file.movers {
        let before = check.fault_count();
        let shape = shapes::shape(&written.shape.value, check);
        let motion = motion(&written.motion, course, check);
        if let (Some(shape), Some(motion)) = (shape, motion)
            && check.fault_count() == before
        {
            let (part, index) = (walls.parts.len() as u16, movers.len() as u16);
            let mover = Mover::new(written.name.value.clone(), part, shape, motion, check.dimensions);
            arrange(written, &mover, (index, spacing, is_packed), layout, check);
            movers.push(mover);
            walls.parts.push(WallPart {
                name: written.name.value.clone(),
                slip: written.slip.unwrap_or(slip),
                velocity: std::array::from_fn(|_| Expression::Constant(0.0)),
                mover: Some(index),
            });
        }
    }
    movers
}

/// Adds the arrangement of the particles of a mover to the layout.
fn arrange(
    written: &MoverFile,
    mover: &Mover,
    (index, spacing, is_packed): (u16, f64, bool),
    layout: &mut WallLayout,
    check: &mut Checker<'_>,
) {
    let Some(fill) = &written.fill else {
        if is_packed {
            layout.layered.push(mover.part);
        }
        return;
    };
    match &fill.value {
        WallFillFile::Layers => layout.layered.push(mover.part),
        WallFillFile::Concentric { center, radius, first } => {
            let rings = concentric((center, radius, *first), fill, (&mover.shape, spacing), check);
            layout.rings.extend(rings.map(|rings| {
                let centre = mover.start.place(rings.centre);
                crate::rings::Rings { centre, wall: Wall::Mover(index.into()).number(), ..rings }
            }));
        }
    }
}

/// Returns the motion of the casing.
pub fn casing_motion(file: &SceneFile, course: Course<'_>, check: &mut Checker<'_>) -> Option<Motion> {
    let walls = &file.walls.as_ref()?.value;
    let written = walls.motion.as_ref()?;
    let openings = file.inlets.len() + file.outlets.len() + file.emitters.len();
    if openings > 0 || !file.periodic.is_empty() {
        let label = "must be left out in a scene with openings or periodic directions";
        check.report(
            Fault::new("all walls move, but openings do not", written.head, label)
                .help("give the bodies that move as `movers`"),
        );
    }
    let velocities =
        walls.velocity.iter().chain(walls.parts.iter().filter_map(|part| part.velocity.as_ref()));
    for velocity in velocities {
        let label = "must be left out: the surface has the velocity of the motion";
        check.report(Fault::new("a wall has a motion and a velocity", velocity.span, label));
    }
    motion(written, course, check)
}

/// Returns a motion; None if it has a fault.
fn motion(file: &Spanned<MotionFile>, course: Course<'_>, check: &mut Checker<'_>) -> Option<Motion> {
    let before = check.fault_count();
    let motion = built(&file.value, file.head, course, check)?;
    if check.fault_count() > before {
        return None;
    }
    if let Some(time) = motion.first_not_finite(course.end) {
        let label = format!("has no finite place, velocity or acceleration at t = {} s", significant(time));
        check.report(Fault::new("a motion is not finite", file.head, label));
        return None;
    }
    Some(motion)
}

fn built(file: &MotionFile, place: Span, course: Course<'_>, check: &mut Checker<'_>) -> Option<Motion> {
    match file {
        MotionFile::Translation { displacement, velocity, file } => {
            let given = [displacement.is_some(), velocity.is_some(), file.is_some()];
            one_of(given, "`displacement`, `velocity` or `file`", place, check)?;
            let curves = match (displacement, velocity, file) {
                (Some(components), ..) => check.time_functions(components)?.map(Curve::Formula),
                (_, Some(components), _) => {
                    let rates = check.time_functions(components)?;
                    let curves = rates.map(|rate| Curve::integral(rate, course.end));
                    let mut curves = curves.into_iter().map(|curve| found(curve, components.span, check));
                    [curves.next()??, curves.next()??, curves.next()??]
                }
                (.., Some(path)) => {
                    let columns = table(path, check.dimensions, course.folder, check)?;
                    let mut curves = columns.into_iter();
                    std::array::from_fn(|_| curves.next().unwrap_or(Curve::Constant(0.0)))
                }
                _ => return None,
            };
            Some(Motion::Translation(curves))
        }
        MotionFile::Rotation { about, axis, radians, rate, file } => {
            let given = [radians.is_some(), rate.is_some(), file.is_some()];
            one_of(given, "`radians`, `rate` or `file`", place, check)?;
            let axis = check.axis(axis.as_ref());
            let about = check.vector(about, "m");
            let angle = match (radians, rate, file) {
                (Some(angle), ..) => Curve::Formula(check.time_function(angle)?),
                (_, Some(rate), _) => {
                    let curve = Curve::integral(check.time_function(rate)?, course.end);
                    found(curve, rate.span, check)?
                }
                (.., Some(path)) => table(path, 1, course.folder, check)?.pop()?,
                _ => return None,
            };
            found(Motion::rotation(about, axis, angle), place, check)
        }
        MotionFile::Chain(motions) => {
            if motions.value.is_empty() {
                check.report(Fault::new("a chain has no motions", motions.span, "must hold at least one"));
                return None;
            }
            let built: Vec<Option<Motion>> =
                motions.value.iter().map(|motion| built(motion, motions.head, course, check)).collect();
            built.into_iter().collect::<Option<Vec<Motion>>>().map(Motion::Chain)
        }
    }
}

/// Reports a motion that does not have exactly one of its fields.
fn one_of(given: [bool; 3], fields: &str, place: Span, check: &mut Checker<'_>) -> Option<()> {
    let count = given.iter().filter(|given| **given).count();
    if count == 1 {
        return Some(());
    }
    let label = format!("has {count} of {fields}, must have one of them");
    check.report(Fault::new("a motion must be given in one way", place, label));
    None
}

/// Returns what was found; reports a fault of the motion at its place.
fn found<T>(result: Result<T, MotionFault>, place: Span, check: &mut Checker<'_>) -> Option<T> {
    match result {
        Ok(found) => Some(found),
        Err(fault) => {
            check.report(Fault::new("a motion cannot be followed", place, fault.to_string()));
            None
        }
    }
}

/// Returns the columns of a table as curves in time.
fn table(path: &Text, count: usize, folder: &Path, check: &mut Checker<'_>) -> Option<Vec<Curve>> {
    let columns = tables::motion_table(path, count, folder, check)?;
    columns.iter().map(|column| found(Curve::table(column), path.span, check)).collect()
}

/// Reports settings of the complete scene that walls that move do not have.
pub fn check_scene(scene: &Scene, file: &SceneFile, faults: &mut Vec<Fault>) {
    if !scene.has_moving_walls() {
        return;
    }
    let first = file.movers.first().map(|mover| mover.name.span);
    let casing = file.walls.as_ref().and_then(|walls| walls.value.motion.as_ref()).map(|motion| motion.head);
    let place = first.or(casing).unwrap_or(Span::PLACEHOLDER);
    if scene.walls.model.pressure() == WallPressure::Mirrored {
        let label =
            "needs walls whose pressure is `Extrapolated`: a mirrored one has no acceleration of the wall";
        faults.push(
            Fault::new("walls that move cannot mirror the pressure", place, label)
                .help("give the wall model `pressure: Extrapolated`"),
        );
    }
    if let Some(fill) = file.fill.as_ref().filter(|fill| matches!(fill.value, FillFile::WallFitted { .. })) {
        let label = "must be `Lattice()` in a scene with movers";
        faults.push(Fault::new("rows fitted to the walls cannot go around movers", fill.head, label));
    }
    if !scene.layout.walled {
        faults.push(
            Fault::new("a scene without walls has movers", place, "must be left out with `walls: None`")
                .help("leave out `walls: None`"),
        );
    }
}
