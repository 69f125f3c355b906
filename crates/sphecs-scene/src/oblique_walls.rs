//! Notes on walls oblique to the lattice, before a run.
//!
//! The particles of such a wall are stairs. Measured with 20 particles across, Re = 20, at 37°
//! (docs/validation/orientation.md): a plug between free-slip walls had 0.82 to 1.17 of the
//! stream's speed, and the pressure of a no-slip channel swung eight times as much as along the
//! lattice, with a gradient 3 % too steep.

use super::lattice::Lattice;
use super::lattice_rotation::wall_directions;
use super::model::{Fill, ParticleSeed, Scene, WallPart};
use sphecs_core::particles::zone::Zone;
use sphecs_core::physics::wall::Slip;

/// Smallest share of a wall that is noted in 2D and in 3D, where edges of ducts count as oblique.
const LEAST_SHARE: [f64; 2] = [0.1, 0.25];

/// Fewest particles or spacings of a wall that are noted.
const FEWEST: f64 = 8.0;

/// Returns what is lost along walls oblique to the lattice.
pub fn notes(scene: &Scene, seeds: &[ParticleSeed]) -> Vec<String> {
    let Fill::Lattice(lattice) = &scene.layout.fill else { return Vec::new() };
    if !scene.layout.walled {
        return Vec::new();
    }
    let cure = "`fill: Layers` of the wall avoids them";
    let parts = scene.walls.parts.iter().enumerate();
    let mut notes: Vec<String> = parts
        .filter(|(_, part)| part.slip != Slip::NoSlip)
        .filter_map(|(index, part)| {
            let share = slipping_share(scene, lattice, seeds, index as u16)?;
            Some(format!(
                "{:.0} % of the free-slip surface of `{}` lies oblique to the lattice, on stairs of wall particles, \
                 which brake the flow as a rough wall does: {cure}",
                100.0 * share,
                part.name
            ))
        })
        .collect();
    if let Some(share) = sticking_share(scene, lattice) {
        notes.push(format!(
            "{:.0} % of the plane walls lie oblique to the lattice, on stairs of wall particles: the pressure of \
             `Wcsph` swings several times as much as between walls along the lattice, and its gradient is some \
             percent too steep; {cure}",
            100.0 * share
        ));
    }
    notes
}

/// Returns the share of the particles next to the surface of a wall part whose surface is oblique
/// to the lattice; None if it is too small to be noted.
fn slipping_share(scene: &Scene, lattice: &Lattice, seeds: &[ParticleSeed], part: u16) -> Option<f64> {
    if scene.layout.layered.contains(&part) {
        return None;
    }
    let is_on_rings = |seed: &ParticleSeed| {
        scene.layout.rings.iter().any(|rings| seed.position.distance(rings.centre) < rings.radius)
    };
    let (mut all, mut oblique) = (0.0, 0.0);
    for seed in seeds.iter().filter(|seed| seed.zone == Zone::Wall && seed.patch == part) {
        if seed.wall_distance < scene.spacing && !is_on_rings(seed) {
            all += 1.0;
            oblique += f64::from(u8::from(lattice.is_oblique(seed.wall_normal)));
        }
    }
    is_noted(scene, oblique, all)
}

/// Returns the share of oblique plane walls under `Wcsph`, where no wall part lies in layers or
/// slips; None if it is too small to be noted.
fn sticking_share(scene: &Scene, lattice: &Lattice) -> Option<f64> {
    let slips = |part: &WallPart| part.slip != Slip::NoSlip;
    if scene.scheme.wcsph().is_none()
        || !scene.layout.layered.is_empty()
        || scene.walls.parts.iter().any(slips)
    {
        return None;
    }
    let patches: Vec<_> = super::fill::patches(scene).map(|(patch, _)| patch).collect();
    let walls = wall_directions(&scene.domain, &patches, scene.spacing, scene.dimensions);
    let of_a_spacing = scene.spacing.powi(scene.dimensions as i32 - 1);
    let area = |is_counted: &dyn Fn(glam::DVec3) -> bool| {
        walls.iter().filter(|wall| is_counted(wall.0)).map(|wall| wall.1).sum::<f64>() / of_a_spacing
    };
    is_noted(scene, area(&|direction| lattice.is_oblique(direction)), area(&|_| true))
}

fn is_noted(scene: &Scene, oblique: f64, all: f64) -> Option<f64> {
    let least = LEAST_SHARE[scene.dimensions - 2];
    (oblique >= FEWEST && oblique >= least * all).then(|| oblique / all)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spawn;

    fn notes_of(fields: &str) -> Vec<String> {
        let text = format!(
            "Scene(title: \"t\", dimensions: 2, spacing: 0.05, smoke: 0.1,
                fluid: (density: 1000.0, viscosity: 1.0e-3, sound_speed: 15.0),
                initial: (velocity: (0.1, 0.0)), time: (end: 1.0), output: (every: 1.0), {fields})"
        );
        let scene = Scene::from_text("walls", &text).load().unwrap_or_else(|faults| panic!("{faults:?}"));
        notes(&scene, &spawn::seeds(&scene))
    }

    const WEDGE: &str = "domain: Polygon(points: [(0.0, -0.3), (1.5, -0.5), (1.5, 0.5), (0.0, 0.3)]),";
    const STEP: &str =
        "domain: Union([Box(min: (0.0, 0.0), max: (1.0, 0.5)), Box(min: (0.5, -0.5), max: (1.0, 0.0))]),";
    const DRUM: &str = "domain: Circle(center: (0.0, 0.0), radius: 0.5),";

    #[test]
    fn what_stairs_cost_is_said_before_the_run() {
        let said = |fields: &str, words: &str| {
            let notes = notes_of(fields);
            assert!(notes.len() == 1 && notes[0].contains(words), "{fields}: {notes:?}");
        };
        said(&format!("{WEDGE} walls: (slip: FreeSlip)"), "brake the flow");
        said(&format!("{DRUM} walls: (slip: FreeSlip)"), "100 % of the free-slip surface of `walls`");
        said(WEDGE, "65 % of the plane walls lie oblique");
        for fields in [
            STEP.to_owned(),
            format!("{STEP} walls: (slip: FreeSlip)"),
            format!("{WEDGE} walls: (slip: FreeSlip, fill: Layers)"),
            format!("{WEDGE} scheme: EdacTvf()"),
            format!("{WEDGE} walls: (fill: Layers)"),
            DRUM.to_owned(),
        ] {
            assert_eq!(notes_of(&fields), Vec::<String>::new(), "{fields}");
        }
    }
}
