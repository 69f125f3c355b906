//! Fill fitted to walls of any shape: zones, fluid and walls of even density, each of its volume.
//!
//! On a lattice the fluid before curved or oblique walls ends in stairs, its mass is off by some
//! percent in narrow sections, and the first steps of a run smooth the stairs by sound. `Packed`
//! has walls in [layers](super::layers), columns (`sections`) in the zones of openings, and as much
//! fluid as the domain has volume (`cell_shares`). Where the density then differs from that of the
//! lattice, the fluid is relaxed (`relaxation`). A domain along the lattice keeps its lattice.

mod cell_shares;
mod relaxation;
mod sections;

use glam::DVec3;

use cell_shares::Cells;
use relaxation::{concentrations, relax};
use sections::{Columns, held_by};
use sphecs_core::math::lattice::LatticeSums;
use sphecs_core::particles::zone::Zone;

use super::fill::{Place, beyond, confined_distance, lattice_ranges, patches, wall_thickness};
use super::lattice::Lattice;
use super::model::{Patch, Scene};
use super::near_points::Region;

/// Relative deviation of the density from that of the lattice above which fluid is relaxed.
const DISTURBED: f64 = 3e-3;

/// Distance from disturbed fluid up to which the fluid is relaxed, in spacings.
const AROUND: f64 = 6.0;

/// Smallest distance of a relaxed particle from a wall, in spacings.
const KEPT_FROM_WALLS: f64 = 0.25;

/// Replaces the fluid and the zones of the lattice among the places of a scene.
pub fn pack(scene: &Scene, lattice: &Lattice, places: &mut Vec<Place>) {
    let zones: Vec<(&Patch, bool, Columns)> = patches(scene)
        .enumerate()
        .map(|(number, (patch, is_inlet))| {
            (patch, is_inlet, Columns::of(scene, lattice, number, patch, is_inlet))
        })
        .collect();
    places.retain(|place| place.zone == Zone::Wall);
    for (number, (patch, is_inlet, columns)) in zones.iter().enumerate() {
        let zone = if *is_inlet { Zone::Inflow } else { Zone::Outflow };
        let outwards = if *is_inlet { -patch.towards } else { patch.towards };
        let number = if *is_inlet { number } else { number - scene.inlets.len() };
        for foot in &columns.feet {
            places.extend(columns.rows.iter().map(|row| Place {
                position: *foot + outwards * *row,
                zone,
                patch: number as u16,
            }));
        }
    }
    let fluid = packed_fluid(scene, lattice, &zones, places);
    places.extend(fluid.into_iter().map(|position| Place { position, zone: Zone::Fluid, patch: 0 }));
}

/// Returns the places of the columns of an inlet in its plane, m, each with its cross-section, m²
/// (m in 2D).
pub fn inlet_columns(scene: &Scene, lattice: &Lattice, inlet: usize) -> Vec<(DVec3, f64)> {
    let patch = &scene.inlets[inlet].patch;
    let columns = Columns::of(scene, lattice, inlet, patch, true);
    // Particles of a column have the volume of a cell over its length.
    let area = scene.discretisation.cell_volume() * columns.rows.len() as f64 / patch.depth;
    columns.feet.into_iter().map(|foot| (foot, area)).collect()
}

/// Returns fluid of even density amid the particles of walls and zones, m.
fn packed_fluid(
    scene: &Scene,
    lattice: &Lattice,
    zones: &[(&Patch, bool, Columns)],
    others: &[Place],
) -> Vec<DVec3> {
    let dimensions = scene.dimensions;
    let ranges = lattice_ranges(scene, lattice, &scene.layout.casing.confines, scene.spacing);
    let centre = |cell: [usize; 3]| {
        lattice.point(std::array::from_fn(|axis| ranges[axis].start + cell[axis] as i64), dimensions)
    };
    let mut edges = [DVec3::ZERO; 3];
    for (axis, edge) in edges.iter_mut().enumerate().take(dimensions) {
        *edge = lattice.rotation.col(axis) * lattice.spacing[axis];
    }
    let cells = Cells {
        dimensions,
        counts: ranges.each_ref().map(|range| (range.end - range.start).max(0) as usize),
        edges,
        centre: &centre,
        distance: &|point| confined_distance(scene, point),
        is_in_front: &|point| is_in_front(scene, zones, point),
    };
    let mut fluid = cells.selected();
    let others: Vec<DVec3> = others.iter().map(|place| place.position).collect();
    match dimensions {
        2 => even::<2>(scene, zones, &mut fluid, others),
        _ => even::<3>(scene, zones, &mut fluid, others),
    }
    fluid
}

