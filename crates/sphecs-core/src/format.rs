//! Numbers as text for the user: counts, durations, byte sizes and significant digits.

/// Returns a duration in s as `42 s`, `3 min 20 s` or `5 h 04 min`.
pub fn duration(seconds: f64) -> String {
    if seconds < 9.95 {
        return format!("{} s", with_digits(seconds, 2));
    }
    let seconds = seconds.round() as u64;
    match seconds {
        0..60 => format!("{seconds} s"),
        60..3600 => format!("{} min {:02} s", seconds / 60, seconds % 60),
        _ => format!("{} h {:02} min", seconds / 3600, seconds % 3600 / 60),
    }
}

/// Returns a count in groups of three digits, `1 234 567`, as in ISO 80000.
pub fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let mut text = String::with_capacity(digits.len() * 4 / 3);
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

/// Returns a number with four significant digits, as [`with_digits`] does.
pub fn significant(value: f64) -> String {
    with_digits(value, 4)
}

/// Returns a number with `digits` significant digits and no trailing zeros.
///
/// Values below a thousandth and from a hundred thousand on have an exponent.
pub fn with_digits(value: f64, digits: usize) -> String {
    let size = value.abs();
    if value.is_infinite() {
        return if value > 0.0 { "∞" } else { "−∞" }.to_owned();
    }
    if value == 0.0 {
        // Without the sign of −0.
        return "0".to_owned();
    }
    if value.is_nan() {
        return "NaN".to_owned();
    }
    let decimals = digits.saturating_sub(1);
    if !(1e-3..1e5).contains(&size) {
        return without_trailing_zeros(&format!("{value:.decimals$e}"));
    }
    let decimals = (decimals as i32 - size.log10().floor() as i32).max(0) as usize;
    without_trailing_zeros(&format!("{value:.decimals$}"))
}

/// Returns a coordinate with four significant digits, or as many as a hundredth of `resolution`
/// needs; a coordinate below a thousandth of it is `0`.
pub fn coordinate(value: f64, resolution: f64) -> String {
    let places = value.abs() / resolution;
    if places < 1e-3 {
        return "0".to_owned();
    }
    // A resolution of 0 leaves four digits.
    let digits = if places.is_finite() { (places.log10().floor() as i32 + 3).clamp(4, 12) } else { 4 };
    with_digits(value, digits as usize)
}

/// Returns a point as `(0.2, 0)`, each component as [`coordinate`] does.
pub fn point(position: &[f64], resolution: f64) -> String {
    let parts: Vec<String> = position.iter().map(|value| coordinate(*value, resolution)).collect();
    format!("({})", parts.join(", "))
}

/// Returns `0.3` for `0.3000` and `4e-7` for `4.000e-7`.
fn without_trailing_zeros(text: &str) -> String {
    let (digits, exponent) = text.split_at(text.find('e').unwrap_or(text.len()));
    let digits =
        if digits.contains('.') { digits.trim_end_matches('0').trim_end_matches('.') } else { digits };
    format!("{digits}{exponent}")
}

/// Returns a number of bytes with a decimal unit: `25 kB`, `12.3 GB`.
pub fn bytes(count: u64) -> String {
    let size = count as f64;
    match count {
        0..10_000 => format!("{count} B"),
        10_000..10_000_000 => format!("{:.0} kB", size / 1e3),
        10_000_000..10_000_000_000 => format!("{:.0} MB", size / 1e6),
        10_000_000_000..10_000_000_000_000 => format!("{:.1} GB", size / 1e9),
        u64::MAX => "more than 1.8e7 TB".to_owned(),
        _ => format!("{:.3e} TB", size / 1e12),
    }
}

/// Returns names and values as two aligned columns, one pair a line.
pub fn two_columns(rows: &[(&str, String)]) -> String {
    let width = rows.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
    rows.iter().map(|(name, value)| format!("  {name:<width$}  {value}")).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_and_counts_have_units_and_groups() {
        for (seconds, text) in [
            (0.0, "0 s"),
            (0.04, "0.04 s"),
            (3.21, "3.2 s"),
            (9.96, "10 s"),
            (59.4, "59 s"),
            (200.0, "3 min 20 s"),
            (18_240.0, "5 h 04 min"),
        ] {
            assert_eq!(duration(seconds), text);
        }
        for (count, text) in [(0, "0"), (999, "999"), (1000, "1 000"), (1_234_567, "1 234 567")] {
            assert_eq!(grouped(count), text);
        }
    }

    #[test]
    fn numbers_have_four_digits_and_no_trailing_zeros() {
        let cases = [
            (0.0, "0"),
            (-0.0, "0"),
            (0.3, "0.3"),
            (9.52e-4, "9.52e-4"),
            (1.428e-3, "0.001428"),
            (2637.04, "2637"),
            (-12.345, "-12.35"),
            (99_999.0, "99999"),
            (4e-7, "4e-7"),
            (1.5e9, "1.5e9"),
            (f64::NAN, "NaN"),
            (f64::INFINITY, "∞"),
        ];
        for (value, text) in cases {
            assert_eq!(significant(value), text);
        }
        assert_eq!(with_digits(0.012345, 2), "0.012");
    }

    /// Of a channel of 100 µm, of one of 12 m, and of a place that rounding moved off the origin.
    #[test]
    fn places_have_the_digits_that_the_resolution_needs() {
        assert_eq!(coordinate(1.234_567e-4, 1e-5), "1.235e-4");
        assert_eq!(coordinate(12.345_678_9, 1e-3), "12.34568");
        assert_eq!(coordinate(-12.0, 0.0), "-12");
        assert_eq!(point(&[-1e-18, 0.2, -0.0], 1e-3), "(0, 0.2, 0)");
    }

    #[test]
    fn byte_sizes_have_a_unit() {
        for (count, text) in [
            (512, "512 B"),
            (25_000, "25 kB"),
            (42_000_000, "42 MB"),
            (12_300_000_000, "12.3 GB"),
            (2 << 50, "2.252e3 TB"),
            (u64::MAX, "more than 1.8e7 TB"),
        ] {
            assert_eq!(bytes(count), text);
        }
    }

    #[test]
    fn columns_are_aligned() {
        assert_eq!(
            two_columns(&[("a", "1".to_owned()), ("speed", "2".to_owned())]),
            "  a      1\n  speed  2"
        );
    }
}
