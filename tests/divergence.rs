//! Detection of an impossible state in the step in which it appears, with its place.

mod common;

use common::{scene_path, simulation, smoke_scene};
use sphecs::bevy_ecs::query::With;
use sphecs::glam::DVec3;
use sphecs::{Clock, Zone};
use sphecs_engine::components::{Fluid, Inflow, Outflow, Position, Thermodynamics, Velocity, Wall};
use sphecs_engine::simulation::{Simulation, Stop};
use sphecs_engine::systems::divergence::check_state;

/// Builds a channel with an inlet, an outlet and walls.
fn start(sets: &[(&str, &str)]) -> Simulation {
    simulation(smoke_scene(&scene_path("quickstart.ron"), sets))
}

/// Builds the channel and takes twelve steps.
fn channel(sets: &[(&str, &str)]) -> Simulation {
    let mut simulation = start(sets);
    for _ in 0..12 {
        simulation.step().expect("a regular flow");
    }
    simulation
}

const EDAC: &[(&str, &str)] = &[("scheme", "EdacTvf()")];

/// Field with a NaN.
#[derive(Clone, Copy, Debug)]
enum Field {
    Position,
    Velocity,
    Density,
    Pressure,
}

/// Writes a NaN to a field of the first particle of a zone.
fn corrupt(simulation: &mut Simulation, zone: Zone, field: Field) {
    let world = simulation.world_mut();
    let mut particles = world.query::<(
        &mut Position,
        &mut Velocity,
        &mut Thermodynamics,
        Option<&Fluid>,
        Option<&Inflow>,
        Option<&Outflow>,
        Option<&Wall>,
    )>();
    let mut found = particles.iter_mut(world).filter(|(_, _, _, fluid, inflow, outflow, wall)| match zone {
        Zone::Fluid => fluid.is_some(),
        Zone::Inflow => inflow.is_some(),
        Zone::Outflow => outflow.is_some(),
        _ => wall.is_some(),
    });
    let (mut position, mut velocity, mut thermodynamics, ..) = found.next().expect("a particle");
    match field {
        Field::Position => position.0.y = f64::NAN,
        Field::Velocity => velocity.0.x = f64::NAN,
        Field::Density => thermodynamics.density = f64::NAN,
        Field::Pressure => thermodynamics.pressure = f64::NAN,
    }
}

#[track_caller]
fn check_detection(sets: &[(&str, &str)], zone: Zone, field: Field) {
    let mut simulation = channel(sets);
    let before = simulation.clock().step;
    corrupt(&mut simulation, zone, field);
    let stop = simulation.step().expect_err("an impossible state");
    let Stop::Diverged { step, .. } = stop else { panic!("{stop}") };
    // The sort finds a position that is not finite before the step is counted.
    assert!(step - before <= 1, "{field:?} of {zone:?}: found {} steps later", step - before);
    let particle = simulation.diverged_particle().expect("a diverged particle").clone();
    assert!(particle.neighbourhood.centre.is_finite());
    assert!(particle.neighbourhood.particle(particle.id).is_some(), "{particle:?}");
    assert!(
        particle.neighbourhood.particles.len() > 20,
        "{} around it",
        particle.neighbourhood.particles.len()
    );
}

#[test]
fn value_that_is_not_finite_stops_the_run_in_the_next_step() {
    for zone in [Zone::Fluid, Zone::Inflow, Zone::Outflow, Zone::Wall] {
        check_detection(&[], zone, Field::Position);
        check_detection(EDAC, zone, Field::Position);
    }
    for zone in [Zone::Fluid, Zone::Outflow] {
        check_detection(&[], zone, Field::Velocity);
        check_detection(EDAC, zone, Field::Velocity);
    }
    check_detection(EDAC, Zone::Fluid, Field::Pressure);
}

