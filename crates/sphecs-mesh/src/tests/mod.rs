//! Tests of readers, repair and queries on surfaces with known answers.

mod bad_inputs;
mod formats;
mod overlaps;
mod polygons;
mod queries;
mod repairs;
mod shapes;
