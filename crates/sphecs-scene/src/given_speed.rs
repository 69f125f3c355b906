//! Largest speeds that a scene prescribes, before it runs.
//!
//! Inlets, walls and forces are sampled in space over their section or surface, and in time at
//! [`sampled_times`](super::sampled_times) with the largest of them improved.

use glam::DVec3;

use super::driven_flow::driven_speed;
use super::expression::Expression;
use super::model::{BodyForce, Emitter, Inlet, InletVelocity, Scene};
use super::sampled_times::largest_in_time;
use sphecs_core::physics::wall::Slip;

/// Returns the largest speed that inlets, walls, initial fields and driving forces prescribe, m/s.
pub fn largest_given_speed(scene: &Scene) -> f64 {
    let inlets = scene.inlets.iter().map(|inlet| inlet_speed(inlet, scene)).fold(0.0, f64::max);
    let emitters = scene.emitters.iter().map(|emitter| emitter_speed(emitter, scene)).fold(0.0, f64::max);
    let moved = initial_speed(scene).max(wall_speed(scene)).max(scene.largest_wall_speed());
    // In the lab the fluid of an emitter that moves has the speed of its wall, too.
    let inlets = inlets.max(emitters + if emitters > 0.0 { scene.largest_wall_speed() } else { 0.0 });
    inlets.max(moved).max(forced_speed(scene)).max(driven_speed(scene))
}

/// Returns the largest speed that an inlet prescribes during a run, m/s.
pub fn inlet_speed(inlet: &Inlet, scene: &Scene) -> f64 {
    let places = section_grid(inlet, scene.dimensions);
    match &inlet.velocity {
        InletVelocity::ProfileTable { speeds, .. } => {
            speeds.iter().flatten().map(|speed| speed.abs()).fold(0.0, f64::max)
        }
        InletVelocity::PoiseuilleStartup { half_width, body_force } => {
            steady_poiseuille(*body_force, *half_width, scene.fluid.viscosity)
        }
        InletVelocity::TimeTable(rows) => {
            let during = rows.iter().filter(|row| row.0 >= 0.0 && row.0 <= scene.time.end);
            let at_knots = during.map(|row| row.1.abs()).fold(0.0, f64::max);
            let at_ends =
                [0.0, scene.time.end].map(|time| inlet.velocity_at(0.0, inlet.patch.at, time).length());
            at_ends.into_iter().fold(at_knots, f64::max)
        }
        InletVelocity::Normal(speed) => largest(&places, std::slice::from_ref(speed), scene.time.end),
        InletVelocity::Components(components) => largest(&places, components, scene.time.end),
        InletVelocity::MassFlow { rate, profile, scale } => {
            let flow = largest(&[DVec3::ZERO], std::slice::from_ref(rate), scene.time.end);
            flow * scale.abs() * largest(&places, std::slice::from_ref(profile), 0.0)
        }
    }
}

/// Returns the largest speed relative to its surface that an emitter prescribes during a run, m/s.
pub fn emitter_speed(emitter: &Emitter, scene: &Scene) -> f64 {
    let at = |time: f64| {
        let speeds = emitter.columns.iter().map(|column| emitter.speed(column, time).abs());
        speeds.fold(0.0, f64::max)
    };
    if emitter.velocity.is_unsteady() { largest_in_time(scene.time.end, at) } else { at(0.0) }
}

/// Returns the largest length of a vector of expressions at some places (m) during a run to `end`,
/// s; infinite if it is not finite at one of them.
fn largest(places: &[DVec3], components: &[Expression], end: f64) -> f64 {
    let at = |time: f64| {
        let lengths = places.iter().map(|p| {
            let squares = components.iter().map(|component| component.value(p.x, p.y, p.z, time).powi(2));
            squares.sum::<f64>().sqrt()
        });
        lengths.map(|length| if length.is_finite() { length } else { f64::INFINITY }).fold(0.0, f64::max)
    };
    let varies = components.iter().any(|component| component.depends_on(&[TIME]));
    if varies { largest_in_time(end, at) } else { at(0.0) }
}

/// Place of the time among the variables of an expression.
const TIME: usize = 3;

/// Returns points of a regular grid over the section of an inlet, with its centre and its edges, m.
fn section_grid(inlet: &Inlet, dimensions: usize) -> Vec<DVec3> {
    let patch = &inlet.patch;
    let offset =
        |index: i32, axis: usize| f64::from(index) / 10.0 * patch.half_extent[axis] * patch.across[axis];
    let second = if dimensions == 3 { -10..=10 } else { 0..=0 };
    let points = (-10..=10)
        .flat_map(|one| second.clone().map(move |two| (one, two)))
        .map(|(one, two)| patch.at + offset(one, 0) + offset(two, 1));
    points.filter(|point| patch.covers(*point, 0.0)).collect()
}

/// Returns the peak velocity of plane Poiseuille flow, g H²/2ν, m/s.
fn steady_poiseuille(force: f64, half_width: f64, viscosity: f64) -> f64 {
    if viscosity > 0.0 { force.abs() * half_width * half_width / (2.0 * viscosity) } else { 0.0 }
}

