//! Saved state of the outlets.

use bevy_ecs::world::World;
use serde::{Deserialize, Serialize};

use super::opening_regions::OpeningRegions;
use super::outlet_balance::OutletBalance;
use super::outlets::Outlets;
use crate::resources::scene::ActiveScene;
use crate::saved_state::{decode_record, encode_record};
use sphecs_core::pass::pair_real::PairReal;
use sphecs_core::pass::ranks::Ranks;
use sphecs_scene::model::Scene;

/// An outlet in a saved state.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SavedOutlet {
    /// Name of its condition.
    condition: String,
    /// Memory of the condition, as a record.
    memory: Vec<u8>,
    /// Mean normal velocity of the fluid next to the outlet, m/s.
    fluid_velocity: f64,
    /// Mean pressure of the fluid next to the outlet, Pa.
    fluid_pressure: f64,
    /// Speed along the normal of each outflow row, m/s.
    convective: Vec<f64>,
    /// Balance of the body force.
    balance: OutletBalance,
    /// Velocity S that sound adds to the flow of the whole domain, m/s.
    sound_velocity: f64,
}

impl SavedOutlet {
    /// Returns the state of an outlet.
    fn of<R: PairReal<D>, const D: usize>(scene: &Scene, outlets: &Outlets<R, D>, index: usize) -> Self {
        let running = &outlets.all[index];
        Self {
            condition: scene.outlets[index].condition.parameters().name().to_owned(),
            memory: running.condition.save(),
            fluid_velocity: running.adjacent.velocity,
            fluid_pressure: running.adjacent.pressure,
            convective: running.speeds.clone(),
            balance: running.balance,
            sound_velocity: outlets.through.sound_velocity[index],
        }
    }

    /// Gives an outlet this state.
    fn restore<R: PairReal<D>, const D: usize>(
        self,
        scene: &Scene,
        outlets: &mut Outlets<R, D>,
        index: usize,
    ) -> Result<(), String> {
        let (patch, condition) =
            (&scene.outlets[index].patch.name, scene.outlets[index].condition.parameters().name());
        if self.condition != condition {
            let found = &self.condition;
            return Err(format!("{patch} has the condition `{found}`, the scene has `{condition}`"));
        }
        let misread = |fault| format!("{patch}: the memory of `{condition}` cannot be read: {fault}");
        let running = &mut outlets.all[index];
        running.condition.restore(&self.memory).map_err(misread)?;
        running.adjacent.velocity = self.fluid_velocity;
        running.adjacent.pressure = self.fluid_pressure;
        running.speeds = self.convective;
        running.balance = self.balance;
        outlets.through.sound_velocity[index] = self.sound_velocity;
        Ok(())
    }
}

/// Returns the outlets of a world as a record.
pub(super) fn save_outlets<R: PairReal<D>, const D: usize>(world: &World) -> Option<Vec<u8>> {
    let scene = &world.resource::<ActiveScene>().0;
    let outlets = world.get_resource::<Outlets<R, D>>()?;
    let saved = (0..scene.outlets.len()).map(|index| SavedOutlet::of(scene, outlets, index));
    Some(encode_record(&saved.collect::<Vec<_>>()))
}

/// Restores the outlets of a world from a record.
pub(super) fn restore_outlets<R: PairReal<D>, const D: usize>(
    world: &mut World,
    bytes: &[u8],
) -> Result<(), String> {
    let scene = world.resource::<ActiveScene>().0.clone();
    let saved: Vec<SavedOutlet> = decode_record(bytes)?;
    if saved.len() != scene.outlets.len() {
        return Err(format!("it has {} outlets, the scene has {}", saved.len(), scene.outlets.len()));
    }
    let outlets = &mut *world.resource_mut::<Outlets<R, D>>();
    saved.into_iter().enumerate().try_for_each(|(index, saved)| saved.restore(&scene, outlets, index))
}

/// Gives all ranks the state of all outlets, which the leaders of their regions have.
///
/// All ranks call it together.
pub(crate) fn share_outlets<R: PairReal<D>, const D: usize>(
    scene: &Scene,
    outlets: &mut Outlets<R, D>,
    openings: &OpeningRegions,
    ranks: &Ranks,
) {
    if openings.are_new() || scene.outlets.is_empty() {
        return;
    }
    let leads = |outlet: usize| openings.leader_of_outlet(outlet) == ranks.rank();
    let own = (0..scene.outlets.len()).filter(|&index| leads(index));
    let own: Vec<_> = own.map(|index| (index, SavedOutlet::of(scene, outlets, index))).collect();
    let own = encode_record(&own);
    let lengths = ranks.values_of_all(&[own.len()]);
    let all = ranks.messages_of_all(&own, &lengths);
    let mut rest = &all[..];
    for length in lengths {
        let (message, others) = rest.split_at(length);
        rest = others;
        // Written above by the same program, for the same scene.
        let saved: Vec<(usize, SavedOutlet)> = decode_record(message).expect("a record of outlets");
        for (index, saved) in saved.into_iter().filter(|(index, _)| !leads(*index)) {
            saved.restore(scene, outlets, index).expect("the state of an outlet of the scene");
        }
    }
}
