//! Bands of figures and the verdicts that follow from them.

use super::schema::BandFile;
use sphecs_core::format::significant;

/// Verdict on a figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Within the goal.
    Goal,
    /// Within the required band.
    Met,
    /// Outside the required band, or without a value.
    Missed,
    /// Outside the goal, without a required band.
    BelowGoal,
    /// Without a band.
    Informational,
}

impl Verdict {
    /// Returns the verdict on a value, None for a figure that could not be measured.
    pub fn on(value: Option<f64>, must: Option<&BandFile>, goal: Option<&BandFile>) -> Self {
        let within = |band: &BandFile| value.is_some_and(|value| holds(band, value));
        match (must, goal) {
            (Some(must), _) if !within(must) => Verdict::Missed,
            (_, Some(goal)) if within(goal) => Verdict::Goal,
            (Some(_), _) => Verdict::Met,
            (None, Some(_)) => Verdict::BelowGoal,
            (None, None) if value.is_some() => Verdict::Informational,
            (None, None) => Verdict::Missed,
        }
    }

    /// Returns the word in tables.
    pub fn word(self) -> &'static str {
        match self {
            Verdict::Goal => "goal",
            Verdict::Met => "met",
            Verdict::Missed => "MISSED",
            Verdict::BelowGoal => "below the goal",
            Verdict::Informational => "",
        }
    }
}

fn holds(band: &BandFile, value: f64) -> bool {
    match band {
        BandFile::AtMost(most) => value <= most.value,
        BandFile::AtLeast(least) => value >= least.value,
        BandFile::Between(least, most) => (least.value..=most.value).contains(&value),
        BandFile::Near { value: centre, by } => (value - centre.value).abs() <= by.value,
    }
}

/// Returns a band as text, as in `2 ± 0.1`.
pub fn band_text(band: &BandFile) -> String {
    match band {
        BandFile::AtMost(most) => format!("≤ {}", significant(most.value)),
        BandFile::AtLeast(least) => format!("≥ {}", significant(least.value)),
        BandFile::Between(least, most) => {
            format!("{} to {}", significant(least.value), significant(most.value))
        }
        BandFile::Near { value, by } => format!("{} ± {}", significant(value.value), significant(by.value)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sphecs_scene::notation::tree::Span;
    use sphecs_scene::notation::typed::Spanned;

    fn placed(value: f64) -> Spanned<f64> {
        Spanned { value, span: Span::PLACEHOLDER, head: Span::PLACEHOLDER }
    }

    #[test]
    fn verdicts_follow_from_bands() {
        let must = BandFile::AtMost(placed(0.5));
        let goal = BandFile::Between(placed(-0.1), placed(0.1));
        let on = |value| Verdict::on(value, Some(&must), Some(&goal));
        assert_eq!(on(Some(0.05)), Verdict::Goal);
        assert_eq!(on(Some(-0.4)), Verdict::Met);
        assert_eq!(on(Some(0.6)), Verdict::Missed);
        assert_eq!(on(Some(f64::NAN)), Verdict::Missed);
        assert_eq!(on(None), Verdict::Missed);
        assert_eq!(Verdict::on(Some(0.6), None, Some(&goal)), Verdict::BelowGoal);
        assert_eq!(Verdict::on(Some(0.6), None, None), Verdict::Informational);
        assert_eq!(Verdict::on(None, None, None), Verdict::Missed);
        let near = BandFile::Near { value: placed(2.0), by: placed(0.1) };
        assert_eq!(Verdict::on(Some(2.05), Some(&near), None), Verdict::Met);
        assert_eq!(band_text(&near), "2 ± 0.1");
    }
}