/// Returns the speed that a constant body force reaches between plates without inlets, m/s. Between
/// walls that slip it has no limit, and none is known.
fn forced_speed(scene: &Scene) -> f64 {
    let brakes = scene.layout.walled && scene.walls.parts.iter().all(|part| part.slip == Slip::NoSlip);
    match &scene.body_force {
        BodyForce::Constant(force) if scene.inlets.is_empty() && brakes => {
            let half_width = 0.5 * scene.reference_length;
            steady_poiseuille(force.length(), half_width, scene.fluid.viscosity)
        }
        _ => 0.0,
    }
}

/// Returns points of a regular grid over the bounds of the domain, m, with the size of a cell, m.
fn domain_grid(scene: &Scene) -> (Vec<DVec3>, f64) {
    let (low, high) = scene.domain.bounds();
    let count: i32 = if scene.dimensions == 2 { 32 } else { 12 };
    let point = |index: i32| {
        let share = |place: i32| (f64::from(index / place % count) + 0.5) / f64::from(count);
        let mut at = DVec3::ZERO;
        for (axis, place) in [1, count, count * count].into_iter().enumerate().take(scene.dimensions) {
            at[axis] = low[axis] + share(place) * (high[axis] - low[axis]);
        }
        at
    };
    let cell = (high - low).max_element() / f64::from(count);
    ((0..count.pow(scene.dimensions as u32)).map(point).collect(), cell)
}

fn initial_speed(scene: &Scene) -> f64 {
    let (points, _) = domain_grid(scene);
    let within: Vec<DVec3> = points.into_iter().filter(|at| scene.domain.contains(*at, 0.0)).collect();
    largest(&within, &scene.initial.velocity, 0.0)
}

/// Returns the largest speed of a wall that moves along itself, m/s, at points of the surface next
/// to those of a grid.
fn wall_speed(scene: &Scene) -> f64 {
    if !scene.layout.walled || !scene.walls.parts.iter().any(|part| part.moves()) {
        return 0.0;
    }
    let (points, cell) = domain_grid(scene);
    let near = points.into_iter().filter(|at| scene.domain.signed_distance(*at).abs() < 2.0 * cell);
    let surface: Vec<DVec3> =
        near.map(|at| scene.domain.nearest_surface(at, 0.5 * scene.spacing, scene.dimensions)).collect();
    let of_part = |index: usize| -> Vec<DVec3> {
        let region = index.checked_sub(1).and_then(|region| scene.layout.wall_regions.get(region));
        let touches = |at: &DVec3| region.is_none_or(|region| region.contains(*at, 1e-3 * scene.spacing));
        surface.iter().copied().filter(touches).collect()
    };
    let parts = scene.walls.parts.iter().enumerate().filter(|(_, part)| part.moves());
    parts.map(|(index, part)| largest(&of_part(index), &part.velocity, scene.time.end)).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene_with(inlet: &str, walls: &str) -> Scene {
        let text = format!(
            r#"Scene(
    title: "Given", dimensions: 2, spacing: 0.002,
    fluid: (density: 1000.0, viscosity: 1e-5, sound_speed: 20.0),
    domain: Box(min: (0.0, 0.0), max: (0.1, 0.04)),
    inlets: [(at: (0.0, 0.02), towards: (1.0, 0.0), velocity: {inlet})],
    outlets: [(at: (0.1, 0.02), towards: (1.0, 0.0))],
    {walls}
    time: (end: 2.0), output: (every: 0.5),
)"#
        );
        Scene::from_text("given", text).load().expect("a scene")
    }

    /// At the times 0, 0.1, 0.2, … s this flow is zero.
    #[test]
    fn peak_of_a_pulsating_inlet_is_its_speed() {
        let scene = scene_with(r#"Normal("0.2*sin(2*pi*10*t)")"#, "");
        assert!((scene.reference_velocity - 0.2).abs() < 1e-9, "{}", scene.reference_velocity);
        let scene = scene_with(r#"MassFlow(rate: "8*sin(2*pi*250*t)")"#, "");
        assert!((scene.reference_velocity - 0.2).abs() < 1e-6, "{}", scene.reference_velocity);
    }

    #[test]
    fn table_counts_as_far_as_the_run_goes() {
        let scene = scene_with("TimeTable(rows: [(0.0, 0.1), (1.0, -0.3), (3.0, 0.9)])", "");
        assert!((scene.reference_velocity - 0.3).abs() < 1e-12, "{}", scene.reference_velocity);
    }

    #[test]
    fn moving_wall_counts() {
        let parts = r#"walls: (parts: [(name: "lid", region: Box(min: (-1.0, 0.03), max: (1.0, 1.0)), velocity: ("0.7*sin(2*pi*10*t)", 0.0))]),"#;
        let scene = scene_with("Normal(0.1)", parts);
        assert!((scene.reference_velocity - 0.7).abs() < 1e-9, "{}", scene.reference_velocity);
    }
}
