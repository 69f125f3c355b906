//! Units that a user writes behind a number. A scene has SI units only and writes none.

use sphecs_core::format::with_digits;

/// Names of units and their values in SI units.
const UNITS: [(&str, f64); 34] = [
    ("m", 1.0),
    ("km", 1e3),
    ("dm", 1e-1),
    ("cm", 1e-2),
    ("mm", 1e-3),
    ("um", 1e-6),
    ("µm", 1e-6),
    ("μm", 1e-6),
    ("nm", 1e-9),
    ("in", 0.0254),
    ("s", 1.0),
    ("ms", 1e-3),
    ("us", 1e-6),
    ("min", 60.0),
    ("h", 3600.0),
    ("kg", 1.0),
    ("g", 1e-3),
    ("mg", 1e-6),
    ("N", 1.0),
    ("kN", 1e3),
    ("Pa", 1.0),
    ("hPa", 1e2),
    ("kPa", 1e3),
    ("MPa", 1e6),
    ("mbar", 1e2),
    ("bar", 1e5),
    ("mmHg", 133.322_387_415),
    ("l", 1e-3),
    ("L", 1e-3),
    ("ml", 1e-6),
    ("mL", 1e-6),
    ("Hz", 1.0),
    ("cSt", 1e-6),
    ("St", 1e-4),
];

/// Returns the value of a unit such as `mm/s` or `kg/m^3` in SI units; None for other text.
pub(crate) fn value(unit: &str) -> Option<f64> {
    let mut value = 1.0;
    let mut sign = 1;
    let mut rest = unit.trim();
    loop {
        let length = rest.find(|c: char| !c.is_alphabetic()).unwrap_or(rest.len());
        let (_, factor) = UNITS.iter().find(|(name, _)| *name == &rest[..length])?;
        rest = &rest[length..];
        let mut power = 1;
        for (written, exponent) in [("^2", 2), ("²", 2), ("2", 2), ("^3", 3), ("³", 3), ("3", 3)] {
            if let Some(after) = rest.strip_prefix(written) {
                (power, rest) = (exponent, after);
                break;
            }
        }
        value *= factor.powi(sign * power);
        match rest.chars().next() {
            None => return Some(value),
            Some('/') => sign = -1,
            Some('*' | '·' | ' ') => {}
            Some(_) => return None,
        }
        rest = rest[rest.chars().next().map_or(0, char::len_utf8)..].trim_start();
    }
}

/// Returns the number and the unit of a text such as `1.25 mm`, with the place of the unit; None if
/// it is not a number with a unit.
pub(crate) fn quantity(text: &str) -> Option<(f64, f64, usize)> {
    let ends = (1..text.len().min(32)).rev().filter(|end| text.is_char_boundary(*end));
    let (number, end) =
        ends.filter_map(|end| Some((text[..end].trim_end().parse::<f64>().ok()?, end))).next()?;
    let at = end + text[end..].len() - text[end..].trim_start().len();
    Some((number, value(&text[at..])?, at))
}

/// Returns advice on a number with a unit, given by its value in SI units.
pub(crate) fn advice(number: f64, unit: f64) -> String {
    // Twelve digits hide the rounding of the product.
    format!("all numbers are in SI units without a name: write `{}`", with_digits(number * unit, 12))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_have_values_in_si() {
        for (unit, expected) in
            [("mm", 1e-3), ("m/s", 1.0), ("mm/s", 1e-3), ("g/cm^3", 1e3), ("kg/m³", 1.0), ("cm2/s", 1e-4)]
        {
            let found = value(unit).expect(unit);
            assert!((found - expected).abs() < 1e-12 * expected, "{unit}: {found}");
        }
        for text in ["", "v0", "mm/", "m/x", "x", "m+s", "pi"] {
            assert_eq!(value(text), None, "{text}");
        }
    }

    #[test]
    fn number_with_a_unit_differs_from_other_text() {
        assert_eq!(quantity("1.25 mm"), Some((1.25, 1e-3, 5)));
        assert_eq!(quantity("-2e-3m"), Some((-2e-3, 1.0, 5)));
        for text in ["1.25", "mm", "2*h", "1.0e-3", "2 x"] {
            assert_eq!(quantity(text), None, "{text}");
        }
        assert!(advice(1.25, 1e-3).contains("`0.00125`"));
    }
}
