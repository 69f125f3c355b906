//! What may stand in a case file: runs, figures with their bands, plots.
//!
//! Numbers may be literals or expressions of the case's constants in quotes; formulas may depend on x, y, z (m) and
//! t (s) as well, those of figures on the figures before them.

use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::scene::notation::typed::Spanned;
use crate::scene::schema::{Formula, Number, Text};

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
    /// Pictures of them.
    #[serde(default)]
    pub plots: Vec<PlotFile>,
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

/// How a figure is measured.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum ValueFile {
    /// Distance of what a line or point probe measured from a reference.
    Profile {
        /// Run.
        run: Text,
        /// Probe of its scene.
        probe: Text,
        /// `u`, `v`, `w`, `pressure` or `density`.
        field: FieldFile,
        /// When.
        when: Spanned<WhenFile>,
        /// What should be there.
        reference: ReferenceFile,
        /// How the distances are put together.
        norm: NormFile,
        /// What they are divided by, default 1.
        #[serde(default)]
        scale: Option<Number>,
    },
    /// A column over time: of the monitor, or of a section or point probe.
    Series {
        /// Run.
        run: Text,
        /// `monitor`, or a probe of the scene.
        table: Text,
        /// Name of the column without its unit.
        column: Text,
        /// From when to when, s.
        over: (Number, Number),
        /// What is taken of it.
        take: TakeFile,
    },
    /// Exponential growth, 1/s, of the amplitude of a wave along a line probe, while it is between two bounds.
    Growth {
        /// Run.
        run: Text,
        /// Line probe over whole wavelengths, its last point the first of the next period.
        probe: Text,
        /// Field.
        field: FieldFile,
        /// Waves on the line.
        waves: Number,
        /// Bounds of the amplitude.
        between: (Number, Number),
    },
    /// Reflection of sound: largest |p' − Z u'| over the second interval against largest |p' + Z u'| over the first.
    Reflection {
        /// Run.
        run: Text,
        /// Point probe, or a line across, its last point the first of the next period.
        probe: Text,
        /// Waves on the line, 0 for a point.
        #[serde(default)]
        waves: Option<Number>,
        /// Impedance Z = ρ c/cos θ, kg/(m² s).
        impedance: Number,
        /// When the incident wave passes, s.
        incident: (Number, Number),
        /// When the reflected one does, s.
        reflected: (Number, Number),
    },
    /// Order of convergence: slope of the logarithms of figures over those of spacings, by least squares.
    Order {
        /// Figures before this one.
        figures: Vec<Text>,
        /// Spacing of each, in any unit.
        spacings: Vec<Number>,
    },
    /// A formula of the figures before this one.
    Formula(Text),
}

/// Quantity of a line or point probe.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
#[expect(missing_docs, reason = "they are the columns of `probes.csv`")]
pub enum FieldFile {
    U,
    V,
    W,
    Pressure,
    Density,
}

/// When a profile is taken.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum WhenFile {
    /// The sample nearest to a time, s; the reference is that of the sample's own time.
    At(Number),
    /// The time mean from the first to the second, s.
    Mean(Number, Number),
    /// Every sample from the first to the second, s: the worst counts.
    Every(Number, Number),
}

/// What a profile should be.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum ReferenceFile {
    /// A formula of x, y, z, t.
    Formula(Formula),
    /// The series of plane Poiseuille flow from rest between y = ± `half_width`: see [`super::exact`].
    PoiseuilleStartup {
        /// Half the gap, m.
        half_width: Number,
        /// Force per mass along x, m/s².
        body_force: Number,
        /// Kinematic viscosity, m²/s.
        viscosity: Number,
    },
    /// The series of plane Couette flow from rest over y from `bottom`, where the wall stands.
    CouetteStartup {
        /// Place of the wall at rest, m.
        bottom: Number,
        /// Gap, m.
        gap: Number,
        /// Speed of the other wall, m/s.
        velocity: Number,
        /// Kinematic viscosity, m²/s.
        viscosity: Number,
    },
    /// Developed laminar flow along x in a rectangular duct about the x axis.
    RectangularDuct {
        /// Half the edge along y, m.
        half_width: Number,
        /// Half the edge along z, m.
        half_height: Number,
        /// Force per mass along x, m/s².
        body_force: Number,
        /// Kinematic viscosity, m²/s.
        viscosity: Number,
    },
    /// Columns of a CSV file beside the case, with straight lines between.
    Table {
        /// File.
        file: Text,
        /// Column of the coordinate, m.
        along: Text,
        /// Axis of the coordinate: `x`, `y` or `z`.
        axis: AxisFile,
        /// Column of the value.
        value: Text,
    },
    /// The same probe and time of another run.
    Run(Text),
}

/// An axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
#[expect(missing_docs, reason = "an axis is its name")]
pub enum AxisFile {
    X,
    Y,
    Z,
}

/// How the distances of a profile are put together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum NormFile {
    /// The largest magnitude.
    Largest,
    /// The root of the mean square.
    RootMeanSquare,
}

/// What is taken of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum TakeFile {
    /// Time mean.
    Mean,
    /// Standard deviation of the samples.
    Deviation,
    /// Largest.
    Largest,
    /// Smallest.
    Smallest,
    /// The last.
    Last,
}

/// A picture.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename = "Plot", deny_unknown_fields)]
pub struct PlotFile {
    /// Name of the file without its extension.
    pub name: Text,
    /// What it shows, in words.
    pub title: String,
    /// What stands at the abscissa, with its unit.
    pub across: String,
    /// What stands at the ordinate, with its unit.
    pub upward: String,
    /// Whether the ordinate is logarithmic.
    #[serde(default)]
    pub logarithmic: bool,
    /// The curves.
    pub curves: Vec<CurveFile>,
}

/// A curve of a plot.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum CurveFile {
    /// A probe's field along an axis, with the reference as a line where one is given.
    Profile {
        /// Run.
        run: Text,
        /// Line probe.
        probe: Text,
        /// Field.
        field: FieldFile,
        /// When; one time or one mean.
        when: Spanned<WhenFile>,
        /// Abscissa.
        axis: AxisFile,
        /// What should be there.
        #[serde(default)]
        reference: Option<Box<ReferenceFile>>,
        /// Words of the legend.
        label: String,
    },
    /// A column over time.
    Series {
        /// Run.
        run: Text,
        /// `monitor`, or a probe.
        table: Text,
        /// Column without its unit.
        column: Text,
        /// Words of the legend.
        label: String,
    },
}
