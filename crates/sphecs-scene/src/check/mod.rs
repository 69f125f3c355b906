//! Checks of all values of a scene file, which make it a scene; all faults are found in one run.
//!
//! 1. [`checker`]: single numbers, vectors and expressions
//! 2. [`shapes`], [`meshes`], [`outlines`], [`outline_points`], [`boundaries`], [`movers`],
//!    [`bodies`], [`patches`], [`mesh_groups`], [`cut`], [`driven`], [`section`], [`tables`],
//!    [`layout`], [`walls`], [`scheme`], [`settings`], [`names`](mod@names),
//!    [`wall_quantities`]: one section each
//! 3. [`mass_flow`]: speeds of the inlets with a prescribed mass flow, for the rows of the fill;
//!    [`emitters`], on the walls of the scene
//! 4. [`consistency`], [`mover_paths`]: faults that only the complete scene shows, once its parts
//!    are valid

use std::path::Path;

use glam::DVec3;

use super::expression::Constants;
use super::faults::Fault;
use super::geometry::Shape;
use super::meshes::MeshFile;
use super::model::{
    Body, BodyForce, Casing, Fill, FluidProperties, Initial, Inlet, Layout, Mover, Outlet, Patch, Scene,
    Scheme, UnopenedPart, Walls,
};
use super::motion::Motion;
use super::movers::without_movers;
use super::schema::SceneFile;

pub mod bodies;
pub mod boundaries;
pub mod checker;
pub mod compressibility;
pub mod consistency;
pub mod cut;
pub mod driven;
pub mod emitters;
pub mod field_grids;
pub mod layout;
pub mod mass_flow;
pub mod mesh_groups;
pub mod meshes;
pub mod mover_paths;
pub mod movers;
pub mod names;
pub mod outline_points;
pub mod outlines;
pub mod patches;
pub mod scheme;
pub mod section;
pub mod settings;
pub mod shapes;
pub mod tables;
pub mod wall_quantities;
pub mod walls;

use checker::Checker;

/// Source of a scene.
#[derive(Clone, Copy, Debug)]
pub struct SceneSource<'a> {
    /// File stem, used for the run folder.
    pub name: &'a str,
    /// The text as run.
    pub text: &'a str,
    /// Folder of tables.
    pub folder: &'a Path,
    /// Tables that replace the files of the folder: the path as the scene writes it, and the text.
    pub tables: &'a [(String, String)],
    /// Files of meshes and outlines that replace those of the folder.
    pub meshes: &'a [MeshFile],
    /// True if the reading of the text found faults, such as unknown fields.
    pub has_faults: bool,
    /// Memory limit of a run, B; None for no limit.
    pub memory: Option<f64>,
}

/// Builds a scene and returns it with all faults. A scene with faults has placeholders and serves
/// only for further checks.
pub fn check(
    file: &SceneFile,
    constants: &Constants,
    source: SceneSource<'_>,
) -> (Option<Scene>, Vec<Fault>) {
    let mut checker = Checker::new(constants, source.text);
    checker.tables = source.tables.to_vec();
    checker.meshes = source.meshes.to_vec();
    checker.folder = source.folder.to_owned();
    checker.has_reading_faults = source.has_faults;
    let scene = check_sections(file, &mut checker, source);
    let is_complete = checker.fault_count() == 0;
    let mut faults = checker.faults;
    if let Some(scene) = &scene {
        consistency::check(scene, file, is_complete, &mut faults);
        if is_complete && faults.is_empty() {
            field_grids::check_scene(scene, file, source.memory, &mut faults);
        }
    }
    (scene, faults)
}

