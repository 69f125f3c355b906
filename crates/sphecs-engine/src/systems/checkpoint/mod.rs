//! The state of a world: everything that the next step depends on, as named columns.
//!
//! - [`particles`]: the particles, from arrays and components
//!
//! A resource that lives across steps is kept by one line where it is inserted: [`Parts::keep`](super::plugin::Parts::keep), in the
//! core plugins as in a plugin of one's own. It is stored whole by its `serde` derive, so that a new field comes along by itself. The
//! test `tests/restart.rs` looks at every resource of a world and fails for one that is neither kept nor named there with the
//! reason why it need not be.
//!
//! To keep something new: a resource: derive `Serialize` and `Deserialize`, and `keep` it; a column of the arrays:
//! `particles/saved.rs`, which does not compile without it; a component: [`particles`].

pub mod particles;

use std::any::TypeId;

use bevy_ecs::resource::Resource;
use bevy_ecs::world::World;
use serde::Serialize;
use serde::de::DeserializeOwned;

use sphecs_core::math::column::{Columns, Misfit};

/// Names of records begin so.
const RECORD: &str = "record.";

/// The resources that are part of the state.
#[derive(Resource, Default)]
pub struct Kept(Vec<Entry>);

struct Entry {
    name: &'static str,
    type_id: TypeId,
    save: fn(&World) -> Option<Vec<u8>>,
    restore: fn(&mut World, &[u8]) -> Result<(), String>,
}

impl Kept {
    /// Makes a resource part of the state, under a name that no other has.
    ///
    /// # Panics
    /// If another resource has the name.
    pub fn add<T: Resource + Serialize + DeserializeOwned>(&mut self, name: &'static str) {
        self.add_with::<T>(name, save_record::<T>, restore_record::<T>);
    }

    /// Makes a resource part of the state by functions of its own that save and restore it.
    ///
    /// # Panics
    /// If another resource has the name.
    pub fn add_with<T: Resource>(
        &mut self,
        name: &'static str,
        save: fn(&World) -> Option<Vec<u8>>,
        restore: fn(&mut World, &[u8]) -> Result<(), String>,
    ) {
        let type_id = TypeId::of::<T>();
        let other = self.0.iter().find(|entry| entry.name == name || entry.type_id == type_id);
        if let Some(other) = other {
            assert!(other.type_id == type_id && other.name == name, "`{name}` and `{}` collide", other.name);
            return;
        }
        self.0.push(Entry { name, type_id, save, restore });
    }

    /// The types that are part of the state.
    pub fn types(&self) -> impl Iterator<Item = TypeId> + '_ {
        self.0.iter().map(|entry| entry.type_id)
    }

    /// Puts the records of all kept resources.
    pub fn save(world: &World, to: &mut Columns) {
        for entry in &world.resource::<Self>().0 {
            // One that its plugin never inserted is missed by name when the state is restored.
            if let Some(bytes) = (entry.save)(world) {
                to.put(format!("{RECORD}{}", entry.name), bytes);
            }
        }
    }

    /// Replaces all kept resources by their records.
    ///
    /// # Errors
    /// [`Misfit`] when a record is missing, does not read, or belongs to nothing in this world.
    pub fn restore(world: &mut World, from: &mut Columns) -> Result<(), Misfit> {
        let entries: Vec<_> =
            world.resource::<Self>().0.iter().map(|entry| (entry.name, entry.restore)).collect();
        for (name, restore) in entries {
            let bytes: Vec<u8> = from.take(&format!("{RECORD}{name}"))?;
            restore(world, &bytes)
                .map_err(|what| Misfit(format!("its record `{name}` does not read: {what}")))?;
        }
        match from.iter().next() {
            Some((name, _)) => Err(Misfit(format!(
                "it has `{name}`, which nothing here takes: was it written with a plugin?"
            ))),
            None => Ok(()),
        }
    }
}

/// A value as a record.
///
/// MessagePack with the names of the fields: a record of other fields is an error, never another value, and numbers keep their bits.
pub fn record<T: Serialize>(value: &T) -> Vec<u8> {
    // Nothing in memory refuses to be written to memory; maps of unknown length, which would, stand in no record.
    rmp_serde::to_vec_named(value).expect("a record is written to memory")
}

/// The value of a record.
///
/// # Errors
/// Where and why it does not read.
pub fn value<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, String> {
    rmp_serde::from_slice(bytes).map_err(|error| error.to_string())
}

fn save_record<T: Resource + Serialize>(world: &World) -> Option<Vec<u8>> {
    world.get_resource::<T>().map(record)
}

fn restore_record<T: Resource + DeserializeOwned>(world: &mut World, bytes: &[u8]) -> Result<(), String> {
    let restored: T = value(bytes)?;
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
        let mut kept = Kept::default();
        kept.add::<Level>("level");
        world.insert_resource(kept);
        world.insert_resource(Level {
            height: f64::from_bits(0x7ff8_0000_0000_0007),
            crossings: vec![1, u64::MAX],
        });
        world
    }

    #[test]
    fn records_keep_every_bit() {
        let mut columns = Columns::default();
        Kept::save(&world(), &mut columns);
        let mut other = world();
        other.insert_resource(Level::default());
        Kept::restore(&mut other, &mut columns.clone()).expect("restored");
        let mut again = Columns::default();
        Kept::save(&other, &mut again);
        assert_eq!(again, columns);
    }

    #[test]
    fn a_record_that_misses_or_is_left_over_is_named() {
        let mut columns = Columns::default();
        Kept::save(&world(), &mut columns);
        let mut windy = world();
        windy.insert_resource(Wind(3.0));
        windy.resource_mut::<Kept>().add::<Wind>("wind");
        let misfit = Kept::restore(&mut windy, &mut columns).expect_err("incomplete").to_string();
        assert!(misfit.contains("record.wind"), "{misfit}");
        let mut columns = Columns::default();
        Kept::save(&windy, &mut columns);
        let misfit = Kept::restore(&mut world(), &mut columns).expect_err("too much").to_string();
        assert!(misfit.contains("record.wind"), "{misfit}");
    }

    #[test]
    fn a_record_of_other_fields_is_an_error() {
        #[derive(Serialize)]
        struct Older {
            height: f64,
        }
        let misread = value::<Level>(&record(&Older { height: 1.0 })).expect_err("a field misses");
        assert!(misread.contains("crossings"), "{misread}");
    }
}
