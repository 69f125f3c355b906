//! Tests of whole scenes.

mod faults;
mod filling;
mod mutations;
mod sets;
mod shapes;
mod shipped;
