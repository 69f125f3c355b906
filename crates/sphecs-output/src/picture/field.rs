//! Fields that can be drawn, and their values for the particles of a frame.

use std::str::FromStr;

use super::view::View;
use super::vorticity::vorticity;
use crate::drawing::colours::Colours;
use crate::frame::Frame;

/// Field to draw.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    /// Magnitude of the velocity, m/s.
    Speed,
    /// Velocity along x, m/s.
    U,
    /// Velocity along y, m/s.
    V,
    /// Velocity along z, m/s.
    W,
    /// Pressure, Pa.
    Pressure,
    /// Density, kg/m³.
    Density,
    /// Vorticity, 1/s: ω_z in 2D, |ω| in 3D.
    Vorticity,
    /// Zone of each particle.
    Zone,
    /// Passive scalar.
    Tag,
}

impl Field {
    /// All fields.
    pub const ALL: [Field; 9] = [
        Field::Speed,
        Field::U,
        Field::V,
        Field::W,
        Field::Pressure,
        Field::Density,
        Field::Vorticity,
        Field::Zone,
        Field::Tag,
    ];

    /// Returns the name on the command line and in pictures.
    pub fn name(self) -> &'static str {
        match self {
            Field::Speed => "speed",
            Field::U => "u",
            Field::V => "v",
            Field::W => "w",
            Field::Pressure => "pressure",
            Field::Density => "density",
            Field::Vorticity => "vorticity",
            Field::Zone => "zone",
            Field::Tag => "tag",
        }
    }

    /// Returns the unit in pictures; empty for dimensionless fields.
    pub fn unit(self) -> &'static str {
        match self {
            Field::Speed | Field::U | Field::V | Field::W => "m/s",
            Field::Pressure => "Pa",
            Field::Density => "kg/m³",
            Field::Vorticity => "1/s",
            Field::Zone | Field::Tag => "",
        }
    }

    /// Returns the default colour map: signed fields diverge from white at zero.
    pub(super) fn colours(self, dimensions: usize) -> Colours {
        match self {
            Field::U | Field::V | Field::W => Colours::Diverging,
            Field::Vorticity if dimensions == 2 => Colours::Diverging,
            Field::Speed | Field::Vorticity | Field::Tag => Colours::Viridis,
            Field::Pressure => Colours::Plasma,
            Field::Density => Colours::Cividis,
            Field::Zone => Colours::Turbo,
        }
    }

    /// Returns true if a pixel has the value of its nearest particle, since labels have no mean.
    pub(super) fn is_label(self) -> bool {
        matches!(self, Field::Zone | Field::Tag)
    }

    /// Returns the fraction of values that the colour scale may cut off at each end.
    ///
    /// A few extreme particles at sharp corners would otherwise hide all other values.
    pub(super) fn cut(self) -> f64 {
        match self {
            Field::Vorticity => 0.002,
            Field::Pressure | Field::Density => 0.001,
            _ => 0.0,
        }
    }

    /// Returns the values of all slots of a frame, NaN without a value; vorticity is computed for
    /// the view only.
    pub(super) fn values(self, frame: &Frame, view: &View) -> Vec<f32> {
        let [u, v, w] = &frame.velocity;
        match self {
            Field::Speed => {
                (0..frame.len()).map(|i| (u[i] * u[i] + v[i] * v[i] + w[i] * w[i]).sqrt()).collect()
            }
            Field::U => u.clone(),
            Field::V => v.clone(),
            Field::W => w.clone(),
            Field::Pressure => frame.pressure.clone(),
            Field::Density => frame.density.clone(),
            Field::Vorticity => vorticity(frame, view),
            Field::Zone => frame.zone.iter().map(|&zone| f32::from(zone)).collect(),
            Field::Tag => frame.tag.clone(),
        }
    }
}

impl FromStr for Field {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Field::ALL.into_iter().find(|field| field.name() == text).ok_or_else(|| {
            let names: Vec<&str> = Field::ALL.iter().map(|field| field.name()).collect();
            let near = names
                .iter()
                .min_by_key(|name| strsim::damerau_levenshtein(name, text))
                .copied()
                .unwrap_or_default();
            format!("`{text}` is not a field, did you mean `{near}`? Fields are {}", names.join(", "))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_read_back() {
        for field in Field::ALL {
            assert_eq!(field.name().parse(), Ok(field));
        }
        let error = "presure".parse::<Field>().expect_err("refused");
        assert!(error.contains("`pressure`"), "{error}");
    }
}
