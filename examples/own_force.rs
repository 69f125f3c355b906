//! Force of a user, and a system that observes the flow.
//!
//! A spring attracts the fluid of a channel to its axis. After every step a system records the
//! number of particles that entered, with the time.
//!
//! ```text
//! cargo run --release --example own_force
//! ```

#![expect(clippy::print_stdout, reason = "the program prints its result")]

use std::error::Error;

use sphecs::bevy_ecs::resource::Resource;
use sphecs::bevy_ecs::schedule::IntoScheduleConfigs;
use sphecs::bevy_ecs::system::{Res, ResMut};
use sphecs::glam::DVec3;
use sphecs::{AddedForces, Clock, Ledger, ParticleState, Plugin, PluginContext, Scene, Simulation, StepSet};

/// Spring that attracts the fluid to the plane y = 0.
struct Spring {
    /// Stiffness per mass, 1/s².
    stiffness: f64,
}

impl Plugin for Spring {
    fn build(&self, context: &mut PluginContext<'_>) {
        let stiffness = self.stiffness;
        let force = move |particle: &ParticleState| DVec3::Y * (-stiffness * particle.position.y);
        context.world.get_resource_or_init::<AddedForces>().add(force);
    }
}

/// Record of the inflow.
struct InflowRecorder;

/// Time, s, and number of particles entered until then, one entry per step.
#[derive(Resource, Default)]
struct InflowRecord(Vec<(f64, u64)>);

impl Plugin for InflowRecorder {
    fn build(&self, context: &mut PluginContext<'_>) {
        context.world.init_resource::<InflowRecord>();
        context.step.add_systems(record_inflow.in_set(StepSet::Observe));
    }
}

fn record_inflow(clock: Res<Clock>, ledger: Res<Ledger>, mut record: ResMut<InflowRecord>) {
    record.0.push((clock.time, ledger.entered.iter().sum()));
}

/// Runs a scene with the spring until a time, s; returns the record of the inflow.
pub(crate) fn run(scene: Scene, until: f64) -> Result<Vec<(f64, u64)>, Box<dyn Error>> {
    let mut simulation =
        Simulation::builder(scene).plugin(Spring { stiffness: 2.0 }).plugin(InflowRecorder).build()?;
    simulation.run_until(until)?;
    Ok(simulation.world().resource::<InflowRecord>().0.clone())
}

fn main() -> Result<(), Box<dyn Error>> {
    let scene = Scene::from_file("scenes/quickstart.ron").load()?;
    for (time, entered) in run(scene, 0.5)?.iter().step_by(100) {
        println!("{time:.4} s: {entered} particles entered");
    }
    Ok(())
}
