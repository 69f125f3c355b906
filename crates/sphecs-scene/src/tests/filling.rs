//! Positions and zones of the initial particles.

use glam::DVec3;

use super::shipped::{scene, smoke};
use crate::fill::beyond;
use crate::model::{ParticleSeed, Scene};
use crate::{seeds, summary};
use sphecs_core::particles::zone::Zone;

fn of(seeds: &[ParticleSeed], zone: Zone) -> Vec<ParticleSeed> {
    seeds.iter().filter(|s| s.zone == zone).copied().collect()
}

/// Returns a straight channel, 1 m long and 0.4 m wide, with additional fields.
fn channel(extra: &str) -> Scene {
    let text = format!(
        "Scene(title: \"t\", dimensions: 2, spacing: 0.05, smoke: 0.1,
            fluid: (density: 1000.0, viscosity: 1.0e-3, sound_speed: 10.0),
            domain: Box(min: (0.0, 0.0), max: (1.0, 0.4)), {extra}
            time: (end: 1.0), output: (every: 0.1))"
    );
    match Scene::from_text("channel", &text).load() {
        Ok(scene) => scene,
        Err(faults) => panic!("{:?}", miette::Report::new(faults)),
    }
}

const OPENINGS: &str = "inlets: [(at: (0.0, 0.2), towards: (1.0, 0.0), velocity: Normal(1.0))],
    outlets: [(at: (1.0, 0.2), towards: (1.0, 0.0), condition: WaveEquation())],";

/// Returns the distances of the neighbours in the support, sorted, in 1e-9 spacings. They are equal
/// for all particles of a uniform fill.
fn neighbourhood(scene: &Scene, seeds: &[ParticleSeed], index: usize, support: f64) -> Vec<i64> {
    let here = seeds[index].position;
    let mut found = Vec::new();
    for seed in seeds.iter().filter(|seed| seed.zone != Zone::Reservoir) {
        let mut offset = seed.position - here;
        for axis in 0..3 {
            if let Some((low, high)) = scene.periodic[axis] {
                let period = high - low;
                offset[axis] -= period * (offset[axis] / period).round();
            }
        }
        let distance = offset.length();
        if distance < support * (1.0 - 1e-6) {
            found.push((distance / scene.spacing * 1e8).round() as i64);
        }
    }
    found.sort_unstable();
    found
}

/// Checks that all fluid particles have the same neighbours, so that a fluid at rest has a uniform
/// density. Particles near rings in a wall are left out, since rings are not a lattice.
fn check_uniform(scene: &Scene) {
    let seeds = seeds(scene);
    let scheme = &scene.scheme;
    let support = scheme.support(scene.spacing);
    let sees_rings = |place: DVec3| {
        scene.layout.rings.iter().any(|rings| place.distance(rings.centre) < rings.radius + support)
    };
    // So are those near walls in layers and near columns of emitters.
    let layered = |seed: &&ParticleSeed| match seed.zone {
        Zone::Wall => scene.layout.layered.contains(&seed.patch),
        Zone::Inflow => scene.emitter(seed.patch).is_some(),
        _ => false,
    };
    let layers: Vec<DVec3> = seeds.iter().filter(layered).map(|seed| seed.position).collect();
    let sees_layers = |place: DVec3| layers.iter().any(|wall| wall.distance(place) < support + scene.spacing);
    let fluid: Vec<usize> = (0..seeds.len())
        .filter(|i| seeds[*i].zone == Zone::Fluid && !sees_rings(seeds[*i].position))
        .collect();
    let step = (fluid.len() / 1500).max(1);
    let fluid: Vec<usize> =
        fluid.into_iter().step_by(step).filter(|i| !sees_layers(seeds[*i].position)).collect();
    let Some(&middle) = fluid.get(fluid.len() / 2) else { return };
    let expected = neighbourhood(scene, &seeds, middle, support);
    for index in fluid {
        let found = neighbourhood(scene, &seeds, index, support);
        let same =
            found.len() == expected.len() && found.iter().zip(&expected).all(|(a, b)| (a - b).abs() <= 2);
        assert!(
            same,
            "{}: {} has {} neighbours, must have {}",
            scene.name,
            seeds[index].position,
            found.len(),
            expected.len()
        );
    }
}

