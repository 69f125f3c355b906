//! Scene of a simulation, with its lengths and its mass.

use std::sync::Arc;

use bevy_ecs::resource::Resource;
use sphecs_scene::model::Scene;

/// Scene that the simulation runs.
#[derive(Resource, Clone, Debug)]
pub struct ActiveScene(pub Arc<Scene>);

/// Lengths and mass of the discretisation.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct Resolution {
    /// Initial spacing Δ, m.
    pub spacing: f64,
    /// Smoothing length h, m.
    pub smoothing_length: f64,
    /// Radius of the kernel's support, m.
    pub support: f64,
    /// Mass of every particle, ρ0 Δ^D, kg (per metre of depth in 2D).
    pub mass: f64,
}

impl Resolution {
    /// Returns the lengths and the mass of a scene.
    pub fn of(scene: &Scene) -> Self {
        let smoothing_length = scene.scheme.smoothing_ratio() * scene.spacing;
        Self {
            spacing: scene.spacing,
            smoothing_length,
            support: scene.scheme.kernel().support_ratio() * smoothing_length,
            mass: scene.fluid.density * scene.spacing.powi(scene.dimensions as i32),
        }
    }
}
