//! Changes of a flow by a caller between steps and by plugins of a user.

mod census;
mod common;
mod plug;

use census::{census, of};
use plug::scene;
use sphecs::bevy_ecs::resource::Resource;
use sphecs::bevy_ecs::schedule::IntoScheduleConfigs;
use sphecs::bevy_ecs::system::{Res, ResMut};
use sphecs::glam::DVec3;
use sphecs::{Clock, Ledger, Simulation, StepSet, Zone};
use sphecs_engine::components::{ParticleId, Position, Velocity};
use sphecs_engine::plugins::{Plugin, PluginContext};
use sphecs_engine::systems::force_fields::FluidState;
use sphecs_engine::systems::forces::{AddedForces, ParticleState};

/// Spacing of the particles, m.
const SPACING: f64 = 0.01;

/// A box of fluid at rest, periodic in both directions.
const CLOSED: [(&str, &str); 4] =
    [("inlets", "[]"), ("outlets", "[]"), ("periodic", r#"["x", "y"]"#), ("constants.u", "0.0")];

fn closed() -> Simulation {
    common::simulation(scene(&CLOSED))
}

/// A constant force per mass, m/s².
struct Wind(DVec3);

impl Plugin for Wind {
    fn build(&self, context: &mut PluginContext<'_>) {
        let force = self.0;
        context.world.get_resource_or_init::<AddedForces>().add(move |_: &ParticleState| force);
    }
}

/// Clock and number of entered particles after each step.
#[derive(Resource, Default)]
struct Seen(Vec<(Clock, u64)>);

struct Watch;

fn watch(clock: Res<Clock>, ledger: Res<Ledger>, mut seen: ResMut<Seen>) {
    seen.0.push((*clock, ledger.entered.iter().sum()));
}

impl Plugin for Watch {
    fn build(&self, context: &mut PluginContext<'_>) {
        context.world.init_resource::<Seen>();
        context.step.add_systems(watch.in_set(StepSet::Observe));
    }
}

#[test]
fn added_force_accelerates_the_fluid_as_newton_predicts() {
    let (wind, more) = (DVec3::new(0.02, -0.01, 0.0), DVec3::new(0.01, 0.0, 0.0));
    let mut simulation = Simulation::builder(scene(&CLOSED))
        .plugin(Wind(wind))
        .plugin(Wind(more))
        .build()
        .expect("a simulation");
    for _ in 0..120 {
        simulation.step().expect("a step");
    }
    let expected = (wind + more) * simulation.clock().time;
    for particle in of(&census(&mut simulation), Zone::Fluid) {
        // Both integrators are exact under a constant force.
        let off = particle.velocity.distance(expected) / expected.length();
        assert!(off < 1e-9, "{} is not {expected}", particle.velocity);
    }
}

/// A drag towards a wind, for each particle or for whole columns.
struct Drag {
    for_columns: bool,
}

impl Plugin for Drag {
    fn build(&self, context: &mut PluginContext<'_>) {
        let drag = |time: f64, position: DVec3, velocity: DVec3| {
            3.0 * (DVec3::new(time, 20.0 * position.x, 0.0) - velocity)
        };
        let mut forces = context.world.get_resource_or_init::<AddedForces>();
        if self.for_columns {
            forces.add_field(move |fluid: &FluidState<'_>, force: &mut [DVec3]| {
                for (row, force) in force.iter_mut().enumerate() {
                    *force += drag(fluid.time, fluid.position[row], fluid.velocity[row]);
                }
            });
        } else {
            forces.add(move |at: &ParticleState| drag(at.time, at.position, at.velocity));
        }
    }
}

#[test]
fn field_equals_the_force_of_each_particle() {
    let moved = |for_columns: bool| {
        let plugin = Drag { for_columns };
        let mut simulation = Simulation::builder(scene(&[])).plugin(plugin).build().expect("a simulation");
        common::advance(&mut simulation, 40);
        census(&mut simulation)
    };
    let (by_columns, by_particle) = (moved(true), moved(false));
    assert_eq!(by_columns.len(), by_particle.len());
    for (one, other) in by_columns.iter().zip(&by_particle) {
        assert_eq!((one.position, one.velocity), (other.position, other.velocity));
    }
}

#[test]
fn table_of_the_particles_equals_their_components() {
    let mut simulation = common::simulation(scene(&[]));
    common::advance(&mut simulation, 60);
    let table = simulation.particles();
    let mut particles = census(&mut simulation);
    particles.retain(|particle| particle.zone != Zone::Reservoir);
    particles.sort_by_key(|particle| particle.id);
    assert!(particles.iter().any(|particle| particle.zone == Zone::Outflow));
    assert_eq!(table.id.len(), particles.len());
    for (row, particle) in particles.iter().enumerate() {
        assert_eq!((table.id[row], table.zone[row]), (particle.id, particle.zone));
        assert_eq!(table.patch[row], particle.patch);
        assert_eq!((table.position[row], table.velocity[row]), (particle.position, particle.velocity));
        assert_eq!((table.density[row], table.pressure[row]), (particle.density, particle.pressure));
    }
}

#[test]
fn system_in_observe_runs_after_each_step() {
    let mut simulation = Simulation::builder(scene(&[])).plugin(Watch).build().expect("a simulation");
    let mut expected = Vec::new();
    for _ in 0..60 {
        simulation.step().expect("a step");
        expected.push((simulation.clock(), simulation.ledger().entered.iter().sum()));
    }
    let seen = &simulation.world().resource::<Seen>().0;
    assert_eq!(*seen, expected);
    assert!(seen.last().is_some_and(|(_, entered)| *entered > 0), "nothing entered");
}

/// An integrator that started from the previous velocities would lose the change.
#[test]
fn next_step_starts_from_the_velocities_of_the_caller() {
    let imposed = DVec3::new(0.03, 0.02, 0.0);
    let mut simulation = closed();
    for _ in 0..7 {
        simulation.step().expect("a step");
    }
    let before = census(&mut simulation);
    let world = simulation.world_mut();
    for mut velocity in world.query::<&mut Velocity>().iter_mut(world) {
        velocity.0 = imposed;
    }
    for step in 1..=60 {
        let from = simulation.clock().time;
        simulation.step().expect("a step");
        let elapsed = simulation.clock().time - from;
        for particle in of(&census(&mut simulation), Zone::Fluid) {
            assert!(
                particle.velocity.distance(imposed) < 1e-9,
                "step {step}: {} is not {imposed}",
                particle.velocity
            );
            if step == 1 {
                let moved = particle.position - before[particle.id as usize].position;
                // A particle that crosses the periodic boundary is wrapped.
                let wrapped = moved.length() > SPACING;
                assert!(wrapped || moved.distance(imposed * elapsed) < 1e-12, "it moved by {moved}");
            }
        }
    }
}

/// Rows, samples and frames of one time share one sort and one density, which must be those of that
/// time.
#[test]
fn samples_belong_to_the_present_step_after_earlier_reads() {
    let simulation = || {
        let wind = Wind(DVec3::new(0.5, 0.3, 0.0));
        Simulation::builder(scene(&[])).plugin(wind).build().expect("a simulation")
    };
    let (mut read, mut twin) = (simulation(), simulation());
    for _ in 0..20 {
        read.monitor_row();
        read.step().expect("a step");
        twin.step().expect("a step");
    }
    let points: Vec<DVec3> = of(&census(&mut read), Zone::Fluid).map(|fluid| fluid.position).collect();
    let (found, expected) = (read.sample(&points), twin.sample(&points));
    assert!(found == expected && found.iter().flatten().count() > 0);
}

#[test]
fn next_step_starts_from_the_positions_of_the_caller() {
    let mut simulation = closed();
    for _ in 0..3 {
        simulation.step().expect("a step");
    }
    let aside = DVec3::new(0.3 * SPACING, 0.0, 0.0);
    let before = census(&mut simulation);
    let moved = before[before.len() / 2];
    let world = simulation.world_mut();
    let mut state = world.query::<(&ParticleId, &mut Position)>();
    let found = state.iter_mut(world).find(|(id, _)| id.0 == moved.id);
    found.expect("the particle").1.0 += aside;
    // Values read before the step belong to the new position: close particles have a higher
    // density.
    let densest = census(&mut simulation)[moved.id as usize];
    assert_eq!(densest.position, moved.position + aside);
    assert!(densest.density > moved.density + 1.0, "{} kg/m³ after {}", densest.density, moved.density);
    simulation.step().expect("a step");
    let pushed = census(&mut simulation)[moved.id as usize];
    assert!(pushed.velocity.x < 0.0, "the neighbour pushes it back, not with {}", pushed.velocity);
}
