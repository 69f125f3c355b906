//! Figures of a scene before it runs, as `sphecs check` prints them.

use glam::DVec3;

use super::driven_flow::{largest_pressure, pressure_difference};
use super::geometry::Shape;
use super::given_speed::inlet_speed;
use super::memory_estimate::{memory, nodes_of_fields};
use super::model::{ParticleSeed, Scene};
use super::oblique_walls;
use sphecs_core::boundary::inlet::Feed;
use sphecs_core::format::{coordinate, point, significant};

/// Returns the size of a particle in a frame before compression, B: position in f64, velocity,
/// density, pressure and tag in f32, zone and passages.
pub fn frame_bytes(dimensions: usize) -> f64 {
    (12 * dimensions + 3 * 4 + 1 + 4) as f64
}

/// The figures of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneSummary {
    /// Particles by zone, in the order of
    /// [`Zone::ALL`](sphecs_core::particles::zone::Zone::ALL).
    pub by_zone: [usize; 5],
    /// Reynolds number of the reference velocity and length.
    pub reynolds: f64,
    /// Mach number of the reference velocity.
    pub mach: f64,
    /// Time step that the sound speed allows, s.
    pub courant_step: f64,
    /// Time step that the viscosity allows, s; infinite without viscosity.
    pub viscous_step: f64,
    /// Steps to the end.
    pub steps: f64,
    /// Largest memory of the run with its output, B.
    pub memory: f64,
    /// Straight wall with the worst fit to the lattice: axis, coordinate (m) and misfit in
    /// spacings.
    pub worst_fit: Option<(char, f64, f64)>,
    /// Remarks for the user: low sound speed, misfit, an inlet that drains.
    pub notes: Vec<String>,
}

/// Returns the figures of a scene with its initial particles.
pub fn summary(scene: &Scene, seeds: &[ParticleSeed]) -> SceneSummary {
    let mut by_zone = [0; 5];
    for seed in seeds {
        by_zone[seed.zone as usize] += 1;
    }
    let speed = scene.reference_velocity;
    let viscosity = scene.fluid.viscosity;
    let courant_step = courant_step(scene);
    let viscous_step = viscous_step(scene);
    let steps = steps_to(scene, scene.time.end);
    let worst_fit = worst_fit(scene);
    SceneSummary {
        by_zone,
        reynolds: speed * scene.reference_length / viscosity,
        mach: speed / scene.fluid.sound_speed,
        courant_step,
        viscous_step,
        steps,
        memory: memory(scene, seeds.len() as f64, nodes_of_fields(scene)),
        worst_fit,
        notes: notes(scene, seeds, worst_fit),
    }
}

/// Returns the acoustic limit of the time step, s, with the signal speed of Alvarado-Rodríguez et
/// al. (2017), Eq. 18: c plus the approach velocity of neighbours.
fn courant_step(scene: &Scene) -> f64 {
    scene.time.cfl * scene.discretisation.smoothing_length
        / (scene.fluid.sound_speed + scene.reference_velocity)
}

/// Returns the viscous limit of the time step, s.
fn viscous_step(scene: &Scene) -> f64 {
    scene.time.viscous * scene.discretisation.smoothing_length.powi(2) / scene.fluid.viscosity
}

/// Returns the estimated number of steps up to a time, s.
pub fn steps_to(scene: &Scene, until: f64) -> f64 {
    (until / courant_step(scene).min(viscous_step(scene))).ceil()
}

fn worst_fit(scene: &Scene) -> Option<(char, f64, f64)> {
    let lattice = super::check::lattice(&scene.layout.fill)?;
    let worst = lattice.fits.iter().max_by(|a, b| a.misfit.total_cmp(&b.misfit))?;
    let axis = ['x', 'y', 'z'][worst.axis];
    Some((axis, worst.coordinate, worst.misfit))
}

/// Relative change of the density above which a note says so.
const COMPRESSION_NOTED: f64 = 0.01;

