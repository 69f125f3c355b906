//! Checks of the emitters of a scene file, and their columns on the walls of the scene.

use std::collections::BTreeMap;
use std::path::Path;

use glam::DVec3;

use super::boundaries::{default_name, velocity};
use super::checker::Checker;
use super::mesh_groups::{PlacedMesh, meshes_of};
use super::patches::MOST_LAYERS;
use super::shapes;
use crate::emitters::contour::Contour;
use crate::emitters::{Emitter, Piece, along_curves, over_surfaces};
use crate::faults::{Fault, advice};
use crate::geometry::Shape;
use crate::model::{InletVelocity, Scene};
use crate::movers::Wall;
use crate::sampled_times::sampled_times;
use crate::schema::{EmitterFile, InletVelocityFile, SceneFile};
use crate::sheets::around;
use crate::wall_particles::surface_of;
use sphecs_core::boundary::inlet::emitter_column::{EmitterColumn, NARROWEST};
use sphecs_core::format::{point, significant};

/// Length by which a column is longer than the support, in spacings. Its end comes nearer by a
/// spacing before a particle enters; there the kernel is nearly 0.
const TRUNCATED: f64 = 0.4;

/// Size of the cubes in which a surface is found in 3D, in spacings.
const CELL: f64 = 0.25;

/// Least distance of particles of different columns, in spacings. Behind a convex surface that is
/// just not too tight they have 0.3 at its end in 2D.
const NEAREST: f64 = 0.2;

/// Distance of the points of a column at which it is compared with others, in spacings.
const STEP: f64 = 0.25;

/// Solid behind the end of a column, in spacings, at least.
const BEHIND: f64 = 0.5;

/// Values of an emitter as written.
#[derive(Debug)]
pub struct Written {
    region: Option<Shape>,
    velocity: InletVelocity,
    /// Layers of its zone.
    layers: f64,
}

/// Returns the values of all emitters as written; None if one has a fault.
pub fn written(
    file: &SceneFile,
    (spacing, support): (f64, f64),
    folder: &Path,
    check: &mut Checker<'_>,
) -> Option<Vec<Written>> {
    let one = |file: &EmitterFile, check: &mut Checker<'_>| {
        let before = check.fault_count();
        let region = file.region.as_ref().map(|region| shapes::shape(&region.value, check));
        if let InletVelocityFile::Components(_)
        | InletVelocityFile::ProfileTable { .. }
        | InletVelocityFile::PoiseuilleStartup { .. } = file.velocity.value
        {
            let label = "must be `Normal`, `TimeTable`, `MassFlow` or `MassFlux`";
            let title = "an emitter sends fluid along its normal";
            check.report(Fault::new(title, file.velocity.head, label));
        }
        let velocity = velocity(&file.velocity, 1.0, folder, check);
        let depth = file.depth.as_ref().map(|depth| (depth.span, check.positive(depth, "m")));
        if let Some((span, depth)) = depth.filter(|(_, depth)| *depth < support * (1.0 - 1e-9)) {
            let least = significant(support);
            let label = format!("is `{depth}` m, must be at least `{least}` m (the support)");
            let title = "the zone of an emitter is shorter than the kernel's support";
            check.report(Fault::new(title, span, label));
        }
        if let Some((span, depth)) = depth.filter(|(_, depth)| *depth > MOST_LAYERS * spacing) {
            let label = format!("is `{depth}` m, must be at most {MOST_LAYERS} spacings");
            check.report(Fault::new("a zone is too long", span, label));
        }
        if file.on.is_none() && file.region.is_none() {
            let label = "must have `on`, `region` or both";
            check.report(Fault::new("an emitter has no surface", file.place(), label));
        }
        let layers = depth.map_or(support + TRUNCATED * spacing, |(_, depth)| depth) / spacing;
        (check.fault_count() == before).then_some(())?;
        let region = match region {
            Some(region) => Some(region?),
            None => None,
        };
        Some(Written { region, velocity: velocity?, layers: (layers - 1e-6).ceil() })
    };
    let all: Vec<Option<Written>> = file.emitters.iter().map(|file| one(file, check)).collect();
    all.into_iter().collect()
}

