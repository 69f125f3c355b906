//! Checks of the inlets and outlets of a scene file.

use std::path::Path;

use super::checker::Checker;
use super::names::{Named, names};
use super::patches::{PatchFile, Site, patch};
use super::tables;
use crate::expression::Expression;
use crate::faults::Fault;
use crate::model::{Inlet, InletVelocity, Outlet};
use crate::notation::typed::Spanned;
use crate::schema::{
    EmitterFile, Formula, FormulaText, InletFile, InletVelocityFile, Number, OutletFile, Text,
};
use crate::time_value::TimeValue;
use sphecs_core::boundary::outlet::OutletCondition;
use sphecs_core::boundary::outlet::pressure_driven::time_function::{Given, TimeFunction};

/// Layers of the zone of an inlet, as in Alvarado-Rodríguez et al. (2017).
const INLET_LAYERS: f64 = 5.0;
/// Layers of the zone of an outlet, more than their five, so that neither end affects its middle.
const OUTLET_LAYERS: f64 = 8.0;

/// Returns all inlets; None if one has a fault. `emitters` share the names of the results with
/// them.
pub fn inlets(
    (files, emitters): (&[InletFile], &[EmitterFile]),
    site: &Site<'_>,
    folder: &Path,
    check: &mut Checker<'_>,
) -> Option<Vec<Inlet>> {
    let mut given = with_defaults(files.iter().map(|file| file.name.as_ref()), "inlet");
    let kind = if emitters.is_empty() { "inlets" } else { "inlets and emitters" };
    given.extend(with_defaults(emitters.iter().map(|file| file.name.as_ref()), "emitter"));
    names(&given, kind, check);
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
            default_name: default_name("inlet", index),
            at: file.at.as_ref(),
            on: file.on.as_ref(),
            towards: file.towards.as_ref(),
            place: file.place(),
            depth: file.depth.as_ref(),
            layers: INLET_LAYERS,
            extent: file.extent,
            closed: file.closed,
            is_inlet: true,
        },
        site,
        check,
    );
    let half = patch.as_ref().map_or(1.0, |patch| patch.half_extent[0]);
    let velocity = velocity(&file.velocity, half, folder, check);
    for fault in file.pressure.faults() {
        check.report_parameter(&fault, "an inlet", file.velocity.head);
    }
    Some(Inlet { patch: patch?, velocity: velocity?, pressure: file.pressure, feed: file.feed })
}

/// Returns the name of an opening that has none in the file.
pub fn default_name(kind: &str, index: usize) -> String {
    format!("{kind} {index}")
}

fn with_defaults<'a>(given: impl Iterator<Item = Option<&'a Text>>, kind: &str) -> Vec<Named<'a>> {
    let named = |(index, name): (usize, Option<&'a Text>)| {
        name.map_or_else(|| Named::Default(default_name(kind, index)), Named::Given)
    };
    given.enumerate().map(named).collect()
}

/// Returns the velocity of an inlet or emitter; None if it has a fault. `half_width` is half the
/// width of the section, m.
pub fn velocity(
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
                (Some(rows), None) => written_rows(rows, "m/s", check),
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
        InletVelocityFile::MassFlow { rate, profile } => mass_velocity(rate, "rate", profile.as_ref(), check),
        InletVelocityFile::MassFlux { flux, profile } => mass_velocity(flux, "flux", profile.as_ref(), check),
        InletVelocityFile::PoiseuilleStartup { half_width: given, body_force } => {
            Some(InletVelocity::PoiseuilleStartup {
                half_width: given.as_ref().map_or(half_width, |given| check.positive(given, "m")),
                body_force: check.finite(body_force, "m/s²"),
            })
        }
    }
}