/// Checks all sections of a scene file; returns None if its shapes have faults.
fn check_sections(file: &SceneFile, check: &mut Checker<'_>, source: SceneSource<'_>) -> Option<Scene> {
    let before = check.fault_count();
    let dimensions = settings::dimensions(file, check);
    check.dimensions = dimensions;
    let spacing = check.positive(&file.spacing, "m");
    check.spacing = spacing;
    let scheme = scheme::scheme(&file.scheme, dimensions, check);
    let (domain, is_valid) = domain(file, &scheme, (before, source.memory), check);
    let smoke_spacing = file.smoke.as_ref().map_or(spacing, |smoke| check.positive(smoke, "m"));
    let (fluid, body_force, initial) = fluid(file, check);
    let before_time = check.fault_count();
    let time = settings::time(&file.time, &scheme, check);
    let end = (check.fault_count() == before_time).then_some(time.end);
    let course = movers::Course { folder: source.folder, end: time.end };
    let Solids { walls, wall_layout, movers, casing_motion, bodies } =
        solids(file, (&domain, spacing), course, check);
    let walled = file.walls.is_some();
    let output = settings::output(&file.output, end, (&walls, walled), check);
    let periodic = layout::periodic(&file.periodic, (&domain, spacing), is_valid, check);
    let site = patches::Site {
        domain: &domain,
        periodic: &periodic,
        spacing,
        support: scheme.support(spacing),
        dimensions,
        is_valid,
    };
    let inlets = boundaries::inlets((&file.inlets, &file.emitters), &site, source.folder, check);
    let emitters = emitters::written(file, (spacing, site.support), source.folder, check);
    let outlets = boundaries::outlets(&file.outlets, &site, source.folder, check);
    settings::references(file, check);
    let (inlets, emitters, outlets) = (inlets?, emitters?, outlets?);
    if !is_valid {
        return None;
    }
    let regions = boundary_zones(&inlets, &outlets, &site);
    let patches = patches_of(&inlets, &outlets);
    let fill = layout::fill((file.fill.as_ref(), walled), &site, &patches, check)?;
    let unopened = unopened(check, &patches, spacing);
    let mut scene = Scene {
        name: source.name.to_owned(),
        title: file.title.value.clone(),
        text: source.text.to_owned(),
        tables: std::mem::take(&mut check.tables),
        meshes: std::mem::take(&mut check.meshes),
        mesh_reports: std::mem::take(&mut check.mesh_reports),
        dimensions,
        precision: file.precision,
        spacing,
        discretisation: scheme.discretisation(dimensions, spacing, fluid.density),
        smoke_spacing,
        fluid,
        scheme,
        body_force,
        container: without_movers(&regions.container, &movers),
        domain: without_movers(&domain, &movers),
        layout: Layout { unopened, ..laid_out(fill, regions, wall_layout, (domain, &movers), walled) },
        movers,
        casing_motion,
        walls,
        bodies,
        inlets,
        emitters: Vec::new(),
        outlets,
        periodic,
        initial,
        reservoir: settings::reservoir(&file.reservoir, check),
        time,
        output,
        reference_velocity: 0.0,
        reference_length: 0.0,
    };
    if check.fault_count() == before {
        mass_flow::set_scales(&mut scene, file, check);
        scene.emitters = emitters::emitters(file, emitters, &scene, check);
    }
    settings::derive(&mut scene, file);
    Some(scene)
}

/// Returns the domain, and true if it has no fault and there were none since the number `before`.
fn domain(
    file: &SceneFile,
    scheme: &Scheme,
    (before, memory): (usize, Option<f64>),
    check: &mut Checker<'_>,
) -> (Shape, bool) {
    check.note_placeholder(file.domain.span);
    let domain = shapes::shape(&file.domain.value, check);
    let is_valid = check.fault_count() == before;
    // A placeholder lets the faults of further sections be found in the same run.
    let domain = domain.unwrap_or(Shape::Ball { center: DVec3::ZERO, radius: 1.0 });
    if !is_valid {
        return (domain, false);
    }
    let fault = consistency::too_many((&domain, check.dimensions), scheme, check.spacing, file, memory);
    let is_small = fault.is_none();
    fault.into_iter().for_each(|fault| check.report(fault));
    (domain, is_small)
}

/// Walls, bodies that move, and bodies whose forces are written.
struct Solids {
    walls: Walls,
    wall_layout: walls::WallLayout,
    movers: Vec<Mover>,
    casing_motion: Option<Motion>,
    bodies: Vec<Body>,
}

fn solids(
    file: &SceneFile,
    (domain, spacing): (&Shape, f64),
    course: movers::Course<'_>,
    check: &mut Checker<'_>,
) -> Solids {
    let (mut walls, mut wall_layout) = walls::walls(file, (domain, spacing), check);
    let movers = movers::movers(file, (&mut walls, &mut wall_layout), (course, spacing), check);
    let casing_motion = movers::casing_motion(file, course, check);
    let places = bodies::Places { walls: &walls, regions: &wall_layout.regions, movers: &movers, domain };
    let bodies = bodies::bodies(file, &places, course.end, check);
    Solids { walls, wall_layout, movers, casing_motion, bodies }
}

