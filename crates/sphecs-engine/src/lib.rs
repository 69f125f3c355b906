//! Components, systems, schedules and plugins of sphecs.

pub mod components;
pub mod simulation;
pub mod systems;
pub mod transfer;
