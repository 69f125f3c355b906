//! Inlets with a prescribed mass flow: the scale between profile and speed.
//!
//! ```text
//! v(x, t) = k ṁ(t) f(x),   k = 1/(ρ0 Σ_r f(x_r) A_r)    for a rate, kg/s
//! v(x, t) = k q(t) f(x),   k = A/(ρ0 Σ_r f(x_r) A_r)    for a flux, kg/(s m²)
//! ```
//!
//! The sum runs over the rows of particles that the inlet feeds. A_r = Δ^D/pitch is the
//! cross-section of a row of particles of mass ρ0 Δ^D. So the particles carry exactly the
//! prescribed mass over the plane. The integral of the profile would differ, by 0.13 % for a
//! parabola over 20 rows. The density is the reference density at any pressure, because all
//! particles of a row move at one velocity and keep their pitch.

use glam::DVec3;

use super::checker::Checker;
use crate::expression::Expression;
use crate::faults::Fault;
use crate::fill;
use crate::model::{Fill, InletVelocity, Patch, Scene};
use crate::packing;
use crate::schema::{InletVelocityFile, SceneFile};
use sphecs_core::particles::zone::Zone;

/// Sets the scale of every inlet with a prescribed mass flow.
pub fn set_scales(scene: &mut Scene, file: &SceneFile, check: &mut Checker<'_>) {
    for (index, written) in file.inlets.iter().enumerate() {
        let (is_flux, profile_file) = match &written.velocity.value {
            InletVelocityFile::MassFlow { profile, .. } => (false, profile),
            InletVelocityFile::MassFlux { profile, .. } => (true, profile),
            _ => continue,
        };
        let Some(InletVelocity::MassFlow { profile, .. }) =
            scene.inlets.get(index).map(|inlet| &inlet.velocity)
        else {
            continue;
        };
        let (carried, size) = carried(scene, index, profile);
        let span = profile_file.as_ref().map_or(written.velocity.head, |profile| profile.span);
        // Relative to Σ |f| A, so that a sum that cancels up to rounding counts as zero.
        if !carried.is_finite() || carried <= 1e-9 * size {
            let label =
                format!("has the mean `{}` over the rows of the inlet, must be above 0", carried / size);
            check.report(
                Fault::new("`profile` of an inlet carries nothing into the domain", span, label)
                    .help("`towards` is the direction of the flow; a profile is positive where it flows in"),
            );
            continue;
        }
        let area = scene.inlets[index].patch.area;
        let per = scene.fluid.density * carried;
        if let InletVelocity::MassFlow { scale, .. } = &mut scene.inlets[index].velocity {
            *scale = if is_flux { area / per } else { 1.0 / per };
        }
    }
}

/// Returns Σ f A and Σ |f| A over the rows of an inlet, m² (m in 2D) times the unit of the profile.
fn carried(scene: &Scene, index: usize, profile: &Expression) -> (f64, f64) {
    let patch = &scene.inlets[index].patch;
    let mut sums = (0.0, 0.0);
    let mut add = |point: DVec3, area: f64| {
        let point = point - patch.towards * patch.along(point);
        let shape = profile.value(point.x, point.y, point.z, 0.0);
        sums.0 += shape * area;
        sums.1 += shape.abs() * area;
    };
    if let Fill::Packed(lattice) = &scene.layout.fill {
        for (foot, area) in packing::inlet_columns(scene, lattice, index) {
            add(foot, area);
        }
    } else if scene.layout.fill.is_oblique(patch.towards) {
        rows_along(patch, scene, &mut add);
    } else {
        // In rows of the lattice each particle represents the cross-section of its row times its
        // share of the length.
        let share = scene.discretisation.cell_volume() / patch.depth;
        for place in fill::places(scene) {
            if place.zone == Zone::Inflow && usize::from(place.patch) == index {
                add(place.position, share);
            }
        }
    }
    sums
}