/// Values that a scheme recomputes in every step cannot be corrupted.
#[test]
fn recomputed_values_recover_from_corruption() {
    let recomputed: [(&[(&str, &str)], Zone, Field); 4] = [
        (&[], Zone::Fluid, Field::Density),
        (&[], Zone::Fluid, Field::Pressure),
        (EDAC, Zone::Fluid, Field::Density),
        (&[], Zone::Inflow, Field::Velocity),
    ];
    for (sets, zone, field) in recomputed {
        let (mut corrupted, mut regular) = (channel(sets), channel(sets));
        // Both start the step from the components.
        regular.world_mut();
        corrupt(&mut corrupted, zone, field);
        for simulation in [&mut corrupted, &mut regular] {
            simulation.step().expect("a regular flow");
        }
        let (mut found, expected) = (corrupted.monitor_row(), regular.monitor_row());
        if zone == Zone::Inflow {
            // For one step the fit of the pressure at the plane lacked the particle, and the column
            // of the inflow zone was compressed a little differently.
            assert!((found.mean_pressure / expected.mean_pressure - 1.0).abs() < 1e-3);
            found.mean_pressure = expected.mean_pressure;
        }
        assert_eq!(found, expected, "{field:?} of {zone:?}");
    }
}

/// Returns the number of steps until the flow diverges, at most `most`; all values before must be
/// finite.
fn steps_to_divergence(simulation: &mut Simulation, most: usize) -> Option<usize> {
    for done in 0..most {
        let stepped = simulation.step();
        if let Err(stop) = stepped {
            assert!(matches!(stop, Stop::Diverged { .. }), "{stop}");
            assert!(
                simulation
                    .diverged_particle()
                    .is_some_and(|particle| !particle.neighbourhood.particles.is_empty())
            );
            return Some(done);
        }
        let row = simulation.monitor_row();
        assert!(row.kinetic_energy.is_finite() && row.mean_pressure.is_finite(), "{row:?}");
    }
    None
}

#[test]
fn flow_faster_than_sound_diverges_with_a_report() {
    for scheme in ["Wcsph()", "EdacTvf()"] {
        // A scene must have an inlet below the sound speed; a force accelerates the flow beyond it.
        let mut simulation =
            start(&[("scheme", scheme), ("fluid.sound_speed", "0.11"), ("body_force", "(50.0, 0.0)")]);
        assert!(steps_to_divergence(&mut simulation, 400).is_some(), "{scheme}");
    }
}

#[test]
fn longest_allowed_time_steps_keep_all_values_finite() {
    for scheme in ["Wcsph()", "Wcsph(integrator: Verlet())", "EdacTvf()"] {
        let mut simulation = start(&[("scheme", scheme), ("time.cfl", "1.0")]);
        assert_eq!(steps_to_divergence(&mut simulation, 200), None, "{scheme}");
    }
}

#[test]
fn excessive_acceleration_stops_the_run_in_the_first_step() {
    let mut simulation = start(&[("body_force", "(1e12, 0.0)")]);
    assert_eq!(steps_to_divergence(&mut simulation, 1), Some(0));
    // Even the shortest allowed step leads to an impossible speed.
    let particle = simulation.diverged_particle().expect("a diverged particle");
    assert!(particle.found.starts_with("speed"), "{}", particle.found);
}

/// Only an external cause makes steps short without making particles fast, such as an added force
/// towards a wall.
#[test]
fn time_step_below_its_minimum_stops_the_run() {
    let mut simulation = channel(&[]);
    let world = simulation.world_mut();
    world.resource_mut::<Clock>().time_step *= 1e-4;
    world.run_system_cached(check_state::<f64, 2>).expect("all resources are in the world");
    let particle = simulation.diverged_particle().expect("a diverged particle");
    assert!(particle.found.starts_with("time step"), "{}", particle.found);
}

#[test]
fn overlapping_particles_are_counted_as_close_pairs() {
    let mut simulation = channel(&[]);
    let world = simulation.world_mut();
    let mut fluid = world.query_filtered::<&mut Position, With<Fluid>>();
    let places: Vec<DVec3> = fluid.iter(world).map(|position| position.0).collect();
    let middle = places.len() / 2;
    for (at, mut position) in fluid.iter_mut(world).enumerate() {
        if at == middle {
            position.0 = places[middle + 1] + DVec3::new(1e-9, 0.0, 0.0);
        }
    }
    // Pair forces act along the distance and hardly separate particles at the same position, so
    // they are reported.
    assert_eq!(steps_to_divergence(&mut simulation, 50), None);
    let row = simulation.monitor_row();
    assert_eq!(row.close_pairs, 1);
    let closest = row.closest_pair.expect("the closest pair");
    // The pair is carried along by less than a spacing in these steps.
    assert!(closest.distance < 1e-3 * simulation.scene().spacing, "{closest:?}");
    assert!((closest.position - places[middle + 1]).length() < simulation.scene().spacing, "{closest:?}");
}
