//! Check of a scene before a long run: particles, passages, speeds, time scales, and the cost of
//! the run on this machine.

use glam::DVec3;

use super::doubtful;
use super::first_steps::time_first_steps;
use super::rank_shares::rank_rows;
use super::report::{scene_rows, scene_table};
use super::run_state::LARGEST_MACH;
use sphecs_core::format::{bytes, grouped, point, significant};
use sphecs_core::particles::zone::Zone;
use sphecs_core::physics::wall::WallPressure;
use sphecs_engine::simulation::Simulation;
use sphecs_scene::closing_gaps::{ClosingGap, NARROW, closing_gaps};
use sphecs_scene::disk_estimate::DiskEstimate;
use sphecs_scene::flow_path::{FlowPath, flow_path};
use sphecs_scene::missing_walls::{missing_wall, movers_without_particles};
use sphecs_scene::model::{BodyForce, ParticleSeed, Scene};
use sphecs_scene::movers::Wall;
use sphecs_scene::opening_figures::{OpeningFigures, opening_figures};
use sphecs_scene::passage::{Passage, narrowest_passage};
use sphecs_scene::summary::summary;
use sphecs_scene::thin_walls::{ThinWall, leaking_thickness, mixing_thickness, thinnest_wall};
use sphecs_scene::wall_particles::overlapping_parts;

/// Wanted number of particles across a passage.
const WANTED_ACROSS: f64 = 10.0;

/// Report on a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct CheckReport {
    /// Title, table and notes.
    pub text: String,
    /// The notes.
    pub notes: Vec<String>,
}

/// Options of a check.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CheckOptions {
    /// End of the run, s; None: that of the scene.
    pub until: Option<f64>,
    /// Build the flow and time its first steps.
    pub timed: bool,
    /// Number of ranks whose shares are found.
    pub ranks: usize,
}

/// Checks a scene with its initial particles on the current thread pool.
pub fn check(scene: &Scene, seeds: Vec<ParticleSeed>, options: &CheckOptions) -> CheckReport {
    let until = options.until.unwrap_or(scene.time.end);
    // The path of the flow takes as long as all else together.
    let (path, (passage, (mut figures, overlaps, thin_walls))) = rayon::join(
        || flow_path(scene, &seeds),
        || {
            let rest =
                || (summary(scene, &seeds), overlap_notes(scene, &seeds), thin_wall_notes(scene, &seeds));
            rayon::join(|| narrowest_passage(scene, &seeds), rest)
        },
    );
    figures.notes.extend(overlaps.into_iter().chain(thin_walls));
    for mesh in &scene.mesh_reports {
        figures.notes.extend(mesh.notes.iter().map(|note| format!("the mesh {} {note}", mesh.name)));
    }
    let by_zone = figures.by_zone.map(|count| count as u64);
    let disk = disk_estimate(scene, by_zone, until);
    let openings: Vec<(String, String)> = opening_figures(scene, until)
        .into_iter()
        .map(|figures| (figures.name.clone(), opening_text(scene, &figures)))
        .collect();
    let mut rows: Vec<(&str, String)> = scene_rows(scene, &figures, by_zone, until, None);
    rows.extend(scene.mesh_reports.iter().map(|mesh| (mesh.name.as_str(), mesh.lines.join("; "))));
    rows.extend(passage.map(|passage| ("passage", passage_text(scene, &passage))));
    rows.extend(path.map(|path| ("fastest", fastest_text(scene, &path))));
    rows.extend(openings.iter().map(|(name, text)| (name.as_str(), text.clone())));
    rows.push(("time scales", scales_text(scene, path.as_ref())));
    figures.notes.extend(notes(scene, until, passage.as_ref(), path.as_ref()));
    figures.notes.extend(closing_gaps(scene, &seeds, until).iter().map(|gap| closing_gap_note(scene, gap)));
    figures.notes.extend(doubtful::notes(scene, &seeds, until, path.as_ref()));
    if options.timed || options.ranks > 1 {
        let built = Simulation::builder(scene.clone()).particles(seeds).build();
        let mut simulation = built.expect("a scene without plugins and saved states can be built");
        rows.extend(rank_rows(&mut simulation, options.ranks));
        if options.timed {
            let (run_time, note) = time_first_steps(simulation, scene, until);
            rows.extend(run_time.map(|text| ("run time", text)));
            figures.notes.extend(note);
        }
    }
    rows.push(("memory", format!("about {} at most, output included", bytes(figures.memory as u64))));
    rows.push(("disk", disk_text(&disk)));
    CheckReport { text: scene_table(scene, &figures, &rows), notes: figures.notes }
}

