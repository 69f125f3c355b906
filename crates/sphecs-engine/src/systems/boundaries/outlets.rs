//! Outlets of a simulation: conditions with their memory, and the systems that apply them.
//!
//! A condition sets the pressure of its zone. Under `Wcsph` the density follows from it, under
//! `EdacTvf` it is summed. The condition also sets the speed at which the zone moves along the
//! normal and the velocity that the fluid sees.

use std::marker::PhantomData;

use bevy_ecs::resource::Resource;
use bevy_ecs::system::{Local, Res, ResMut};
use bevy_ecs::world::World;
use glam::DVec3;

use super::opening_numbers::OpeningNumbers;
use super::opening_regions::OpeningRegions;
use super::outlet_balance::{OutletBalance, OutletForce, PlaneMotion, ReducedBuffers};
use super::outlet_records::{restore_outlets, save_outlets};
use super::outlet_registry::{AddedOutlets, OutletFaults};
use super::patch_rows::PatchRows;
use super::prescribed_inflow::PrescribedInflow;
use super::through_flow::ThroughFlow;
use crate::arrays::Arrays;
use crate::resources::clock::Clock;
use crate::resources::grid::Grid;
use crate::resources::pair::Pair;
use crate::resources::pair_sums::Sums;
use crate::resources::scene::ActiveScene;
use crate::saved_state::{SavedResources, decode_record, encode_record};
use sphecs_core::boundary::flow::FlowProperties;
use sphecs_core::boundary::outlet::OutletVisitor;
use sphecs_core::boundary::outlet::method::{Advanced, Needs, OutflowMotion, OutletMethod, PlanePressure};
use sphecs_core::boundary::outlet::outflow_zone::{OutflowZone, ZoneBuffers};
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::rows::{real_vector, set_real_vector};
use sphecs_core::pass::fits::PointFlow;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_core::pass::settings::PairSettings;
use sphecs_scene::model::{Outlet, Scene};

/// Outlets of a simulation.
#[derive(Resource)]
pub struct Outlets<R: PairReal<D>, const D: usize> {
    /// Outlets, in the order of the scene.
    pub all: Vec<RunningOutlet<R, D>>,
    needs: Vec<Needs>,
    inflow: PrescribedInflow,
    numbers: OpeningNumbers,
    pub(super) through: ThroughFlow,
}

/// An outlet with its condition and the state of the present stage.
pub struct RunningOutlet<R: PairReal<D>, const D: usize> {
    /// Mean normal velocity and pressure of the fluid next to the outlet.
    pub adjacent: PointFlow,
    /// Speed along the normal of each outflow row of the outlet, m/s.
    pub speeds: Vec<f64>,
    /// Balance of the body force.
    pub balance: OutletBalance,
    pub(super) condition: Box<dyn RunningCondition<R, D>>,
}

