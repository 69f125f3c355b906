//! Checks of the complete scene: memory, overlaps, openings, fields at the particles.

use glam::DVec3;

use super::{bodies, compressibility, driven, mover_paths, movers, walls};
use crate::expression::Expression;
use crate::faults::Fault;
use crate::fill::{self, Place};
use crate::geometry::Shape;
use crate::memory_estimate::bytes_per_particle;
use crate::model::{BodyForce, InletVelocity, Patch, ProbeKind, Scene, Scheme};
use crate::notation::tree::Span;
use crate::sampled_times::sampled_times;
use crate::schema::{Formula, InletFile, InletVelocityFile as Written, OutletFile, SceneFile};
use crate::summary;
use sphecs_core::format;
use sphecs_core::particles::zone::Zone;
use sphecs_core::physics::wall::Slip;

/// Memory limit even with `--allow-oversize`, more than any machine has, B.
const MOST_MEMORY: f64 = 1e15;

/// Adds the faults that only the complete scene shows; `is_complete` is true if no value is a
/// placeholder.
pub fn check(scene: &Scene, file: &SceneFile, is_complete: bool, faults: &mut Vec<Fault>) {
    let others = faults.len();
    overlaps(scene, file, faults);
    if faults.len() > others {
        return;
    }
    let places = fill::places(scene);
    openings(scene, file, &places, faults);
    walls::fitted_twice(scene, file, faults);
    movers::check_scene(scene, file, faults);
    if scene.fluid.viscosity == 0.0 {
        let exact = |inlet: &&InletFile| matches!(inlet.velocity.value, Written::PoiseuilleStartup { .. });
        faults.extend(file.inlets.iter().filter(exact).map(|inlet| {
            let label = "has no profile in a fluid without viscosity";
            Fault::new("`PoiseuilleStartup` needs a viscosity", inlet.velocity.head, label)
        }));
    }
    if scene.fluid.viscosity == 0.0 && scene.walls.parts.iter().any(|part| part.slip == Slip::WallFunction) {
        let label = "is `0`: without it the law of the wall has no stress";
        faults.push(
            Fault::new("`WallFunction` needs a viscosity", file.fluid.viscosity.span, label)
                .help("give the fluid its `viscosity`, or the walls `slip: FreeSlip`"),
        );
    }
    // These checks would misread placeholders.
    if is_complete && faults.is_empty() {
        compressibility::check_limits(scene, file, faults);
        driven::check_openings(scene, file, faults);
        probes(scene, file, faults);
        bodies::have_particles(scene, file, &places, faults);
        mover_paths::check(scene, file, &places, faults);
        fields(scene, file, &places, faults);
    }
}

/// Reports a domain whose parts are so far apart that the lattice does not fit into memory.
fn too_empty(
    (domain, dimensions): (&Shape, usize),
    reach: f64,
    spacing: f64,
    file: &SceneFile,
    memory: Option<f64>,
) -> Option<Fault> {
    let (low, high) = domain.bounds();
    let extent = high - low + DVec3::splat(2.0 * reach);
    let places: f64 = (0..dimensions).map(|axis| extent[axis] / spacing).product();
    if places <= memory.unwrap_or(f64::INFINITY).min(MOST_MEMORY) / fill::BYTES_PER_PLACE as f64 {
        return None;
    }
    let label = format!(
        "gives `{places:.2e}` places of the lattice in the box around the domain, nearly all of them empty"
    );
    Some(
        Fault::new("the parts of the domain are too far apart", file.spacing.span, label)
            .help("find a shape of `domain` far away from the others"),
    )
}