/// Returns the emitters of a scene that has no faults and is complete but for them.
pub fn emitters(
    file: &SceneFile,
    written: Vec<Written>,
    scene: &Scene,
    check: &mut Checker<'_>,
) -> Vec<Emitter> {
    if let Some(first) = file.emitters.first().filter(|_| !scene.layout.walled) {
        let label = "must be left out with `walls: None`";
        check.report(Fault::new("a scene without walls has emitters", first.place(), label));
        return Vec::new();
    }
    let all = file.emitters.iter().zip(written).enumerate();
    all.filter_map(|(index, (file, written))| emitter(file, index, written, scene, check)).collect()
}

fn emitter(
    file: &EmitterFile,
    index: usize,
    written: Written,
    scene: &Scene,
    check: &mut Checker<'_>,
) -> Option<Emitter> {
    let before = check.fault_count();
    let (wall, pieces) = pieces(file, written.region.as_ref(), scene, check)?;
    let depth = written.layers * scene.spacing;
    if pieces.is_empty() {
        let title = "an emitter has no surface there";
        let label = "must hold a part of the surface of a wall or mover";
        let help = "`region` is a shape that the surface passes through, of a mover without displacement";
        let place = file.region.as_ref().map_or(file.place(), |region| region.head);
        check.report(Fault::new(title, place, label).help(help));
        return None;
    }
    let pose = scene.start_pose(wall);
    let columns = pieces.iter().map(|piece| EmitterColumn {
        foot: pose.map_or(piece.foot, |pose| pose.reference(piece.foot)),
        normal: pose.map_or(piece.normal, |pose| pose.reference_direction(piece.normal)),
        area: piece.area,
        curvature_sum: piece.curvature_sum,
        curvature_product: piece.curvature_product,
    });
    let name = file.name.as_ref().map_or_else(|| default_name("emitter", index), |name| name.value.clone());
    let mut emitter = Emitter {
        name,
        wall,
        part: surface_of(scene, wall, pieces[0].foot).2,
        velocity: written.velocity,
        columns: columns.collect(),
        depth,
    };
    fits(file, &emitter, &pieces, scene, check);
    if check.fault_count() == before {
        apart(file, &emitter, &pieces, scene, check);
    }
    scale(file, &mut emitter, scene, check);
    one_way(file, &emitter, scene, check);
    (check.fault_count() == before).then_some(emitter)
}

/// Returns the wall of an emitter and the pieces of its surface; None if there is no such surface.
fn pieces(
    file: &EmitterFile,
    region: Option<&Shape>,
    scene: &Scene,
    check: &mut Checker<'_>,
) -> Option<(Wall, Vec<Piece>)> {
    let Some(on) = &file.on else {
        return Some((Wall::Casing, on_wall(scene, Wall::Casing, None, region)));
    };
    if let Some(index) = scene.movers.iter().position(|mover| mover.name == on.value) {
        return Some((Wall::Mover(index), on_wall(scene, Wall::Mover(index), None, region)));
    }
    let parts = scene.walls.parts.iter().skip(1).zip(&scene.layout.wall_regions);
    if let Some((_, part)) = parts.clone().find(|(part, _)| part.name == on.value) {
        return Some((Wall::Casing, on_wall(scene, Wall::Casing, Some(part), region)));
    }
    let meshes = meshes_of(scene);
    let group = meshes.iter().find_map(|mesh| Some((mesh, mesh.group(&on.value)?)));
    let Some((mesh, group)) = group else {
        let movers = scene.movers.iter().map(|mover| mover.name.as_str());
        let parts = parts.map(|(part, _)| part.name.as_str());
        let groups = meshes.iter().flat_map(PlacedMesh::group_names);
        let label = "must be the name of a mover, of a wall part or of a group of a mesh";
        let title = format!("no surface has the name `{}`", on.value);
        let known: Vec<&str> = movers.chain(parts).chain(groups).collect();
        let help = advice(&on.value, known);
        check.report(Fault::new(title, on.span, label).help(help));
        return None;
    };
    let triangles = mesh.triangles_in(group, |place| beyond(scene, mesh.wall, region, place) <= 0.0);
    Some((mesh.wall, over_surfaces::pieces(scene, mesh.wall, &triangles)))
}

