//! Loading of a scene from a file or a text, with changes of values.

use std::borrow::Borrow;
use std::path::{Path, PathBuf};

use super::check::{self, SceneSource};
use super::constants;
use super::expression::Constants;
use super::faults::{Fault, SceneErrors};
use super::meshes::MeshFile;
use super::model::Scene;
use super::notation::reader::{self, Parsed};
use super::notation::{paths, typed};
use super::schema::SceneFile;
use super::text_file;

/// A value of a scene, as RON text.
///
/// Numbers and booleans are converted; text is taken as RON: `"Mirror()"` is a condition,
/// `"\"x^2\""` an expression.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneValue(String);

impl From<&str> for SceneValue {
    fn from(text: &str) -> Self {
        Self(text.to_owned())
    }
}

impl From<String> for SceneValue {
    fn from(text: String) -> Self {
        Self(text)
    }
}

impl From<f64> for SceneValue {
    fn from(number: f64) -> Self {
        // The shortest decimal that is read back as the same number.
        Self(format!("{number:e}"))
    }
}

macro_rules! value_from {
    ($($kind:ty),*) => {
        $(impl From<$kind> for SceneValue {
            fn from(value: $kind) -> Self {
                Self(value.to_string())
            }
        })*
    };
}
value_from!(bool, i32, i64, u32, u64, usize);

/// Text of a scene, or the file that holds it.
#[derive(Clone, Debug)]
enum Input {
    File(PathBuf),
    Text { name: String, text: String },
}

/// A scene to be loaded; made by [`Scene::from_file`] and [`Scene::from_text`].
///
/// ```
/// use sphecs_scene::Scene;
///
/// # fn main() -> Result<(), sphecs_scene::SceneErrors> {
/// # let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/quickstart.ron");
/// let scene = Scene::from_file(path).set("spacing", 5e-3).set("precision", "F32").load()?;
/// assert_eq!(scene.spacing, 5e-3);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
#[must_use = "a scene is read by `load`"]
pub struct SceneLoader {
    input: Input,
    sets: Vec<(String, String)>,
    smoke: bool,
    memory: Option<f64>,
    tables: Vec<(String, String)>,
    meshes: Vec<MeshFile>,
}

impl Scene {
    /// Begins to load the scene of a RON file; its tables are read from the folder of the file.
    pub fn from_file(path: impl Into<PathBuf>) -> SceneLoader {
        SceneLoader::new(Input::File(path.into()))
    }

    /// Begins to load a scene from RON text under a name; its tables are read from the current
    /// folder.
    pub fn from_text(name: impl Into<String>, text: impl Into<String>) -> SceneLoader {
        SceneLoader::new(Input::Text { name: name.into(), text: text.into() })
    }
}

impl SceneLoader {
    fn new(input: Input) -> Self {
        Self { input, sets: Vec::new(), smoke: false, memory: None, tables: Vec::new(), meshes: Vec::new() }
    }

    /// Changes the value at a path of the scene: `spacing`, `fluid.sound_speed`,
    /// `outlets.0.condition`.
    pub fn set(mut self, path: impl AsRef<str>, value: impl Into<SceneValue>) -> Self {
        self.sets.push((path.as_ref().to_owned(), value.into().0));
        self
    }

    /// Changes the values at several paths; each pair is a path and its value as RON text.
    pub fn sets<I, P, V>(mut self, sets: I) -> Self
    where
        I: IntoIterator,
        I::Item: Borrow<(P, V)>,
        P: AsRef<str>,
        V: AsRef<str>,
    {
        let owned = sets.into_iter().map(|set| {
            let (path, value) = set.borrow();
            (path.as_ref().to_owned(), value.as_ref().to_owned())
        });
        self.sets.extend(owned);
        self
    }

    /// Takes the `smoke` spacing of the scene for its spacing: coarse, for quick tests. A spacing
    /// that is set has precedence.
    pub fn smoke(mut self) -> Self {
        self.smoke = true;
        self
    }

    /// Refuses a scene whose particles need more memory than this, B; None for no bound, the
    /// default.
    pub fn memory(mut self, limit: impl Into<Option<f64>>) -> Self {
        self.memory = limit.into();
        self
    }

    /// Takes these tables for those of the folder: the path as the scene writes it, and the text.
    pub fn tables(mut self, tables: impl IntoIterator<Item = (String, String)>) -> Self {
        self.tables.extend(tables);
        self
    }

    /// Takes these files of meshes and outlines for those of the folder.
    pub fn meshes(mut self, meshes: impl IntoIterator<Item = MeshFile>) -> Self {
        self.meshes.extend(meshes);
        self
    }

