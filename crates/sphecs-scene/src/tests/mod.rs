//! Tests of whole scenes.

mod builder;
mod emitters;
mod faults;
mod filling;
mod gridded;
#[cfg(feature = "schema")]
mod manual;
mod meshes;
mod mutations;
mod openings;
mod outlines;
mod potential_flow;
mod schema_fields;
mod sets;
mod shapes;
mod shipped;
mod turned;