/// Reports more particles than memory or particle numbers allow, estimated from the domain.
pub fn too_many(
    (domain, dimensions): (&Shape, usize),
    scheme: &Scheme,
    spacing: f64,
    file: &SceneFile,
    memory: Option<f64>,
) -> Option<Fault> {
    let reach = fill::layers(scheme) * spacing;
    let volume = summary::estimated_volume(domain, reach, dimensions);
    let count = volume / spacing.powi(dimensions as i32);
    let bytes = bytes_per_particle(scheme, file.precision);
    let limit = f64::from(u32::MAX).min(memory.unwrap_or(f64::INFINITY) / bytes);
    if let Some(stored) = file.reservoir.particles.filter(|n| n.value as f64 > limit) {
        return Some(Fault::new(
            "the reservoir is larger than the memory",
            stored.span,
            format!("is `{}`, must be at most `{limit:.2e}`", stored.value),
        ));
    }
    if count <= limit {
        return too_empty((domain, dimensions), reach, spacing, file, memory);
    }
    let have = memory.map_or("particle numbers end at 4.29e9".to_owned(), |bytes| {
        format!("{:.1} GB are free", bytes / 1e9)
    });
    let needed = count * bytes / 1e9;
    let least = 1.02 * (volume / limit).powf(1.0 / dimensions as f64);
    Some(
        Fault::new(
            "too many particles",
            file.spacing.span,
            format!("gives about {count:.2e} particles, that is {needed:.1} GB; {have}"),
        )
        .help(format!(
            "{}raise `spacing` to at least `{least:.2e}`{}",
            if domain.has_mesh() { "is the `unit` of the mesh right? or " } else { "" },
            // The range of the particle numbers is a hard limit.
            if memory.is_some() { ", or run with `--allow-oversize`" } else { "" }
        )),
    )
}

/// Returns the spans of `at` in the file: inlets, then outlets.
fn at_spans(file: &SceneFile) -> Vec<Span> {
    let inlets = file.inlets.iter().map(InletFile::place);
    inlets.chain(file.outlets.iter().map(OutletFile::place)).collect()
}

/// Reports zones that overlap the domain or each other.
fn overlaps(scene: &Scene, file: &SceneFile, faults: &mut Vec<Fault>) {
    let patches: Vec<(&Patch, bool)> = fill::patches(scene).collect();
    let spans = at_spans(file);
    let tolerance = 1e-3 * scene.spacing;
    for (index, (patch, is_inlet)) in patches.iter().enumerate() {
        let mut into_domain = None;
        let mut into_zone = None;
        for point in zone_points(patch, *is_inlet, scene) {
            if fill::periodic_distance(&scene.domain, &scene.periodic, point) < -tolerance {
                into_domain.get_or_insert(point);
            }
            for (other, zone) in scene.layout.zones.iter().enumerate().take(index) {
                let beyond = fill::beyond(patches[other].0, patches[other].1, point);
                if zone.contains(point, -tolerance) && beyond < patches[other].0.depth {
                    into_zone.get_or_insert(other);
                }
            }
        }
        let name = &patch.name;
        if let Some(point) = into_domain {
            faults.push(
                Fault::new(
                    format!("the zone of `{name}` runs into the domain"),
                    spans[index],
                    format!("at {} m both are there", printed(point, scene)),
                )
                .help("shorten `depth` or move the opening"),
            );
        }
        if let Some(other) = into_zone {
            faults.push(
                Fault::new(
                    format!("the zones of `{name}` and `{}` overlap", patches[other].0.name),
                    spans[index],
                    "two openings must not share a place",
                )
                .help("shorten `depth` or move one of them"),
            );
        }
    }
}

/// Returns points of a zone, a spacing apart, m.
pub(super) fn zone_points(patch: &Patch, is_inlet: bool, scene: &Scene) -> Vec<DVec3> {
    let outwards = if is_inlet { -patch.towards } else { patch.towards };
    let steps = |extent: f64| ((extent / scene.spacing).ceil() as i32).clamp(0, 200);
    let [a, b] = patch.half_extent;
    let (na, nb) = (steps(a), steps(b));
    let nd = (patch.depth / scene.spacing).round() as i32;
    let mut points = Vec::new();
    for i in -na..=na {
        for j in -nb..=nb {
            for k in 0..nd {
                let share = |index: i32, count: i32, extent: f64| {
                    0.99 * extent * f64::from(index) / f64::from(count.max(1))
                };
                points.push(
                    patch.at
                        + share(i, na, a) * patch.across[0]
                        + share(j, nb, b) * patch.across[1]
                        + (f64::from(k) + 0.5) * scene.spacing * outwards,
                );
            }
        }
    }
    points.retain(|point| patch.covers(*point, 0.0));
    points
}