    /// Reads and checks the scene.
    ///
    /// # Errors
    /// All faults of the scene, each with its place.
    pub fn load(mut self) -> Result<Scene, SceneErrors> {
        let present = PathBuf::from(".");
        let (shown, name, text, folder) =
            match std::mem::replace(&mut self.input, Input::File(PathBuf::new())) {
                Input::Text { name, text } => (name.clone(), name, text, present),
                Input::File(path) => {
                    let name = path.file_stem().map_or("scene".into(), |stem| stem.to_string_lossy());
                    let folder = path.parent().map_or(present, Path::to_owned);
                    (path.display().to_string(), name.into_owned(), text_of(&path)?, folder)
                }
            };
        // A fault of either spacing is reported by the reading at the scene's own spacing.
        let is_set = self.sets.iter().any(|(path, _)| path == "spacing");
        if let Some(smoke) = (self.smoke && !is_set).then(|| smoke_spacing(&text, &self.sets)).flatten() {
            self = self.set("spacing", smoke);
        }
        let source = SceneSource {
            name: &name,
            text: &text,
            folder: &folder,
            tables: &self.tables,
            meshes: &self.meshes,
            has_faults: false,
            memory: self.memory,
        };
        read(&shown, source, &self.sets)
    }
}

/// Returns the text of a scene file.
fn text_of(path: &Path) -> Result<String, SceneErrors> {
    let shown = path.display().to_string();
    let refused = |reason: String| {
        let help = match path.join("summary.json").exists() {
            true => format!(
                "it is the folder of a run: `sphecs resume {shown}` continues the run, `sphecs info {shown}` describes it, \
                 `sphecs run {shown}/scene.ron` runs its scene again"
            ),
            false => "give the path of a scene, such as `scenes/quickstart.ron`".to_owned(),
        };
        SceneErrors::new(&shown, "", vec![Fault::placeless(reason).help(help)])
    };
    if path.is_dir() {
        return Err(refused(format!("{shown} is a folder, must be a scene file")));
    }
    let bytes = std::fs::read(path).map_err(|error| refused(format!("{shown}: {error}")))?;
    text_file::decoded(bytes).map_err(|reason| refused(format!("{shown} is not a text file: {reason}")))
}

/// Returns the smoke spacing of a scene whose two spacings are valid, m, without filling the scene.
fn smoke_spacing(text: &str, sets: &[(String, String)]) -> Option<f64> {
    let edited = paths::apply(text, sets).ok()?;
    let (_, file, _) = sections(&edited.text).ok()?;
    let file = file.filter(|file| !file.spacing.is_placeholder())?;
    let (spacing, smoke) = (file.spacing.value, file.smoke?.value);
    (spacing.is_finite() && spacing > 0.0 && smoke.is_finite() && smoke > 0.0).then_some(smoke)
}

/// Returns constants and sections of a text with their faults, or the faults alone of a text that
/// cannot be read at all.
fn sections(text: &str) -> Result<(Constants, Option<SceneFile>, Vec<Fault>), Vec<Fault>> {
    let Parsed { root, mut faults, unbalanced } = reader::read(text);
    if unbalanced {
        return Err(faults);
    }
    let constants = constants::read(&root, &mut faults);
    let (file, typed_faults) = typed::read::<SceneFile>(&root, &constants);
    faults.extend(typed_faults);
    Ok((constants, file, faults))
}

/// Reads and checks the scene of a text with `--set` values; `shown` is its name in faults.
fn read(shown: &str, source: SceneSource<'_>, sets: &[(String, String)]) -> Result<Scene, SceneErrors> {
    let refused = |faults| SceneErrors::new(shown, source.text, faults);
    let edited = paths::apply(source.text, sets).map_err(refused)?;
    let text = edited.text.as_str();
    let (constants, file, mut faults) =
        sections(text).map_err(|faults| SceneErrors::new(shown, text, faults))?;
    let mut scene = None;
    if let Some(file) = &file {
        let (checked, value_faults) =
            check::check(file, &constants, SceneSource { text, has_faults: !faults.is_empty(), ..source });
        faults.extend(value_faults);
        scene = checked;
    }
    for fault in &mut faults {
        let in_scene = fault.span.filter(|_| fault.source.is_none());
        if let Some(path) = in_scene.and_then(|span| edited.path_of(span)) {
            fault.title = format!("--set {path}: {}", fault.title);
            if fault.label.ends_with("must be text in quotes") && fault.help.is_none() {
                // The shell has taken the quotes away.
                fault.help = Some(format!("in single quotes, too: --set '{path}=\"…\"'"));
            }
        }
    }
    match scene {
        Some(scene) if faults.is_empty() => Ok(scene),
        _ => Err(SceneErrors::new(shown, text, faults)),
    }
}
