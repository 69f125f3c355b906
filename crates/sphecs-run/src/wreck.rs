//! What is said and kept of a flow that cannot go on.

use std::path::Path;

use glam::DVec3;

use super::words::{figure, grouped};
use sphecs_engine::resources::clock::Clock;
use sphecs_engine::simulation::Stop;
use sphecs_engine::systems::divergence::DivergedParticle;
use sphecs_engine::systems::divergence::NearbyParticle;
use sphecs_output::blow_up;
use sphecs_output::error::OutputError;
use sphecs_output::header::Header;
use sphecs_output::summary::Status;
use sphecs_scene::model::{Patch, Scene};

/// How the run ended, and what usually helps.
pub fn cure(stop: &Stop) -> (Status, String) {
    match stop {
        Stop::Diverged { advice, .. } => (Status::BlownUp, (*advice).to_owned()),
        Stop::Drained { .. } => {
            (Status::Failed, "lengthen its `depth`, lower `time.end`, or let it be `Fed`".to_owned())
        }
        Stop::ReservoirEmpty { .. } => {
            (Status::Failed, "raise `reservoir.particles`, or let it grow with `when_empty: Grow`".to_owned())
        }
    }
}

/// Keeps the surroundings of a fault and says what is known of its particle, a line each. To be called when the results are closed: the last
/// frame is read back.
pub fn particulars(
    folder: &Path,
    header: &Header,
    scene: &Scene,
    clock: &Clock,
    fault: &DivergedParticle,
) -> String {
    let vector = |vector: DVec3| {
        let parts: Vec<String> = vector.to_array().into_iter().take(header.dimensions).map(figure).collect();
        format!("({})", parts.join(", "))
    };
    let mut text = String::new();
    if let Some(own) = fault.neighbourhood.particle(fault.id) {
        text += &format!(
            "\nin the step: density {} kg/m³, pressure {} Pa, acceleration {} m/s²; velocity {} m/s after it, {} m/s before",
            figure(own.density),
            figure(own.pressure),
            vector(own.acceleration),
            vector(own.velocity),
            vector(own.previous_velocity),
        );
    }
    // What cannot be read back is no reason to hide the rest.
    if let Ok(Some((time, good))) = blow_up::in_last_frame(folder, fault.id) {
        text += &format!(
            "\nin the last frame, t = {} s: {} at {} m, velocity {} m/s, density {} kg/m³, pressure {} Pa",
            figure(time),
            good.zone.name(),
            vector(good.position),
            vector(good.velocity),
            figure(good.density),
            figure(good.pressure),
        );
    }
    text += &next_to_outlet(scene, fault).unwrap_or_default();
    let nearest = |(near, distance): (&NearbyParticle, f64)| {
        format!(
            ", the nearest, {} particle {}, {} Δ away",
            near.zone.name(),
            near.id,
            figure(distance / header.spacing)
        )
    };
    let (count, closest) = fault.neighbourhood.neighbours(fault.id);
    text += &format!("\n{} neighbours{}", grouped(count as u64), closest.map_or_else(String::new, nearest));
    text + &match blow_up::write(folder, header, clock, fault) {
        Ok([data, picture]) => {
            format!("\nits surroundings are in `{}`, drawn in `{}`", data.display(), picture.display())
        }
        Err(error) => format!("\nits surroundings could not be kept: {error}"),
    }
}

/// The outlet in whose zone, or within two supports before which, a particle failed: its condition is the first thing to doubt.
fn next_to_outlet(scene: &Scene, fault: &DivergedParticle) -> Option<String> {
    let reach = 2.0 * scene.scheme.support(scene.spacing);
    let near = |patch: &Patch| {
        let along = patch.along(fault.position);
        along > -reach && along < patch.depth + reach && patch.covers(fault.position, reach)
    };
    let (number, outlet) = scene.outlets.iter().enumerate().find(|(_, outlet)| near(&outlet.patch))?;
    let along = outlet.patch.along(fault.position) / scene.spacing;
    let side = if along < 0.0 { "before" } else { "behind" };
    Some(format!(
        "\nit is {} Δ {side} the plane of outlet {number}, `{}`, which may be why: docs/which_outlet.md says which condition holds where",
        figure(along.abs()),
        outlet.condition.parameters().name()
    ))
}

/// What is left of a run: frames and checkpoint.
pub fn kept(folder: &Path, frames: u64, last_checkpoint: Option<u64>) -> String {
    let path = folder.display();
    let checkpoint = last_checkpoint
        .map_or_else(String::new, |step| format!("; the last checkpoint is of step {}", grouped(step)));
    format!(
        "\n{frames} frames up to there are in `{path}`: `sphecs render {path} --all` draws how it came{checkpoint}"
    )
}

/// What is said when the results could not be closed.
pub fn not_closed(error: &OutputError) -> String {
    format!("\nthe results could not be closed: {error}")
}
