//! Outlets: what each remembers, and which room applies its condition.
//!
//! A condition sets the pressure of its zone; under `Wcsph` the density follows from it, under `EdacTvf` it is summed. It says with
//! which speed the zone moves along the normal, and what the fluid sees of its velocity.

use bevy_ecs::resource::Resource;
use bevy_ecs::system::{Local, Res, ResMut};
use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::absorb::AbsorbingZone;
use super::hybrid::{HybridZone, apply_hybrid};
use super::kept::{apply_characteristic, apply_do_nothing, apply_mirror, apply_modified_do_nothing};
use super::rows::PatchRows;
use super::wave_zone::{ZoneMove, apply_wave};
use crate::arrays::Arrays;
use crate::resources::clock::Clock;
use crate::resources::grid::Grid;
use crate::resources::pair::Pair;
use crate::resources::pair_sums::Sums;
use crate::resources::scene::ActiveScene;
use sphecs_core::math::grid::CellGrid;
use sphecs_core::math::real::Real;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::rows::set_real_vector;
use sphecs_core::pass::fits::{PointFit, PointFlow};
use sphecs_core::pass::points::PointFlows;
use sphecs_core::pass::settings::PairSettings;
use sphecs_core::pass::sums::PairSums;
use sphecs_core::physics::outlet::characteristic::References;
use sphecs_core::physics::outlet::{Outflow, OutletCondition};
use sphecs_scene::model::{Outlet, Scene};

/// What each outlet remembers from step to step.
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct OutletStates(pub Vec<OutletState>);

/// Memory of one outlet, and what the present stage found there.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OutletState {
    /// State of an absorbing zone.
    pub absorbing: AbsorbingZone,
    /// State of a hybrid zone.
    pub hybrid: HybridZone,
    /// Mean normal velocity of the fluid next to the outlet, m/s.
    pub fluid_velocity: f64,
    /// Mean pressure of the fluid next to the outlet, Pa.
    pub fluid_pressure: f64,
    /// Speed along the normal with which each outflow row of the outlet moves, m/s.
    pub convective: Vec<f64>,
}

impl OutletState {
    /// The mean flow next to the outlet.
    pub fn mean(&self) -> PointFlow {
        PointFlow { velocity: self.fluid_velocity, pressure: self.fluid_pressure, ..PointFlow::default() }
    }
}

/// What the conditions of a stage work on.
pub struct OutletStage<'a, R: Real, const D: usize> {
    /// The scene.
    pub scene: &'a Scene,
    /// The outlet.
    pub outlet: &'a Outlet,
    /// Rows by patch.
    pub rows: &'a PatchRows,
    /// Outflow rows of the outlet.
    pub zone: &'a [u32],
    /// Number of the outlet.
    pub index: usize,
    /// Size of the last step, s.
    pub time_step: f64,
    /// Settings of the pair sums.
    pub pair: &'a PairSettings,
    grid: &'a CellGrid<D>,
    pub(super) buffers: &'a mut OutletBuffers<R, D>,
    sums: &'a mut PairSums<R, D>,
    /// The particles.
    pub arrays: &'a mut ParticleArrays<R, D>,
}

/// Points with the fluid found at them, and a column that a mean is taken of; kept from step to step.
#[derive(Default)]
pub struct OutletBuffers<R: Real, const D: usize> {
    flows: PointFlows<D>,
    column: Vec<R>,
    /// What a wave equation's stage found for the rows of its zone.
    pub(super) of_zone: Vec<ZoneMove>,
}

