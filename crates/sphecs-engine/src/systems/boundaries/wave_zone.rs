//! The zone of a wave equation: pressure, convective velocity and rates of its particles.

use bevy_ecs::system::{Local, Res, ResMut};
use glam::DVec3;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::outlets::{OutletStage, OutletState};
use super::rows::PatchRows;
use crate::arrays::Arrays;
use crate::resources::grid::Grid;
use crate::resources::pair::Pair;
use crate::resources::pair_sums::Sums;
use crate::resources::scene::ActiveScene;
use sphecs_core::math::lattice::ETA_SQUARED;
use sphecs_core::math::real::Real;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::rows::set_real_vector;
use sphecs_core::pass::fits::PointFit;
use sphecs_core::pass::waves::{WaveFound, sum_waves};
use sphecs_core::physics::outlet::convection::{backflow_pressure, convective_velocity};
use sphecs_core::physics::outlet::wave::WaveSetting;
use sphecs_core::physics::outlet::{Frame, OutletPressure};

/// Particles of the zone that a thread takes at least.
const CHUNK: usize = 64;

/// Layers inside the plane at which the fluid is sampled: nearer, half of the kernel would see no fluid.
const LAYERS_INSIDE: f64 = 1.0;

/// Sets pressure and density of the zone of a wave equation and finds its convective velocities.
pub fn apply_wave<R: Real, const D: usize>(stage: &mut OutletStage<'_, R, D>, state: &mut OutletState) {
    let (scene, outlet, zone, normal) = (stage.scene, stage.outlet, stage.zone, stage.normal());
    let Some(wave) = outlet.condition.wave() else { return };
    set_pressure(wave.pressure, zone, stage.time_step, stage.arrays);
    let absorbs = matches!(wave.pressure, OutletPressure::Absorbing { .. });
    let inside = |foot: DVec3| foot - normal * (LAYERS_INSIDE * scene.spacing);
    let offsets = if absorbs { state.absorbing.section(scene, outlet).offsets.as_slice() } else { &[] };
    let section = PointFit::Section { normal, across: outlet.patch.across };
    stage.find_at_zone(
        section,
        |point| inside(point - normal * outlet.patch.along(point)),
        offsets.iter().map(|&offset| inside(outlet.patch.at + offset)),
    );
    let mean = state.mean();
    let points = &stage.found()[zone.len()..];
    state.absorbing.advance(scene, outlet, points, mean, stage.time_step);
    let impedance = stage.impedance();
    // A pressure that a particle keeps from step to step must not lose its dynamic part again and again.
    let given = matches!(wave.pressure, OutletPressure::Reference(_) | OutletPressure::Absorbing { .. });
    let mut of_zone = std::mem::take(&mut stage.buffers.of_zone);
    let (arrays, found, pair) = (&*stage.arrays, stage.found(), stage.pair);
    let absorbing = &state.absorbing;
    let moves = zone.par_iter().enumerate().with_min_len(CHUNK).map(|(at, &row)| {
        let row = row as usize;
        let flow = found[at].unwrap_or(mean);
        let own = arrays.pressure[row].to_f64();
        let (pressure, velocity) = if absorbs {
            absorbing.at(scene, outlet, arrays.position_of(row), flow)
        } else {
            (own, convective_velocity(flow.velocity, flow.pressure, own, impedance))
        };
        let pressure =
            if given { backflow_pressure(pressure, velocity, scene.fluid.density) } else { pressure };
        ZoneMove { pressure, velocity, density: pair.density_at(pressure) }
    });
    moves.collect_into_vec(&mut of_zone);
    for (&row, &ZoneMove { pressure, velocity, density }) in zone.iter().zip(&of_zone) {
        let row = row as usize;
        stage.arrays.pressure[row] = R::from_f64(pressure);
        state.convective.push(velocity);
        match density {
            Some(density) => stage.arrays.density[row] = R::from_f64(density),
            // The divergence drives an evolved pressure: it must see the velocity with which the zone moves, not that with
            // which its particles crossed the plane, or the outlet throws back a quarter of a pulse of sound.
            None if wave.frame == Frame::Moving => {
                let own = stage.arrays.velocity_of(row);
                let moved = own + normal * (velocity - own.dot(normal));
                set_real_vector(&mut stage.arrays.velocity, row, moved);
            }
            None => {}
        }
    }
    stage.buffers.of_zone = of_zone;
}

/// What a step finds for a particle of the zone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZoneMove {
    /// Pressure, Pa.
    pressure: f64,
    /// Convective velocity, m/s.
    velocity: f64,
    /// Density that the pressure belongs to, kg/m³; None where it is summed.
    density: Option<f64>,
}

fn set_pressure<R: Real, const D: usize>(
    pressure: OutletPressure,
    zone: &[u32],
    time_step: f64,
    arrays: &mut ParticleArrays<R, D>,
) {
    match pressure {
        OutletPressure::Frozen => {}
        OutletPressure::Reference(pressure) => {
            for &row in zone {
                arrays.pressure[row as usize] = R::from_f64(pressure);
            }
        }
        OutletPressure::Relaxed { target, time } => {
            let share = -(-time_step / time).exp_m1();
            for &row in zone {
                let pressure = arrays.pressure[row as usize].to_f64();
                arrays.pressure[row as usize] = R::from_f64(pressure + share * (target - pressure));
            }
        }
        // See `absorb`.
        OutletPressure::Absorbing { .. } => {}
    }
}

/// Rates of outflow particles by the wave equation of their outlet, and their shifting vector; none of either under another condition.
///
/// Rods that slide past each other bring particles close together, and a vortex carries such pairs back into the fluid, whose density sees them
/// at once: so the zone of a wave equation is kept even by the same shifting as the fluid.
pub fn outlet_rates<R: Real, const D: usize>(
    scene: Res<ActiveScene>,
    pair: Res<Pair>,
    grid: Res<Grid<D>>,
    rows: Res<PatchRows>,
    mut waves: Local<Vec<WaveFound>>,
    mut sums: ResMut<Sums<R, D>>,
    mut arrays: ResMut<Arrays<R, D>>,
) {
    let scene = &*scene.0;
    for (outlet, rows) in scene.outlets.iter().zip(&rows.outflow) {
        let Some(wave) = outlet.condition.wave() else {
            for &row in rows {
                set_real_vector(&mut arrays.acceleration, row as usize, DVec3::ZERO);
                set_real_vector(&mut sums.0.shift, row as usize, DVec3::ZERO);
            }
            continue;
        };
        let setting = WaveSetting {
            frame: wave.frame,
            transverse: wave.transverse,
            normal: outlet.patch.towards,
            dimensions: scene.dimensions,
            eta_squared: ETA_SQUARED,
            viscosity: scene.fluid.viscosity,
        };
        sum_waves(&setting, &pair.0, &grid.0, &arrays, &mut sums.0, rows, &mut waves);
        for (&row, wave) in rows.iter().zip(&*waves) {
            let row = row as usize;
            set_real_vector(&mut arrays.acceleration, row, wave.sums.rate(&setting));
            let mut concentration = wave.concentration;
            // Beyond the far end there is nothing: the normal part would empty the zone.
            if outlet.patch.along(arrays.position_of(row)) > outlet.patch.depth - pair.0.support() {
                concentration -= setting.normal * concentration.dot(setting.normal);
            }
            set_real_vector(&mut sums.0.shift, row, concentration);
        }
    }
}