/// Relaxes the fluid near places where its density is not that of the lattice.
fn even<const D: usize>(
    scene: &Scene,
    zones: &[(&Patch, bool, Columns)],
    fluid: &mut Vec<DVec3>,
    mut others: Vec<DVec3>,
) {
    let (spacing, lengths) = (scene.spacing, &scene.discretisation);
    let region = region(scene);
    let lattice = LatticeSums::new(lengths.kernel, lengths.smoothing_ratio, D).density;
    let all: Vec<DVec3> = fluid.iter().chain(&others).copied().collect();
    let shares = concentrations::<D>(fluid, &all, &region, lengths);
    let disturbed =
        fluid.iter().zip(&shares).filter(|(_, share)| (**share / lattice - 1.0).abs() > DISTURBED);
    let disturbed: Vec<DVec3> = disturbed.map(|(point, _)| *point).collect();
    // Points near disturbed ones have a sum over these with a wide kernel.
    let wide = sphecs_core::discretisation::Discretisation {
        smoothing_length: AROUND * spacing / lengths.kernel.support_ratio(),
        support: AROUND * spacing,
        ..*lengths
    };
    let near = concentrations::<D>(fluid, &disturbed, &region, &wide);
    let mut moving = Vec::new();
    let mut is_moving = near.iter().map(|sum| *sum > 0.0);
    fluid.retain(|point| {
        let moves = is_moving.next() == Some(true);
        if moves {
            moving.push(*point);
        }
        !moves
    });
    others.extend(fluid.iter());
    let held = |to: DVec3, bound: f64| {
        let (mut to, mut bound) = held_by(to, bound, spacing, D, &|point| confined_distance(scene, point));
        for (number, (patch, is_inlet, columns)) in zones.iter().enumerate() {
            let past = beyond(patch, *is_inlet, to) - columns.start + KEPT_FROM_WALLS * spacing;
            if past > 0.0 && is_before_zone(scene, number, patch, *is_inlet, to) {
                let outwards = if *is_inlet { -patch.towards } else { patch.towards };
                to -= outwards * past;
                bound += past;
            }
        }
        (to, bound)
    };
    relax::<D>(&mut moving, &others, &region, lengths, held);
    fluid.extend(moving);
}

/// Returns the box of all particles, with its periodic directions.
fn region(scene: &Scene) -> Region {
    let margin = DVec3::splat(wall_thickness(scene) + scene.spacing);
    let (low, high) = scene.layout.casing.confines.bounds();
    Region::of(scene, low - margin, high + margin)
}

/// Returns true if a point lies in front of the zones of all openings.
fn is_in_front(scene: &Scene, zones: &[(&Patch, bool, Columns)], point: DVec3) -> bool {
    zones.iter().enumerate().all(|(number, (patch, is_inlet, columns))| {
        beyond(patch, *is_inlet, point) <= columns.start
            || !is_before_zone(scene, number, patch, *is_inlet, point)
    })
}

