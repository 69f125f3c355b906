//! Numbers as people read them.

/// A duration as people say it: `42 s`, `3 min 20 s`, `5 h 04 min`.
pub fn duration(seconds: f64) -> String {
    if seconds < 9.95 {
        return format!("{seconds:.1} s");
    }
    let seconds = seconds.round() as u64;
    match seconds {
        0..60 => format!("{seconds} s"),
        60..3600 => format!("{} min {:02} s", seconds / 60, seconds % 60),
        _ => format!("{} h {:02} min", seconds / 3600, seconds % 3600 / 60),
    }
}

/// A count with thin groups of three, `1 234 567`, as ISO 80000 writes numbers.
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

/// A figure with four digits: plain between a thousandth and a hundred thousand, else with an exponent.
pub fn figure(value: f64) -> String {
    let size = value.abs();
    if value.is_infinite() {
        return if value > 0.0 { "∞" } else { "−∞" }.to_owned();
    }
    if value == 0.0 || value.is_nan() {
        return format!("{value}");
    }
    if !(1e-3..1e5).contains(&size) {
        return tidy(&format!("{value:.3e}"));
    }
    let decimals = (3 - size.log10().floor() as i32).max(0) as usize;
    tidy(&format!("{value:.decimals$}"))
}

/// Without zeros that say nothing: `0.3000` is `0.3`, `4.000e-7` is `4e-7`.
fn tidy(text: &str) -> String {
    let (digits, exponent) = text.split_at(text.find('e').unwrap_or(text.len()));
    let digits =
        if digits.contains('.') { digits.trim_end_matches('0').trim_end_matches('.') } else { digits };
    format!("{digits}{exponent}")
}

/// Two columns: names to the left, values behind them, one pair a line.
pub fn columns(rows: &[(&str, String)]) -> String {
    let width = rows.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
    rows.iter().map(|(name, value)| format!("  {name:<width$}  {value}")).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_and_counts_read_well() {
        for (seconds, text) in
            [(0.04, "0.0 s"), (9.96, "10 s"), (59.4, "59 s"), (200.0, "3 min 20 s"), (18_240.0, "5 h 04 min")]
        {
            assert_eq!(duration(seconds), text);
        }
        for (count, text) in [(0, "0"), (999, "999"), (1000, "1 000"), (1_234_567, "1 234 567")] {
            assert_eq!(grouped(count), text);
        }
    }

    #[test]
    fn figures_have_four_digits_and_no_idle_zeros() {
        let cases = [
            (0.0, "0"),
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
            assert_eq!(figure(value), text);
        }
    }

    #[test]
    fn columns_are_aligned() {
        assert_eq!(columns(&[("a", "1".to_owned()), ("speed", "2".to_owned())]), "  a      1\n  speed  2");
    }
}
