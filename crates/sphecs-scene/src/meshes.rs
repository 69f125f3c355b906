//! Files of meshes and outlines of a scene: closed surfaces and polylines that become shapes.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

/// Unit of the coordinates in the file of a mesh or an outline, which the file does not state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum LengthUnit {
    /// 1e-6 m. Take it for files in µm.
    Micrometre,
    /// 1e-3 m. Take it for most CAD programs.
    Millimetre,
    /// 1e-2 m. Take it for files in cm.
    Centimetre,
    /// 1 m. Take it for files in m.
    Metre,
    /// 0.0254 m. Take it for files in inches.
    Inch,
    /// 0.3048 m. Take it for files in feet.
    Foot,
}

impl LengthUnit {
    /// Returns the length of the unit, m.
    pub fn metres(self) -> f64 {
        match self {
            Self::Micrometre => 1e-6,
            Self::Millimetre => 1e-3,
            Self::Centimetre => 1e-2,
            Self::Metre => 1.0,
            Self::Inch => 0.0254,
            Self::Foot => 0.3048,
        }
    }
}

/// A file of a mesh or an outline that a scene names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshFile {
    /// Path as the scene writes it.
    pub path: String,
    /// Bytes of the file.
    pub bytes: Arc<[u8]>,
}

/// Sentences on what was read from the files of a mesh or an outline, changed and found, for
/// `sphecs check`.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshReport {
    /// Paths of its files.
    pub name: String,
    /// Sentences on it.
    pub lines: Vec<String>,
    /// Sentences on what a user should look at.
    pub notes: Vec<String>,
}
