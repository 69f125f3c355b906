//! Inlets and outlets of the file.

use std::path::Path;

use super::checker::Checker;
use super::patches::{PatchFile, Site, patch};
use super::tables;
use crate::expression::Expression;
use crate::faults::Fault;
use crate::model::{Inlet, InletVelocity, Outlet};
use crate::notation::tree::Span;
use crate::notation::typed::Spanned;
use crate::schema::{Formula, InletFile, InletVelocityFile, Number, OutletFile, Text};
use sphecs_core::physics::inlet::InletPressure;
use sphecs_core::physics::outlet::{OutletCondition, OutletPressure};

/// Layers of an inlet's zone: Alvarado-Rodríguez et al. (2017) take five.
const INLET_LAYERS: f64 = 5.0;
/// Layers of an outlet's zone: more than their five, so that its middle is free of both ends.
const OUTLET_LAYERS: f64 = 8.0;

/// All inlets; None with a fault.
pub fn inlets(
    files: &[InletFile],
    site: &Site<'_>,
    folder: &Path,
    check: &mut Checker<'_>,
) -> Option<Vec<Inlet>> {
    names(files.iter().map(|file| file.name.as_ref()), "inlets", check);
    let inlets: Vec<Option<Inlet>> =
        files.iter().enumerate().map(|(index, file)| inlet(file, index, site, folder, check)).collect();
    inlets.into_iter().collect()
}

fn inlet(
    file: &InletFile,
    index: usize,
    site: &Site<'_>,
    folder: &Path,
    check: &mut Checker<'_>,
) -> Option<Inlet> {
    let patch = patch(
        &PatchFile {
            name: file.name.as_ref(),
            default_name: format!("inlet {index}"),
            at: &file.at,
            towards: &file.towards,
            depth: file.depth.as_ref(),
            layers: INLET_LAYERS,
            is_inlet: true,
        },
        site,
        check,
    );
    let half = patch.as_ref().map_or(1.0, |patch| patch.half_extent[0]);
    let velocity = velocity(&file.velocity, half, folder, check);
    if let InletPressure::Prescribed(pressure) = file.pressure {
        finite(pressure, "the pressure of an inlet", file.velocity.head, check);
    }
    Some(Inlet { patch: patch?, velocity: velocity?, pressure: file.pressure, feed: file.feed })
}

fn finite(value: f64, what: &str, span: Span, check: &mut Checker<'_>) {
    if !value.is_finite() {
        let label = format!("is `{value}`, must be finite");
        check.report(Fault::new(format!("{what} is not finite"), span, label));
    }
}

fn names<'a>(names: impl Iterator<Item = Option<&'a Text>>, kind: &str, check: &mut Checker<'_>) {
    let mut known: Vec<&str> = Vec::new();
    for name in names.flatten() {
        if known.contains(&name.value.as_str()) {
            check.report(Fault::new(
                format!("two {kind} are called `{}`", name.value),
                name.span,
                "must differ",
            ));
        }
        known.push(&name.value);
    }
}

fn velocity(
    file: &Spanned<InletVelocityFile>,
    half_width: f64,
    folder: &Path,
    check: &mut Checker<'_>,
) -> Option<InletVelocity> {
    match &file.value {
        InletVelocityFile::Normal(speed) => Some(InletVelocity::Normal(check.formula(speed))),
        InletVelocityFile::Components(components) => {
            Some(InletVelocity::Components(check.components(components)))
        }
        InletVelocityFile::TimeTable { rows, file: path } => {
            let rows = match (rows, path) {
                (Some(rows), None) => written_rows(rows, check),
                (None, Some(path)) => tables::time_table(path, folder, check)?,
                _ => {
                    check.report(Fault::new(
                        "a table in time needs `rows` or `file`",
                        file.head,
                        "must have one of the two",
                    ));
                    return None;
                }
            };
            if rows.is_empty() {
                check.report(Fault::new("a table in time is empty", file.head, "must have rows"));
                return None;
            }
            Some(InletVelocity::TimeTable(rows))
        }
        InletVelocityFile::ProfileTable { file: path } => tables::profile_table(path, folder, check),
        InletVelocityFile::MassFlow { rate, profile } => metered(rate, "rate", profile.as_ref(), check),
        InletVelocityFile::MassFlux { flux, profile } => metered(flux, "flux", profile.as_ref(), check),
        InletVelocityFile::PoiseuilleStartup { half_width: given, body_force } => {
            Some(InletVelocity::PoiseuilleStartup {
                half_width: given.as_ref().map_or(half_width, |given| check.positive(given, "m")),
                body_force: check.finite(body_force, "m/s²"),
            })
        }
    }
}

