//! The plugins that every simulation has: which system runs in which set.

use bevy_ecs::schedule::IntoScheduleConfigs;
use bevy_ecs::world::World;

use super::bodies::{Bodies, sum_body_forces, sum_edac_body_forces};
use super::boundaries::hold::{HeldAtWalls, hold_at_walls};
use super::boundaries::inlets::apply_inlets;
use super::boundaries::outlets::{OutletStates, apply_outlets};
use super::boundaries::rows::PatchRows;
use super::boundaries::walls::apply_walls;
use super::boundaries::watch::{OutletWatch, watch_outlets};
use super::boundaries::wave_zone::outlet_rates;
use super::clock::Clock;
use super::edac::{even_outlets, kick_and_drift, sum_edac_rates, sum_volumes};
use super::failure::{Failure, check_state};
use super::forces::{AddedForces, add_forces};
use super::home::{FreshHome, gather};
use super::integrate::kick;
use super::monitor::PreviousRow;
use super::neighbours::{Spare, sort_particles};
use super::plugin::{Parts, Plugin};
use super::rates::{
    RatesFound, StepsSincePlain, Sums, add_wall_friction, sum_density, sum_gradients, sum_rates,
};
use super::schedule::{Stage, StageSystems, StepSystems};
use super::setup::SceneInUse;
use super::shift::shift;
use super::stopwatch::Stopwatch;
use super::transitions::stock::FreeNumbers;
use super::transitions::{TransitionLists, transition};
use crate::arrays::Arrays;
use sphecs_core::math::real::Real;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::physics::shifting::Shifting;
use sphecs_scene::model::ProbeKind;

/// The arrays, their sort and the two homes of the state.
pub struct NeighboursPlugin<R, const D: usize>(pub std::marker::PhantomData<R>);

/// The scheme of Alvarado-Rodríguez et al. (2017): density, gradients, rates, forces, Verlet, shifting.
pub struct WcsphPlugin<R, const D: usize>(pub std::marker::PhantomData<R>);

/// The scheme of Negi et al. (2020): volumes, rates, forces, kick–drift–kick with the transport velocity.
pub struct EdacTvfPlugin<R, const D: usize>(pub std::marker::PhantomData<R>);

/// Inflow, outflow and wall particles, and the change of zones.
pub struct BoundaryPlugin<R, const D: usize>(pub std::marker::PhantomData<R>);

/// Checks after each step.
pub struct ObservePlugin<R, const D: usize>(pub std::marker::PhantomData<R>);

fn run_stage(world: &mut World) {
    world.run_schedule(Stage);
}

impl<R: Real, const D: usize> Plugin for NeighboursPlugin<R, D> {
    fn build(&self, parts: &mut Parts<'_>) {
        parts.world.init_resource::<FreshHome>();
        parts.world.init_resource::<Stopwatch>();
        parts.world.init_resource::<PatchRows>();
        parts.world.insert_resource(Spare::<R>(Default::default()));
        parts.world.insert_resource(Arrays::<R, D>::default());
        parts.step.add_systems(gather::<R, D>.in_set(StepSystems::Gather));
        parts.step.add_systems(run_stage.in_set(StepSystems::Advance));
        parts.stage.add_systems(sort_particles::<R, D>.in_set(StageSystems::Neighbours));
    }
}

