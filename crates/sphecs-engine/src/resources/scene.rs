//! Scene of a simulation.

use std::sync::Arc;

use bevy_ecs::resource::Resource;
use sphecs_scene::model::Scene;

/// Scene that the simulation runs.
#[derive(Resource, Clone, Debug)]
pub struct ActiveScene(pub Arc<Scene>);
