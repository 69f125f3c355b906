//! Pressure, convective velocity and rates of outflow particles, by the condition of their outlet.

use bevy_ecs::resource::Resource;
use bevy_ecs::system::{Local, Res, ResMut};
use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::absorb::AbsorbingZone;
use super::rows::PatchRows;
use crate::math::lattice::ETA_SQUARED;
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::rows::set_real_vector;
use crate::pass::points::{PointFit, PointFlow, PointFlows};
use crate::pass::waves::{WaveFound, sum_waves};
use crate::physics::outlet::convection::{backflow_pressure, convective_velocity};
use crate::physics::outlet::wave::WaveSetting;
use crate::physics::outlet::{Frame, OutletPressure};
use crate::scene::model::Outlet;
use crate::systems::clock::Clock;
use crate::systems::neighbours::Grid;
use crate::systems::pair::Pair;
use crate::systems::rates::Sums;
use crate::systems::setup::SceneInUse;

/// What each outlet remembers from step to step.
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct OutletStates(pub Vec<OutletState>);

/// Memory of one outlet, and what the present stage found there.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OutletState {
    /// State of an absorbing zone.
    pub absorbing: AbsorbingZone,
    /// Mean normal velocity of the fluid next to the outlet, m/s.
    pub fluid_velocity: f64,
    /// Mean pressure of the fluid next to the outlet, Pa.
    pub fluid_pressure: f64,
    /// Convective velocity of each outflow row of the outlet, m/s.
    pub convective: Vec<f64>,
}

/// Layers inside the plane at which the fluid is sampled: nearer, half of the kernel would see no fluid.
const LAYERS_INSIDE: f64 = 1.0;

fn mean(rows: &[u32], value: impl Fn(usize) -> f64) -> f64 {
    if rows.is_empty() {
        return 0.0;
    }
    rows.iter().map(|&row| value(row as usize)).sum::<f64>() / rows.len() as f64
}

/// Sets pressure and density of outflow particles and finds their convective velocities.
pub fn apply_outlets<R: Real, const D: usize>(
    scene: Res<SceneInUse>,
    clock: Res<Clock>,
    pair: Res<Pair>,
    grid: Res<Grid<D>>,
    rows: Res<PatchRows>,
    mut flows: Local<PointFlows<D>>,
    mut states: ResMut<OutletStates>,
    mut sums: ResMut<Sums<R, D>>,
    mut arrays: ResMut<ParticleArrays<R, D>>,
) {
    let scene = &*scene.0;
    states.0.resize_with(scene.outlets.len(), OutletState::default);
    for (index, outlet) in scene.outlets.iter().enumerate() {
        let normal = outlet.patch.towards;
        let (zone, before) = (&rows.outflow[index], &rows.before_outlet[index]);
        let state = &mut states.0[index];
        if !before.is_empty() {
            state.fluid_velocity = mean(before, |row| arrays.velocity_of(row).dot(normal));
            state.fluid_pressure = mean(before, |row| arrays.pressure[row].to_f64());
        }
        set_pressure(outlet, zone, clock.time_step, &mut arrays);
        let absorbs = matches!(outlet.condition.pressure(), OutletPressure::Absorbing { .. });
        flows.points.clear();
        let inside = |foot: DVec3| {
            let point = foot - normal * (LAYERS_INSIDE * scene.spacing);
            std::array::from_fn(|axis| point[axis])
        };
        flows.points.extend(zone.iter().map(|&row| {
            let x = arrays.position_of(row as usize);
            inside(x - normal * outlet.patch.along(x))
        }));
        if absorbs {
            let section = state.absorbing.section(scene, outlet);
            flows.points.extend(section.offsets.iter().map(|&offset| inside(outlet.patch.at + offset)));
        }
        let section = PointFit::Section { normal, across: outlet.patch.across };
        flows.find(section, &pair.0, &grid.0, &arrays, &mut sums.0);
        let (feet, points) = flows.found.split_at(zone.len());
        let mean = PointFlow { velocity: state.fluid_velocity, pressure: state.fluid_pressure };
        state.absorbing.advance(scene, outlet, points, mean, clock.time_step);
        let impedance = scene.fluid.density * scene.fluid.sound_speed;
        state.convective.clear();
        for (&row, found) in zone.iter().zip(feet) {
            let row = row as usize;
            let flow = found.unwrap_or(mean);
            let own = arrays.pressure[row].to_f64();
            let (pressure, velocity) = if absorbs {
                state.absorbing.at(scene, outlet, arrays.position_of(row), flow)
            } else {
                (own, convective_velocity(flow.velocity, flow.pressure, own, impedance))
            };
            arrays.pressure[row] = R::from_f64(pressure);
            state.convective.push(velocity);
        }
        // A pressure that a particle keeps from step to step must not lose its dynamic part again and again.
        let given = matches!(
            outlet.condition.pressure(),
            OutletPressure::Reference(_) | OutletPressure::Absorbing { .. }
        );
        for (&row, &velocity) in zone.iter().zip(&state.convective) {
            let row = row as usize;
            let pressure = arrays.pressure[row].to_f64();
            let pressure =
                if given { backflow_pressure(pressure, velocity, scene.fluid.density) } else { pressure };
            arrays.pressure[row] = R::from_f64(pressure);
            match pair.0.density_at(pressure) {
                Some(density) => arrays.density[row] = R::from_f64(density),
                // The divergence drives an evolved pressure: it must see the velocity with which the zone moves, not that with
                // which its particles crossed the plane, or the outlet throws back a quarter of a pulse of sound.
                None if outlet.condition.frame() == Frame::Moving => {
                    let own = arrays.velocity_of(row);
                    let moved = own + normal * (velocity - own.dot(normal));
                    set_real_vector(&mut arrays.velocity, row, moved);
                }
                None => {}
            }
        }
    }
}

fn set_pressure<R: Real, const D: usize>(
    outlet: &Outlet,
    zone: &[u32],
    time_step: f64,
    arrays: &mut ParticleArrays<R, D>,
) {
    match outlet.condition.pressure() {
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

/// Rates of outflow particles by the wave equation of their outlet, and their shifting vector.
///
/// Rods that slide past each other bring particles close together, and a vortex carries such pairs back into the fluid, whose density sees them
/// at once: so the zone is kept even by the same shifting as the fluid.
pub fn outlet_rates<R: Real, const D: usize>(
    scene: Res<SceneInUse>,
    pair: Res<Pair>,
    grid: Res<Grid<D>>,
    rows: Res<PatchRows>,
    mut waves: Local<Vec<WaveFound>>,
    mut sums: ResMut<Sums<R, D>>,
    mut arrays: ResMut<ParticleArrays<R, D>>,
) {
    let scene = &*scene.0;
    for (outlet, rows) in scene.outlets.iter().zip(&rows.outflow) {
        let setting = WaveSetting {
            frame: outlet.condition.frame(),
            transverse: outlet.condition.transverse(),
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