fn disk_estimate(scene: &Scene, by_zone: [u64; 5], until: f64) -> DiskEstimate {
    let all: u64 = by_zone.iter().sum();
    let moving = all - by_zone[Zone::Wall as usize];
    DiskEstimate::of_particles(scene, moving as f64, all as f64, Some(until), None)
}

fn point_text(scene: &Scene, at: DVec3) -> String {
    format!("{} m", point(&at.to_array()[..scene.dimensions], scene.spacing))
}

/// Returns the particles across the narrowest passage and its place.
fn passage_text(scene: &Scene, passage: &Passage) -> String {
    format!(
        "narrowest {} m at {}: {:.1} particles across",
        significant(passage.width()),
        point_text(scene, passage.middle()),
        passage.width() / scene.spacing
    )
}

/// Returns a note on a passage with few particles across. It is no fault of the scene: acute
/// corners and wedges have such places. With n particles between two plates the flow of a developed
/// profile is 1 + 3/n² times the exact one, measured for n = 2 to 20.
fn passage_note(scene: &Scene, passage: &Passage) -> Option<String> {
    let across = passage.width() / scene.spacing;
    (across < WANTED_ACROSS - 0.01).then(|| {
        format!(
            "the narrowest passage has {across:.1} particles across, between plates a laminar flow is {} % too large with \
             these: {WANTED_ACROSS} or more are wanted, `spacing` of at most {} m",
            significant_two(300.0 / across.powi(2)),
            significant(passage.width() / WANTED_ACROSS)
        )
    })
}

/// Returns the largest mean speed, and the largest of a developed laminar profile with that mean.
fn fastest_text(scene: &Scene, path: &FlowPath) -> String {
    let speed = path.mean_speed();
    let peak = peak_of_mean(scene.dimensions) * speed;
    let mach = |speed: f64| significant_two(speed / scene.fluid.sound_speed);
    format!(
        "about {} m/s on average over the section at {}, at t = {} s: Mach = {}, {} in a developed laminar profile",
        significant_two(speed),
        point_text(scene, path.at),
        significant(path.time),
        mach(speed),
        mach(peak)
    )
}

/// Returns size, velocity, flow and Reynolds number of an opening: one velocity if it stays the
/// same.
fn opening_text(scene: &Scene, figures: &OpeningFigures) -> String {
    let is_flat = scene.dimensions == 2;
    let area = significant(figures.area);
    let size = match (figures.section, figures.columns) {
        (_, Some((count, depth))) => {
            let unit = if is_flat { "m wide" } else { "m²" };
            let columns = if count == 1 { "column" } else { "columns" };
            format!("{area} {unit}, {count} {columns} of particles {} m deep", significant(depth))
        }
        (Some([perimeter, diameter]), None) if !is_flat => {
            let [perimeter, diameter] = [perimeter, diameter].map(significant);
            format!("{area} m², perimeter {perimeter} m, hydraulic diameter {diameter} m")
        }
        _ => format!("{area} m wide"),
    };
    let unit = if is_flat { "kg/(s m)" } else { "kg/s" };
    let flow = |velocity: f64| {
        let rate = velocity * figures.area * scene.fluid.density;
        format!("{} m/s, {} {unit}", significant(velocity), significant(rate))
    };
    let Some(&(_, first)) = figures.velocities.first() else { return size };
    let largest = figures.velocities.iter().map(|(_, velocity)| velocity.abs()).fold(0.0, f64::max);
    let is_steady = figures.velocities.iter().all(|(_, velocity)| (velocity - first).abs() <= 1e-9 * largest);
    let flows = if is_steady {
        flow(first)
    } else {
        let at = |(time, velocity): &(f64, f64)| format!("{} at {} s", flow(*velocity), significant(*time));
        figures.velocities.iter().map(at).collect::<Vec<_>>().join("; ")
    };
    let reynolds = figures.section.map(|[_, diameter]| largest * diameter / scene.fluid.viscosity);
    let reynolds = if let Some(reynolds) = reynolds.filter(|reynolds| reynolds.is_finite()) {
        format!(", Re = {} by the hydraulic diameter", significant(reynolds))
    } else {
        String::new()
    };
    format!("{size}: {flows}{reynolds}")
}

/// Returns a number with two significant digits, for estimates.
fn significant_two(value: f64) -> String {
    sphecs_core::format::with_digits(value, 2)
}

/// Returns the ratio of the largest to the mean speed of a developed laminar flow: 3/2 between
/// plates, 2 in a round pipe.
fn peak_of_mean(dimensions: usize) -> f64 {
    if dimensions == 2 { 1.5 } else { 2.0 }
}

