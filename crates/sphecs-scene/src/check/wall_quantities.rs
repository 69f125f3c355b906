//! Checks of the quantities at the walls: parts and intervals.

use super::checker::Checker;
use super::settings::sampled_mean;
use crate::faults::{Fault, advice};
use crate::model::Walls;
use crate::notation::typed::Spanned;
use crate::schema::WallQuantitiesFile;
use crate::wall_points::WallOutput;

/// Returns the settings of the quantities at the walls; `every` is the interval of the frames, s.
pub fn wall_quantities(
    written: &Spanned<WallQuantitiesFile>,
    (walls, walled): (&Walls, bool),
    (every, end): (f64, Option<f64>),
    check: &mut Checker<'_>,
) -> WallOutput {
    let file = &written.value;
    if !walled {
        let label = "has no meaning in a scene without walls";
        check.report(Fault::new("the scene lacks walls to measure at", written.head, label));
    }
    let every = file.every.as_ref().map_or(every, |number| check.positive(number, "s"));
    let (mean, mean_every) = sampled_mean(file.mean.as_ref(), file.mean_every.as_ref(), end, check);
    let all = 0..walls.parts.len() as u16;
    let Some(names) = &file.parts else {
        return WallOutput { parts: all.collect(), every, mean, mean_every };
    };
    if names.is_empty() {
        let label = "has an empty list `parts`";
        let fault = Fault::new("the quantities at the walls have no wall", written.head, label);
        check.report(fault.help("name parts of the walls, or leave out `parts` for all of them"));
    }
    let mut parts: Vec<u16> = Vec::new();
    for name in names {
        let Some(part) = all.clone().find(|part| walls.parts[usize::from(*part)].name == name.value) else {
            let known = walls.parts.iter().map(|part| part.name.as_str());
            let label = "must be the name of a part of the walls";
            let fault = Fault::new(format!("the walls have no part `{}`", name.value), name.span, label);
            check.report(fault.help(advice(&name.value, known)));
            continue;
        };
        if parts.contains(&part) {
            let label = "every part must be named once";
            check.report(Fault::new(format!("`{}` is named twice", name.value), name.span, label));
        }
        parts.push(part);
    }
    parts.sort_unstable();
    WallOutput { parts, every, mean, mean_every }
}
