//! Outlets: the door lists the rooms and holds the closed choices.
//!
//! - [`absorbing`]: an outlet pressure that lets plane sound waves leave
//! - [`continuation`]: a zone that carries a wave of sound on
//! - [`convection`]: how fast an outflow zone is carried away
//! - [`oblique`]: an outlet pressure that lets sound leave at any angle
//! - [`wave`]: the outgoing wave equation

pub mod absorbing;
pub mod continuation;
pub mod convection;
pub mod oblique;
pub mod wave;

use serde::{Deserialize, Serialize};

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

impl OutletCondition {
    /// Pressure of the outflow particles.
    pub fn pressure(&self) -> OutletPressure {
        match *self {
            OutletCondition::WaveEquation { pressure, .. } | OutletCondition::Orlanski { pressure, .. } => {
                pressure
            }
        }
    }

    /// Frame in which the wave equation is integrated.
    pub fn frame(&self) -> Frame {
        match *self {
            OutletCondition::WaveEquation { frame, .. } | OutletCondition::Orlanski { frame, .. } => frame,
        }
    }

    /// Form of the transverse Laplacian; None where it is dropped.
    pub fn transverse(&self) -> Option<TransverseOperator> {
        match *self {
            OutletCondition::WaveEquation { transverse, .. } => Some(transverse),
            OutletCondition::Orlanski { .. } => None,
        }
    }
}
