//! Meaning, unit and default of a field, read from its doc line.
//!
//! ```text
//! Largest factor of the image velocity, dimensionless, default no cap; Morris et al. take 1.5.
//!                                       └─ unit ────┘          └ default
//! ```
//!
//! A unit stands between commas, a default behind `default` up to a semicolon or the end of the
//! sentence.

/// Units of the scene file, a longer one before its beginning.
const UNITS: [&str; 20] = [
    "s of wall time",
    "s and m/s",
    "s and Pa",
    "Pa s/m³",
    "m³/Pa",
    "in any unit",
    "dimensionless",
    "kg/(s m²)",
    "kg/m³",
    "kg/s",
    "m/s²",
    "m²/s",
    "m/s",
    "m²",
    "rad/s",
    "Pa",
    "rad",
    "degrees",
    "m",
    "s",
];

const DEFAULT: &str = " default ";

/// Parts of a doc line.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct DocLine {
    /// The text without unit and default.
    pub meaning: String,
    /// Unit, `dimensionless` or `any`; None if the text has no unit.
    pub unit: Option<String>,
    /// Default in words; None if the text has none.
    pub default: Option<String>,
}

impl DocLine {
    /// Reads a doc line, which may be wrapped.
    pub(super) fn read(text: &str) -> Self {
        let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
        let (text, unit) = cut_unit(&text);
        let (meaning, default) = cut_default(&text);
        let unit = unit.map(|unit| if unit == "in any unit" { "any" } else { unit }.to_owned());
        Self { meaning, unit, default }
    }
}

/// Removes the first unit of a text.
fn cut_unit(text: &str) -> (String, Option<&'static str>) {
    for (at, _) in text.match_indices(", ") {
        let rest = &text[at + 2..];
        let ends = |unit: &&&str| rest[unit.len()..].starts_with([',', ';', '.', ':']);
        let unit = UNITS.iter().filter(|unit| rest.starts_with(**unit)).find(ends);
        if let Some(unit) = unit {
            return (format!("{}{}", &text[..at], &rest[unit.len()..]), Some(unit));
        }
    }
    (text.to_owned(), None)
}

/// Removes the default of a text.
fn cut_default(text: &str) -> (String, Option<String>) {
    let Some(at) = text.find(DEFAULT).filter(|at| text[..*at].ends_with([',', ';'])) else {
        return (text.to_owned(), None);
    };
    let rest = &text[at + DEFAULT.len()..];
    let sentence = rest.find(". ").unwrap_or_else(|| rest.trim_end_matches('.').len());
    let end = rest.find(';').map_or(sentence, |semicolon| semicolon.min(sentence));
    (format!("{}{}", &text[..at - 1], &rest[end..]), Some(rest[..end].to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> (String, String, String) {
        let line = DocLine::read(text);
        (line.meaning, line.unit.unwrap_or_default(), line.default.unwrap_or_default())
    }

    #[test]
    fn parts_of_a_doc_line_are_found() {
        let parts = |meaning: &str, unit: &str, default: &str| {
            (meaning.to_owned(), unit.to_owned(), default.to_owned())
        };
        assert_eq!(read("Particle spacing Δ, m."), parts("Particle spacing Δ.", "m", ""));
        assert_eq!(
            read("Length of its zone, m, rounded up to whole\nspacings; default five spacings."),
            parts("Length of its zone, rounded up to whole spacings.", "m", "five spacings")
        );
        assert_eq!(
            read("Courant factor, dimensionless, default 0.5, with `Verlet` 0.3. Smaller is slower."),
            parts("Courant factor. Smaller is slower.", "dimensionless", "0.5, with `Verlet` 0.3")
        );
        assert_eq!(
            read("Speed, in any unit, an expression; default uniform."),
            parts("Speed, an expression.", "any", "uniform")
        );
        assert_eq!(read("The default walls, metres."), parts("The default walls, metres.", "", ""));
    }
}
