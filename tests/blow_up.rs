//! An impossible state stops a run in the step in which it appears, and says where.

use std::path::Path;

use sphecs::bevy_ecs::query::With;
use sphecs::components::{Fluid, Inflow, Outflow, Position, Thermodynamics, Velocity, Wall};
use sphecs::glam::DVec3;
use sphecs::particles::zone::Zone;
use sphecs::resources::clock::Clock;
use sphecs::scene::load_smoke;
use sphecs::simulation::{Simulation, Stop};
use sphecs::systems::divergence::check_state;

/// A channel with an inlet, an outlet and walls.
fn start(sets: &[(&str, &str)]) -> Simulation {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/quickstart.ron");
    let sets: Vec<(String, String)> =
        sets.iter().map(|(path, value)| ((*path).into(), (*value).into())).collect();
    Simulation::from_scene(load_smoke(&path, &sets).expect("a scene"))
}

/// The same after some steps.
fn channel(sets: &[(&str, &str)]) -> Simulation {
    let mut simulation = start(sets);
    for _ in 0..12 {
        simulation.step().expect("a sound flow");
    }
    simulation
}

const EDAC: &[(&str, &str)] = &[("scheme", "EdacTvf()")];

/// A field that is spoilt.
#[derive(Clone, Copy, Debug)]
enum Spoilt {
    Position,
    Velocity,
    Density,
    Pressure,
}

/// Puts a NaN into a field of the first particle of a zone.
fn spoil(simulation: &mut Simulation, zone: Zone, field: Spoilt) {
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
        Spoilt::Position => position.0.y = f64::NAN,
        Spoilt::Velocity => velocity.0.x = f64::NAN,
        Spoilt::Density => thermodynamics.density = f64::NAN,
        Spoilt::Pressure => thermodynamics.pressure = f64::NAN,
    }
}

#[track_caller]
fn is_caught_at_once(sets: &[(&str, &str)], zone: Zone, field: Spoilt) {
    let mut simulation = channel(sets);
    let before = simulation.clock().step;
    spoil(&mut simulation, zone, field);
    let stop = simulation.step().expect_err("an impossible state");
    let Stop::BlowUp { step, .. } = stop else { panic!("{stop}") };
    // A position that is nowhere is found by the sort, before the step is counted.
    assert!(step - before <= 1, "{field:?} of {zone:?}: found {} steps later", step - before);
    let fault = simulation.fault().expect("a fault").clone();
    assert!(fault.neighbourhood.middle.is_finite());
    assert!(fault.neighbourhood.particle(fault.id).is_some(), "{fault:?}");
    assert!(fault.neighbourhood.particles.len() > 20, "{} around it", fault.neighbourhood.particles.len());
}

#[test]
fn what_is_not_finite_is_caught_in_the_step_it_appears() {
    for zone in [Zone::Fluid, Zone::Inflow, Zone::Outflow, Zone::Wall] {
        is_caught_at_once(&[], zone, Spoilt::Position);
        is_caught_at_once(EDAC, zone, Spoilt::Position);
    }
    for zone in [Zone::Fluid, Zone::Outflow] {
        is_caught_at_once(&[], zone, Spoilt::Velocity);
        is_caught_at_once(EDAC, zone, Spoilt::Velocity);
    }
    is_caught_at_once(EDAC, Zone::Fluid, Spoilt::Pressure);
}

/// What a scheme finds anew at every step cannot be spoilt.
#[test]
fn what_is_found_anew_heals() {
    let healed: [(&[(&str, &str)], Zone, Spoilt); 4] = [
        (&[], Zone::Fluid, Spoilt::Density),
        (&[], Zone::Fluid, Spoilt::Pressure),
        (EDAC, Zone::Fluid, Spoilt::Density),
        (&[], Zone::Inflow, Spoilt::Velocity),
    ];
    for (sets, zone, field) in healed {
        let (mut spoilt, mut sound) = (channel(sets), channel(sets));
        // Both start the step from their components.
        sound.world_mut();
        spoil(&mut spoilt, zone, field);
        for simulation in [&mut spoilt, &mut sound] {
            simulation.step().expect("a sound flow");
        }
        assert_eq!(spoilt.monitor_row(), sound.monitor_row(), "{field:?} of {zone:?}");
    }
}

/// Steps until the flow blows up, at most `most`, and checks that no state between was not finite.
fn steps_to_blow_up(simulation: &mut Simulation, most: usize) -> Option<usize> {
    for done in 0..most {
        let stepped = simulation.step();
        if let Err(stop) = stepped {
            assert!(matches!(stop, Stop::BlowUp { .. }), "{stop}");
            assert!(simulation.fault().is_some_and(|fault| !fault.neighbourhood.particles.is_empty()));
            return Some(done);
        }
        let row = simulation.monitor_row();
        assert!(row.kinetic_energy.is_finite() && row.mean_pressure.is_finite(), "{row:?}");
    }
    None
}

#[test]
fn sound_slower_than_the_flow_blows_up_with_a_report() {
    for scheme in ["Wcsph()", "EdacTvf()"] {
        // The inlet is just slower than sound, as a scene must have it; a force makes the flow faster.
        let mut simulation =
            start(&[("scheme", scheme), ("fluid.sound_speed", "0.11"), ("body_force", "(50.0, 0.0)")]);
        assert!(steps_to_blow_up(&mut simulation, 400).is_some(), "{scheme}");
    }
}

#[test]
fn the_longest_steps_that_a_scene_may_have_pass_nothing_that_is_not_finite() {
    for scheme in ["Wcsph()", "Wcsph(integrator: Verlet())", "EdacTvf()"] {
        let mut simulation = start(&[("scheme", scheme), ("time.cfl", "1.0")]);
        assert_eq!(steps_to_blow_up(&mut simulation, 200), None, "{scheme}");
    }
}

#[test]
fn an_acceleration_beyond_all_bounds_is_caught_in_its_first_step() {
    let mut simulation = start(&[("body_force", "(1e12, 0.0)")]);
    assert_eq!(steps_to_blow_up(&mut simulation, 1), Some(0));
    // The shortest step that it may force gives speeds beyond theirs.
    let fault = simulation.fault().expect("a fault");
    assert!(fault.found.starts_with("speed"), "{}", fault.found);
}

/// What makes steps so short without making anything fast comes from outside: an added force that walls hold against, say.
#[test]
fn a_step_below_its_floor_is_caught() {
    let mut simulation = channel(&[]);
    let world = simulation.world_mut();
    world.resource_mut::<Clock>().time_step *= 1e-4;
    world.run_system_cached(check_state::<f64, 2>).expect("its resources are there");
    let fault = simulation.fault().expect("a fault");
    assert!(fault.found.starts_with("time step"), "{}", fault.found);
}

#[test]
fn particles_that_overlap_are_counted() {
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
    // Forces part a pair along its distance, so hardly when there is none: it is for the user to see.
    assert_eq!(steps_to_blow_up(&mut simulation, 50), None);
    assert_eq!(simulation.monitor_row().close_pairs, 1);
}
