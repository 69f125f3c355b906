//! Plots and pictures of a case.

use serde::Deserialize;

use super::figure::{AxisFile, FieldFile, NormFile, ReferenceFile, WhenFile};
use sphecs_scene::notation::typed::Spanned;
use sphecs_scene::schema::{Number, Text};

/// Plot of curves.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename = "Plot", deny_unknown_fields)]
pub struct PlotFile {
    /// Name of the file without its extension.
    pub name: Text,
    /// Title.
    pub title: String,
    /// Label of the abscissa with its unit.
    pub across: String,
    /// Label of the ordinate with its unit.
    pub upward: String,
    /// True if the ordinate is logarithmic.
    #[serde(default)]
    pub logarithmic: bool,
    /// Curves.
    pub curves: Vec<CurveFile>,
}

/// Curve of a plot.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum CurveFile {
    /// Field of a probe along an axis, with its reference if there is one.
    Profile {
        /// Run.
        run: Text,
        /// Line probe.
        probe: Text,
        /// Field.
        field: FieldFile,
        /// Time or interval of one profile.
        when: Spanned<WhenFile>,
        /// Coordinate along the line, the abscissa.
        axis: AxisFile,
        /// Upright profile at a station: the coordinate is the ordinate, and the abscissa is the
        /// first number plus the second times the value.
        #[serde(default)]
        upright: Option<(Number, Number)>,
        /// Reference.
        #[serde(default)]
        reference: Option<Box<ReferenceFile>>,
        /// Label in the legend.
        label: String,
    },
    /// Column over time, the mean over the points of a probe.
    Series {
        /// Run.
        run: Text,
        /// `monitor`, or a probe.
        table: Text,
        /// Column without its unit.
        column: Text,
        /// Interval shown, s, default all.
        #[serde(default)]
        over: Option<(Number, Number)>,
        /// Reference at the first point of the probe.
        #[serde(default)]
        reference: Option<Box<ReferenceFile>>,
        /// Label in the legend.
        label: String,
    },
    /// Distance of the field of a probe from its reference over time.
    Distance {
        /// Run.
        run: Text,
        /// Line or point probe; `*` stands for any letters and may match several probes.
        probe: Text,
        /// Field.
        field: FieldFile,
        /// Reference, which must not be another run.
        reference: Box<ReferenceFile>,
        /// Norm of the distances at one time.
        norm: NormFile,
        /// Divisor, default 1.
        #[serde(default)]
        scale: Option<Number>,
        /// Label in the legend.
        label: String,
    },
}

impl CurveFile {
    /// Returns the run of the curve.
    pub fn run(&self) -> &Text {
        match self {
            CurveFile::Profile { run, .. }
            | CurveFile::Series { run, .. }
            | CurveFile::Distance { run, .. } => run,
        }
    }
}

/// Pictures of a field of the particles of a run at some times.
#[derive(Clone, Debug, Deserialize)]
#[serde(rename = "Picture", deny_unknown_fields)]
pub struct PictureFile {
    /// Name of the files without number and extension.
    pub name: Text,
    /// Title.
    pub title: String,
    /// Run; the first member of an ensemble.
    pub run: Text,
    /// Field, as of `sphecs render`: `speed`, `u`, `v`, `w`, `pressure`, `density`, `vorticity`,
    /// `zone` or `tag`.
    pub field: Text,
    /// Times, s; the frame nearest to each is shown.
    pub times: Vec<Number>,
    /// Values at the ends of the colour scale, default those of the frame.
    #[serde(default)]
    pub range: Option<(Number, Number)>,
    /// Width, pixels, default 900.
    #[serde(default)]
    pub width: Option<Spanned<u32>>,
    /// Axis normal to the slice of a 3D flow and position on it, m; default the middle of z.
    #[serde(default)]
    pub slice: Option<(AxisFile, Number)>,
}
