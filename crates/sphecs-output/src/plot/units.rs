//! Units as people write them, from those of the files.

/// Returns `m/s` for `m s-1`, `kg/(m s)` for `kg m-1 s-1`, and nothing for `1`.
pub(super) fn written(unit: &str) -> String {
    let (mut above, mut below) = (Vec::new(), Vec::new());
    for part in unit.split_whitespace().filter(|part| *part != "1") {
        match part.split_once('-') {
            Some((name, power)) => below.push(raised(name, power)),
            None => {
                let name = part.trim_end_matches(|letter: char| letter.is_ascii_digit());
                above.push(raised(name, &part[name.len()..]));
            }
        }
    }
    match (above.join(" "), below.as_slice()) {
        (above, []) => above,
        (above, below) => {
            let above = if above.is_empty() { "1".to_owned() } else { above };
            let below = if below.len() > 1 { format!("({})", below.join(" ")) } else { below.join(" ") };
            format!("{above}/{below}")
        }
    }
}

fn raised(name: &str, power: &str) -> String {
    match power {
        "" | "1" => name.to_owned(),
        "2" => format!("{name}²"),
        "3" => format!("{name}³"),
        other => format!("{name}^{other}"),
    }
}

#[cfg(test)]
mod tests {
    use super::written;

    #[test]
    fn units_are_fractions() {
        for (unit, expected) in [
            ("m s-1", "m/s"),
            ("kg m-1 s-1", "kg/(m s)"),
            ("kg m-3", "kg/m³"),
            ("s-1", "1/s"),
            ("J m-1", "J/m"),
            ("N m", "N m"),
            ("m2", "m²"),
            ("1", ""),
        ] {
            assert_eq!(written(unit), expected);
        }
    }
}
