//! Names of openings, wall parts, bodies and probes in the results.
//!
//! NetCDF names and file names bear neither every character nor any length. A name is written
//! with ASCII letters, digits and `_` only, and the scene is checked for two that would become one.

/// Most characters of a name, so that with `outlet_mass_flow_` in front it is shorter than the 256
/// of a NetCDF name.
pub const MOST_CHARACTERS: usize = 100;

/// Returns a name as the results have it: every character that is no ASCII letter or digit becomes
/// `_`, and a name that does not begin with a letter gets `at_` in front.
pub fn result_name(name: &str) -> String {
    let plain: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    match plain.starts_with(|c: char| c.is_ascii_alphabetic()) {
        true => plain,
        false => format!("at_{plain}"),
    }
}

/// Returns true if two names are one in the results, on file systems that ignore case too.
pub fn collide(one: &str, other: &str) -> bool {
    result_name(one).eq_ignore_ascii_case(&result_name(other))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_keep_letters_and_digits() {
        assert_eq!(
            ["inlet", "left side", "Öffnung", "2", "../x"].map(result_name),
            ["inlet", "left_side", "at__ffnung", "at_2", "at____x"]
        );
        assert!(collide("Gap", "gap") && collide("left side", "left-side") && !collide("a", "b"));
    }
}
