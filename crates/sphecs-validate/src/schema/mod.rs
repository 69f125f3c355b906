//! What may stand in a case file: runs, figures with their bands, plots and pictures.
//!
//! Numbers may be literals or expressions of the case's constants in quotes; formulas may depend on x, y, z (m) and
//! t (s) as well, those of figures on the figures before them.
//!
//! Rooms: [`value`] (how a figure is measured), [`drawing`] (plots and pictures).

use serde::Deserialize;
use serde::de::IgnoredAny;

use sphecs_scene::schema::{Number, Text};

pub mod drawing;
pub mod value;

pub use drawing::{CurveFile, PictureFile, PlotFile};
pub use value::{
    AxisFile, CoefficientFile, FeatureFile, FieldFile, NormFile, ReferenceFile, TakeFile, ValueFile, WhenFile,
};

/// A case.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename = "Case", deny_unknown_fields)]
pub struct CaseFile {
    /// One line for people.
    pub title: String,
    /// Where the case and its reference come from.
    pub source: String,
    /// What is computed, Markdown.
    pub setting: String,
    /// What the source printed, what is known of misses; Markdown.
    #[serde(default)]
    pub remarks: Option<String>,
    /// Named constants, read before everything else.
    #[serde(default)]
    pub constants: Option<IgnoredAny>,
    /// Flows to be run.
    pub runs: Vec<RunFile>,
    /// What is measured of them.
    pub figures: Vec<FigureFile>,
    /// Curves of them.
    #[serde(default)]
    pub plots: Vec<PlotFile>,
    /// Maps of them.
    #[serde(default)]
    pub pictures: Vec<PictureFile>,
}

/// From which tier on something is run.
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

/// A flow to be run.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename = "Run", deny_unknown_fields)]
pub struct RunFile {
    /// Name, unique in the case; that of its folder too.
    pub name: Text,
    /// Name of a shipped scene, or the path of a scene beside the case file.
    pub scene: Text,
    /// Values put into the scene, as by `--set`.
    #[serde(default)]
    pub set: Vec<(Text, Text)>,
    /// From which tier on it is run, default `Usual`.
    #[serde(default)]
    pub tier: Tier,
    /// True if it is known that it may blow up: that is then told, and what looks at it is left out. Default false.
    #[serde(default)]
    pub may_fail: bool,
    /// The same flow again, so that its figures are means with a standard error.
    #[serde(default)]
    pub again: Option<AgainFile>,
}

impl RunFile {
    /// Its members in a tier: what is put into the scene for each, the run itself first.
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

    /// Name of a member's folder: the run's, and from the second on its number.
    pub fn member_name(&self, member: usize) -> String {
        if member == 0 { self.name.value.clone() } else { format!("{}.{}", self.name.value, member + 1) }
    }
}

/// Further members of an ensemble: the run with other values of something that should not matter.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename = "Again", deny_unknown_fields)]
pub struct AgainFile {
    /// Path of the value in the scene, as by `--set`: a tiny disturbance of the start.
    pub set: Text,
    /// Its value in each further member.
    pub to: Vec<Text>,
    /// From which tier on they are run, default `Full`.
    #[serde(default = "full")]
    pub tier: Tier,
}

fn full() -> Tier {
    Tier::Full
}

/// Something that is measured.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename = "Figure", deny_unknown_fields)]
pub struct FigureFile {
    /// Name, unique in the case; formulas of later figures know it.
    pub name: Text,
    /// What it is, in words, with its unit.
    pub what: String,
    /// How it is measured.
    pub value: ValueFile,
    /// Band to be met.
    #[serde(default)]
    pub must: Option<BandFile>,
    /// Band that is aimed at.
    #[serde(default)]
    pub goal: Option<BandFile>,
    /// What the source printed.
    #[serde(default)]
    pub printed: Option<Number>,
}

/// Where a figure has to lie.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum BandFile {
    /// Not above.
    AtMost(Number),
    /// Not below.
    AtLeast(Number),
    /// Neither below the first nor above the second.
    Between(Number, Number),
    /// Not farther from a value than so much.
    Near {
        /// The value.
        value: Number,
        /// Largest distance.
        by: Number,
    },
}
