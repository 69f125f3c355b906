//! Tests of readers, repair and queries on surfaces with known answers.

mod queries;
mod shapes;