/// Returns the signed distance of a place at the start from a region, m; negative without one.
fn beyond(scene: &Scene, wall: Wall, region: Option<&Shape>, place: DVec3) -> f64 {
    let reference = scene.start_pose(wall).map_or(place, |pose| pose.reference(place));
    region.map_or(f64::NEG_INFINITY, |region| region.signed_distance(reference))
}

/// Returns the pieces of the surface of a wall in a part of it and in a region.
fn on_wall(scene: &Scene, wall: Wall, part: Option<&Shape>, region: Option<&Shape>) -> Vec<Piece> {
    let distance = |place: DVec3| {
        let of_part = part.map_or(f64::NEG_INFINITY, |part| part.signed_distance(place));
        beyond(scene, wall, region, place).max(of_part)
    };
    if scene.dimensions == 2 {
        return along_curves::pieces(scene, wall, &distance);
    }
    let margin = DVec3::splat(scene.spacing);
    let (mut low, mut high) = wall.bounds(scene);
    let placed = region.map(|region| match wall {
        Wall::Casing => region.bounds(),
        Wall::Mover(index) => {
            let pose = scene.movers[index].start;
            let shape = Box::new(region.clone());
            Shape::Placed { shape, rotation: pose.rotation, scale: 1.0, origin: pose.origin }.bounds()
        }
    });
    for (lower, upper) in placed.into_iter().chain(part.map(Shape::bounds)) {
        (low, high) = (low.max(lower), high.min(upper));
    }
    let surface = |place: DVec3| wall.distance(scene, place);
    let contour =
        Contour { surface: &surface, region: &distance, low: low - margin, cell: CELL * scene.spacing };
    over_surfaces::pieces(scene, wall, &contour.triangles(high + margin))
}

/// Reports columns that meet behind an edge.
fn apart(file: &EmitterFile, emitter: &Emitter, pieces: &[Piece], scene: &Scene, check: &mut Checker<'_>) {
    let nearest = NEAREST * scene.spacing;
    let cell = |point: DVec3| (point / nearest).floor().as_i64vec3().to_array();
    let step = STEP * scene.spacing;
    let steps = (emitter.depth / step).round() as u32;
    let points = || {
        let depths = (1..=steps).map(|at| f64::from(at) * step);
        let of_column = move |(index, column): (usize, &EmitterColumn)| {
            let column = *column;
            depths.clone().map(move |depth| (index, column.point(depth)))
        };
        emitter.columns.iter().enumerate().flat_map(of_column)
    };
    let mut cells: BTreeMap<[i64; 3], Vec<(usize, DVec3)>> = BTreeMap::new();
    points().for_each(|(index, point)| cells.entry(cell(point)).or_default().push((index, point)));
    let meets = |(index, point): &(usize, DVec3)| {
        let near = around(cell(*point)).filter_map(|cell| cells.get(&cell)).flatten();
        near.into_iter().any(|(other, at)| other != index && at.distance(*point) < nearest)
    };
    if let Some((index, _)) = points().find(meets) {
        let title = "the columns behind an emitter meet";
        let place = point(&pieces[index].foot.to_array()[..scene.dimensions], scene.spacing);
        let label = format!("has an edge near {place} m, or parts that face each other across the solid");
        let help = "give each face an emitter of its own, and leave solid behind both";
        check.report(Fault::new(title, file.place(), label).help(help));
    }
}

