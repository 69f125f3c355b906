//! Measurement of a figure of a case.

use serde::Deserialize;

use sphecs_scene::notation::typed::Spanned;
use sphecs_scene::schema::{Formula, Number, Text};

/// Measurement of a figure.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum ValueFile {
    /// Distance of the values of line or point probes from a reference.
    Profile {
        /// Run.
        run: Text,
        /// Probe of the scene; `*` stands for any letters and may match several probes.
        probe: Text,
        /// Field.
        field: FieldFile,
        /// Time or interval.
        when: Spanned<WhenFile>,
        /// Reference.
        reference: ReferenceFile,
        /// Norm of the distances.
        norm: NormFile,
        /// Divisor, default 1.
        #[serde(default)]
        scale: Option<Number>,
    },
    /// Feature of the profile of a line probe.
    Feature {
        /// Run.
        run: Text,
        /// Line probe; `*` stands for any letters and may match several probes.
        probe: Text,
        /// Field.
        field: FieldFile,
        /// Time or interval; `Every` for the largest and the smallest only.
        when: Spanned<WhenFile>,
        /// Feature.
        take: FeatureFile,
        /// Divisor, default 1.
        #[serde(default)]
        scale: Option<Number>,
    },
    /// Statistic of a column over time of the monitor, of the forces on bodies, or of a section or
    /// point probe.
    Series {
        /// Run.
        run: Text,
        /// `monitor`, `forces`, or a probe of the scene.
        table: Text,
        /// Name of the column without its unit.
        column: Text,
        /// Interval, s.
        over: (Number, Number),
        /// Statistic.
        take: TakeFile,
        /// Divisor, default 1.
        #[serde(default)]
        scale: Option<Number>,
    },
    /// Comparison of a column over time with a function of time.
    Signal {
        /// Run.
        run: Text,
        /// `monitor`, `forces`, or a probe of the scene.
        table: Text,
        /// Name of the column without its unit.
        column: Text,
        /// Interval, s.
        over: (Number, Number),
        /// The function, an expression of t.
        reference: Formula,
        /// Kind of comparison.
        take: SignalFile,
        /// Divisor, default 1.
        #[serde(default)]
        scale: Option<Number>,
    },
    /// Torque about the origin on the fluid inside a closed curve in 2D by pressure and momentum
    /// that pass through it, time mean, N.
    TorqueThrough {
        /// Run.
        run: Text,
        /// Line probes whose points in their order are the curve; `*` stands for any letters.
        probes: Text,
        /// Interval, s.
        over: (Number, Number),
    },
    /// Coefficient of a body over the interval given by the scene, as in `forces_mean.csv`.
    Body {
        /// Run.
        run: Text,
        /// Name of the wall part of the body.
        body: Text,
        /// Coefficient.
        take: CoefficientFile,
    },
    /// Relative distance of a column over time from another run, √(Σ (f − f_other)²/Σ f_other²).
    ///
    /// Sums run over the samples of the first run, to whose times the other is interpolated. Negi
    /// et al. (2020), Eq. 32.
    Departure {
        /// Run.
        run: Text,
        /// `monitor`, `forces`, or a probe of the scene.
        table: Text,
        /// Name of the column without its unit.
        column: Text,
        /// Other run.
        from: Text,
        /// Interval, s.
        over: (Number, Number),
    },
    /// Growth rate, 1/s, of the amplitude of a wave along a line probe while it is between two
    /// bounds.
    Growth {
        /// Run.
        run: Text,
        /// Line probe over whole wavelengths; its last point is the first of the next period.
        probe: Text,
        /// Field.
        field: FieldFile,
        /// Number of waves on the line.
        waves: Number,
        /// Bounds of the amplitude.
        between: (Number, Number),
    },
    /// Reflection coefficient of an acoustic wave: largest |p' − Z u'| in the second interval over
    /// largest |p' + Z u'| in the first.
    Reflection {
        /// Run.
        run: Text,
        /// Point probe, or a line across the channel whose last point is the first of the next
        /// period.
        probe: Text,
        /// Number of waves on the line, 0 for a point.
        #[serde(default)]
        waves: Option<Number>,
        /// Velocity towards the outlet, default `u`.
        #[serde(default)]
        velocity: Option<FieldFile>,
        /// Impedance Z = ρ c/cos θ, kg/(m² s).
        impedance: Number,
        /// Interval of the incident wave, s.
        incident: (Number, Number),
        /// Interval of the reflected wave, s.
        reflected: (Number, Number),
    },
    /// Order of convergence: least-squares slope of the logarithms of figures over the logarithms
    /// of spacings.
    Order {
        /// Earlier figures.
        figures: Vec<Text>,
        /// Spacing of each, in any unit.
        spacings: Vec<Number>,
    },
    /// Formula of earlier figures.
    Formula(Text),
}

