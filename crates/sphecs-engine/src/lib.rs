//! Components, systems, schedules and plugins of sphecs.

pub mod arrays;
pub mod components;
pub mod simulation;
pub mod systems;
pub mod transfer;
