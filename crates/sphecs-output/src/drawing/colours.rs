//! Colour maps.

use colorous::Gradient;

/// Colour map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colours {
    /// Perceptually uniform, dark blue to yellow.
    Viridis,
    /// Perceptually uniform, dark blue over red to yellow.
    Plasma,
    /// Perceptually uniform, blue to yellow, suitable for colour-blind readers.
    Cividis,
    /// Rainbow with even steps.
    Turbo,
    /// Blue, white at the middle, red.
    Diverging,
}

impl Colours {
    /// All maps with their names on the command line.
    pub const ALL: [(&'static str, Colours); 5] = [
        ("viridis", Colours::Viridis),
        ("plasma", Colours::Plasma),
        ("cividis", Colours::Cividis),
        ("turbo", Colours::Turbo),
        ("diverging", Colours::Diverging),
    ];

    /// Returns the colour at a fraction of the scale, clamped to 0 to 1.
    pub(crate) fn at(self, share: f64) -> [u8; 3] {
        let share = share.clamp(0.0, 1.0);
        let (gradient, share): (Gradient, f64) = match self {
            Colours::Viridis => (colorous::VIRIDIS, share),
            Colours::Plasma => (colorous::PLASMA, share),
            Colours::Cividis => (colorous::CIVIDIS, share),
            Colours::Turbo => (colorous::TURBO, share),
            Colours::Diverging => (colorous::RED_BLUE, 1.0 - share),
        };
        let colour = gradient.eval_continuous(share);
        [colour.r, colour.g, colour.b]
    }
}

impl std::str::FromStr for Colours {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        Colours::ALL.iter().find(|(name, _)| *name == text).map(|&(_, colours)| colours).ok_or_else(|| {
            let names: Vec<&str> = Colours::ALL.iter().map(|&(name, _)| name).collect();
            format!("`{text}` is not a colour map, colour maps are {}", names.join(", "))
        })
    }
}
