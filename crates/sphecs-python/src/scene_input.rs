//! Scenes as the Python side hands them over: a path, or a text under a name, with changed values.

use std::path::PathBuf;

use pyo3::{FromPyObject, PyResult, Python};

use crate::exceptions::scene_error;
use crate::guard::detached;
use sphecs::Scene;

/// Scene to be loaded.
#[derive(Clone, Debug, FromPyObject)]
pub(crate) struct SceneInput {
    /// Path of the file; None for a text.
    #[pyo3(item)]
    path: Option<PathBuf>,
    /// Name of the text.
    #[pyo3(item)]
    name: String,
    /// Text; empty for a file.
    #[pyo3(item)]
    text: String,
    /// Paths and values, RON.
    #[pyo3(item)]
    sets: Vec<(String, String)>,
    /// Take the coarse smoke spacing.
    #[pyo3(item)]
    smoke: bool,
}

impl SceneInput {
    /// Returns the name of the file or text in messages.
    pub(crate) fn shown(&self) -> String {
        self.path.as_ref().map_or_else(|| self.name.clone(), |path| path.display().to_string())
    }

    /// Reads and checks the scene; refuses particles that need more than `memory`, B.
    pub(crate) fn read(&self, memory: Option<f64>) -> Result<Scene, sphecs::SceneErrors> {
        let loader = match &self.path {
            Some(path) => Scene::from_file(path),
            None => Scene::from_text(&self.name, &self.text),
        };
        let loader = loader.sets(&self.sets).memory(memory);
        if self.smoke { loader.smoke() } else { loader }.load()
    }

    /// Reads and checks the scene, or returns a `SceneError` with all its faults.
    pub(crate) fn load(&self, py: Python<'_>, memory: Option<f64>) -> PyResult<Scene> {
        let loaded = detached(py, || self.read(memory))?;
        loaded.map_err(|errors| scene_error(py, &self.shown(), &errors))
    }
}
