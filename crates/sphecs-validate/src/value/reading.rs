//! The value of a figure, and what an ensemble knows of its error.
//!
//! ```text
//! value = Σ_i f_i/n,   error = s/√n,   s² = Σ_i (f_i − value)²/(n − 1)
//! ```
//!
//! over the n members of the run. A formula of figures of one ensemble is evaluated member by member; one of several
//! takes their errors as independent, error² = Σ_k (f(…, x_k + e_k, …) − f)².

use std::collections::BTreeMap;

use sphecs_scene::expression::Constants;

/// What a figure came to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reading {
    /// The value, or the mean over the members.
    pub value: f64,
    /// Standard error of it; None where there is but one member.
    pub error: Option<f64>,
    /// Values of the members; empty where they have none of their own.
    pub members: Vec<f64>,
    /// The run whose members they are.
    pub ensemble: Option<String>,
    /// True if the true value may be larger: a line that was too short.
    pub at_least: bool,
}

impl Reading {
    /// Returns a value without error.
    pub fn plain(value: f64) -> Self {
        Self { value, ..Self::default() }
    }

    /// Returns the mean over the members of a run.
    pub fn over(run: &str, members: Vec<f64>) -> Self {
        let (value, deviation) = mean_and_deviation(&members);
        let count = members.len() as f64;
        Self {
            value,
            error: (members.len() > 1).then(|| deviation / count.sqrt()),
            ensemble: Some(run.to_owned()),
            members,
            at_least: false,
        }
    }
}

/// Mean, and standard deviation of a sample with n − 1 in the denominator: 0 of a single value.
pub fn mean_and_deviation(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (mean, (squares / (count - 1.0).max(1.0)).sqrt())
}

/// Returns the name under which a formula knows the standard error of a figure.
pub fn error_of(figure: &str) -> String {
    format!("{figure}_error")
}

/// Returns the names in a formula.
pub fn names(formula: &str) -> impl Iterator<Item = &str> {
    formula
        .split(|c: char| !c.is_ascii_alphanumeric() && c != '_')
        .filter(|word| word.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_'))
}

/// Returns the value of a formula of figures; `known` has their values.
///
/// # Errors
/// That it speaks of figures that were not measured.
pub fn formula(
    text: &str,
    known: &Constants,
    readings: &BTreeMap<String, Reading>,
) -> Result<Reading, String> {
    let value_of = |constants: &Constants| {
        constants.number(text).map_err(|_| "of figures that were not measured".to_owned())
    };
    let value = value_of(known)?;
    let mut words: Vec<&str> = names(text).collect();
    words.sort_unstable();
    words.dedup();
    // What is put in relation to an error has none worth telling.
    let is_error = |word: &&str| readings.keys().any(|figure| error_of(figure) == **word);
    if words.iter().any(is_error) {
        return Ok(Reading::plain(value));
    }
    let used: Vec<(&str, &Reading)> =
        words.into_iter().filter_map(|word| Some((word, readings.get(word)?))).collect();
    let at_least = used.iter().any(|(_, reading)| reading.at_least);
    let spread: Vec<(&str, &Reading)> =
        used.into_iter().filter(|(_, reading)| reading.error.is_some()).collect();
    let Some(&(_, first)) = spread.first() else {
        return Ok(Reading { at_least, ..Reading::plain(value) });
    };
    let count = first.members.len();
    let of_one_ensemble = count > 1
        && spread
            .iter()
            .all(|(_, reading)| reading.ensemble == first.ensemble && reading.members.len() == count);
    if let Some(run) = first.ensemble.as_ref().filter(|_| of_one_ensemble) {
        let member = |member: usize| {
            let mut constants = known.clone();
            spread.iter().for_each(|(name, reading)| constants.define(name, reading.members[member]));
            value_of(&constants)
        };
        let members = (0..count).map(member).collect::<Result<Vec<_>, _>>()?;
        return Ok(Reading { at_least, ..Reading::over(run, members) });
    }
    let mut squares = 0.0;
    for (name, reading) in spread {
        let mut constants = known.clone();
        constants.define(name, reading.value + reading.error.unwrap_or(0.0));
        squares += (value_of(&constants)? - value).powi(2);
    }
    Ok(Reading { value, error: Some(squares.sqrt()), at_least, ..Reading::default() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_ensemble_has_a_mean_and_its_error() {
        let reading = Reading::over("r", vec![1.0, 2.0, 3.0, 6.0]);
        // s² = (4 + 1 + 0 + 9)/3.
        assert_eq!((reading.value, reading.error), (3.0, Some((14.0_f64 / 3.0).sqrt() / 2.0)));
        assert_eq!(Reading::over("r", vec![2.0]).error, None);
    }

    fn known(readings: &BTreeMap<String, Reading>) -> Constants {
        let mut known = Constants::default();
        readings.iter().for_each(|(name, reading)| known.define(name, reading.value));
        known
    }

    #[test]
    fn a_formula_of_one_ensemble_goes_member_by_member() {
        // They rise together: their difference is the same in every member.
        let readings = BTreeMap::from([
            ("a".to_owned(), Reading::over("r", vec![1.0, 3.0])),
            ("b".to_owned(), Reading::over("r", vec![2.0, 4.0])),
        ]);
        let found = formula("b - a", &known(&readings), &readings).expect("a value");
        assert_eq!((found.value, found.error), (1.0, Some(0.0)));
    }

    #[test]
    fn errors_of_different_runs_add_as_squares() {
        let with = |value, error| Reading { error: Some(error), ..Reading::plain(value) };
        let readings = BTreeMap::from([("a".to_owned(), with(7.0, 0.3)), ("b".to_owned(), with(2.0, 0.4))]);
        let found = formula("a - b", &known(&readings), &readings).expect("a value");
        assert!((found.value - 5.0).abs() < 1e-12);
        assert!((found.error.expect("an error") - 0.5).abs() < 1e-12);
        let mut known = known(&readings);
        known.define("a_error", 0.3);
        let found = formula("a/a_error", &known, &readings).expect("a value");
        assert!((found.value - 70.0 / 3.0).abs() < 1e-12 && found.error.is_none());
        assert!(formula("a - c", &known, &readings).is_err());
    }

    #[test]
    fn names_of_a_formula_are_its_words() {
        assert_eq!(names("max(a_1/2.0, b2_error)").collect::<Vec<_>>(), ["max", "a_1", "b2_error"]);
    }
}