/// A condition with its memory, for one precision and dimension.
pub(super) trait RunningCondition<R: PairReal<D>, const D: usize>: Send + Sync {
    fn needs(&self) -> Needs;
    fn apply(&mut self, zone: &mut OutflowZone<'_, R, D>);
    fn find_rates(&mut self, zone: &mut OutflowZone<'_, R, D>);
    /// Returns the pressure at the plane by its parts.
    fn plane_pressure(&self) -> PlanePressure;
    /// Moves rows, with the speed along the normal of each, by a time step (s).
    fn move_particles(
        &self,
        normal: DVec3,
        rows: (&[u32], &[f64]),
        time_step: f64,
        arrays: &mut ParticleArrays<R, D>,
    );
    /// Returns the memory as a record.
    fn save(&self) -> Vec<u8>;
    /// Restores the memory from a record.
    fn restore(&mut self, record: &[u8]) -> Result<(), String>;
}

/// A condition of a known type with its memory.
pub(super) struct WithMemory<M: OutletMethod> {
    method: M,
    memory: M::Memory,
}

impl<M: OutletMethod> WithMemory<M> {
    /// Returns a condition with an empty memory.
    pub(super) fn new(method: &M) -> Self {
        Self { method: method.clone(), memory: M::Memory::default() }
    }
}

impl<M: OutletMethod, R: PairReal<D>, const D: usize> RunningCondition<R, D> for WithMemory<M> {
    fn needs(&self) -> Needs {
        self.method.needs()
    }

    fn apply(&mut self, zone: &mut OutflowZone<'_, R, D>) {
        self.method.apply(zone, &mut self.memory);
    }

    fn find_rates(&mut self, zone: &mut OutflowZone<'_, R, D>) {
        self.method.find_rates(zone, &mut self.memory);
    }

    fn plane_pressure(&self) -> PlanePressure {
        self.method.plane_pressure(&self.memory)
    }

    fn move_particles(
        &self,
        normal: DVec3,
        (rows, speeds): (&[u32], &[f64]),
        time_step: f64,
        arrays: &mut ParticleArrays<R, D>,
    ) {
        for (&row, &speed) in rows.iter().zip(speeds) {
            let row = row as usize;
            let velocity = arrays.velocity_of(row);
            let acceleration = real_vector(&arrays.acceleration, row);
            let particle = OutflowMotion { velocity, acceleration, speed, normal, time_step };
            let Advanced { velocity: next, speed } = self.method.advance(&particle);
            set_real_vector(&mut arrays.previous_velocity, row, velocity);
            set_real_vector(&mut arrays.velocity, row, next);
            let way = normal * (speed * time_step);
            for axis in 0..D {
                arrays.position[axis][row] += way[axis];
            }
        }
    }

    fn save(&self) -> Vec<u8> {
        encode_record(&self.memory)
    }

    fn restore(&mut self, record: &[u8]) -> Result<(), String> {
        self.memory = decode_record(record)?;
        Ok(())
    }
}

/// Adds an empty memory to a condition of the engine.
struct Start<R, const D: usize>(PhantomData<R>);

impl<R: PairReal<D>, const D: usize> OutletVisitor for Start<R, D> {
    type Output = Box<dyn RunningCondition<R, D>>;

    fn visit<M: OutletMethod>(self, method: &M) -> Self::Output {
        Box::new(WithMemory::new(method))
    }
}

/// Inserts the outlets of a scene and makes them part of the saved state; called after the plugins
/// have added their conditions.
///
/// # Errors
/// [`OutletFaults`] for conditions that no plugin adds and for parameters out of range.
pub fn insert_outlets<R: PairReal<D>, const D: usize>(
    world: &mut World,
    scene: &Scene,
) -> Result<(), OutletFaults> {
    let added = world.get_resource_or_init::<AddedOutlets>();
    let mut faults = Vec::new();
    let mut outlets = Vec::new();
    for outlet in &scene.outlets {
        let condition = match outlet.condition.visit(Start(PhantomData::<R>)) {
            Ok(condition) => condition,
            Err(name) => match added.start(name) {
                Ok(condition) => condition,
                Err(found) => {
                    faults.extend(found.into_iter().map(|fault| format!("{}: {fault}", outlet.patch.name)));
                    continue;
                }
            },
        };
        outlets.push(RunningOutlet {
            adjacent: PointFlow::default(),
            speeds: Vec::new(),
            balance: OutletBalance::default(),
            condition,
        });
    }
    if !faults.is_empty() {
        return Err(OutletFaults(faults));
    }
    let needs: Vec<Needs> = outlets.iter().map(|outlet| outlet.condition.needs()).collect();
    let inflow = PrescribedInflow::new(scene);
    let through = ThroughFlow::new(scene, &needs);
    world.insert_resource(Outlets::<R, D> {
        all: outlets,
        needs,
        inflow,
        numbers: OpeningNumbers::default(),
        through,
    });
    let mut saved = world.get_resource_or_init::<SavedResources>();
    saved.add_with::<Outlets<R, D>>("outlets", save_outlets::<R, D>, restore_outlets::<R, D>);
    Ok(())
}

impl<R: PairReal<D>, const D: usize> Outlets<R, D> {
    /// Returns the requirements of the conditions, in the order of the scene.
    pub fn needs(&self) -> &[Needs] {
        &self.needs
    }
}

impl<R: PairReal<D>, const D: usize> RunningOutlet<R, D> {
    /// Moves the outflow particles of the outlet by a time step, s. Each moves along the normal
    /// only.
    pub fn move_particles(
        &self,
        outlet: &Outlet,
        rows: &[u32],
        time_step: f64,
        arrays: &mut ParticleArrays<R, D>,
    ) {
        self.condition.move_particles(outlet.patch.towards, (rows, &self.speeds), time_step, arrays);
    }
}

/// Returns the properties of the flow of a scene that conditions refer to.
fn flow_properties<'a>(
    scene: &Scene,
    is_in_domain: &'a (dyn Fn(DVec3) -> bool + Sync),
) -> FlowProperties<'a> {
    FlowProperties {
        dimensions: scene.dimensions,
        spacing: scene.spacing,
        density: scene.fluid.density,
        sound_speed: scene.fluid.sound_speed,
        viscosity: scene.fluid.viscosity,
        reference_velocity: scene.reference_velocity,
        periodic: scene.periodic,
        is_in_domain,
    }
}

