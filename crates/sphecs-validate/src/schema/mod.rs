//! Notation of a case file: runs, figures with their bands, plots and pictures.
//!
//! Numbers may be literals or quoted expressions of the constants of the case. Formulas may also
//! depend on x, y, z (m) and t (s), formulas of figures on earlier figures.
//!
//! - [`figure`]: measurement of a figure
//! - [`drawing`]: plots and pictures

use serde::Deserialize;
use serde::de::IgnoredAny;

use sphecs_scene::schema::{Number, Text};

pub mod drawing;
pub mod figure;

pub use drawing::{CurveFile, PictureFile, PlotFile};
pub use figure::{
    AxisFile, CoefficientFile, FeatureFile, FieldFile, NormFile, ReferenceFile, SignalFile, TakeFile,
    ValueFile, WhenFile,
};

/// Case.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename = "Case", deny_unknown_fields)]
pub struct CaseFile {
    /// Title.
    pub title: String,
    /// Source of the case and of its reference.
    pub source: String,
    /// Reference in a few words, for the first sentence of the page.
    #[serde(default)]
    pub compared_with: Option<String>,
    /// Flow that is computed, Markdown.
    pub setting: String,
    /// Values in the source and reasons of missed bands, Markdown.
    #[serde(default)]
    pub remarks: Option<String>,
    /// Named constants, read before everything else.
    #[serde(default)]
    pub constants: Option<IgnoredAny>,
    /// Runs.
    pub runs: Vec<RunFile>,
    /// Figures measured from the runs.
    pub figures: Vec<FigureFile>,
    /// Plots of the runs.
    #[serde(default)]
    pub plots: Vec<PlotFile>,
    /// Pictures of the runs.
    #[serde(default)]
    pub pictures: Vec<PictureFile>,
}

/// Lowest tier that includes a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
pub enum Tier {
    /// `sphecs validate --quick`: minutes.
    Quick,
    /// `sphecs validate`: hours.
    #[default]
    Usual,
    /// `sphecs validate --full`: everything, at published resolution.
    Full,
}

/// Run of a scene.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename = "Run", deny_unknown_fields)]
pub struct RunFile {
    /// Name of the run and of its folder, unique in the case.
    pub name: Text,
    /// Name of a shipped scene, or the path of a scene relative to the case file.
    pub scene: Text,
    /// Values changed in the scene, as by `--set`.
    #[serde(default)]
    pub set: Vec<(Text, Text)>,
    /// Lowest tier that includes the run, default `Usual`.
    #[serde(default)]
    pub tier: Tier,
    /// True if the run may diverge: it is then reported, and figures of it are omitted. Default
    /// false.
    #[serde(default)]
    pub may_fail: bool,
    /// Further members of an ensemble, so that figures are means with a standard error.
    #[serde(default)]
    pub again: Option<AgainFile>,
}

impl RunFile {
    /// Returns the members in a tier as the values changed in the scene, the run itself first.
    pub fn members(&self, tier: Tier) -> Vec<Vec<(String, String)>> {
        let own: Vec<(String, String)> =
            self.set.iter().map(|(path, value)| (path.value.clone(), value.value.clone())).collect();
        let again = self.again.as_ref().filter(|again| again.tier <= tier);
        let others = again.into_iter().flat_map(|again| {
            again.to.iter().map(|value| {
                let mut set = own.clone();
                set.push((again.set.value.clone(), value.value.clone()));
                set
            })
        });
        std::iter::once(own.clone()).chain(others).collect()
    }

    /// Returns the name of the folder of a member: the name of the run, with a number from the
    /// second member on.
    pub fn member_name(&self, member: usize) -> String {
        if member == 0 { self.name.value.clone() } else { format!("{}.{}", self.name.value, member + 1) }
    }
}

/// Further members of an ensemble: the run with a tiny change that should not affect its
/// statistics.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename = "Again", deny_unknown_fields)]
pub struct AgainFile {
    /// Path of the value in the scene, as by `--set`: a tiny disturbance of the initial state.
    pub set: Text,
    /// Value in each further member.
    pub to: Vec<Text>,
    /// Lowest tier that includes them, default `Full`.
    #[serde(default = "full")]
    pub tier: Tier,
}

fn full() -> Tier {
    Tier::Full
}

/// Quantity that is measured.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename = "Figure", deny_unknown_fields)]
pub struct FigureFile {
    /// Name, unique in the case, for use in later formulas.
    pub name: Text,
    /// Description with the unit.
    pub what: String,
    /// Measurement.
    pub value: ValueFile,
    /// Required band.
    #[serde(default)]
    pub must: Option<BandFile>,
    /// Goal.
    #[serde(default)]
    pub goal: Option<BandFile>,
    /// Value in the source.
    #[serde(default)]
    pub printed: Option<Number>,
    /// True for a figure without a band that the summary of the page lists. Default false.
    #[serde(default)]
    pub in_summary: bool,
}

/// Band of a figure.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum BandFile {
    /// Upper bound.
    AtMost(Number),
    /// Lower bound.
    AtLeast(Number),
    /// Lower and upper bound.
    Between(Number, Number),
    /// Largest distance from a value.
    Near {
        /// Value.
        value: Number,
        /// Largest distance.
        by: Number,
    },
}
