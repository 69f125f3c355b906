//! Outlets: the door lists the rooms and holds the closed choices.
//!
//! - [`absorbing`]: an outlet pressure that lets plane sound waves leave
//! - [`characteristic`]: the outgoing characteristic about reference values
//! - [`continuation`]: a zone that carries a wave of sound on
//! - [`convection`]: how fast an outflow zone is carried away
//! - [`do_nothing`]: particles that keep what they had when they crossed
//! - [`hybrid`]: the base flow is kept, sound leaves by its characteristic
//! - [`mirror`]: the fluid's mirror image
//! - [`modified_do_nothing`]: the same, carried away by the fluid
//! - [`oblique`]: an outlet pressure that lets sound leave at any angle
//! - [`wave`]: the outgoing wave equation
//!
//! `WaveEquation` and `Orlanski` set rates and share their rooms; each of the others sets what a particle has in every step, as an
//! [`Outflow`].

pub mod absorbing;
pub mod characteristic;
pub mod continuation;
pub mod convection;
pub mod do_nothing;
pub mod hybrid;
pub mod mirror;
pub mod modified_do_nothing;
pub mod oblique;
pub mod wave;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use mirror::MirrorVariant;
use modified_do_nothing::ShownVelocity;

/// What an outflow particle does.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum OutletCondition {
    /// Outgoing wave equation with transverse diffusion: Alvarado-Rodríguez et al. (2017), Eqs. 27, 29 and 30.
    WaveEquation {
        /// Frame in which ∂v/∂t is integrated.
        #[serde(default)]
        frame: Frame,
        /// Form of the transverse Laplacian.
        #[serde(default)]
        transverse: TransverseOperator,
        /// Pressure of the outflow particles.
        #[serde(default)]
        pressure: OutletPressure,
    },
    /// The same without the diffusion term, Eq. 28.
    Orlanski {
        /// Frame in which ∂v/∂t is integrated.
        #[serde(default)]
        frame: Frame,
        /// Pressure of the outflow particles.
        #[serde(default)]
        pressure: OutletPressure,
    },
    /// Velocity and pressure stay as they were when the particle crossed: Negi et al. (2020), Eqs. 14–16.
    DoNothing,
    /// The same, but moved with the velocity of the fluid next to the plane: Negi et al. (2020), Eqs. 17 and 18.
    ModifiedDoNothing {
        /// Normal velocity that the fluid sees of its particles.
        #[serde(default)]
        shown: ShownVelocity,
    },
    /// Velocity and pressure of the fluid's mirror image: Negi et al. (2020), Eqs. 22–24.
    Mirror {
        /// What is made of the value and the slope at the image.
        #[serde(default)]
        variant: MirrorVariant,
    },
    /// The outgoing characteristic about reference values, nothing comes in: Negi et al. (2020), Eqs. 25–27. Its two fields have no
    /// default: a stream of another velocity than this has a pressure of ρ0 c0 times the difference.
    Characteristic {
        /// Reference velocity along the outlet's normal, m/s.
        velocity: f64,
        /// Reference pressure, Pa.
        pressure: f64,
    },
    /// The base flow is kept as by `DoNothing`, sound leaves as by `Characteristic` about it: Negi et al. (2020), Eqs. 28–31.
    Hybrid {
        /// Velocity u of the threshold: while |p − `pressure`| ≥ ½ ρ0 u² a particle's flow is taken for sound, m/s. None: the mean
        /// speed of what enters, followed over `steps`.
        #[serde(default)]
        velocity: Option<f64>,
        /// Pressure about which sound swings, Pa, default 0.
        #[serde(default)]
        pressure: f64,
        /// Steps N of the time mean that is taken for the base flow, default 6.
        #[serde(default = "usual_steps")]
        steps: f64,
    },
}

/// N of Negi et al. (2020), Sec. 3.4.
fn usual_steps() -> f64 {
    6.0
}

/// What a condition says of an outflow particle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outflow {
    /// Velocity, m/s.
    pub velocity: DVec3,
    /// Pressure, Pa.
    pub pressure: f64,
    /// Speed along the normal with which it moves, m/s.
    pub speed: f64,
}

impl Outflow {
    /// A particle whose velocity (m/s) is that with which it moves along the normal.
    pub fn moving(velocity: DVec3, pressure: f64, normal: DVec3) -> Self {
        Self { velocity, pressure, speed: velocity.dot(normal) }
    }

    /// The same with another velocity along the normal, m/s.
    pub fn at_speed(self, speed: f64, normal: DVec3) -> Self {
        Self { velocity: self.velocity + normal * (speed - self.velocity.dot(normal)), speed, ..self }
    }
}