/// Comparison of a column with a function of time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum SignalFile {
    /// Factor by which the function fits the samples best, least squares.
    Factor,
    /// Root mean square of the differences.
    RootMeanSquare,
    /// Largest magnitude of a difference.
    Largest,
}

/// Coefficient of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum CoefficientFile {
    /// Mean drag coefficient.
    DragMean,
    /// Half the difference of the largest and the smallest drag coefficient.
    DragAmplitude,
    /// Mean lift coefficient.
    LiftMean,
    /// Half the difference of the largest and the smallest lift coefficient.
    LiftAmplitude,
    /// Strouhal number of the lift.
    Strouhal,
    /// Amplitude of the part of the drag coefficient that repeats with the Strouhal number.
    DragFittedAmplitude,
    /// Amplitude of the part of the lift coefficient that repeats with the Strouhal number.
    LiftFittedAmplitude,
    /// Root mean square of the drag coefficient's deviation from its mean.
    DragRms,
    /// Root mean square of the lift coefficient's deviation from its mean.
    LiftRms,
}

/// Quantity of a line or point probe: a column of `probes.csv`, or derived from columns.
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
    /// Velocity along a direction, m/s, given by its components, which must have length 1.
    Along(Spanned<Vec<Number>>),
    /// Derivative of another field along the line, per m, by central differences.
    Slope(Box<FieldFile>),
}

/// Time or interval of a profile.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum WhenFile {
    /// Sample nearest to a time, s; the reference is evaluated at the time of the sample.
    At(Number),
    /// Time mean from the first to the second, s.
    Mean(Number, Number),
    /// All samples from the first to the second, s.
    Every(Number, Number),
}

/// Reference of a profile.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum ReferenceFile {
    /// Formula of x, y, z, t.
    Formula(Formula),
    /// Plane Poiseuille flow from rest between y = ± `half_width`, see [`exact`](crate::exact).
    PoiseuilleStartup {
        /// Half the gap, m.
        half_width: Number,
        /// Force per mass along x, m/s².
        body_force: Number,
        /// Kinematic viscosity, m²/s.
        viscosity: Number,
    },
    /// Plane Couette flow from rest above the wall at rest at y = `bottom`.
    CouetteStartup {
        /// Position of the wall at rest, m.
        bottom: Number,
        /// Gap, m.
        gap: Number,
        /// Velocity of the other wall, m/s.
        velocity: Number,
        /// Kinematic viscosity, m²/s.
        viscosity: Number,
    },
    /// Developed laminar flow along x in a rectangular duct about the x axis.
    RectangularDuct {
        /// Half width along y, m.
        half_width: Number,
        /// Half width along z, m.
        half_height: Number,
        /// Force per mass along x, m/s².
        body_force: Number,
        /// Kinematic viscosity, m²/s.
        viscosity: Number,
    },
    /// Columns of a CSV file in the folder of the case, interpolated linearly.
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
    /// Equal probe and time of another run. For ensembles the means are compared, with the error of
    /// their difference if both have several members.
    Run(Text),
    /// Other members of the ensemble of the run: root mean square of the distances of two members.
    Members,
}

/// Axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
#[expect(missing_docs, reason = "the variants are the names of the axes")]
pub enum AxisFile {
    X,
    Y,
    Z,
}

/// Norm of the distances of a profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum NormFile {
    /// Largest magnitude.
    Largest,
    /// Root mean square.
    RootMeanSquare,
}

/// Feature of a profile. Positions are distances from the first point of the line, m.
#[derive(Clone, Debug, Deserialize)]
pub enum FeatureFile {
    /// Largest value.
    Largest,
    /// Smallest value.
    Smallest,
    /// Position of the largest value, m.
    PlaceOfLargest,
    /// Length around the largest value on which the value is at least this fraction of it, m.
    Width(Number),
    /// End of the longest interval of negative values, m: 0 without one, a lower bound if it
    /// reaches the end of the line.
    Reattachment,
}

/// Statistic of a column.
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
    /// Last.
    Last,
    /// Least-squares slope, per second.
    Drift,
}
