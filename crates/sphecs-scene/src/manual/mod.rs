//! Reference of the scene file, from the doc lines of its types.
//!
//! ```text
//! types ─ schemars ─▶ JSON Schema ─▶ entries ─▶ `sphecs explain`, page of the manual
//! ```
//!
//! * `json_schema`: the JSON Schema, with units and defaults
//! * `doc_line`: meaning, unit and default of a doc line
//! * `entries`: structs, fields and choices of the file
//! * `lookup`: entries of a path
//! * `explain`: text of an entry for a terminal
//! * `scene_page`: page of the manual
//! * `examples`: passages of scenes
//! * `since`: versions that added a field or choice

mod doc_line;
mod entries;
mod examples;
mod explain;
mod json_schema;
mod lookup;
mod scene_page;
mod since;

pub use entries::{Argument, Choice, Content, Field, Manual, Page, ValueKind};
pub use examples::{example, examples};
pub use json_schema::json_schema;
pub use lookup::{Entry, Item, UnknownPath};
#[cfg(test)]
pub(crate) use since::newer_names;