#[test]
fn a_fluid_at_rest_is_uniform_in_every_shipped_scene() {
    for name in super::shipped::names() {
        check_uniform(&smoke(&name));
    }
}

#[test]
fn channel_has_one_particle_per_cell() {
    let scene = channel(OPENINGS);
    let seeds = seeds(&scene);
    // There are 20 × 8 cells, and five and eight columns of eight in the zones; the reservoir holds
    // as many as the inflow zone.
    let counts = Zone::ALL.map(|zone| of(&seeds, zone).len());
    assert_eq!(counts, [160, counts[1], 40, 64, 40]);
    let walls = of(&seeds, Zone::Wall);
    // With h = 1.5 Δ the support is 3 Δ: three layers on each side, along domain and zones.
    assert_eq!(walls.len(), 2 * 3 * (20 + 5 + 8));
}

#[test]
fn half_a_spacing_lies_between_fluid_and_straight_walls() {
    for name in ["quickstart.ron", "poiseuille.ron", "duct3d.ron"] {
        let scene = scene(name);
        let half = 0.5 * scene.spacing;
        let seeds = seeds(&scene);
        let nearest =
            of(&seeds, Zone::Wall).iter().map(|seed| seed.wall_distance).fold(f64::INFINITY, f64::min);
        assert!((nearest - half).abs() < 1e-9 * half.max(1e-3), "{name}: {nearest}");
        for seed in of(&seeds, Zone::Fluid) {
            assert!(scene.domain.contains(seed.position, 1e-9 * half), "{name}: {}", seed.position);
        }
    }
}

#[test]
fn misfit_of_a_width_is_shared_by_both_walls() {
    let scene = scene("constricted_r2.ron");
    let seeds = seeds(&scene);
    let mut throat: Vec<f64> = of(&seeds, Zone::Fluid)
        .iter()
        .filter(|seed| (seed.position.x - 0.0389).abs() < 0.03)
        .map(|seed| seed.position.y)
        .collect();
    throat.sort_by(f64::total_cmp);
    throat.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
    assert_eq!(throat.len(), 14);
    assert!((throat[0] + throat[13]).abs() < 1e-12, "rows are symmetric about the axis");
}

#[test]
fn walls_surround_the_flow_except_at_openings() {
    let scene = channel(OPENINGS);
    let seeds = seeds(&scene);
    for seed in of(&seeds, Zone::Wall) {
        let p = seed.position;
        assert!(p.y < 0.0 || p.y > 0.4, "{p} is in an opening");
        assert!(p.x > -0.25 && p.x < 1.4, "{p} is behind a zone");
        let surface = if p.y < 0.0 { 0.0 } else { 0.4 };
        assert!((seed.wall_distance - (p.y - surface).abs()).abs() < 1e-12);
        assert_eq!(seed.wall_normal, DVec3::Y * (surface - p.y).signum());
    }
    for (zone, patch, is_inlet) in
        [(Zone::Inflow, &scene.inlets[0].patch, true), (Zone::Outflow, &scene.outlets[0].patch, false)]
    {
        for seed in of(&seeds, zone) {
            let beyond = beyond(patch, is_inlet, seed.position);
            assert!(beyond > 0.0 && beyond < patch.depth && patch.covers(seed.position, 0.0));
        }
    }
}

#[test]
fn closed_box_has_walls_on_all_sides() {
    let scene = channel("");
    let seeds = seeds(&scene);
    let corner = of(&seeds, Zone::Wall)
        .into_iter()
        .find(|seed| seed.position.distance(DVec3::new(-0.025, -0.025, 0.0)) < 1e-9);
    let corner = corner.map(|seed| (seed.wall_distance, seed.wall_normal));
    let (distance, normal) = corner.unwrap_or_default();
    // Behind a corner the nearest surface point is the corner itself.
    assert!((distance - 0.025 * std::f64::consts::SQRT_2).abs() < 1e-9);
    assert!(normal.distance(DVec3::new(1.0, 1.0, 0.0).normalize()) < 1e-6);
}

