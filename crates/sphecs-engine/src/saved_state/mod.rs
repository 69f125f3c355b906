//! Saved state of a world: everything that the next step depends on, as named columns.
//!
//! - `part`: the particles that a rank holds
//! - `particles`: the particles, from arrays and components
//!
//! A resource that later steps depend on is saved by one line where it is inserted,
//! [`PluginContext::save_resource`](crate::plugins::PluginContext::save_resource). It is stored
//! whole by its `serde` derive, so that a new field is saved without further code. The test
//! `tests/restart.rs` inspects every resource of a world, and fails for one that is neither saved
//! nor listed there with a reason.
//!
//! To save a new resource, derive `Serialize` and `Deserialize` and insert it by `save_resource`.
//! Add a new column of the arrays to `particles/saved.rs`, which does not compile without it. Add a
//! new component to `saved_state/particles.rs`.

pub(crate) mod part;
pub(crate) mod particles;

use std::any::TypeId;

use bevy_ecs::resource::Resource;
use bevy_ecs::world::World;
use serde::Serialize;
use serde::de::DeserializeOwned;

use sphecs_core::math::column::{ColumnMismatch, Columns};

/// Prefix of the column names of records.
const RECORD: &str = "record.";

/// Resources that are part of the saved state.
#[derive(Resource, Default)]
pub struct SavedResources {
    entries: Vec<Entry>,
    collision: Option<[&'static str; 2]>,
}

struct Entry {
    name: &'static str,
    type_id: TypeId,
    save: fn(&World) -> Option<Vec<u8>>,
    restore: fn(&mut World, &[u8]) -> Result<(), String>,
}

impl SavedResources {
    /// Adds a resource to the saved state, under a unique name.
    pub(crate) fn add<T: Resource + Serialize + DeserializeOwned>(&mut self, name: &'static str) {
        self.add_with::<T>(name, save_record::<T>, restore_record::<T>);
    }

    /// Adds a resource to the saved state, under a unique name, with functions of its own that
    /// encode and decode it.
    pub(crate) fn add_with<T: Resource>(
        &mut self,
        name: &'static str,
        save: fn(&World) -> Option<Vec<u8>>,
        restore: fn(&mut World, &[u8]) -> Result<(), String>,
    ) {
        let type_id = TypeId::of::<T>();
        match self.entries.iter().find(|entry| entry.name == name || entry.type_id == type_id) {
            Some(other) if other.type_id == type_id && other.name == name => {}
            Some(other) => self.collision = self.collision.or(Some([name, other.name])),
            None => self.entries.push(Entry { name, type_id, save, restore }),
        }
    }

    /// Returns the first name that could not be added, and the name of the resource that it
    /// collides with.
    pub(crate) fn collision(&self) -> Option<[&'static str; 2]> {
        self.collision
    }

    /// Returns the types of the saved resources.
    pub fn types(&self) -> impl Iterator<Item = TypeId> + '_ {
        self.entries.iter().map(|entry| entry.type_id)
    }

    /// Saves all resources as records.
    pub(crate) fn save(world: &World, to: &mut Columns) {
        for entry in &world.resource::<Self>().entries {
            // A resource that its plugin never inserted is reported as missing when the state is
            // restored.
            if let Some(bytes) = (entry.save)(world) {
                to.put(format!("{RECORD}{}", entry.name), bytes);
            }
        }
    }

    /// Replaces all saved resources by their records.
    ///
    /// # Errors
    /// [`ColumnMismatch`] if a record is missing, cannot be decoded, or belongs to no resource of
    /// this world.
    pub(crate) fn restore(world: &mut World, from: &mut Columns) -> Result<(), ColumnMismatch> {
        let entries: Vec<_> =
            world.resource::<Self>().entries.iter().map(|entry| (entry.name, entry.restore)).collect();
        for (name, restore) in entries {
            let bytes: Vec<u8> = from.take(&format!("{RECORD}{name}"))?;
            restore(world, &bytes)
                .map_err(|cause| ColumnMismatch(format!("record `{name}` cannot be decoded: {cause}")))?;
        }
        match from.iter().next() {
            Some((name, _)) => Err(ColumnMismatch(format!(
                "nothing takes the column `{name}`; add the plugin with which the state was saved"
            ))),
            None => Ok(()),
        }
    }
}