/// A rate in time and a profile in space, not yet scaled to each other: see [`meter`](super::meter).
fn metered(
    rate: &Formula,
    name: &str,
    profile: Option<&Formula>,
    check: &mut Checker<'_>,
) -> Option<InletVelocity> {
    let mut expression = |formula: &Formula, name: &str, strangers: &[usize], rule: &str, help: &str| {
        let expression = check.formula(formula);
        if expression.depends_on(strangers) {
            let title = format!("`{name}` of an inlet {rule}");
            check.report(Fault::new(title, formula.span, rule).help(help));
            return None;
        }
        Some(expression)
    };
    let (of_time, of_place) = ("must depend on t alone", "must depend on x, y and z alone");
    let found = expression(rate, name, &[0, 1, 2], of_time, "what varies over the plane goes into `profile`");
    let shape = match profile {
        None => Some(Expression::Constant(1.0)),
        Some(profile) => {
            let help = format!("what varies in time goes into `{name}`");
            expression(profile, "profile", &[3], of_place, &help)
        }
    };
    Some(InletVelocity::Metered { rate: found?, profile: shape?, scale: 1.0 })
}

fn written_rows(rows: &[(Number, Number)], check: &mut Checker<'_>) -> Vec<(f64, f64)> {
    let mut result: Vec<(f64, f64)> = Vec::new();
    for (time, speed) in rows {
        let row = (check.finite(time, "s"), check.finite(speed, "m/s"));
        if result.last().is_some_and(|last| last.0 >= row.0) {
            check.report(Fault::new(
                "the times of a table do not rise",
                time.span,
                format!("is `{}` s, must be later than the row before", row.0),
            ));
        }
        result.push(row);
    }
    result
}

/// All outlets; None with a fault.
pub fn outlets(files: &[OutletFile], site: &Site<'_>, check: &mut Checker<'_>) -> Option<Vec<Outlet>> {
    names(files.iter().map(|file| file.name.as_ref()), "outlets", check);
    let outlets: Vec<Option<Outlet>> = files
        .iter()
        .enumerate()
        .map(|(index, file)| {
            if let Some(file) = &file.condition {
                condition(file, check);
            }
            let patch = patch(
                &PatchFile {
                    name: file.name.as_ref(),
                    default_name: format!("outlet {index}"),
                    at: &file.at,
                    towards: &file.towards,
                    depth: file.depth.as_ref(),
                    layers: OUTLET_LAYERS,
                    is_inlet: false,
                },
                site,
                check,
            )?;
            let condition =
                file.condition.as_ref().map_or_else(OutletCondition::default, |condition| condition.value);
            Some(Outlet { patch, condition })
        })
        .collect();
    outlets.into_iter().collect()
}

/// The numbers of an outlet's condition.
fn condition(file: &Spanned<OutletCondition>, check: &mut Checker<'_>) {
    let mut positive = |value: f64, what: &str, unit: &str| {
        if !(value.is_finite() && value > 0.0) {
            let label = format!("is `{value}`{unit}, must be finite and greater than 0");
            check.report(Fault::new(format!("{what} is not positive"), file.head, label));
        }
    };
    let pressure = match file.value {
        OutletCondition::WaveEquation { pressure, .. } | OutletCondition::Orlanski { pressure, .. } => {
            let (target, time) = match pressure {
                OutletPressure::Frozen => return,
                OutletPressure::Reference(target) => (target, 1.0),
                OutletPressure::Relaxed { target, time } => (target, time),
                OutletPressure::Absorbing { target, time, .. } => (target, time.unwrap_or(1.0)),
            };
            positive(time, "the time constant of an outlet's pressure", " s");
            target
        }
        OutletCondition::DoNothing
        | OutletCondition::ModifiedDoNothing { .. }
        | OutletCondition::Mirror { .. } => return,
        OutletCondition::Characteristic { velocity, pressure } => {
            finite(velocity, "the reference velocity of an outlet", file.head, check);
            pressure
        }
        OutletCondition::Hybrid { velocity, pressure, steps } => {
            positive(velocity.unwrap_or(1.0), "the velocity of an outlet's threshold", " m/s");
            if !(steps.is_finite() && steps >= 1.0) {
                let label = format!("is `{steps}` steps, must be finite and at least 1");
                check.report(Fault::new("the time mean of an outlet is too short", file.head, label));
            }
            pressure
        }
    };
    finite(pressure, "the pressure of an outlet", file.head, check);
}