/// Returns the layout of the particles, all ends of the domain open.
fn laid_out(
    fill: Fill,
    regions: BoundaryZones,
    walls: walls::WallLayout,
    (domain, movers): (Shape, &[Mover]),
    walled: bool,
) -> Layout {
    let BoundaryZones { zones, container, confines } = regions;
    let walls::WallLayout { regions: wall_regions, rings, layered } = walls;
    Layout {
        fill,
        confines: without_movers(&confines, movers),
        casing: Casing { domain, container, confines },
        zones,
        wall_regions,
        rings,
        layered,
        unopened: Vec::new(),
        walled,
    }
}

fn patches_of<'a>(inlets: &'a [Inlet], outlets: &'a [Outlet]) -> Vec<&'a Patch> {
    let patches = inlets.iter().map(|inlet| &inlet.patch);
    patches.chain(outlets.iter().map(|outlet| &outlet.patch)).collect()
}

/// Returns the parts of the domain's ends that no opening covers.
fn unopened(check: &mut Checker<'_>, patches: &[&Patch], spacing: f64) -> Vec<UnopenedPart> {
    let covers = |patch: &Patch, part: &UnopenedPart| {
        patch.along(part.at).abs() < 0.01 * spacing && patch.covers(part.at, 0.25 * spacing)
    };
    let parts = std::mem::take(&mut check.unopened).into_iter();
    parts.filter(|part| !patches.iter().any(|patch| covers(patch, part))).collect()
}

/// Checks the fluid, the body force and the initial state.
fn fluid(file: &SceneFile, check: &mut Checker<'_>) -> (FluidProperties, BodyForce, Initial) {
    let fluid = FluidProperties {
        density: check.positive(&file.fluid.density, "kg/m³"),
        viscosity: check.not_negative(&file.fluid.viscosity, "m²/s"),
        sound_speed: check.positive(&file.fluid.sound_speed, "m/s"),
    };
    let body_force = match &file.body_force {
        None => BodyForce::Constant(DVec3::ZERO),
        Some(components) => settings::body_force(check.components(components)),
    };
    let initial = Initial {
        velocity: check.components_or_zero(file.initial.velocity.as_ref()),
        pressure: check.formula_or_zero(file.initial.pressure.as_ref()),
        tag: check.formula_or_zero(file.initial.tag.as_ref()),
    };
    (fluid, body_force, initial)
}

/// Regions of the inflow and outflow particles.
struct BoundaryZones {
    /// Zones, extended beyond their depth so that nothing is filled behind them.
    zones: Vec<Shape>,
    /// Domain and zones.
    container: Shape,
    /// Domain and extended zones.
    confines: Shape,
}

fn boundary_zones(inlets: &[Inlet], outlets: &[Outlet], site: &patches::Site<'_>) -> BoundaryZones {
    let (domain, spacing, dimensions) = (site.domain, site.spacing, site.dimensions);
    let (mut zones, mut container, mut confines) = (Vec::new(), vec![domain.clone()], vec![domain.clone()]);
    let extension = site.support + 3.0 * spacing;
    for (patch, inwards) in inlets
        .iter()
        .map(|inlet| (&inlet.patch, inlet.patch.towards))
        .chain(outlets.iter().map(|o| (&o.patch, -o.patch.towards)))
    {
        container.push(section::zone(domain, patch, -inwards, patch.depth, spacing, dimensions));
        let zone = section::zone(domain, patch, -inwards, patch.depth + extension, spacing, dimensions);
        confines.push(zone.clone());
        zones.push(zone);
    }
    BoundaryZones { zones, container: joined(container), confines: joined(confines) }
}

fn joined(mut shapes: Vec<Shape>) -> Shape {
    match shapes.len() {
        1 => shapes.remove(0),
        _ => Shape::Union(shapes),
    }
}

/// Returns the lattice of the fill, if it is one, to measure its fit to the walls.
pub fn lattice(fill: &Fill) -> Option<&super::lattice::Lattice> {
    match fill {
        Fill::Lattice(lattice) => Some(lattice),
        Fill::Packed(_) | Fill::WallFitted { .. } => None,
    }
}