fn notes(scene: &Scene, seeds: &[ParticleSeed], worst_fit: Option<(char, f64, f64)>) -> Vec<String> {
    let mut notes = Vec::new();
    if scene.reference_velocity > 0.1 * scene.fluid.sound_speed {
        notes.push(format!(
            "the sound speed, {} m/s, is less than ten times the reference velocity, {} m/s: \
             density errors grow with the square of the Mach number",
            significant(scene.fluid.sound_speed),
            significant(scene.reference_velocity)
        ));
    }
    if scene.source_count() > 0 && scene.outlets.is_empty() {
        notes.push("there is no outlet: the inflow accumulates and the pressure rises".to_owned());
    }
    let is_driven = pressure_difference(scene) > 0.0;
    if scene.source_count() == 0 && !scene.outlets.is_empty() && !is_driven {
        notes.push("there is no inlet: the outlets alone determine the inflow and the outflow".to_owned());
    }
    let compression = largest_pressure(scene) / (scene.fluid.density * scene.fluid.sound_speed.powi(2));
    if compression > COMPRESSION_NOTED {
        notes.push(format!(
            "the pressures of the openings, up to {} Pa, change the density by {} %: a sound speed of {} m/s \
             would keep it below {} %",
            significant(largest_pressure(scene)),
            significant(100.0 * compression),
            significant(scene.fluid.sound_speed * (compression / COMPRESSION_NOTED).sqrt()),
            100.0 * COMPRESSION_NOTED
        ));
    }
    if let Some((axis, place, misfit)) = worst_fit.filter(|(_, _, misfit)| *misfit > 0.1) {
        notes.push(format!(
            "the wall at {axis} = {} m misses the middle between two rows by {misfit:.2} spacings: \
             a spacing that divides the widths fits better",
            coordinate(place, scene.spacing)
        ));
    }
    notes.extend(oblique_walls::notes(scene, seeds));
    for part in &scene.layout.unopened {
        let unit = if scene.dimensions == 2 { "m wide" } else { "m² large" };
        notes.push(format!(
            "the end of the domain at `{}` has another part, {} {unit}, around {} m, which stays a wall: \
             `extent: Whole` opens it too, `closed: true` says that it is a wall",
            part.opening,
            significant(part.area),
            point(&part.at.to_array()[..scene.dimensions], scene.spacing)
        ));
    }
    if scene.scheme.wcsph().is_some() && scene.initial.pressure.constant() != Some(0.0) {
        notes.push(
            "`initial.pressure` does not reach the fluid: its density is summed before the first step and its pressure \
             follows from it; to start under pressure, reduce the spacing of the particles or use a body force"
                .to_owned(),
        );
    }
    for inlet in scene.inlets.iter().filter(|inlet| inlet.feed == Feed::Once) {
        let lasts = inlet.patch.depth / inlet_speed(inlet, scene);
        if lasts < scene.time.end {
            notes.push(format!(
                "{} is filled once and drained after {} s by its fastest flow: the run stops there, before its end at {} s",
                inlet.patch.name,
                significant(lasts),
                significant(scene.time.end)
            ));
        }
    }
    notes
}

/// Returns the volume (area in 2D) within `reach` of a domain, m³ (m²), from samples, accurate to 1
/// to 2 %.
pub fn estimated_volume(domain: &Shape, reach: f64, dimensions: usize) -> f64 {
    let (low, high) = domain.bounds();
    let (low, high) = (low - DVec3::splat(reach), high + DVec3::splat(reach));
    // Samples by an additive recurrence with powers of the root of x^(d+1) = x + 1. They are
    // uniform in all directions; the rows of a grid could miss a thin duct.
    const SAMPLES: u32 = 1 << 14;
    let root: f64 = if dimensions == 2 { 1.324_717_957_244_746 } else { 1.220_744_084_605_759_6 };
    let mut hits = 0;
    for index in 0..SAMPLES {
        let mut at = DVec3::ZERO;
        for axis in 0..dimensions {
            let share = (0.5 + f64::from(index) * root.powi(-1 - axis as i32)).fract();
            at[axis] = low[axis] + share * (high[axis] - low[axis]);
        }
        hits += u32::from(domain.signed_distance(at) <= reach);
    }
    let extent = high - low;
    let volume: f64 = (0..dimensions).map(|axis| extent[axis]).product();
    volume * f64::from(hits) / f64::from(SAMPLES)
}
