//! Built-in systems of every simulation and their sets.

use bevy_ecs::schedule::IntoScheduleConfigs;
use bevy_ecs::world::World;

use super::PluginContext;
use crate::arrays::Arrays;
use crate::resources::clock::Clock;
use crate::resources::grid::SortBuffers;
use crate::resources::pair_sums::{RatesFound, StepsSinceCorrection, Sums};
use crate::resources::scene::ActiveScene;
use crate::resources::state_location::{StateLocation, gather};
use crate::resources::stopwatch::Stopwatch;
use crate::schedule::{Stage, StageSet, StepSet};
use crate::systems::body_forces::{Bodies, finish_body_forces, sum_body_forces, sum_edac_body_forces};
use crate::systems::boundaries::emitter_states::EmitterStates;
use crate::systems::boundaries::emitters::apply_emitters;
use crate::systems::boundaries::inflow_columns::InflowColumns;
use crate::systems::boundaries::inlets::apply_inlets;
use crate::systems::boundaries::movers::{MoverParticles, PresentPoses};
use crate::systems::boundaries::opening_regions::OpeningRegions;
use crate::systems::boundaries::outlet_diagnostics::{OutletDiagnostics, diagnose_outlets};
use crate::systems::boundaries::outlet_registry::AddedOutlets;
use crate::systems::boundaries::outlets::{apply_outlets, find_outlet_rates};
use crate::systems::boundaries::patch_rows::PatchRows;
use crate::systems::boundaries::wall_contacts::WallContacts;
use crate::systems::boundaries::wall_projection::{WallProjections, join_projections, project_to_walls};
use crate::systems::boundaries::walls::apply_walls;
use crate::systems::divergence::{Failure, check_state};
use crate::systems::edac::{kick_and_drift, shift_outlets, sum_edac_rates, sum_volumes};
use crate::systems::forces::{AddedForces, add_forces};
use crate::systems::monitor::PreviousRow;
use crate::systems::neighbours::sort_particles;
use crate::systems::transitions::reservoir::FreeNumbers;
use crate::systems::transitions::{TransitionLists, transition};
use crate::systems::wcsph::kick::kick;
use crate::systems::wcsph::rates::{add_wall_friction, sum_density, sum_gradients, sum_rates};
use crate::systems::wcsph::shift::shift;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_scene::model::{ProbeKind, Scene, Scheme};

/// Adds the systems of the engine for a scene in the precision `R` and in `D` dimensions.
pub(crate) fn add_builtin<R: PairReal<D>, const D: usize>(scene: &Scene, context: &mut PluginContext<'_>) {
    add_arrays::<R, D>(context);
    match scene.scheme {
        Scheme::Wcsph(_) => add_wcsph::<R, D>(context),
        Scheme::EdacTvf(_) => add_edac_tvf::<R, D>(context),
    }
    add_boundaries::<R, D>(context);
    add_checks::<R, D>(context);
}

fn run_stage(world: &mut World) {
    world.run_schedule(Stage);
}

/// Adds the particle arrays, their sort, and the transfer from the components.
fn add_arrays<R: PairReal<D>, const D: usize>(context: &mut PluginContext<'_>) {
    context.world.init_resource::<StateLocation>();
    context.world.init_resource::<Stopwatch>();
    context.world.init_resource::<PatchRows>();
    context.world.init_resource::<OpeningRegions>();
    context.world.insert_resource(SortBuffers::<R>(Default::default()));
    context.world.insert_resource(Arrays::<R, D>::default());
    context.step.add_systems(gather::<R, D>.in_set(StepSet::Gather));
    context.step.add_systems(run_stage.in_set(StepSet::Advance));
    context.stage.add_systems(sort_particles::<R, D>.in_set(StageSet::Neighbours));
}

/// Adds the scheme of Alvarado-Rodríguez et al. (2017): density, gradients, rates, forces, kick,
/// shifting.
fn add_wcsph<R: PairReal<D>, const D: usize>(context: &mut PluginContext<'_>) {
    context.save_resource::<Clock>("clock");
    context.save_resource::<RatesFound>("rates_found");
    context.save_resource::<StepsSinceCorrection>("steps_since_correction");
    context.world.init_resource::<AddedForces>();
    context.world.init_resource::<Bodies>();
    context.world.insert_resource(Sums::<R, D>(Default::default()));
    let drifts = stores_drift(&context.world.resource::<ActiveScene>().0);
    context.world.insert_resource(Arrays(ParticleArrays::<R, D> { drifts, ..Default::default() }));
    context.stage.add_systems((
        sum_density::<R, D>.in_set(StageSet::Density),
        sum_gradients::<R, D>.in_set(StageSet::Gradients),
        (sum_rates::<R, D>, add_wall_friction::<R, D>, sum_body_forces::<R, D>)
            .chain()
            .in_set(StageSet::Rates),
        add_forces::<R, D>.in_set(StageSet::Forces),
        kick::<R, D>.in_set(StageSet::Kick),
    ));
    context.step.add_systems(shift::<R, D>.in_set(StepSet::Shift));
}