/// What the conditions that solve a wave equation have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WaveCondition {
    /// Frame in which the wave equation is integrated.
    pub frame: Frame,
    /// Form of the transverse Laplacian; None where it is dropped.
    pub transverse: Option<TransverseOperator>,
    /// Pressure of the outflow particles.
    pub pressure: OutletPressure,
}

/// Frame in which the wave equation of an outlet is integrated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Frame {
    /// As printed: ∂v/∂t of a fixed point, integrated along the moving particle.
    Fixed,
    /// Carried by the particle, the convective term drops out.
    #[default]
    Moving,
}

/// Discrete form of the transverse Laplacian of Alvarado-Rodríguez et al. (2017), Eq. 29.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum TransverseOperator {
    /// L v = 2 Σ V v_ob g / (−Σ V y_ob² g), g = e_y² F, walls included.
    #[default]
    Normalised,
    /// As printed with the sign mended.
    Printed,
    /// Español & Revenga (2003).
    Consistent,
}

/// Pressure of outflow particles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum OutletPressure {
    /// As it was when the particle crossed the outlet.
    Frozen,
    /// A given pressure, Pa.
    Reference(f64),
    /// The crossing pressure, relaxed towards `target` (Pa) over `time` (s).
    Relaxed {
        /// Pressure approached, Pa.
        target: f64,
        /// Time constant, s.
        time: f64,
    },
    /// Lets sound leave: the incoming characteristic is held at `target` (Pa) and the mean velocity followed over
    /// `time` (s).
    Absorbing {
        /// Mean pressure approached, Pa.
        #[serde(default)]
        target: f64,
        /// Time constant with which the mean velocity is followed, s. None: four passages of sound through the
        /// domain along the outlet's normal.
        #[serde(default)]
        time: Option<f64>,
        /// Which waves may leave.
        #[serde(default)]
        waves: Waves,
    },
}

/// Waves of sound that an absorbing outlet lets leave.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Waves {
    /// Plane ones that run along the normal: those of the section's mean.
    Plane,
    /// Waves at any angle too.
    #[default]
    All,
}

impl Default for OutletPressure {
    fn default() -> Self {
        OutletPressure::Absorbing { target: 0.0, time: None, waves: Waves::All }
    }
}

impl Default for OutletCondition {
    /// What the comparison in docs/which_outlet.md came to, under either scheme.
    fn default() -> Self {
        OutletCondition::WaveEquation {
            frame: Frame::default(),
            transverse: TransverseOperator::default(),
            pressure: OutletPressure::default(),
        }
    }
}

impl OutletCondition {
    /// Its name in a scene.
    pub fn name(&self) -> &'static str {
        match self {
            OutletCondition::WaveEquation { .. } => "WaveEquation",
            OutletCondition::Orlanski { .. } => "Orlanski",
            OutletCondition::DoNothing => "DoNothing",
            OutletCondition::ModifiedDoNothing { .. } => "ModifiedDoNothing",
            OutletCondition::Mirror { .. } => "Mirror",
            OutletCondition::Characteristic { .. } => "Characteristic",
            OutletCondition::Hybrid { .. } => "Hybrid",
        }
    }

    /// Velocity (m/s) and pressure (Pa) that it is given for its surroundings; 0 where it has none.
    pub fn references(&self) -> (f64, f64) {
        match *self {
            OutletCondition::WaveEquation { pressure, .. } | OutletCondition::Orlanski { pressure, .. } => {
                let target = match pressure {
                    OutletPressure::Frozen => 0.0,
                    OutletPressure::Reference(target)
                    | OutletPressure::Relaxed { target, .. }
                    | OutletPressure::Absorbing { target, .. } => target,
                };
                (0.0, target)
            }
            OutletCondition::Characteristic { velocity, pressure } => (velocity, pressure),
            OutletCondition::Hybrid { velocity, pressure, .. } => (velocity.unwrap_or(0.0), pressure),
            OutletCondition::DoNothing
            | OutletCondition::ModifiedDoNothing { .. }
            | OutletCondition::Mirror { .. } => (0.0, 0.0),
        }
    }

    /// The wave equation of the condition, if it solves one.
    pub fn wave(&self) -> Option<WaveCondition> {
        match *self {
            OutletCondition::WaveEquation { frame, transverse, pressure } => {
                Some(WaveCondition { frame, transverse: Some(transverse), pressure })
            }
            OutletCondition::Orlanski { frame, pressure } => {
                Some(WaveCondition { frame, transverse: None, pressure })
            }
            OutletCondition::DoNothing
            | OutletCondition::ModifiedDoNothing { .. }
            | OutletCondition::Mirror { .. }
            | OutletCondition::Characteristic { .. }
            | OutletCondition::Hybrid { .. } => None,
        }
    }
}