/// Reports columns that do not fit into the solid behind the surface.
fn fits(file: &EmitterFile, emitter: &Emitter, pieces: &[Piece], scene: &Scene, check: &mut Checker<'_>) {
    let before = check.fault_count();
    let mut report = |title: &str, foot: DVec3, what: String, help: &str| {
        let place = point(&foot.to_array()[..scene.dimensions], scene.spacing);
        let label = format!("{what} near {place} m");
        check.report(Fault::new(title, file.place(), label).help(help));
    };
    let narrowest = |column: &EmitterColumn| column.narrowing(emitter.depth);
    let folded = emitter.columns.iter().zip(pieces).find(|(column, _)| narrowest(column) < NARROWEST);
    if let Some((_, piece)) = folded {
        let what = format!(
            "is curved so tightly that its columns meet within {} m behind it",
            significant(emitter.depth)
        );
        report("the surface of an emitter is curved too tightly", piece.foot, what, "lower `spacing`");
        return;
    }
    let least = BEHIND * scene.spacing;
    let thin = pieces.iter().find(|piece| {
        let end = piece.foot - (emitter.depth + least) * piece.normal;
        emitter.wall.distance(scene, end) < 0.0
    });
    if let Some(piece) = thin {
        let needed = significant(emitter.depth + 2.0 * least);
        let what = format!("must be at least {needed} m thick");
        let help = "make the solid thicker, or lower `spacing`";
        report("the solid behind an emitter is too thin for its inflow zone", piece.foot, what, help);
    }
    let others = scene.outlets.iter().map(|outlet| (&outlet.patch, outlet.patch.depth, 0.0));
    let openings = others.chain(scene.inlets.iter().map(|inlet| (&inlet.patch, 0.0, inlet.patch.depth)));
    for (patch, behind, before) in openings {
        let hit = pieces.iter().find(|piece| {
            let ends = [piece.foot, piece.foot - emitter.depth * piece.normal];
            ends.iter().any(|end| {
                let along = patch.along(*end);
                patch.covers(*end, scene.spacing) && (-before..=behind).contains(&along)
            })
        });
        if let Some(piece) = hit {
            let what = format!("runs into the zone of `{}`", patch.name);
            report("an emitter is in the zone of an opening", piece.foot, what, "move one of them");
        }
    }
    if check.fault_count() == before && emitter.columns.len() > usize::from(u16::MAX) * 1000 {
        let label = format!("has {} pieces of a spacing, must have fewer", emitter.columns.len());
        check.report(Fault::new("an emitter is too large", file.place(), label));
    }
}

/// Sets the scale of a prescribed mass flow.
///
/// ```text
/// v_n(x, t) = k ṁ(t) f(x),   k = 1/(ρ0 Σ f A)    for a rate
/// v_n(x, t) = k q(t) f(x),   k = Σ A/(ρ0 Σ f A)  for a flux
/// ```
fn scale(file: &EmitterFile, emitter: &mut Emitter, scene: &Scene, check: &mut Checker<'_>) {
    let is_flux = matches!(file.velocity.value, InletVelocityFile::MassFlux { .. });
    let total = emitter.area();
    let InletVelocity::MassFlow { profile, scale, .. } = &mut emitter.velocity else { return };
    let shape = |column: &EmitterColumn| {
        let foot = column.foot;
        profile.value(foot.x, foot.y, foot.z, 0.0) * column.area
    };
    let carried: f64 = emitter.columns.iter().map(shape).sum();
    if !carried.is_finite() || carried <= 1e-9 * total {
        let title = "`profile` of an emitter carries nothing into the domain";
        let label = format!("has the mean `{}` over its surface, must be above 0", carried / total);
        check.report(Fault::new(title, file.velocity.head, label));
        return;
    }
    *scale = if is_flux { total } else { 1.0 } / (scene.fluid.density * carried);
}

/// Reports a speed that is not a number or points out of the fluid at some time.
fn one_way(file: &EmitterFile, emitter: &Emitter, scene: &Scene, check: &mut Checker<'_>) {
    for time in sampled_times(scene.time.end) {
        for column in &emitter.columns {
            let speed = emitter.speed(column, time);
            if speed.is_finite() && speed >= -1e-12 * scene.fluid.sound_speed {
                continue;
            }
            let place = point(&column.foot.to_array()[..scene.dimensions], scene.spacing);
            let (title, help) = if speed.is_finite() {
                ("an emitter draws fluid in", "take an outlet where fluid leaves")
            } else {
                ("the speed of an emitter is not finite", "check its formula")
            };
            let label = format!(
                "is `{}` m/s at {place} m, t = {} s, must be at least 0",
                significant(speed),
                significant(time)
            );
            check.report(Fault::new(title, file.velocity.head, label).help(help));
            return;
        }
    }
}