impl<R: Real, const D: usize> OutletStage<'_, R, D> {
    /// Unit normal of the outlet.
    pub fn normal(&self) -> DVec3 {
        self.outlet.patch.towards
    }

    /// ρ0 c0, kg/(m² s).
    pub fn impedance(&self) -> f64 {
        self.scene.fluid.density * self.scene.fluid.sound_speed
    }

    /// Velocity (m/s) and pressure (Pa) of a row.
    pub fn own(&self, row: usize) -> (DVec3, f64) {
        (self.arrays.velocity_of(row), self.arrays.pressure[row].to_f64())
    }

    /// Fits the fluid at the places of the zone's particles, moved, and then at others.
    pub fn find_at_zone(
        &mut self,
        fit: PointFit,
        moved: impl Fn(DVec3) -> DVec3,
        others: impl Iterator<Item = DVec3>,
    ) {
        let (zone, flows) = (self.zone, &mut self.buffers.flows);
        let points = zone.iter().map(|&row| moved(self.arrays.position_of(row as usize))).chain(others);
        flows.points.clear();
        flows.points.extend(points.map(|point| std::array::from_fn(|axis| point[axis])));
        flows.find(fit, self.pair, self.grid, self.arrays, self.sums);
    }

    /// Takes means over the fluid at the zone's particles of what rows have, 0 for those that are not named.
    pub fn find_mean(&mut self, values: impl Iterator<Item = (usize, f64)>) {
        let OutletBuffers { flows, column, .. } = &mut *self.buffers;
        column.clear();
        column.resize(self.arrays.len(), R::default());
        for (row, value) in values {
            column[row] = R::from_f64(value);
        }
        flows.points.clear();
        flows.points.extend(self.zone.iter().map(|&row| {
            let point = self.arrays.position_of(row as usize);
            std::array::from_fn(|axis| point[axis])
        }));
        flows.find_mean(column, self.pair, self.grid, self.arrays, self.sums);
    }

    /// What was found at the points.
    pub fn found(&self) -> &[Option<PointFlow>] {
        &self.buffers.flows.found
    }

    /// Mean of what was found where there is fluid; None where there is none anywhere.
    pub fn mean_found(&self, value: impl Fn(&PointFlow) -> f64) -> Option<f64> {
        let (mut sum, mut count) = (0.0, 0);
        for flow in self.found().iter().flatten() {
            sum += value(flow);
            count += 1;
        }
        (count > 0).then(|| sum / f64::from(count))
    }

    /// Gives a row what the condition says.
    pub fn set(&mut self, row: usize, outflow: Outflow, state: &mut OutletState) {
        self.arrays.pressure[row] = R::from_f64(outflow.pressure);
        if let Some(density) = self.pair.density_at(outflow.pressure) {
            self.arrays.density[row] = R::from_f64(density);
        }
        set_real_vector(&mut self.arrays.velocity, row, outflow.velocity);
        state.convective.push(outflow.speed);
    }
}

fn mean(rows: &[u32], value: impl Fn(usize) -> f64) -> f64 {
    rows.iter().map(|&row| value(row as usize)).sum::<f64>() / rows.len() as f64
}

/// Sets pressure, density and velocity of outflow particles and finds with which speed they move.
pub fn apply_outlets<R: Real, const D: usize>(
    scene: Res<ActiveScene>,
    clock: Res<Clock>,
    pair: Res<Pair>,
    grid: Res<Grid<D>>,
    rows: Res<PatchRows>,
    mut buffers: Local<OutletBuffers<R, D>>,
    mut states: ResMut<OutletStates>,
    mut sums: ResMut<Sums<R, D>>,
    mut arrays: ResMut<Arrays<R, D>>,
) {
    let scene = &*scene.0;
    states.0.resize_with(scene.outlets.len(), OutletState::default);
    for (index, outlet) in scene.outlets.iter().enumerate() {
        let state = &mut states.0[index];
        let before = &rows.before_outlet[index];
        if !before.is_empty() {
            let normal = outlet.patch.towards;
            state.fluid_velocity = mean(before, |row| arrays.velocity_of(row).dot(normal));
            state.fluid_pressure = mean(before, |row| arrays.pressure[row].to_f64());
        }
        state.convective.clear();
        let mut stage = OutletStage {
            scene,
            outlet,
            rows: &rows,
            zone: &rows.outflow[index],
            index,
            time_step: clock.time_step,
            pair: &pair.0,
            grid: &grid.0,
            buffers: &mut buffers,
            sums: &mut sums.0,
            arrays: &mut arrays,
        };
        match outlet.condition {
            OutletCondition::WaveEquation { .. } | OutletCondition::Orlanski { .. } => {
                apply_wave(&mut stage, state);
            }
            OutletCondition::DoNothing => apply_do_nothing(&mut stage, state),
            OutletCondition::ModifiedDoNothing { shown } => {
                apply_modified_do_nothing(&mut stage, shown, state);
            }
            OutletCondition::Mirror { variant } => apply_mirror(&mut stage, variant, state),
            OutletCondition::Characteristic { velocity, pressure } => {
                apply_characteristic(&mut stage, References { velocity, pressure }, state);
            }
            OutletCondition::Hybrid { velocity, pressure, steps } => {
                apply_hybrid(&mut stage, velocity, pressure, steps, state);
            }
        }
    }
}
