//! Plots and pictures of a case.

use serde::Deserialize;

use super::value::{AxisFile, FieldFile, NormFile, ReferenceFile, WhenFile};
use sphecs_scene::notation::typed::Spanned;
use sphecs_scene::schema::{Number, Text};

/// Curves in a plane.
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
    /// True if the ordinate is logarithmic.
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
        /// Coordinate along the line: the abscissa.
        axis: AxisFile,
        /// The profile upright at a station: the coordinate is the ordinate, and the abscissa is the first number plus the
        /// second times the value.
        #[serde(default)]
        upright: Option<(Number, Number)>,
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
        /// Times that are shown, s, default all.
        #[serde(default)]
        over: Option<(Number, Number)>,
        /// Words of the legend.
        label: String,
    },
    /// How far a probe's field is from what it should be, over time.
    Distance {
        /// Run.
        run: Text,
        /// Line or point probe; with `*` for any letters it is all that have such a name.
        probe: Text,
        /// Field.
        field: FieldFile,
        /// What should be there: not another run.
        reference: Box<ReferenceFile>,
        /// How the distances of a time are put together.
        norm: NormFile,
        /// What they are divided by, default 1.
        #[serde(default)]
        scale: Option<Number>,
        /// Words of the legend.
        label: String,
    },
}

impl CurveFile {
    /// Returns the run that it shows.
    pub fn run(&self) -> &Text {
        match self {
            CurveFile::Profile { run, .. }
            | CurveFile::Series { run, .. }
            | CurveFile::Distance { run, .. } => run,
        }
    }
}

/// Maps of a field of a run's particles at some times, one picture each.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename = "Picture", deny_unknown_fields)]
pub struct PictureFile {
    /// Name of the files without number and extension.
    pub name: Text,
    /// What they show, in words.
    pub title: String,
    /// Run; of an ensemble its first member.
    pub run: Text,
    /// Field, as of `sphecs render`: `speed`, `u`, `v`, `w`, `pressure`, `density`, `vorticity`, `zone` or `tag`.
    pub field: Text,
    /// Times, s; the frame nearest to each is shown.
    pub times: Vec<Number>,
    /// Values at the ends of the colour scale, default those of the frame.
    #[serde(default)]
    pub range: Option<(Number, Number)>,
    /// Width, pixels, default 900.
    #[serde(default)]
    pub width: Option<Spanned<u32>>,
    /// Axis across the slice of a 3D flow and its place on it, m, default the middle across z.
    #[serde(default)]
    pub slice: Option<(AxisFile, Number)>,
}