/// Returns true if the displacements by shifting are stored; only the mass flow through a section
/// needs them.
fn stores_drift(scene: &Scene) -> bool {
    let has_sections =
        scene.output.probes.iter().any(|probe| matches!(probe.kind, ProbeKind::Section { .. }));
    let shifts = scene.scheme.wcsph().is_some_and(|scheme| !scheme.shifting.is_off());
    has_sections && shifts
}

/// Adds the scheme of Negi et al. (2020): volumes, rates, forces, kick–drift–kick with the
/// transport velocity.
fn add_edac_tvf<R: PairReal<D>, const D: usize>(context: &mut PluginContext<'_>) {
    context.save_resource::<Clock>("clock");
    context.save_resource::<RatesFound>("rates_found");
    context.world.init_resource::<AddedForces>();
    context.world.init_resource::<Bodies>();
    context.world.insert_resource(Sums::<R, D>(Default::default()));
    context.world.insert_resource(Arrays(ParticleArrays::<R, D> {
        evolves_pressure: true,
        drifts: true,
        ..Default::default()
    }));
    context.stage.add_systems((
        sum_volumes::<R, D>.in_set(StageSet::Density),
        (sum_edac_rates::<R, D>, add_wall_friction::<R, D>, sum_edac_body_forces::<R, D>)
            .chain()
            .in_set(StageSet::Rates),
        add_forces::<R, D>.in_set(StageSet::Forces),
        kick_and_drift::<R, D>.in_set(StageSet::Kick),
    ));
    context.step.add_systems(shift_outlets::<R, D>.in_set(StepSet::Shift));
}

/// Adds the systems of inflow, outflow and wall particles, and the change of zones.
fn add_boundaries<R: PairReal<D>, const D: usize>(context: &mut PluginContext<'_>) {
    context.save_resource::<InflowColumns>("inflow_columns");
    context.save_resource::<OutletDiagnostics>("outlet_diagnostics");
    context.save_resource::<WallProjections>("wall_projections");
    context.save_resource::<WallContacts>("wall_contacts");
    context.save_resource::<FreeNumbers>("free_numbers");
    context.world.init_resource::<PresentPoses>();
    if context.world.resource::<ActiveScene>().0.has_moving_walls() {
        context.save_resource::<MoverParticles>("mover_particles");
    }
    let has_emitters = !context.world.resource::<ActiveScene>().0.emitters.is_empty();
    if has_emitters {
        context.save_resource::<EmitterStates>("emitters");
    }
    context.world.init_resource::<AddedOutlets>();
    context.world.init_resource::<TransitionLists>();
    // Walls need the pressure of inflow and outflow particles, so they come last.
    context.stage.add_systems(
        (apply_inlets::<R, D>, apply_outlets::<R, D>, apply_walls::<R, D>).chain().in_set(StageSet::Boundary),
    );
    if has_emitters {
        let order = apply_emitters::<R, D>.after(apply_inlets::<R, D>).before(apply_outlets::<R, D>);
        context.stage.add_systems(order.in_set(StageSet::Boundary));
    }
    // Only the systems of one scheme are in the schedule; an order relative to the other has no
    // effect.
    context.stage.add_systems(
        (find_outlet_rates::<R, D>, finish_body_forces)
            .chain()
            .in_set(StageSet::Rates)
            .after(sum_body_forces::<R, D>)
            .after(sum_edac_body_forces::<R, D>),
    );
    context.step.add_systems(
        project_to_walls::<R, D>.in_set(StepSet::Shift).after(shift::<R, D>).after(shift_outlets::<R, D>),
    );
    context.step.add_systems((transition::<R, D>, join_projections).chain().in_set(StepSet::Transition));
    // A user's system that runs after `check_state` then runs after both.
    context.step.add_systems(diagnose_outlets::<R, D>.in_set(StepSet::Observe).before(check_state::<R, D>));
}

/// Adds the checks after each step.
fn add_checks<R: PairReal<D>, const D: usize>(context: &mut PluginContext<'_>) {
    context.world.init_resource::<Failure>();
    context.save_resource::<PreviousRow>("previous_row");
    context.step.add_systems(check_state::<R, D>.in_set(StepSet::Observe));
}