/// Returns the velocity from a rate in time and a profile in space, before it is scaled by
/// [`mass_flow`](super::mass_flow).
fn mass_velocity(
    rate: &Formula,
    name: &str,
    profile: Option<&Formula>,
    check: &mut Checker<'_>,
) -> Option<InletVelocity> {
    let mut expression = |formula: &Formula, name: &str, excluded: &[usize], rule: &str, help: &str| {
        let expression = check.formula(formula);
        if expression.depends_on(excluded) {
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
    Some(InletVelocity::MassFlow { rate: found?, profile: shape?, scale: 1.0 })
}

fn written_rows(rows: &[(Number, Number)], unit: &str, check: &mut Checker<'_>) -> Vec<(f64, f64)> {
    let mut result: Vec<(f64, f64)> = Vec::new();
    for (time, speed) in rows {
        let row = (check.finite(time, "s"), check.finite(speed, unit));
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

/// Returns all outlets; None if one has a fault.
pub fn outlets(
    files: &[OutletFile],
    site: &Site<'_>,
    folder: &Path,
    check: &mut Checker<'_>,
) -> Option<Vec<Outlet>> {
    let names_given = files.iter().map(|file| file.name.as_ref());
    names(&with_defaults(names_given, "outlet"), "outlets", check);
    let outlets: Vec<Option<Outlet>> = files
        .iter()
        .enumerate()
        .map(|(index, file)| {
            let given = file.condition.as_ref().map(|file| condition(file, folder, check));
            let patch = patch(
                &PatchFile {
                    name: file.name.as_ref(),
                    default_name: default_name("outlet", index),
                    at: file.at.as_ref(),
                    on: file.on.as_ref(),
                    towards: file.towards.as_ref(),
                    place: file.place(),
                    depth: file.depth.as_ref(),
                    layers: OUTLET_LAYERS,
                    extent: file.extent,
                    closed: file.closed,
                    is_inlet: false,
                },
                site,
                check,
            )?;
            let condition = file.condition.as_ref().map(|condition| condition.value.clone());
            let condition = condition.unwrap_or_default();
            Some(Outlet { patch, condition, given: given.unwrap_or(Some(None))? })
        })
        .collect();
    outlets.into_iter().collect()
}

/// Reports the parameters of an outlet condition that are out of range, and returns the quantity
/// that it is given in time; None if that has a fault.
fn condition(
    file: &Spanned<OutletCondition>,
    folder: &Path,
    check: &mut Checker<'_>,
) -> Option<Option<TimeValue>> {
    let parameters = file.value.parameters();
    let condition = format!("the outlet condition `{}`", parameters.name());
    let faults = parameters.faults();
    for fault in &faults {
        check.report_parameter(fault, &condition, file.head);
    }
    match parameters.given() {
        Some(given) if faults.is_empty() => time_value(given, file, folder, check).map(Some),
        Some(_) => None,
        None => Some(None),
    }
}

/// Returns a quantity that a condition is given in time; None if it has a fault.
fn time_value(
    given: Given<'_>,
    file: &Spanned<OutletCondition>,
    folder: &Path,
    check: &mut Checker<'_>,
) -> Option<TimeValue> {
    let before = check.fault_count();
    let spanned = |text: &str, check: &Checker<'_>| check.span_of_text(text, file.span).unwrap_or(file.head);
    let value = if let Some(path) = given.file {
        let span = spanned(path, check);
        let path = Text { value: path.to_owned(), span, head: span };
        TimeValue::Table(tables::time_table(&path, folder, check)?)
    } else if let Some(rows) = given.rows {
        let number = |value: f64| Number { value, span: file.head, head: file.head };
        let rows: Vec<_> = rows.iter().map(|row| (number(row.0), number(row.1))).collect();
        if rows.is_empty() {
            check.report(Fault::new("a table in time is empty", file.head, "must have rows"));
        }
        TimeValue::Table(written_rows(&rows, "Pa", check))
    } else {
        let (value, span) = match given.value? {
            TimeFunction::Number(value) => (FormulaText::Number(*value), file.head),
            TimeFunction::Text(text) => (FormulaText::Text(text.clone()), spanned(text, check)),
        };
        let expression = check.formula(&Formula { value, span, head: span });
        if expression.depends_on(&[0, 1, 2]) {
            let title = "the quantity of an opening depends on the place";
            check.report(Fault::new(title, span, "must depend on t alone"));
        }
        TimeValue::Expression(expression)
    };
    (check.fault_count() == before).then_some(value)
}