/// Returns true if a point is in the zone of an opening, or in front of it by less than a spacing.
fn is_before_zone(scene: &Scene, number: usize, patch: &Patch, is_inlet: bool, point: DVec3) -> bool {
    let past = beyond(patch, is_inlet, point);
    if past < -scene.spacing {
        return false;
    }
    let outwards = if is_inlet { -patch.towards } else { patch.towards };
    let inside = point + outwards * (0.5 * scene.spacing - past).max(0.0);
    scene.layout.zones[number].contains(inside, 0.5 * scene.spacing)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::model::ParticleSeed;
    use crate::spawn::seeds;

    fn scene(dimensions: usize, fill: &str, fields: &str) -> Scene {
        let rest = if dimensions == 2 { "(0.0, 0.0)" } else { "(0.0, 0.0, 0.0)" };
        let text = format!(
            "Scene(title: \"t\", dimensions: {dimensions}, spacing: 0.05, smoke: 0.1, fill: {fill},
                fluid: (density: 1000.0, viscosity: 1.0e-3, sound_speed: 15.0), initial: (velocity: {rest}),
                time: (end: 1.0), output: (every: 1.0), reference: (velocity: 1.0), {fields})"
        );
        Scene::from_text("packed", &text).load().unwrap_or_else(|faults| panic!("{faults:?}"))
    }

    fn positions(seeds: &[ParticleSeed], zone: Zone) -> Vec<DVec3> {
        seeds.iter().filter(|seed| seed.zone == zone).map(|seed| seed.position).collect()
    }

    /// Checks that the fluid has a volume, m³ (m² in 2D), and nearly the density of the lattice.
    fn check<const D: usize>(domain: &str, volume: f64) {
        let scene = scene(D, "Packed()", domain);
        let seeds = seeds(&scene);
        let lengths = &scene.discretisation;
        let (cell, fluid) = (lengths.cell_volume(), positions(&seeds, Zone::Fluid));
        let off = fluid.len() as f64 - volume / cell;
        // The volume of a cut cell is known to a hundredth or so of the cell.
        assert!(off.abs() < 1.0 + 2e-3 * volume / cell, "{domain}: {off} particles too many");
        let all: Vec<DVec3> = seeds.iter().map(|seed| seed.position).collect();
        let lattice = LatticeSums::new(lengths.kernel, lengths.smoothing_ratio, D).density;
        for (point, share) in fluid.iter().zip(concentrations::<D>(&fluid, &all, &region(&scene), lengths)) {
            assert!(
                (share / lattice - 1.0).abs() < 0.011,
                "{domain}: density {} at {point}",
                share / lattice
            );
        }
    }

    #[test]
    fn fluid_around_a_circle_has_its_mass_and_an_even_density() {
        check::<2>("domain: Circle(center: (0.01, 0.02), radius: 0.8)", PI * 0.64);
        check::<2>(
            "domain: Difference([Box(min: (-1.0, -1.0), max: (1.0, 1.0)), Circle(center: (0.01, 0.02), radius: 0.4)])",
            4.0 - PI * 0.16,
        );
    }

    #[test]
    fn fluid_in_a_sphere_has_its_mass_and_an_even_density() {
        check::<3>("domain: Sphere(center: (0.01, 0.02, 0.03), radius: 0.5)", 4.0 / 3.0 * PI * 0.125);
    }

    const RING: &str =
        "domain: Difference([Cylinder(from: (0.0, 0.0, 0.0), to: (0.5, 0.0, 0.0), radius: 0.6),
            Cylinder(from: (-1.0, 0.0, 0.0), to: (2.0, 0.0, 0.0), radius: 0.3)]),
        inlets: [(at: (0.0, 0.45, 0.0), towards: (1.0, 0.0, 0.0), velocity: MassFlow(rate: 1.0))],
        outlets: [(at: (0.5, 0.45, 0.0), towards: (1.0, 0.0, 0.0))]";

    /// The columns have the area of the ring, so that a prescribed velocity carries its mass flow.
    #[test]
    fn columns_of_a_ring_have_its_area() {
        check::<3>(RING, 0.5 * PI * (0.36 - 0.09));
        let scene = scene(3, "Packed()", RING);
        let seeds = seeds(&scene);
        let feet = seeds.iter().filter(|seed| seed.zone == Zone::Inflow).map(|seed| {
            assert!(seed.position.x < 0.0, "{}", seed.position);
            (seed.position.y.to_bits(), seed.position.z.to_bits())
        });
        let feet: std::collections::BTreeSet<_> = feet.collect();
        let area = feet.len() as f64 * 0.0025;
        assert!((area / (PI * 0.27) - 1.0).abs() < 0.005, "{area} m²");
        let velocity = scene.inlets[0].velocity_at(scene.fluid.viscosity, DVec3::new(0.0, 0.45, 0.0), 0.0);
        assert!((velocity.x * 1000.0 * area - 1.0).abs() < 1e-9, "{velocity}");
    }

    /// A channel that fits has its lattice, along the axes and turned.
    #[test]
    fn fitted_channels_keep_their_lattice() {
        for domain in [
            "Box(min: (0.0, 0.0), max: (2.0, 1.0))",
            "Rotated(angle: 20.0, shape: Box(min: (0.0, 0.0), max: (2.0, 1.0)))",
        ] {
            let (s, c) = if domain.starts_with('R') { 20.0_f64.to_radians().sin_cos() } else { (0.0, 1.0) };
            let openings = format!(
                "domain: {domain}, inlets: [(at: ({}, {}), towards: ({c}, {s}), velocity: Normal(1.0))],
                    outlets: [(at: ({}, {}), towards: ({c}, {s}))]",
                -0.5 * s,
                0.5 * c,
                2.0 * c - 0.5 * s,
                2.0 * s + 0.5 * c
            );
            let [lattice, packed] = ["Lattice()", "Packed()"].map(|fill| seeds(&scene(2, fill, &openings)));
            for zone in [Zone::Fluid, Zone::Wall, Zone::Inflow, Zone::Outflow] {
                let (lattice, packed) = (positions(&lattice, zone), positions(&packed, zone));
                assert_eq!(lattice.len(), packed.len(), "{zone:?} of {domain}");
                for point in packed {
                    let nearest =
                        lattice.iter().map(|other| other.distance(point)).fold(f64::INFINITY, f64::min);
                    assert!(nearest < 1e-9, "{zone:?} at {point}, {nearest} m off");
                }
            }
        }
    }

    /// Three threads place the particles as one does.
    #[test]
    fn places_do_not_depend_on_the_number_of_threads() {
        let scene = scene(3, "Packed()", RING);
        let [one, three] = [1, 3].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| seeds(&scene)).into_iter().map(|seed| seed.position).collect::<Vec<_>>()
        });
        assert_eq!(one, three);
    }
}
