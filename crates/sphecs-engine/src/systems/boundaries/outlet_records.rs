//! Saved state of the outlets.

use bevy_ecs::world::World;
use serde::{Deserialize, Serialize};

use super::outlet_balance::OutletBalance;
use super::outlets::Outlets;
use crate::resources::scene::ActiveScene;
use crate::saved_state::{decode_record, encode_record};
use sphecs_core::pass::pair_real::PairReal;

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

/// Returns the outlets of a world as a record.
pub(super) fn save_outlets<R: PairReal<D>, const D: usize>(world: &World) -> Option<Vec<u8>> {
    let scene = &world.resource::<ActiveScene>().0;
    let Outlets { all, through, .. } = world.get_resource::<Outlets<R, D>>()?;
    let saved = scene.outlets.iter().zip(all).enumerate().map(|(index, (outlet, running))| SavedOutlet {
        condition: outlet.condition.parameters().name().to_owned(),
        memory: running.condition.save(),
        fluid_velocity: running.adjacent.velocity,
        fluid_pressure: running.adjacent.pressure,
        convective: running.speeds.clone(),
        balance: running.balance,
        sound_velocity: through.sound_velocity[index],
    });
    Some(encode_record(&saved.collect::<Vec<_>>()))
}

/// Restores the outlets of a world from a record.
pub(super) fn restore_outlets<R: PairReal<D>, const D: usize>(
    world: &mut World,
    bytes: &[u8],
) -> Result<(), String> {
    let scene = world.resource::<ActiveScene>().0.clone();
    let saved: Vec<SavedOutlet> = decode_record(bytes)?;
    let Outlets { all, through, .. } = &mut *world.resource_mut::<Outlets<R, D>>();
    if saved.len() != scene.outlets.len() {
        return Err(format!("it has {} outlets, the scene has {}", saved.len(), scene.outlets.len()));
    }
    let sound_velocities = through.sound_velocity.iter_mut();
    for (((outlet, running), sound_velocity), saved) in
        scene.outlets.iter().zip(all).zip(sound_velocities).zip(saved)
    {
        let (patch, condition) = (&outlet.patch.name, outlet.condition.parameters().name());
        if saved.condition != condition {
            let found = &saved.condition;
            return Err(format!("{patch} has the condition `{found}`, the scene has `{condition}`"));
        }
        let misread = |fault| format!("{patch}: the memory of `{condition}` cannot be read: {fault}");
        running.condition.restore(&saved.memory).map_err(misread)?;
        running.adjacent.velocity = saved.fluid_velocity;
        running.adjacent.pressure = saved.fluid_pressure;
        running.speeds = saved.convective;
        running.balance = saved.balance;
        *sound_velocity = saved.sound_velocity;
    }
    Ok(())
}