/// Checks that probes lie in the domain.
fn probes(scene: &Scene, file: &SceneFile, faults: &mut Vec<Fault>) {
    for (probe, written) in scene.output.probes.iter().zip(&file.output.probes) {
        let points = match &probe.kind {
            ProbeKind::Point(at) | ProbeKind::Section { at, .. } => vec![*at],
            ProbeKind::Line { from, to, .. } => vec![*from, *to],
        };
        let outside = points.iter().find(|point| {
            fill::periodic_distance(&scene.container, &scene.periodic, **point) > 0.5 * scene.spacing
        });
        if let Some(point) = outside {
            faults.push(Fault::new(
                format!("probe `{}` is outside the domain", probe.name),
                written.kind.head,
                format!("is ({}, {}, {}) m, must be in the domain", point.x, point.y, point.z),
            ));
        }
    }
}

/// Checks that domain and zones have particles and that every side is wall, patch or periodic.
fn openings(scene: &Scene, file: &SceneFile, places: &[Place], faults: &mut Vec<Fault>) {
    let count = |zone: Zone, patch: usize| {
        let counted = places.iter().filter(|p| p.zone == zone && usize::from(p.patch) == patch);
        counted.count()
    };
    let fluid = count(Zone::Fluid, 0);
    if fluid == 0 {
        let label = format!("is `{}` m: no particle fits into the domain", scene.spacing);
        faults.push(Fault::new("the spacing is too coarse for the domain", file.spacing.span, label));
        return;
    }
    for (index, inlet) in scene.inlets.iter().enumerate() {
        if count(Zone::Inflow, index) == 0 {
            let title = format!("no particle fits into the zone of `{}`", inlet.patch.name);
            faults.push(Fault::new(
                title,
                file.inlets[index].place(),
                "the opening is narrower than a spacing",
            ));
        }
    }
    for (index, outlet) in scene.outlets.iter().enumerate() {
        if count(Zone::Outflow, index) == 0 {
            let title = format!("no particle fits into the zone of `{}`", outlet.patch.name);
            faults.push(Fault::new(
                title,
                file.outlets[index].place(),
                "the opening is narrower than a spacing",
            ));
        }
    }
    if scene.layout.walled {
        return;
    }
    let mut walled = scene.clone();
    walled.layout.walled = true;
    let bare = fill::places(&walled);
    if let Some(place) = bare.iter().find(|place| place.zone == Zone::Wall) {
        let at = place.position;
        faults.push(
            Fault::new(
                "a side of the domain is neither wall nor opening nor periodic",
                file.domain.head,
                format!("near {} m nothing holds the fluid", printed(at, scene)),
            )
            .help("there is no free surface: leave out `walls: None`, or make the direction `periodic`"),
        );
    }
}

fn printed(point: DVec3, scene: &Scene) -> String {
    format::point(&point.to_array()[..scene.dimensions], scene.spacing)
}

/// Largest numbers of times at which all places are checked, and of places at all times.
const FEW_TIMES: usize = 10;
const PLACES: usize = 20;

