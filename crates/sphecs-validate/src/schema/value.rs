//! How a figure of a case is measured.

use serde::Deserialize;

use sphecs_scene::notation::typed::Spanned;
use sphecs_scene::schema::{Formula, Number, Text};

/// How a figure is measured.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum ValueFile {
    /// Distance of what line or point probes measured from a reference.
    Profile {
        /// Run.
        run: Text,
        /// Probe of its scene; with `*` for any letters it is all that have such a name.
        probe: Text,
        /// Field.
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
    /// What the profile of a line probe looks like.
    Feature {
        /// Run.
        run: Text,
        /// Line probe; with `*` for any letters it is all that have such a name.
        probe: Text,
        /// Field.
        field: FieldFile,
        /// When; `Every` for the largest and the smallest only.
        when: Spanned<WhenFile>,
        /// What is looked for.
        take: FeatureFile,
        /// What it is divided by, default 1.
        #[serde(default)]
        scale: Option<Number>,
    },
    /// A column over time: of the monitor, of the forces on bodies, or of a section or point probe.
    Series {
        /// Run.
        run: Text,
        /// `monitor`, `forces`, or a probe of the scene.
        table: Text,
        /// Name of the column without its unit.
        column: Text,
        /// From when to when, s.
        over: (Number, Number),
        /// What is taken of it.
        take: TakeFile,
        /// What it is divided by, default 1.
        #[serde(default)]
        scale: Option<Number>,
    },
    /// A coefficient of a body over the interval that the scene gives it, as in `forces_mean.csv`.
    Body {
        /// Run.
        run: Text,
        /// Name of the body's wall part.
        body: Text,
        /// Which.
        take: CoefficientFile,
    },
    /// How far a column over time is from that of another run: √(Σ (f − f_other)²/Σ f_other²) over the samples of the first, between whose
    /// times the other's are interpolated. Negi et al. (2020), Eq. 32.
    Departure {
        /// Run.
        run: Text,
        /// `monitor`, `forces`, or a probe of the scene.
        table: Text,
        /// Name of the column without its unit.
        column: Text,
        /// The other run.
        from: Text,
        /// From when to when, s.
        over: (Number, Number),
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

/// A coefficient of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum CoefficientFile {
    /// Mean drag coefficient.
    DragMean,
    /// Half of the largest less the least drag coefficient.
    DragAmplitude,
    /// Mean lift coefficient.
    LiftMean,
    /// Half of the largest less the least lift coefficient.
    LiftAmplitude,
    /// Strouhal number of the lift.
    Strouhal,
}

/// Quantity of a line or point probe: a column of `probes.csv`, or what follows from it.
#[derive(Clone, Debug, Deserialize)]
pub enum FieldFile {
    /// Velocity along x, m/s.
    #[serde(rename = "u")]
    U,
    /// Velocity along y, m/s.
    #[serde(rename = "v")]
    V,
    /// Velocity along z, m/s.
    #[serde(rename = "w")]
    W,
    /// Magnitude of the velocity, m/s.
    #[serde(rename = "speed")]
    Speed,
    /// Pressure, Pa.
    #[serde(rename = "pressure")]
    Pressure,
    /// Density, kg/m³.
    #[serde(rename = "density")]
    Density,
    /// Velocity along a direction, m/s: its components, not longer or shorter than 1 by more than rounding.
    Along(Spanned<Vec<Number>>),
    /// Slope of another field along the line, over m: central differences between its points.
    Slope(Box<FieldFile>),
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
    /// The series of plane Poiseuille flow from rest between y = ± `half_width`: see [`exact`](crate::exact).
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
    /// The same probe and time of another run. Of ensembles the means are compared, and the error is that of their
    /// difference where both have several members.
    Run(Text),
    /// The other members of the run's own ensemble: the root of the mean square of the distances of two of them.
    Members,
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

/// What is looked for in a profile. Places are distances from the line's first point, m.
#[derive(Clone, Debug, Deserialize)]
pub enum FeatureFile {
    /// The largest value.
    Largest,
    /// The smallest value.
    Smallest,
    /// Where the value is largest, m.
    PlaceOfLargest,
    /// Length of the stretch about the largest value on which the value is at least this share of it, m.
    Width(Number),
    /// End of the longest stretch of negative values, m: 0 without one, and a lower bound where it reaches the line's end.
    Reattachment,
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
    /// Slope of the straight line nearest to it, by least squares, per second.
    Drift,
}
