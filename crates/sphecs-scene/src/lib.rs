//! Floor 4: from a RON file to a scene that cannot be wrong.
//!
//! ```text
//! text ─ notation ─▶ tree with places ─ schema ─▶ SceneFile ─ check ─▶ Scene ─ spawn ─▶ particles
//!        (--set)                       (serde)              (checks)          (fill, walls)
//! ```
//!
//! * [`notation`]: RON with places, `--set`
//! * [`schema`]: what may stand in a file
//! * [`constants`]: its named numbers
//! * [`expression`], [`geometry`]: fields and shapes
//! * [`check`]: every check of values
//! * [`model`], [`scheme`]: the checked scene
//! * [`lattice`], [`fill`], [`rows`], [`wall_particles`], [`spawn`]: its particles
//! * [`inflow`]: velocities of its inlets
//! * [`body`], [`probe`]: what is measured
//! * [`summary`]: its figures
//! * [`disk_estimate`]: what a run of it takes of the disk
//! * [`faults`]: what is wrong with it

use std::path::Path;

pub mod body;
pub mod check;
pub mod constants;
pub mod disk_estimate;
pub mod expression;
pub mod faults;
pub mod fill;
pub mod geometry;
pub mod inflow;
pub mod lattice;
pub mod model;
pub mod notation;
pub mod outline;
pub mod probe;
pub mod rings;
pub mod rows;
pub mod schema;
pub mod scheme;
pub mod spawn;
pub mod summary;
pub mod wall_particles;

#[cfg(test)]
mod tests;

use check::Origin;
use expression::Constants;
use faults::{Fault, SceneFaults};
use model::Scene;
use notation::reader::{self, Reading};
use notation::{paths, typed};
use schema::SceneFile;

pub use spawn::seeds;

/// Reads a scene file, with values of `sets` (path, RON value) put in. A scene with more particles than the free memory holds is refused.
///
/// # Errors
/// All faults of the scene.
pub fn load(path: &Path, sets: &[(String, String)]) -> Result<Scene, SceneFaults> {
    load_within(path, sets, summary::available_memory())
}

/// Reads a scene file, with values of `sets` put in, whose particles may take so much memory (B; None: any).
///
/// # Errors
/// All faults of the scene.
pub fn load_within(
    path: &Path,
    sets: &[(String, String)],
    memory: Option<f64>,
) -> Result<Scene, SceneFaults> {
    let shown = path.display().to_string();
    let refused = |reason: String| {
        let fault =
            Fault::placeless(reason).help("give the path of a scene, such as `scenes/quickstart.ron`");
        SceneFaults::new(&shown, "", vec![fault])
    };
    let bytes = std::fs::read(path).map_err(|error| refused(format!("{shown}: {error}")))?;
    let text = String::from_utf8(bytes)
        .map_err(|error| refused(format!("{shown} is no text: {}", error.utf8_error())))?;
    let name = path.file_stem().map_or("scene".into(), |stem| stem.to_string_lossy());
    let folder = path.parent().unwrap_or(Path::new("."));
    let origin = Origin { name: &name, text: &text, folder, tables: &[], memory };
    read(&shown, origin, sets)
}

/// Reads a scene from a text; tables are looked for in the present folder.
///
/// # Errors
/// All faults of the scene.
pub fn load_str(name: &str, text: &str, sets: &[(String, String)]) -> Result<Scene, SceneFaults> {
    load_kept(name, text, &[], sets)
}

/// Reads a scene from a text and the texts of its tables, each with the path by which the scene names it; others are looked for in the
/// present folder.
///
/// # Errors
/// All faults of the scene.
pub fn load_kept(
    name: &str,
    text: &str,
    tables: &[(String, String)],
    sets: &[(String, String)],
) -> Result<Scene, SceneFaults> {
    let memory = summary::available_memory();
    let origin = Origin { name, text, folder: Path::new("."), tables, memory };
    read(name, origin, sets)
}

/// Reads a scene file at its `smoke` spacing: coarse, for quick tests.
///
/// # Errors
/// All faults of the scene.
pub fn load_smoke(path: &Path, sets: &[(String, String)]) -> Result<Scene, SceneFaults> {
    load_smoke_within(path, sets, summary::available_memory())
}

/// Reads a scene file at its `smoke` spacing, within so much memory (B; None: any).
///
/// # Errors
/// All faults of the scene.
pub fn load_smoke_within(
    path: &Path,
    sets: &[(String, String)],
    memory: Option<f64>,
) -> Result<Scene, SceneFaults> {
    let Ok(text) = std::fs::read_to_string(path) else {
        return load_within(path, sets, memory);
    };
    // What is wrong with either spacing shows in the scene as it stands.
    let Some(smoke) = smoke_spacing(&text, sets) else {
        return load_within(path, sets, memory);
    };
    let mut sets = sets.to_vec();
    sets.push(("spacing".to_owned(), format!("{smoke:e}")));
    load_within(path, &sets, memory)
}

/// The smoke spacing of a scene whose two spacings are sound, m; nothing is filled to find it.
fn smoke_spacing(text: &str, sets: &[(String, String)]) -> Option<f64> {
    let edited = paths::apply(text, sets).ok()?;
    let (_, file, _) = parts(&edited.text).ok()?;
    let [spacing, smoke] = file.map(|file| [file.spacing.value, file.smoke.value])?;
    (spacing.is_finite() && spacing > 0.0 && smoke.is_finite() && smoke > 0.0).then_some(smoke)
}

/// Constants and sections of a text with what is wrong with them, or its faults alone where nothing can be made of it.
fn parts(text: &str) -> Result<(Constants, Option<SceneFile>, Vec<Fault>), Vec<Fault>> {
    let Reading { root, mut faults, lost } = reader::read(text);
    if lost {
        return Err(faults);
    }
    let constants = constants::read(&root, &mut faults);
    let (file, typed_faults) = typed::read::<SceneFile>(&root, &constants);
    faults.extend(typed_faults);
    Ok((constants, file, faults))
}

fn read(shown: &str, origin: Origin<'_>, sets: &[(String, String)]) -> Result<Scene, SceneFaults> {
    let refused = |faults| SceneFaults::new(shown, origin.text, faults);
    let edited = paths::apply(origin.text, sets).map_err(refused)?;
    let text = edited.text.as_str();
    let (constants, file, mut faults) =
        parts(text).map_err(|faults| SceneFaults::new(shown, text, faults))?;
    let origin = Origin { text, ..origin };
    let mut scene = None;
    if let Some(file) = &file {
        let (built, value_faults) = check::build(file, &constants, origin);
        faults.extend(value_faults);
        scene = built;
    }
    for fault in &mut faults {
        let in_scene = fault.span.filter(|_| fault.source.is_none());
        if let Some(path) = in_scene.and_then(|span| edited.path_of(span)) {
            fault.title = format!("--set {path}: {}", fault.title);
        }
    }
    match scene {
        Some(scene) if faults.is_empty() => Ok(scene),
        _ => Err(SceneFaults::new(shown, text, faults)),
    }
}
