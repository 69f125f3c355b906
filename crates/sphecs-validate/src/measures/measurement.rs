//! Value of a figure and its standard error from an ensemble.
//!
//! ```text
//! value = Σ_i f_i/n,   error = s/√n,   s² = Σ_i (f_i − value)²/(n − 1)
//! ```
//!
//! The sums are over the n members of the run. A formula of figures of one ensemble is evaluated
//! member by member. A formula of several ensembles treats their errors as independent, error² =
//! Σ_k (f(…, x_k + e_k, …) − f)².

use std::collections::BTreeMap;

use sphecs_scene::expression::Constants;

/// Value of a figure.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measurement {
    /// Value, or mean over the members.
    pub value: f64,
    /// Standard error; None with one member only.
    pub error: Option<f64>,
    /// Values of the members; empty if they have none.
    pub members: Vec<f64>,
    /// Run of the members.
    pub ensemble: Option<String>,
    /// True if the value is a lower bound, as for a line that is too short.
    pub at_least: bool,
}

impl Measurement {
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

/// Returns mean and standard deviation of a sample with n − 1 in the denominator; 0 for a single
/// value.
pub fn mean_and_deviation(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (mean, (squares / (count - 1.0).max(1.0)).sqrt())
}

/// Returns the name of the standard error of a figure in formulas.
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
/// The formula has figures that were not measured.
pub fn formula(
    text: &str,
    known: &Constants,
    measurements: &BTreeMap<String, Measurement>,
) -> Result<Measurement, String> {
    let value_of = |constants: &Constants| {
        constants.number(text).map_err(|_| "has figures that were not measured".to_owned())
    };
    let value = value_of(known)?;
    let mut words: Vec<&str> = names(text).collect();
    words.sort_unstable();
    words.dedup();
    // A ratio to an error has no meaningful error.
    let is_error = |word: &&str| measurements.keys().any(|figure| error_of(figure) == **word);
    if words.iter().any(is_error) {
        return Ok(Measurement::plain(value));
    }
    let used: Vec<(&str, &Measurement)> =
        words.into_iter().filter_map(|word| Some((word, measurements.get(word)?))).collect();
    let at_least = used.iter().any(|(_, measurement)| measurement.at_least);
    let spread: Vec<(&str, &Measurement)> =
        used.into_iter().filter(|(_, measurement)| measurement.error.is_some()).collect();
    let Some(&(_, first)) = spread.first() else {
        return Ok(Measurement { at_least, ..Measurement::plain(value) });
    };
    let count = first.members.len();
    let of_one_ensemble = count > 1
        && spread.iter().all(|(_, measurement)| {
            measurement.ensemble == first.ensemble && measurement.members.len() == count
        });
    if let Some(run) = first.ensemble.as_ref().filter(|_| of_one_ensemble) {
        let member = |member: usize| {
            let mut constants = known.clone();
            spread.iter().for_each(|(name, measurement)| constants.define(name, measurement.members[member]));
            value_of(&constants)
        };
        let members = (0..count).map(member).collect::<Result<Vec<_>, _>>()?;
        return Ok(Measurement { at_least, ..Measurement::over(run, members) });
    }
    let mut squares = 0.0;
    for (name, measurement) in spread {
        let mut constants = known.clone();
        constants.define(name, measurement.value + measurement.error.unwrap_or(0.0));
        squares += (value_of(&constants)? - value).powi(2);
    }
    Ok(Measurement { value, error: Some(squares.sqrt()), at_least, ..Measurement::default() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ensemble_has_a_mean_and_a_standard_error() {
        let measurement = Measurement::over("r", vec![1.0, 2.0, 3.0, 6.0]);
        // s² = (4 + 1 + 0 + 9)/3.
        assert_eq!((measurement.value, measurement.error), (3.0, Some((14.0_f64 / 3.0).sqrt() / 2.0)));
        assert_eq!(Measurement::over("r", vec![2.0]).error, None);
    }

    fn known(measurements: &BTreeMap<String, Measurement>) -> Constants {
        let mut known = Constants::default();
        measurements.iter().for_each(|(name, measurement)| known.define(name, measurement.value));
        known
    }

    #[test]
    fn formula_of_one_ensemble_is_evaluated_member_by_member() {
        // Both figures rise together, so their difference is equal in every member.
        let measurements = BTreeMap::from([
            ("a".to_owned(), Measurement::over("r", vec![1.0, 3.0])),
            ("b".to_owned(), Measurement::over("r", vec![2.0, 4.0])),
        ]);
        let found = formula("b - a", &known(&measurements), &measurements).expect("a value");
        assert_eq!((found.value, found.error), (1.0, Some(0.0)));
    }

    #[test]
    fn errors_of_independent_runs_add_in_quadrature() {
        let with = |value, error| Measurement { error: Some(error), ..Measurement::plain(value) };
        let measurements =
            BTreeMap::from([("a".to_owned(), with(7.0, 0.3)), ("b".to_owned(), with(2.0, 0.4))]);
        let found = formula("a - b", &known(&measurements), &measurements).expect("a value");
        assert!((found.value - 5.0).abs() < 1e-12);
        assert!((found.error.expect("an error") - 0.5).abs() < 1e-12);
        let mut known = known(&measurements);
        known.define("a_error", 0.3);
        let found = formula("a/a_error", &known, &measurements).expect("a value");
        assert!((found.value - 70.0 / 3.0).abs() < 1e-12 && found.error.is_none());
        assert!(formula("a - c", &known, &measurements).is_err());
    }

    #[test]
    fn names_of_a_formula_are_found() {
        assert_eq!(names("max(a_1/2.0, b2_error)").collect::<Vec<_>>(), ["max", "a_1", "b2_error"]);
    }
}