/// Returns the times that sound, flow and viscosity need through the domain, s.
fn scales_text(scene: &Scene, path: Option<&FlowPath>) -> String {
    let (low, high) = scene.domain.bounds();
    let diagonal =
        (high - low).to_array().into_iter().take(scene.dimensions).map(|x| x * x).sum::<f64>().sqrt();
    let length = path.map_or(diagonal, |path| path.length);
    let speed = scene.reference_velocity;
    let passes = path.map(FlowPath::passage_time).or((speed > 0.0).then(|| length / speed));
    let mut parts = vec![format!("sound passes in {} s", significant_two(length / scene.fluid.sound_speed))];
    parts.extend(passes.map(|time| format!("the flow in {} s", significant_two(time))));
    if scene.fluid.viscosity > 0.0 {
        let time = scene.reference_length.powi(2) / scene.fluid.viscosity;
        parts.push(format!(
            "viscosity crosses {} m in {} s",
            significant(scene.reference_length),
            significant_two(time)
        ));
    }
    parts.join(", ")
}

/// Returns a note for each pair of wall parts whose regions share surface.
fn overlap_notes(scene: &Scene, seeds: &[ParticleSeed]) -> Vec<String> {
    let name = |part: u16| &scene.walls.parts[usize::from(part)].name;
    let note = |([first, second], count): ([u16; 2], usize)| {
        format!(
            "the regions of the wall parts `{}` and `{}` overlap: {} wall particles lie in both and count for the \
             first, with its slip and its forces",
            name(first),
            name(second),
            grouped(count as u64)
        )
    };
    overlapping_parts(scene, seeds).into_iter().map(note).collect()
}

/// Returns a note on a wall through which its two sides disturb each other.
fn closing_gap_note(scene: &Scene, gap: &ClosingGap) -> String {
    let name = |mover: usize| format!("`{}`", scene.movers[mover].name);
    let other = match gap.wall {
        Wall::Casing => "the other walls".to_owned(),
        Wall::Mover(other) => name(other),
    };
    let (at, time) = (point_text(scene, gap.place), significant(gap.time));
    let closes = if gap.width == 0.0 {
        format!("closes at t = {time} s near {at}")
    } else {
        format!(
            "closes to {} m, {:.1} particles, at t = {time} s near {at}",
            significant(gap.width),
            gap.width / scene.spacing
        )
    };
    let cure = if gap.width > 0.0 {
        format!("; `spacing` of at most {} m resolves it by three", significant(gap.width / NARROW))
    } else {
        String::new()
    };
    format!(
        "the gap between {} and {other} {closes}: particles that do not leave it in time are compressed{cure}",
        name(gap.mover)
    )
}

/// Returns the notes on solids thinner than the support.
fn thin_wall_notes(scene: &Scene, seeds: &[ParticleSeed]) -> Vec<String> {
    let missing = missing_wall(scene, seeds).map(|wall| {
        let thickness = significant(wall.thickness());
        format!(
            "the solid at {} is {thickness} m thin and has no particles, so that the flow passes through it: make it a \
             spacing thick, or `spacing` of at most {thickness} m",
            point_text(scene, wall.middle())
        )
    });
    let thin = thinnest_wall(scene, seeds).and_then(|wall| thin_wall_note(scene, &wall));
    missing.into_iter().chain(movers_without_particles(scene, seeds)).chain(thin).collect()
}

fn thin_wall_note(scene: &Scene, wall: &ThinWall) -> Option<String> {
    let (thickness, at) = (significant(wall.thickness()), point_text(scene, wall.middle()));
    // Both limits are in proportion to the spacing.
    let cure = |limit: f64| significant(scene.spacing * wall.thickness() / limit);
    let (leaking, mixing) = (leaking_thickness(scene), mixing_thickness(scene));
    if wall.thickness() < leaking {
        return Some(format!(
            "the wall at {at} is {thickness} m thin: the fluid of its two sides feels each other through less than \
             {} m, `walls: (one_sided: true)` separates them, or `spacing` of at most {} m",
            significant(leaking),
            cure(leaking)
        ));
    }
    (wall.thickness() < mixing && scene.walls.model.pressure() == WallPressure::Extrapolated).then(|| {
        format!(
            "the wall at {at} is {thickness} m thin: its particles mix the pressures of both sides below {} m, \
             `walls: (one_sided: true)` separates them, or `spacing` of at most {} m",
            significant(mixing),
            cure(mixing)
        )
    })
}

