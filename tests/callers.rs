//! What a caller and a plugin of one's own can do with a flow.

mod census;
mod plug;

use census::{census, of};
use plug::scene;
use sphecs::bevy_ecs::resource::Resource;
use sphecs::bevy_ecs::schedule::IntoScheduleConfigs;
use sphecs::bevy_ecs::system::{Res, ResMut};
use sphecs::components::{ParticleId, Position, Velocity};
use sphecs::glam::DVec3;
use sphecs::particles::zone::Zone;
use sphecs::plugins::{Plugin, PluginContext};
use sphecs::resources::clock::Clock;
use sphecs::resources::ledger::Ledger;
use sphecs::schedule::StepSet;
use sphecs::simulation::Simulation;
use sphecs::systems::forces::{AddedForces, ParticleState};

/// Spacing of the particles, m.
const SPACING: f64 = 0.01;

/// A box of fluid at rest, periodic in both directions.
const CLOSED: [(&str, &str); 4] =
    [("inlets", "[]"), ("outlets", "[]"), ("periodic", r#"["x", "y"]"#), ("constants.u", "0.0")];

fn closed() -> Simulation {
    Simulation::from_scene(scene(&CLOSED))
}

/// A constant force per mass, m/s².
struct Wind(DVec3);

impl Plugin for Wind {
    fn build(&self, parts: &mut PluginContext<'_>) {
        let force = self.0;
        parts.world.get_resource_or_init::<AddedForces>().add(move |_: &ParticleState| force);
    }
}

/// What a system of one's own saw after each step.
#[derive(Resource, Default)]
struct Seen(Vec<(Clock, u64)>);

struct Watch;

fn watch(clock: Res<Clock>, ledger: Res<Ledger>, mut seen: ResMut<Seen>) {
    seen.0.push((*clock, ledger.entered.iter().sum()));
}

impl Plugin for Watch {
    fn build(&self, parts: &mut PluginContext<'_>) {
        parts.world.init_resource::<Seen>();
        parts.step.add_systems(watch.in_set(StepSet::Observe));
    }
}

#[test]
fn an_added_force_accelerates_the_fluid_as_newton_says() {
    let (wind, more) = (DVec3::new(0.02, -0.01, 0.0), DVec3::new(0.01, 0.0, 0.0));
    let mut simulation = Simulation::with_plugins(scene(&CLOSED), &[&Wind(wind), &Wind(more)]);
    for _ in 0..120 {
        simulation.step().expect("a step");
    }
    let expected = (wind + more) * simulation.clock().time;
    for particle in of(&census(&mut simulation), Zone::Fluid) {
        // A plain step and a leapfrog are both exact under a constant force.
        let off = particle.velocity.distance(expected) / expected.length();
        assert!(off < 1e-9, "{} is not {expected}", particle.velocity);
    }
}

#[test]
fn a_system_in_observe_sees_the_step_that_has_just_been_made() {
    let mut simulation = Simulation::with_plugins(scene(&[]), &[&Watch]);
    let mut expected = Vec::new();
    for _ in 0..60 {
        simulation.step().expect("a step");
        expected.push((simulation.clock(), simulation.ledger().entered.iter().sum()));
    }
    let seen = &simulation.world().resource::<Seen>().0;
    assert_eq!(*seen, expected);
    assert!(seen.last().is_some_and(|(_, entered)| *entered > 0), "nothing entered");
}

/// The leapfrog would lose it: it starts from the velocities one step earlier, which are no caller's business.
#[test]
fn the_next_step_starts_from_the_velocities_that_a_caller_leaves() {
    let stirred = DVec3::new(0.03, 0.02, 0.0);
    let mut simulation = closed();
    for _ in 0..7 {
        simulation.step().expect("a step");
    }
    let before = census(&mut simulation);
    let world = simulation.world_mut();
    for mut velocity in world.query::<&mut Velocity>().iter_mut(world) {
        velocity.0 = stirred;
    }
    for step in 1..=60 {
        let from = simulation.clock().time;
        simulation.step().expect("a step");
        let elapsed = simulation.clock().time - from;
        for particle in of(&census(&mut simulation), Zone::Fluid) {
            assert!(
                particle.velocity.distance(stirred) < 1e-9,
                "step {step}: {} is not {stirred}",
                particle.velocity
            );
            if step == 1 {
                let moved = particle.position - before[particle.id as usize].position;
                // Across the seam of the period a particle comes in again on the other side.
                let wrapped = moved.length() > SPACING;
                assert!(wrapped || moved.distance(stirred * elapsed) < 1e-12, "it moved by {moved}");
            }
        }
    }
}

/// Rows, samples and frames of one time are read from one sort and one density: of that time, not of the one read before.
#[test]
fn what_is_read_is_of_the_present_step_however_often_it_was_read_before() {
    let wind = Wind(DVec3::new(0.5, 0.3, 0.0));
    let (mut read, mut twin) = [(), ()].map(|()| Simulation::with_plugins(scene(&[]), &[&wind])).into();
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
fn the_next_step_starts_from_the_positions_that_a_caller_leaves() {
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
    // What is read before the step belongs to the new place: two particles that stand close have a higher density.
    let densest = census(&mut simulation)[moved.id as usize];
    assert_eq!(densest.position, moved.position + aside);
    assert!(densest.density > moved.density + 1.0, "{} kg/m³ after {}", densest.density, moved.density);
    simulation.step().expect("a step");
    let pushed = census(&mut simulation)[moved.id as usize];
    assert!(pushed.velocity.x < 0.0, "the neighbour pushes it back, not with {}", pushed.velocity);
}