/// Encodes a value as a record.
///
/// A record is MessagePack with the names of the fields: a record with other fields is an error,
/// never another value, and numbers keep their bits.
pub fn encode_record<T: Serialize>(value: &T) -> Vec<u8> {
    // Writing to memory fails only for a map of unknown length, which no record contains.
    rmp_serde::to_vec_named(value).expect("a record can be written to memory")
}

/// Decodes the value of a record.
///
/// # Errors
/// The place and the reason of the failure.
pub fn decode_record<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, String> {
    rmp_serde::from_slice(bytes).map_err(|error| error.to_string())
}

fn save_record<T: Resource + Serialize>(world: &World) -> Option<Vec<u8>> {
    world.get_resource::<T>().map(encode_record)
}

fn restore_record<T: Resource + DeserializeOwned>(world: &mut World, bytes: &[u8]) -> Result<(), String> {
    let restored: T = decode_record(bytes)?;
    world.insert_resource(restored);
    Ok(())
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;

    #[derive(Resource, Serialize, Deserialize, Debug, PartialEq, Default)]
    #[serde(deny_unknown_fields)]
    struct Level {
        height: f64,
        crossings: Vec<u64>,
    }

    #[derive(Resource, Serialize, Deserialize, Default)]
    #[serde(deny_unknown_fields)]
    struct Wind(f64);

    fn world() -> World {
        let mut world = World::new();
        let mut saved = SavedResources::default();
        saved.add::<Level>("level");
        world.insert_resource(saved);
        world.insert_resource(Level {
            height: f64::from_bits(0x7ff8_0000_0000_0007),
            crossings: vec![1, u64::MAX],
        });
        world
    }

    #[test]
    fn records_keep_every_bit() {
        let mut columns = Columns::default();
        SavedResources::save(&world(), &mut columns);
        let mut other = world();
        other.insert_resource(Level::default());
        SavedResources::restore(&mut other, &mut columns.clone()).expect("restored");
        let mut again = Columns::default();
        SavedResources::save(&other, &mut again);
        assert_eq!(again, columns);
    }

    #[test]
    fn missing_or_superfluous_record_is_named() {
        let mut columns = Columns::default();
        SavedResources::save(&world(), &mut columns);
        let mut windy = world();
        windy.insert_resource(Wind(3.0));
        windy.resource_mut::<SavedResources>().add::<Wind>("wind");
        let mismatch = SavedResources::restore(&mut windy, &mut columns).expect_err("incomplete").to_string();
        assert!(mismatch.contains("record.wind"), "{mismatch}");
        let mut columns = Columns::default();
        SavedResources::save(&windy, &mut columns);
        let mismatch = SavedResources::restore(&mut world(), &mut columns).expect_err("too much").to_string();
        assert!(mismatch.contains("record.wind"), "{mismatch}");
    }

    #[test]
    fn collision_of_names_is_reported() {
        let mut saved = SavedResources::default();
        saved.add::<Level>("level");
        saved.add::<Level>("level");
        assert_eq!(saved.collision(), None, "the same resource may be added again");
        saved.add::<Wind>("level");
        assert_eq!(saved.collision(), Some(["level", "level"]));
    }

    #[test]
    fn record_with_other_fields_is_an_error() {
        #[derive(Serialize)]
        struct Older {
            height: f64,
        }
        let error =
            decode_record::<Level>(&encode_record(&Older { height: 1.0 })).expect_err("a field is missing");
        assert!(error.contains("crossings"), "{error}");
    }
}
