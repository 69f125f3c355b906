//! Checks of the openings that a pressure drives.

use crate::faults::Fault;
use crate::model::Scene;
use crate::sampled_times::sampled_times;
use crate::schema::SceneFile;

/// Rounding of the sum of shares.
const SLACK: f64 = 1e-9;

/// Reports given quantities that are not finite, and shares of the inflow that have no inflow, no
/// outlet for the rest, or no pressure.
pub fn check_openings(scene: &Scene, file: &SceneFile, faults: &mut Vec<Fault>) {
    let mut shares = 0.0;
    let mut last_share = None;
    for (outlet, written) in scene.outlets.iter().zip(&file.outlets) {
        let Some(written) = &written.condition else { continue };
        if let Some(given) = &outlet.given
            && let Some(time) = sampled_times(scene.time.end).find(|time| !given.at(*time).is_finite())
        {
            let label = format!("is `{}` at t = {time} s, must be finite", given.at(time));
            faults.push(Fault::new("the quantity of an opening is not finite", written.head, label));
        }
        if let Some(share) = outlet.condition.parameters().share() {
            shares += share;
            last_share = Some(written.head);
            if scene.inlets.is_empty() {
                let label = "must have a prescribed inflow to share";
                let help = "add an inlet with a velocity, or take `Pressure`";
                faults.push(Fault::new("`FlowShare` without an inlet", written.head, label).help(help));
            }
        }
    }
    let Some(head) = last_share else { return };
    if scene.outlets.iter().all(|outlet| outlet.condition.parameters().share().is_some()) {
        let label = "nothing sets the pressure";
        let help =
            "give one outlet `Pressure(value: 0.0)` or the default condition; it takes the rest of the flow";
        faults.push(Fault::new("all outlets have `FlowShare`", head, label).help(help));
    } else if shares > 1.0 + SLACK {
        let label = format!("the shares add up to {shares}, must be at most 1");
        faults.push(Fault::new("the outlets share more than the inflow", head, label));
    }
}
