//! Limits of a weakly compressible fluid.

use crate::faults::Fault;
use crate::given_speed::inlet_speed;
use crate::model::{Scene, Scheme};
use crate::schema::SceneFile;
use sphecs_core::boundary::outlet::method::References;
use sphecs_core::format::significant;
use sphecs_core::physics::edac::Edac;

/// Reports velocities at the sound speed, pressures that would double the density, and a background
/// pressure that is unstable at the time step.
pub fn check_limits(scene: &Scene, file: &SceneFile, faults: &mut Vec<Fault>) {
    let sound_speed = scene.fluid.sound_speed;
    let most = scene.fluid.density * sound_speed * sound_speed;
    for (inlet, written) in scene.inlets.iter().zip(&file.inlets) {
        let speed = inlet_speed(inlet, scene);
        if speed.is_finite() && speed >= sound_speed {
            let label = format!(
                "reaches {} m/s, must stay below the sound speed, {sound_speed} m/s",
                significant(speed)
            );
            faults.push(
                Fault::new("an inlet is as fast as sound", written.velocity.head, label)
                    .help("ten times the fastest velocity is usual for `fluid.sound_speed`"),
            );
        }
    }
    let conditions = file.outlets.iter().map(|outlet| outlet.condition.as_ref());
    for (outlet, written) in scene.outlets.iter().zip(conditions) {
        let Some(written) = written else { continue };
        let References { velocity, pressure } = outlet.condition.parameters().references();
        if velocity.abs() >= sound_speed {
            let label =
                format!("has a velocity of {velocity} m/s, must be below the sound speed, {sound_speed} m/s");
            faults.push(Fault::new("an outlet is as fast as sound", written.head, label));
        }
        if pressure.abs() >= most {
            let label = format!("has a pressure of {pressure} Pa, must be below ρ0 c0² = {most} Pa");
            faults.push(Fault::new("the pressure of an outlet is too large", written.head, label));
        }
    }
    if let Scheme::EdacTvf(scheme) = &scene.scheme {
        let (background, cfl) = (scheme.terms.background, scene.time.cfl);
        if let Some(written) = &file.time.cfl
            && background * cfl > Edac::LARGEST_BACKGROUND_STEP
        {
            let label = format!(
                "is `{cfl}`: times `background: {background}` that is {:.3}, must be at most {}",
                background * cfl,
                Edac::LARGEST_BACKGROUND_STEP
            );
            faults.push(
                Fault::new("the time step is too long for the background pressure", written.span, label)
                    .help("a smaller `time.cfl` or a smaller `background` of the scheme"),
            );
        }
    }
}