/// Returns a fault for a field that is not finite at one of the points (m) and times (s): all
/// places are checked at a few times, and some places at all times.
fn not_finite(expression: &Expression, formula: &Formula, points: &[DVec3], times: &[f64]) -> Option<Fault> {
    let some = points.len().div_ceil(PLACES).max(1);
    let few = times.len().div_ceil(FEW_TIMES).max(1);
    let (at, time) = times.iter().enumerate().find_map(|(index, time)| {
        let step = if index.is_multiple_of(few) { 1 } else { some };
        let is_bad = |p: &&DVec3| !expression.value(p.x, p.y, p.z, *time).is_finite();
        points.iter().step_by(step).find(is_bad).map(|bad| (*bad, *time))
    })?;
    let value = expression.value(at.x, at.y, at.z, time);
    Some(Fault::new(
        "a field is not finite",
        formula.span,
        format!(
            "is `{value}` at {} m, t = {} s",
            format::point(&at.to_array(), 0.0),
            format::significant(time)
        ),
    ))
}

/// Checks that fields are finite at all particles and at sampled times of the run.
fn fields(scene: &Scene, file: &SceneFile, places: &[Place], faults: &mut Vec<Fault>) {
    let of = |zone: fn(Zone) -> bool| {
        let chosen = places.iter().filter(move |place| zone(place.zone));
        chosen.map(|place| place.position).collect::<Vec<_>>()
    };
    let flowing = of(|zone| zone != Zone::Wall);
    let walls = of(|zone| zone == Zone::Wall);
    let all_times: Vec<f64> = sampled_times(scene.time.end).collect();
    let mut finite = |expression: &Expression, formula: &Formula, points: &[DVec3], times: &[f64]| {
        faults.extend(not_finite(expression, formula, points, times));
    };
    let initial = &file.initial;
    if let Some(velocity) = &initial.velocity {
        for (expression, formula) in scene.initial.velocity.iter().zip(&velocity.value) {
            finite(expression, formula, &flowing, &[0.0]);
        }
    }
    if let Some(formula) = &initial.pressure {
        finite(&scene.initial.pressure, formula, &flowing, &[0.0]);
    }
    if let Some(formula) = &initial.tag {
        finite(&scene.initial.tag, formula, &flowing, &[0.0]);
    }
    if let (Some(force), BodyForce::Expression(components)) = (&file.body_force, &scene.body_force) {
        for (expression, formula) in components.iter().zip(&force.value) {
            finite(expression, formula, &flowing, &all_times);
        }
    }
    if let Some(velocity) = file.walls.as_ref().and_then(|walls| walls.value.velocity.as_ref()) {
        for (expression, formula) in scene.walls.parts[0].velocity.iter().zip(&velocity.value) {
            finite(expression, formula, &walls, &all_times);
        }
    }
    let written_parts = file.walls.iter().flat_map(|walls| &walls.value.parts);
    for ((part, region), written) in
        scene.walls.parts.iter().skip(1).zip(&scene.layout.wall_regions).zip(written_parts)
    {
        let Some(velocity) = &written.velocity else { continue };
        let reach = fill::wall_thickness(scene);
        let of_part: Vec<DVec3> =
            walls.iter().copied().filter(|point| region.signed_distance(*point) <= reach).collect();
        for (expression, formula) in part.velocity.iter().zip(&velocity.value) {
            finite(expression, formula, &of_part, &all_times);
        }
    }
    for (index, (inlet, written)) in scene.inlets.iter().zip(&file.inlets).enumerate() {
        let points: Vec<DVec3> = places
            .iter()
            .filter(|p| p.zone == Zone::Inflow && usize::from(p.patch) == index)
            .map(|p| p.position)
            .collect();
        match (&inlet.velocity, &written.velocity.value) {
            (InletVelocity::Normal(expression), Written::Normal(formula)) => {
                finite(expression, formula, &points, &all_times);
            }
            (
                InletVelocity::MassFlow { rate: expression, .. },
                Written::MassFlow { rate: formula, .. } | Written::MassFlux { flux: formula, .. },
            ) => finite(expression, formula, &[DVec3::ZERO], &all_times),
            (InletVelocity::Components(components), Written::Components(formulas)) => {
                for (expression, formula) in components.iter().zip(&formulas.value) {
                    finite(expression, formula, &points, &all_times);
                }
            }
            _ => {}
        }
    }
}