/// Returns the notes on passage, speed and duration.
fn notes(scene: &Scene, until: f64, passage: Option<&Passage>, path: Option<&FlowPath>) -> Vec<String> {
    let mut notes = Vec::new();
    notes.extend(passage.and_then(|passage| passage_note(scene, passage)));
    notes.extend(weight_note(scene));
    let Some(path) = path else { return notes };
    let mach = path.mean_speed() / scene.fluid.sound_speed;
    // The reference velocity has a note of its own.
    if mach > LARGEST_MACH && scene.reference_velocity <= LARGEST_MACH * scene.fluid.sound_speed {
        notes.push(format!(
            "the mean speed reaches Mach {} at {}, {LARGEST_MACH} or less is wanted: `fluid.sound_speed` of at least {} m/s",
            significant_two(mach),
            point_text(scene, path.at),
            significant(path.mean_speed() / LARGEST_MACH)
        ));
    }
    if until < path.passage_time() {
        notes.push(format!(
            "the run ends at {} s, before the flow has passed once, in {} s: the start still determines the result",
            significant(until),
            significant_two(path.passage_time())
        ));
    }
    notes.extend(early_mean_note(scene, until, path));
    notes
}

/// Largest relative density difference by weight.
const LARGEST_COMPRESSION: f64 = 0.01;

/// Returns a note on a fluid that its weight compresses by more than a percent.
fn weight_note(scene: &Scene) -> Option<String> {
    let (low, high) = scene.domain.bounds();
    let middle =
        (0.5 * (low + high)).with_z(if scene.dimensions == 2 { 0.0 } else { 0.5 * (low.z + high.z) });
    let force = match &scene.body_force {
        BodyForce::Constant(force) => *force,
        BodyForce::Expression(components) => {
            DVec3::from(components.each_ref().map(|c| c.value(middle.x, middle.y, middle.z, 0.0)))
        }
    };
    // Along a periodic direction a force drives the flow.
    let walled = (0..scene.dimensions).filter(|&axis| scene.periodic[axis].is_none());
    let energy: f64 = walled.map(|axis| force[axis].abs() * (high[axis] - low[axis])).sum();
    let compression = energy / scene.fluid.sound_speed.powi(2);
    (compression > LARGEST_COMPRESSION).then(|| {
        format!(
            "its weight compresses the fluid by {} % from top to bottom, {} % or less is wanted: `fluid.sound_speed` \
             of at least {} m/s",
            significant_two(100.0 * compression),
            100.0 * LARGEST_COMPRESSION,
            significant_two((energy / LARGEST_COMPRESSION).sqrt())
        )
    })
}

/// Returns a note on time means that begin before the flow has passed once and could begin later.
fn early_mean_note(scene: &Scene, until: f64, path: &FlowPath) -> Option<String> {
    let passes = path.passage_time();
    // The number of digits of the advice.
    let is_early = |from: f64| from < 0.95 * passes && passes < until;
    let probes = scene.output.probes.iter().filter_map(|probe| Some((probe.name.as_str(), probe.mean?.0)));
    let bodies = scene.bodies.iter().filter(|body| body.reference.is_some());
    let fields = scene.output.fields.iter().filter_map(|fields| Some(("fields", fields.mean?.0)));
    let walls = scene.output.walls.iter().filter_map(|walls| Some(("walls", walls.mean?.0)));
    let bodies = bodies.map(|body| (body.name.as_str(), body.mean.0));
    let all = probes.chain(bodies).chain(fields).chain(walls);
    let early: Vec<String> =
        all.filter(|(_, from)| is_early(*from)).map(|(name, _)| format!("`{name}`")).collect();
    if early.is_empty() {
        return None;
    }
    Some(format!(
        "the time means of {} begin before the flow has passed once, in {} s: they contain the start, `mean` of \
         ({}, …) leaves it out",
        early.join(", "),
        significant_two(passes),
        significant_two(passes)
    ))
}

/// Returns the size of the results by kind.
fn disk_text(disk: &DiskEstimate) -> String {
    let size = |size: f64| bytes(size as u64);
    let mut parts = vec![format!("{} frames {}", grouped(disk.frames as u64), size(disk.frame_bytes))];
    let mut add = |name: &str, bytes: f64| {
        if bytes > 0.0 {
            parts.push(format!("{name} {}", size(bytes)));
        }
    };
    add("fields", disk.field_bytes);
    add("walls", disk.wall_bytes);
    add("probes", disk.probe_bytes);
    add("forces", disk.force_bytes);
    add("monitor", disk.monitor_bytes);
    add("checkpoints", disk.checkpoint_bytes);
    format!(
        "at most {}: {}; up to {} while results are packed",
        size(disk.total()),
        parts.join(", "),
        size(disk.bytes())
    )
}