/// Parts of a running outlet that a system may change.
struct OutletParts<'a, R: PairReal<D>, const D: usize> {
    condition: &'a mut dyn RunningCondition<R, D>,
    adjacent: &'a mut PointFlow,
    balance: &'a mut OutletBalance,
    /// True if the pressure gradient of the flow continues into the zone.
    is_bidirectional: bool,
    /// Fluid rows in the last layers before the outlet.
    before: &'a [u32],
    /// Acceleration that the inlets prescribe, with shares by area, m/s²; None without inlets.
    acceleration: Option<f64>,
}

/// Calls a function with the parts and the zone of each outlet of whose region this rank is a
/// member.
fn for_each_zone<R: PairReal<D>, const D: usize>(
    (scene, clock, pair, grid): (&Scene, &Clock, &PairSettings, &Grid<D>),
    (openings, rows): (&OpeningRegions, &PatchRows),
    outlets: &mut Outlets<R, D>,
    (buffers, sums, arrays): (&mut ZoneBuffers<R, D>, &mut Sums<R, D>, &mut ParticleArrays<R, D>),
    mut work: impl FnMut(OutletParts<'_, R, D>, &mut OutflowZone<'_, R, D>),
) {
    let is_in_domain = |point: DVec3| scene.domain.contains(point, 0.0);
    let flow = flow_properties(scene, &is_in_domain);
    let area: f64 = scene.outlets.iter().map(|outlet| outlet.patch.area).sum();
    for (index, (outlet, running)) in scene.outlets.iter().zip(&mut outlets.all).enumerate() {
        if !openings.has_outlet(index) {
            continue;
        }
        let pair = pair.of_region(openings.of_outlet(index));
        let RunningOutlet { adjacent, speeds, balance, condition } = running;
        let mut zone = OutflowZone {
            flow,
            patch: &outlet.patch,
            extent: scene.extent_along(outlet.patch.towards),
            prescribed: outlets.inflow.at_outlet(index),
            is_balanced: false,
            area_share: outlet.patch.area / area,
            total_inflow: outlets.inflow.rate(),
            through_velocity: outlets.through.velocity(index),
            given: outlet.given.as_ref().map_or(0.0, |given| given.at(clock.time)),
            rows: &rows.outflow[index],
            upstream: &rows.upstream[index],
            inflow_speed: outlets.numbers.inflow_speed(),
            adjacent: *adjacent,
            time_step: clock.time_step,
            is_first_step: clock.step == 0,
            pair: &pair,
            grid: &grid.0,
            arrays: &mut *arrays,
            sums: &mut sums.0,
            buffers: &mut *buffers,
            speeds,
        };
        let before = &rows.before_outlet[index];
        let is_bidirectional = outlets.needs[index].is_bidirectional;
        let acceleration = outlets.inflow.acceleration().filter(|_| zone.through_velocity.is_none());
        let acceleration = acceleration.map(|rate| rate / area);
        let condition = &mut **condition;
        let parts = OutletParts { condition, adjacent, balance, is_bidirectional, before, acceleration };
        work(parts, &mut zone);
    }
}

