//! Fluid at rest: a uniform fluid stays uniform, and water under gravity carries its weight.

use sphecs::Simulation;
use sphecs::bevy_ecs::entity::Entity;
use sphecs::bevy_ecs::query::{With, Without};
use sphecs::glam::DVec3;
use sphecs_engine::arrays::Arrays;
use sphecs_engine::components::{Fluid, ParticleId, Position, Reservoir, Thermodynamics, Velocity};

use crate::{advance, flow, smoke};

/// Shipped scenes that start at rest between walls along the axes.
const AT_REST: [&str; 7] = [
    "constricted_r1.ron",
    "constricted_r2.ron",
    "constricted_r3.ron",
    "duct3d.ron",
    "poiseuille.ron",
    "poiseuille_periodic.ron",
    "quickstart.ron",
];

/// Returns the largest |p|, Pa, and the largest speed, m/s, of all particles outside the reservoir,
/// with the position of that pressure.
fn extremes(simulation: &mut Simulation) -> (f64, f64, DVec3) {
    let world = simulation.world_mut();
    let mut query = world.query_filtered::<(&Position, &Thermodynamics, &Velocity), Without<Reservoir>>();
    let mut found = (0.0, 0.0, DVec3::ZERO);
    for (position, thermodynamics, velocity) in query.iter(world) {
        found.1 = f64::max(found.1, velocity.0.length());
        let pressure = thermodynamics.pressure.abs();
        if pressure > found.0 {
            found = (pressure, found.1, position.0);
        }
    }
    found
}

/// Every neighbour sum is that of the lattice, so that only rounding errors are left: some 1e-14 of
/// ρ0 c0² in the pressure (measured up to 2.7e-14), and speeds of that size over c0.
#[track_caller]
fn check(name: &str) {
    let mut still = Vec::new();
    if name.starts_with("poiseuille") {
        still.push(("body_force", "(0.0, 0.0)"));
    }
    if name != "poiseuille_periodic.ron" {
        still.push(("inlets.0.velocity", "Normal(0.0)"));
        still.push(("reference", "(velocity: 1.0e-3)"));
    }
    let mut simulation = smoke(name, &still);
    let fluid = simulation.scene().fluid;
    let scale = fluid.density * fluid.sound_speed.powi(2);
    for steps in [0, 20] {
        advance(&mut simulation, steps);
        let (pressure, speed, at) = extremes(&mut simulation);
        assert!(pressure < 1e-10 * scale, "{name}, {steps} steps: {} ρ0 c0² at {at} m", pressure / scale);
        assert!(speed < 1e-10 * fluid.sound_speed, "{name}, {steps} steps: {speed} m/s");
    }
}

#[test]
fn uniform_fluid_stays_at_rest_without_pressure() {
    for name in AT_REST {
        check(name);
    }
}

/// Closed box filled completely; viscosity damps the acoustic waves of its settling within a second
/// or two.
pub(crate) const BOX: &str = r#"Scene(
    title: "Closed box under gravity", dimensions: 2, spacing: 0.05, smoke: 0.1,
    fluid: (density: 1000.0, viscosity: 0.1, sound_speed: 10.0),
    domain: Box(min: (-0.5, -0.5), max: (0.5, 0.5)),
    body_force: (0.0, -1.0),
    time: (end: 10.0), output: (every: 0.1), reference: (velocity: 1.0, length: 1.0),
)"#;

/// Hydrostatics on a lattice has the error of the kernel sums (measured 0.25 %: 802.0 Pa). After
/// 8 s the acoustic waves of the settling have decreased to 1e-5 m/s. The mean pressure stays zero
/// as initially, except for the curvature of the equation of state.
#[test]
fn closed_box_carries_the_weight_of_its_water() {
    let mut simulation = flow(BOX, &[]);
    simulation.run_until(8.0).expect("water at rest");
    let heights: Vec<f64> = (0..9).map(|i| -0.4 + 0.1 * f64::from(i)).collect();
    let points: Vec<DVec3> = heights.iter().map(|&y| DVec3::new(0.02, y, 0.0)).collect();
    for (sample, y) in simulation.sample(&points).iter().zip(&heights) {
        let pressure = sample.expect("water").pressure;
        let expected = -1000.0 * y;
        assert!((pressure - expected).abs() < 0.01 * 500.0, "{pressure} Pa at y = {y} m, not {expected} Pa");
    }
    let row = simulation.monitor_row();
    assert!(row.largest_speed < 1e-3, "{} m/s are left", row.largest_speed);
    assert_eq!((row.through_walls, row.close_pairs), (0, 0));
}

/// A particle is shot at a wall in water at rest: it stops at the surface and keeps its velocity
/// along it.
#[test]
fn particle_shot_at_a_wall_stays_in_front_of_it() {
    let mut simulation = smoke(
        "constricted_r2.ron",
        &[("inlets.0.velocity", "Normal(0.0)"), ("reference", "(velocity: 1.0e-3)")],
    );
    let spacing = simulation.scene().spacing;
    let in_front = |simulation: &Simulation, at: DVec3| -simulation.scene().container.signed_distance(at);
    let world = simulation.world_mut();
    let mut query = world.query_filtered::<(Entity, &Position), With<Fluid>>();
    let middle = |at: DVec3| (at - DVec3::new(-0.1, 0.0444, 0.0)).length();
    let nearest = query.iter(world).min_by(|a, b| middle(a.1.0).total_cmp(&middle(b.1.0)));
    let (shot, at) = nearest.map(|(entity, at)| (entity, at.0)).expect("a fluid particle");
    // Half a spacing per step would already be behind the surface, but steps decrease with the
    // speed.
    let (start, velocity) = (at + DVec3::Y * (0.6 * spacing), DVec3::new(0.1, 6.0, 0.0));
    world.entity_mut(shot).insert((Position(start), Velocity(velocity)));
    simulation.step().expect("a step");
    let row = simulation.monitor_row();
    assert_eq!((row.held_at_walls, row.through_walls), (1, 0), "{row:?}");
    let world = simulation.world_mut();
    let [after, now] =
        [world.get::<Position>(shot).map(|at| at.0), world.get::<Velocity>(shot).map(|velocity| velocity.0)]
            .map(|vector| vector.expect("the particle"));
    let id = world.get::<ParticleId>(shot).expect("the particle").0;
    let arrays = world.resource::<Arrays<f64, 2>>();
    let row = arrays.id.iter().position(|&other| other == id).expect("its row");
    let before = arrays.row(row).previous_velocity;
    let depth = in_front(&simulation, after);
    assert!((0.0..1e-3 * spacing).contains(&depth), "{} Δ in front of the wall, from {at}", depth / spacing);
    // It keeps the velocity along the wall of both halves of the kick. The direction of the wall is
    // a quotient of differences, exact except for the last digits.
    assert!(
        now.y.abs() < 1e-9 && before.y.abs() < 1e-9 && (before.x - 0.5 * (now.x + 0.1)).abs() < 1e-12,
        "{now} {before}"
    );
}