#[test]
fn wall_parts_cover_the_surface_in_their_region() {
    let scene = channel(
        "walls: (slip: NoSlip, parts: [(name: \"lid\", region: Box(min: (-1.0, 0.3), max: (2.0, 1.0)),
            slip: FreeSlip, velocity: (1.0, 0.0))]),",
    );
    for seed in of(&seeds(&scene), Zone::Wall) {
        let surface = seed.position + seed.wall_distance * seed.wall_normal;
        assert_eq!(seed.patch, u16::from(surface.y > 0.3 - 1e-3 * scene.spacing), "{}", seed.position);
        assert_eq!(seed.velocity.x, f64::from(seed.patch));
    }
}

#[test]
fn rotated_channel_has_as_many_particles_as_an_aligned_one() {
    let text = "Scene(title: \"t\", dimensions: 2, spacing: 0.05, smoke: 0.1,
        fluid: (density: 1000.0, viscosity: 1.0e-3, sound_speed: 10.0),
        constants: {\"c\": \"cos(pi/6)\", \"s\": \"sin(pi/6)\"},
        domain: Rotated(angle: 30.0, shape: Box(min: (0.0, -0.2), max: (1.0, 0.2))),
        inlets: [(at: (0.0, 0.0), towards: (\"c\", \"s\"), velocity: Normal(1.0))],
        outlets: [(at: (\"c\", \"s\"), towards: (\"c\", \"s\"), condition: Orlanski())],
        time: (end: 1.0), output: (every: 0.1))";
    let scene = match Scene::from_text("turned", text).load() {
        Ok(scene) => scene,
        Err(faults) => panic!("{:?}", miette::Report::new(faults)),
    };
    assert!((scene.inlets[0].patch.area - 0.4).abs() < 1e-9);
    check_uniform(&scene);
    let seeds = seeds(&scene);
    let expected = 0.4 / (0.05 * 0.05);
    let found = of(&seeds, Zone::Fluid).len() as f64;
    // Points at least Δ/4 inside a wall are kept, so at most a quarter of the rows at walls is
    // missing.
    assert!((found / expected - 1.0).abs() < 0.08, "{found} of {expected}");
}

#[test]
fn round_pipes_have_round_sections() {
    let text = "Scene(title: \"t\", dimensions: 3, spacing: 0.1, smoke: 0.1,
        fluid: (density: 1000.0, viscosity: 1.0e-3, sound_speed: 10.0),
        domain: Cylinder(from: (0.0, 0.0, 0.0), to: (2.0, 0.0, 0.0), radius: 0.5),
        inlets: [(at: (0.0, 0.1, 0.1), towards: (1.0, 0.0, 0.0), velocity: Normal(1.0))],
        outlets: [(at: (2.0, 0.0, 0.0), towards: (1.0, 0.0, 0.0), condition: WaveEquation())],
        time: (end: 1.0), output: (every: 0.1))";
    let scene = match Scene::from_text("pipe", text).load() {
        Ok(scene) => scene,
        Err(faults) => panic!("{:?}", miette::Report::new(faults)),
    };
    let patch = &scene.inlets[0].patch;
    assert!(patch.at.length() < 1e-6, "centred at {}", patch.at);
    assert!((patch.area / (std::f64::consts::PI * 0.25) - 1.0).abs() < 1e-6, "{}", patch.area);
    check_uniform(&scene);
}

#[test]
fn wall_fitted_rows_give_every_particle_the_same_area() {
    let scene = match Scene::from_file(super::shipped::path("inclined_plates.ron"))
        .set("fill", "WallFitted(lower: \"-l1 - x*s\", upper: \"l1 + x*s\")")
        .load()
    {
        Ok(scene) => scene,
        Err(faults) => panic!("{:?}", miette::Report::new(faults)),
    };
    let fluid = of(&seeds(&scene), Zone::Fluid);
    let cell = scene.spacing * scene.spacing;
    let area = 4.0e-3 * (2.0 * 2.5e-4 + 4.0e-3 * 3.503_f64.to_radians().tan());
    // The plane of the outlet may cut the last column, one of about 30 rows.
    assert!((fluid.len() as f64 * cell / area - 1.0).abs() < 0.01, "{}", fluid.len());
    for seed in &fluid {
        let half = 2.5e-4 + seed.position.x * 3.503_f64.to_radians().tan();
        assert!(seed.position.y.abs() < half);
    }
}

#[test]
fn order_of_the_seeds_is_reproducible() {
    let scene = smoke("constricted_r2.ron");
    let first = seeds(&scene);
    assert_eq!(first, seeds(&scene));
    assert!(first.windows(2).all(|pair| pair[0].zone <= pair[1].zone));
}

#[test]
fn square_bend_is_filled_and_open_at_both_ends() {
    let text = "Scene(title: \"t\", dimensions: 3, spacing: 0.1, smoke: 0.1,
        fluid: (density: 1000.0, viscosity: 1.0e-3, sound_speed: 10.0),
        scheme: Wcsph(smoothing_ratio: 1.5),
        domain: Union([
            Box(min: (-1.0, -0.2, -0.2), max: (0.0, 0.2, 0.2)),
            Bend(start: (0.0, 0.0, 0.0), direction: (1.0, 0.0, 0.0), center: (0.0, 0.8, 0.0), angle: 90.0,
                section: Rectangular(width: 0.4, height: 0.4)),
            Box(min: (0.6, 0.8, -0.2), max: (1.0, 1.8, 0.2)),
        ]),
        inlets: [(at: (-1.0, 0.0, 0.0), towards: (1.0, 0.0, 0.0), velocity: Normal(1.0))],
        outlets: [(at: (0.8, 1.8, 0.0), towards: (0.0, 1.0, 0.0), condition: WaveEquation())],
        time: (end: 1.0), output: (every: 0.1))";
    let scene = match Scene::from_text("bend", text).load() {
        Ok(scene) => scene,
        Err(faults) => panic!("{:?}", miette::Report::new(faults)),
    };
    for area in [scene.inlets[0].patch.area, scene.outlets[0].patch.area] {
        assert!((area - 0.16).abs() < 1e-9, "{area}");
    }
    check_uniform(&scene);
    let seeds = seeds(&scene);
    // Legs of 1 m and an arc of 0.8 · π/2 m with a section of 4 × 4 cells; the walls of the arc cut
    // cells.
    let expected = 0.16 * (2.0 + 0.8 * std::f64::consts::FRAC_PI_2) / 1e-3;
    let found = of(&seeds, Zone::Fluid).len() as f64;
    assert!((found / expected - 1.0).abs() < 0.08, "{found} of {expected}");
    assert_eq!(of(&seeds, Zone::Inflow).len(), 16 * 5);
    assert_eq!(of(&seeds, Zone::Outflow).len(), 16 * 8);
    for seed in of(&seeds, Zone::Wall) {
        let surface = seed.position + seed.wall_distance * seed.wall_normal;
        let off = scene.container.signed_distance(surface).abs();
        // A particle up to Δ/4 in front of its surface has distance 0.
        assert!(off < 1e-6 || (seed.wall_distance == 0.0 && off <= 0.0251), "{}: {off}", seed.position);
    }
}

#[test]
fn periodic_box_without_walls_is_filled_completely() {
    let text = "Scene(title: \"t\", dimensions: 3, spacing: 0.1, smoke: 0.1,
        fluid: (density: 1000.0, viscosity: 1.0e-3, sound_speed: 10.0),
        domain: Box(min: (-0.3, 0.0, 1.0), max: (0.7, 1.1, 2.2)), periodic: [\"x\", \"y\", \"z\"], walls: None,
        time: (end: 1.0), output: (every: 0.1))";
    let scene = match Scene::from_text("periodic", text).load() {
        Ok(scene) => scene,
        Err(faults) => panic!("{:?}", miette::Report::new(faults)),
    };
    let seeds = seeds(&scene);
    assert_eq!((seeds.len(), of(&seeds, Zone::Fluid).len()), (10 * 11 * 12, 10 * 11 * 12));
    check_uniform(&scene);
}

#[test]
fn jitter_moves_only_fluid_and_is_reproducible() {
    let even = seeds(&channel(OPENINGS));
    let jittered = |share: &str| {
        let scene = channel(&format!("{OPENINGS} fill: Lattice(jitter: {share}),"));
        let seeds = seeds(&scene);
        assert!(of(&seeds, Zone::Fluid).iter().all(|seed| scene.domain.contains(seed.position, 0.0)));
        seeds
    };
    let (found, again) = (jittered("0.2"), jittered("0.2"));
    assert_eq!(found, again);
    assert_eq!(found.len(), even.len());
    let (mut squares, mut sum, mut count) = (0.0, DVec3::ZERO, 0.0);
    for (seed, place) in found.iter().zip(&even) {
        let offset = (seed.position - place.position) / 0.05;
        assert_eq!(seed.zone, place.zone);
        if seed.zone != Zone::Fluid {
            assert_eq!(offset, DVec3::ZERO, "{:?}", seed.zone);
            continue;
        }
        assert!(offset.abs().max_element() <= 0.2 && offset.z == 0.0, "{offset}");
        (squares, sum, count) = (squares + offset.length_squared(), sum + offset, count + 1.0);
    }
    // Uniform numbers from −0.2 to 0.2 have the variance 0.2²/3 along each of two axes; 160
    // particles.
    assert!((squares / count / (2.0 * 0.04 / 3.0) - 1.0).abs() < 0.15, "{}", squares / count);
    assert!((sum / count).length() < 0.03, "{}", sum / count);
    let half = jittered("0.1");
    for ((seed, place), far) in half.iter().zip(&even).zip(&found) {
        let (near, far) = (seed.position - place.position, far.position - place.position);
        assert!((far - near * 2.0).length() < 1e-12, "the same way, half as far");
    }
}

#[test]
fn jitter_stays_inside_a_periodic_box() {
    let scene = channel("walls: None, periodic: [\"x\", \"y\"], fill: Lattice(jitter: 0.2),");
    let found = seeds(&scene);
    assert_eq!(found.len(), 20 * 8);
    for seed in found {
        assert!(
            (0.0..1.0).contains(&seed.position.x) && (0.0..0.4).contains(&seed.position.y),
            "{}",
            seed.position
        );
    }
}

#[test]
fn ineffective_pressure_and_draining_inlets_are_noted() {
    let notes = |extra: &str| {
        let scene = channel(extra);
        summary::summary(&scene, &seeds(&scene)).notes.join("\n")
    };
    let quiet = notes(OPENINGS);
    assert!(!quiet.contains("initial.pressure") && !quiet.contains("filled once"), "{quiet}");
    let pressed = notes(&format!("{OPENINGS} initial: (pressure: \"100*x\"),"));
    assert!(pressed.contains("`initial.pressure` does not reach the fluid"), "{pressed}");
    // At 1 m/s a zone of 0.5 m lasts 0.5 s of a run of 1 s.
    let once = OPENINGS.replace("velocity: Normal(1.0)", "velocity: Normal(1.0), feed: Once, depth: 0.5");
    let drained = notes(&once);
    assert!(drained.contains("inlet 0 is filled once") && drained.contains("after 0.5 s"), "{drained}");
}

#[test]
fn volume_estimate_is_within_two_per_cent_even_of_thin_shapes() {
    for name in ["square_bend.ron", "quickstart.ron", "duct3d.ron", "cylinder_re20.ron"] {
        let scene = smoke(name);
        let cell = scene.discretisation.cell_volume();
        let places = crate::fill::places(&scene);
        let fluid = places.iter().filter(|place| place.zone != Zone::Wall).count() as f64 * cell;
        let estimate = summary::estimated_volume(&scene.container, 0.0, scene.dimensions);
        assert!((estimate / fluid - 1.0).abs() < 0.02, "{name}: {estimate} for {fluid}");
    }
}