/// Finds the mean flow next to an outlet; without fluid there the earlier mean is kept.
fn find_adjacent<R: PairReal<D>, const D: usize>(
    adjacent: &mut PointFlow,
    normal: DVec3,
    rows: &[u32],
    arrays: &ParticleArrays<R, D>,
) {
    if !rows.is_empty() {
        let mean = |value: &dyn Fn(usize) -> f64| {
            rows.iter().map(|&row| value(row as usize)).sum::<f64>() / rows.len() as f64
        };
        adjacent.velocity = mean(&|row| arrays.velocity_of(row).dot(normal));
        adjacent.pressure = mean(&|row| arrays.pressure[row].to_f64());
    }
}

/// Sets pressure, density and velocity of outflow particles and finds the speeds at which they
/// move.
pub fn apply_outlets<R: PairReal<D>, const D: usize>(
    scene: Res<ActiveScene>,
    clock: Res<Clock>,
    (pair, grid): (Res<Pair>, Res<Grid<D>>),
    (openings, rows): (Res<OpeningRegions>, Res<PatchRows>),
    (mut buffers, mut reduced): (Local<ZoneBuffers<R, D>>, Local<ReducedBuffers<R>>),
    mut outlets: ResMut<Outlets<R, D>>,
    mut sums: ResMut<Sums<R, D>>,
    mut arrays: ResMut<Arrays<R, D>>,
) {
    let scene = &*scene.0;
    outlets.inflow.find(scene, clock.time);
    let Outlets { all, needs, inflow, numbers, through } = &mut *outlets;
    numbers.find((all, needs), (&openings, &rows), &arrays, &pair.0.ranks);
    through.find(
        (scene, clock.time, clock.time_step),
        inflow,
        |outlet| numbers.plane_pressure(outlet),
        (&grid.0, &arrays, &pair.0.ranks),
    );
    let work = |outlet: OutletParts<'_, R, D>, zone: &mut OutflowZone<'_, R, D>| {
        let force = OutletForce::new(scene, zone.patch, outlet.is_bidirectional, outlet.balance, clock.time);
        if let Some(force) = &force {
            reduced.reduce(force, zone.rows, zone.arrays);
        }
        zone.is_balanced = force.is_some();
        find_adjacent(outlet.adjacent, zone.patch.towards, outlet.before, zone.arrays);
        zone.adjacent = *outlet.adjacent;
        zone.speeds.clear();
        outlet.condition.apply(zone);
        if let Some(force) = &force {
            reduced.restore(force, zone.rows, zone.pair, zone.arrays);
        }
    };
    let state = (&mut *buffers, &mut *sums, &mut **arrays);
    for_each_zone((scene, &clock, &pair.0, &grid), (&openings, &rows), &mut outlets, state, work);
}

/// Finds rates and shifting vectors of outflow particles.
pub fn find_outlet_rates<R: PairReal<D>, const D: usize>(
    scene: Res<ActiveScene>,
    clock: Res<Clock>,
    (pair, grid): (Res<Pair>, Res<Grid<D>>),
    (openings, rows): (Res<OpeningRegions>, Res<PatchRows>),
    mut buffers: Local<ZoneBuffers<R, D>>,
    mut outlets: ResMut<Outlets<R, D>>,
    mut sums: ResMut<Sums<R, D>>,
    mut arrays: ResMut<Arrays<R, D>>,
) {
    let scene = &*scene.0;
    let work = |outlet: OutletParts<'_, R, D>, zone: &mut OutflowZone<'_, R, D>| {
        outlet.condition.find_rates(zone);
        if let Some(force) =
            OutletForce::new(scene, zone.patch, outlet.is_bidirectional, outlet.balance, clock.time)
        {
            let motion = PlaneMotion {
                velocity: zone.through_velocity.unwrap_or(zone.adjacent.velocity),
                acceleration: outlet.acceleration,
                passage: zone.extent / scene.fluid.sound_speed,
                time_step: zone.time_step,
            };
            outlet.balance.accelerate(&force, &motion, zone.rows, zone.arrays);
        }
    };
    let state = (&mut *buffers, &mut *sums, &mut **arrays);
    for_each_zone((scene, &clock, &pair.0, &grid), (&openings, &rows), &mut outlets, state, work);
}