/// Calls `add` with the rows that fill an oblique zone and their cross-sections; see
/// `boundary/inlet/injection.rs`.
fn rows_along(patch: &Patch, scene: &Scene, add: &mut impl FnMut(DVec3, f64)) {
    let cells = [0, 1].map(|side| {
        let extent = 2.0 * patch.half_extent[side];
        let is_there = patch.across[side] != DVec3::ZERO && extent > 0.0;
        if is_there { (extent / scene.spacing).round().max(1.0) as usize } else { 1 }
    });
    let middle = |side: usize, cell: usize| {
        let width = 2.0 * patch.half_extent[side] / cells[side] as f64;
        patch.across[side] * ((cell as f64 + 0.5) * width - patch.half_extent[side])
    };
    let mut area = 1.0;
    for side in 0..scene.dimensions - 1 {
        area *= 2.0 * patch.half_extent[side] / cells[side] as f64;
    }
    for first in 0..cells[0] {
        for second in 0..cells[1] {
            let point = patch.at + middle(0, first) + middle(1, second);
            // The point is moved just inside the domain, whose surface is the plane.
            let inside = point + patch.towards * (1e-3 * scene.spacing);
            if patch.covers(inside, 0.0) && scene.domain.contains(inside, 0.0) {
                add(point, area);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::model::Scene;
    use crate::spawn::seeds;
    use sphecs_core::particles::zone::Zone;

    fn scene(text: &str, velocity: &str) -> Scene {
        let set = [("inlets.0.velocity", velocity)];
        Scene::from_text("mass_flow", text).sets(set).load().unwrap_or_else(|faults| panic!("{faults:?}"))
    }

    /// Returns the mass flow of the particles of the zone through the plane at a time (s), kg/s.
    fn carried(scene: &Scene, time: f64) -> f64 {
        let inlet = &scene.inlets[0];
        let mass = scene.discretisation.mass;
        let inflow = seeds(scene).into_iter().filter(|seed| seed.zone == Zone::Inflow);
        let speed = |at| inlet.velocity_at(0.0, at, time).dot(inlet.patch.towards);
        inflow.map(|seed| mass * speed(seed.position) / inlet.patch.depth).sum()
    }

    const CHANNEL: &str = r#"Scene(
        title: "Channel with a mass flow", dimensions: 2, spacing: 0.02, smoke: 0.04,
        fluid: (density: 900.0, viscosity: 1.0e-2, sound_speed: 20.0),
        domain: Box(min: (0.0, 0.0), max: (0.4, 0.413)),
        inlets: [(at: (0.0, 0.2), towards: (1.0, 0.0), velocity: Normal(1.0))],
        outlets: [(at: (0.4, 0.2), towards: (1.0, 0.0), condition: WaveEquation())],
        time: (end: 2.0), output: (every: 0.1),
    )"#;

    const PIPE: &str = r#"Scene(
        title: "Pipe with a mass flow", dimensions: 3, spacing: 0.02, smoke: 0.04,
        fluid: (density: 900.0, viscosity: 1.0e-2, sound_speed: 20.0),
        domain: Cylinder(from: (0.0, 0.0, 0.0), to: (0.4, 0.0, 0.0), radius: 0.11),
        inlets: [(at: (0.0, 0.0, 0.0), towards: (1.0, 0.0, 0.0), velocity: Normal(1.0))],
        outlets: [(at: (0.4, 0.0, 0.0), towards: (1.0, 0.0, 0.0), condition: WaveEquation())],
        time: (end: 2.0), output: (every: 0.1),
    )"#;

    #[test]
    fn particles_of_an_inlet_carry_the_prescribed_mass_flow() {
        // Cases: a width that is not a multiple of the spacing, and a round section on a square
        // lattice.
        for (text, profile) in [(CHANNEL, "y*(0.413 - y)"), (PIPE, "0.0121 - y^2 - z^2"), (PIPE, "1 + 3*y")] {
            let ramped = scene(text, &format!("MassFlow(rate: \"30*t\", profile: \"{profile}\")"));
            assert!(
                (carried(&ramped, 1.5) / 45.0 - 1.0).abs() < 1e-12,
                "{profile}: {}",
                carried(&ramped, 1.5)
            );
            let flux = scene(text, &format!("MassFlux(flux: 200.0, profile: \"{profile}\")"));
            let expected = 200.0 * flux.inlets[0].patch.area;
            assert!((carried(&flux, 0.0) / expected - 1.0).abs() < 1e-12, "{profile}");
            assert!(flux.reference_velocity > 0.1 && flux.reference_velocity < 2.0);
        }
    }

    #[test]
    fn uniform_flux_over_an_oblique_inlet_gives_a_uniform_speed() {
        let turned = CHANNEL
            .replace("domain:", "fill: Lattice(angle: 0.0), domain:")
            .replace("Box(min: (0.0, 0.0), max: (0.4, 0.413))", "Rotated(angle: 20, shape: Box(min: (0.0, 0.0), max: (0.4, 0.413)))")
            .replace("(at: (0.0, 0.2), towards: (1.0, 0.0)", "(at: (\"-0.2*sin(pi/9)\", \"0.2*cos(pi/9)\"), towards: (\"cos(pi/9)\", \"sin(pi/9)\")")
            .replace("(at: (0.4, 0.2), towards: (1.0, 0.0)", "(at: (\"0.4*cos(pi/9) - 0.2*sin(pi/9)\", \"0.4*sin(pi/9) + 0.2*cos(pi/9)\"), towards: (\"cos(pi/9)\", \"sin(pi/9)\")");
        let scene = scene(&turned, "MassFlux(flux: 450.0)");
        let inlet = &scene.inlets[0];
        assert!(scene.layout.fill.is_oblique(inlet.patch.towards));
        let speed = inlet.velocity_at(0.0, inlet.patch.at, 0.0).dot(inlet.patch.towards);
        assert!((speed - 0.5).abs() < 1e-4, "{speed} m/s");
    }
}
