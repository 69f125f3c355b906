//! Distance of two flows, each given by the members of an ensemble.
//!
//! ```text
//! d = ‖ā − b̄‖,   error of d = ‖√(s_a²/n_a + s_b²/n_b)‖,   within one flow: ‖√2 s_a‖
//! ```
//!
//! ā and s_a are mean and standard deviation over the n_a members at each point of the probes.
//! Flows whose distance is not well above its error are statistically indistinguishable: for two
//! ensembles of one flow the root mean square of d equals its error. The distance of two members of
//! one flow, in that norm, is the sensitivity of the flow to a tiny disturbance.

use super::measurement::{Measurement, mean_and_deviation};
use super::profile::{norm, profiles};
use super::{RunResults, fields};
use crate::schema::{FieldFile, NormFile, WhenFile};

/// Quantity that is compared.
#[derive(Clone, Copy, Debug)]
pub struct Comparison<'a> {
    /// Probes.
    pub probe: &'a str,
    /// Field.
    pub field: &'a FieldFile,
    /// Time or interval.
    pub when: &'a WhenFile,
    /// Norm over the points.
    pub norm: NormFile,
}

/// Mean and deviation at a point.
type Point = (f64, f64);

impl Comparison<'_> {
    /// Returns mean and deviation over the members at all points and times.
    fn points(&self, members: &[RunResults]) -> Result<Vec<Point>, String> {
        let values = |member: &RunResults| {
            let probe = fields::probe(&member.probes, self.probe)?;
            let found = profiles(&probe, self.field, self.when)?;
            Ok(found.into_iter().flat_map(|profile| profile.values).collect::<Vec<f64>>())
        };
        let values = members.iter().map(values).collect::<Result<Vec<_>, String>>()?;
        let count = values.first().map_or(0, Vec::len);
        if values.iter().any(|values| values.len() != count) {
            return Err(format!("probe `{}` has other points or times in a member", self.probe));
        }
        let of_point = |at: usize| {
            let members: Vec<f64> = values.iter().map(|values| values[at]).collect();
            mean_and_deviation(&members)
        };
        Ok((0..count).map(of_point).collect())
    }

    /// Returns the distance of two flows, with its error if both have several members.
    ///
    /// # Errors
    /// Results are missing, or the probes have other points.
    pub fn between(&self, one: &[RunResults], other: &[RunResults]) -> Result<Measurement, String> {
        let (a, b) = (self.points(one)?, self.points(other)?);
        if a.len() != b.len() {
            return Err(format!("probe `{}` has other points or times in the other run", self.probe));
        }
        let pairs = || a.iter().zip(&b);
        let distances: Vec<f64> = pairs().map(|(a, b)| a.0 - b.0).collect();
        let (n_a, n_b) = (one.len() as f64, other.len() as f64);
        let errors =
            || pairs().map(|(a, b)| (a.1 * a.1 / n_a + b.1 * b.1 / n_b).sqrt()).collect::<Vec<f64>>();
        let error = (one.len() > 1 && other.len() > 1).then(|| norm(&errors(), self.norm));
        Ok(Measurement { error, ..Measurement::plain(norm(&distances, self.norm)) })
    }

    /// Returns the root mean square of the distances of two members of one flow over all pairs.
    ///
    /// # Errors
    /// Results are missing, or there is one member only.
    pub fn within(&self, members: &[RunResults]) -> Result<Measurement, String> {
        if members.len() < 2 {
            return Err("the run has one member only".to_owned());
        }
        let distances: Vec<f64> =
            self.points(members)?.iter().map(|point| std::f64::consts::SQRT_2 * point.1).collect();
        Ok(Measurement::plain(norm(&distances, self.norm)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sphecs_output::probes::history::ProbeHistory;
    use sphecs_scene::notation::tree::Span;
    use sphecs_scene::notation::typed::Spanned;

    /// Returns a run with u at two points at 0 s.
    fn run(u: [f64; 2]) -> RunResults {
        let probe = ProbeHistory {
            name: "line".to_owned(),
            places: vec![[0.0; 3], [1.0, 0.0, 0.0]],
            times: vec![0.0],
            columns: vec![("u", u.to_vec())],
        };
        RunResults { probes: vec![probe], ..RunResults::default() }
    }

    fn comparison(when: &WhenFile) -> Comparison<'_> {
        Comparison { probe: "line", field: &FieldFile::U, when, norm: NormFile::RootMeanSquare }
    }

    fn start() -> WhenFile {
        WhenFile::At(Spanned { value: 0.0, span: Span::PLACEHOLDER, head: Span::PLACEHOLDER })
    }

    #[test]
    fn distance_of_means_has_the_errors_of_both() {
        let when = start();
        let one = [run([1.0, 3.0]), run([3.0, 3.0])];
        let other = [run([0.0, 0.0]), run([0.0, 0.0])];
        let found = comparison(&when).between(&one, &other).expect("a distance");
        assert!((found.value - (13.0_f64 / 2.0).sqrt()).abs() < 1e-12);
        // s² = 2 at the first point for two members, 0 at the second.
        assert!((found.error.expect("an error") - 0.5_f64.sqrt()).abs() < 1e-12);
        assert_eq!(comparison(&when).between(&one[..1], &other).expect("a distance").error, None);
    }

    #[test]
    fn distance_of_two_members_is_their_norm() {
        let when = start();
        let found = comparison(&when).within(&[run([1.0, 0.0]), run([1.0, 4.0])]).expect("a distance");
        assert!((found.value - 8.0_f64.sqrt()).abs() < 1e-12, "{found:?}");
        assert!(comparison(&when).within(&[run([1.0, 0.0])]).is_err());
    }

    #[test]
    fn distance_of_ensembles_of_one_flow_equals_its_error() {
        // 200 pairs of ensembles of four uniformly distributed values.
        let mut state = 7_u64;
        let mut number = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let when = start();
        let (mut squares, mut errors) = (0.0, 0.0);
        for _ in 0..200 {
            let mut ensemble = || [0; 4].map(|_| run([number(), number()]));
            let (one, other) = (ensemble(), ensemble());
            let found = comparison(&when).between(&one, &other).expect("a distance");
            squares += found.value.powi(2);
            errors += found.error.expect("an error").powi(2);
        }
        // 400 squares with a relative deviation of 1 each: 7 %.
        assert!((squares / errors - 1.0).abs() < 0.2, "{}", squares / errors);
    }
}