impl<R: Real, const D: usize> Plugin for WcsphPlugin<R, D> {
    fn build(&self, parts: &mut Parts<'_>) {
        parts.keep::<Clock>("clock");
        parts.keep::<RatesFound>("rates_found");
        parts.keep::<StepsSincePlain>("steps_since_plain");
        parts.world.init_resource::<AddedForces>();
        parts.world.init_resource::<Bodies>();
        parts.world.insert_resource(Sums::<R, D>(Default::default()));
        let scene = &parts.world.resource::<SceneInUse>().0;
        // Only sections ask for it.
        let has_sections =
            scene.output.probes.iter().any(|probe| matches!(probe.kind, ProbeKind::Section { .. }));
        let shifts = scene.scheme.wcsph().is_some_and(|scheme| scheme.shifting != Shifting::Off);
        let drifts = has_sections && shifts;
        parts.world.insert_resource(Arrays(ParticleArrays::<R, D> { drifts, ..Default::default() }));
        parts.stage.add_systems((
            sum_density::<R, D>.in_set(StageSystems::Density),
            sum_gradients::<R, D>.in_set(StageSystems::Gradients),
            (sum_rates::<R, D>, add_wall_friction::<R, D>, sum_body_forces::<R, D>)
                .chain()
                .in_set(StageSystems::Rates),
            add_forces::<R, D>.in_set(StageSystems::Forces),
            kick::<R, D>.in_set(StageSystems::Kick),
        ));
        parts.step.add_systems(shift::<R, D>.in_set(StepSystems::Shift));
    }
}

impl<R: Real, const D: usize> Plugin for EdacTvfPlugin<R, D> {
    fn build(&self, parts: &mut Parts<'_>) {
        parts.keep::<Clock>("clock");
        parts.keep::<RatesFound>("rates_found");
        parts.world.init_resource::<AddedForces>();
        parts.world.init_resource::<Bodies>();
        parts.world.insert_resource(Sums::<R, D>(Default::default()));
        parts.world.insert_resource(Arrays(ParticleArrays::<R, D> {
            evolves_pressure: true,
            drifts: true,
            ..Default::default()
        }));
        parts.stage.add_systems((
            sum_volumes::<R, D>.in_set(StageSystems::Density),
            (sum_edac_rates::<R, D>, add_wall_friction::<R, D>, sum_edac_body_forces::<R, D>)
                .chain()
                .in_set(StageSystems::Rates),
            add_forces::<R, D>.in_set(StageSystems::Forces),
            kick_and_drift::<R, D>.in_set(StageSystems::Kick),
        ));
        parts.step.add_systems(even_outlets::<R, D>.in_set(StepSystems::Shift));
    }
}

impl<R: Real, const D: usize> Plugin for BoundaryPlugin<R, D> {
    fn build(&self, parts: &mut Parts<'_>) {
        parts.keep::<OutletStates>("outlets");
        parts.keep::<OutletWatch>("outlet_watch");
        parts.keep::<HeldAtWalls>("held_at_walls");
        parts.keep::<FreeNumbers>("free_numbers");
        parts.world.init_resource::<TransitionLists>();
        // Walls look at the pressure of inflow and outflow particles, so they come last.
        parts.stage.add_systems(
            (apply_inlets::<R, D>, apply_outlets::<R, D>, apply_walls::<R, D>)
                .chain()
                .in_set(StageSystems::Boundary),
        );
        // Of the two schemes' systems one is there; the other is no bound.
        parts.stage.add_systems(
            outlet_rates::<R, D>
                .in_set(StageSystems::Rates)
                .after(sum_body_forces::<R, D>)
                .after(sum_edac_body_forces::<R, D>),
        );
        parts.step.add_systems(
            hold_at_walls::<R, D>.in_set(StepSystems::Shift).after(shift::<R, D>).after(even_outlets::<R, D>),
        );
        parts.step.add_systems(transition::<R, D>.in_set(StepSystems::Transition));
        // So that what comes behind the check comes behind both.
        parts.step.add_systems(watch_outlets.in_set(StepSystems::Observe).before(check_state::<R, D>));
    }
}

impl<R: Real, const D: usize> Plugin for ObservePlugin<R, D> {
    fn build(&self, parts: &mut Parts<'_>) {
        parts.world.init_resource::<Failure>();
        parts.keep::<PreviousRow>("previous_row");
        parts.step.add_systems(check_state::<R, D>.in_set(StepSystems::Observe));
    }
}
