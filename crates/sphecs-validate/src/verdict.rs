//! Bands and verdicts: computed, never typed in.

use super::schema::BandFile;

/// How a figure stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Within the band that is aimed at.
    Goal,
    /// Within the band to be met.
    Met,
    /// Outside the band to be met, or without a value.
    Missed,
    /// Outside the band that is aimed at, where nothing has to be met.
    Short,
    /// Said without a band.
    Told,
}

impl Verdict {
    /// Returns the verdict on a value; None for one that could not be told.
    pub fn on(value: Option<f64>, must: Option<&BandFile>, goal: Option<&BandFile>) -> Self {
        let within = |band: &BandFile| value.is_some_and(|value| holds(band, value));
        match (must, goal) {
            (Some(must), _) if !within(must) => Verdict::Missed,
            (_, Some(goal)) if within(goal) => Verdict::Goal,
            (Some(_), _) => Verdict::Met,
            (None, Some(_)) => Verdict::Short,
            (None, None) if value.is_some() => Verdict::Told,
            (None, None) => Verdict::Missed,
        }
    }

    /// Returns the word of the tables.
    pub fn word(self) -> &'static str {
        match self {
            Verdict::Goal => "goal",
            Verdict::Met => "met",
            Verdict::Missed => "MISSED",
            Verdict::Short => "short of the goal",
            Verdict::Told => "",
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

/// Returns a band in signs.
pub fn signs(band: &BandFile) -> String {
    match band {
        BandFile::AtMost(most) => format!("≤ {}", number(most.value)),
        BandFile::AtLeast(least) => format!("≥ {}", number(least.value)),
        BandFile::Between(least, most) => format!("{} to {}", number(least.value), number(most.value)),
        BandFile::Near { value, by } => format!("{} ± {}", number(value.value), number(by.value)),
    }
}

/// Returns a number to four digits, as people read it.
pub fn number(value: f64) -> String {
    figures(value, 4)
}

/// Returns a number to so many digits.
pub fn figures(value: f64, digits: i32) -> String {
    let size = value.abs();
    if value == 0.0 || !value.is_finite() {
        format!("{value}")
    } else if (1e-3..1e5).contains(&size) {
        let digits = (digits - 1 - size.log10().floor() as i32).max(0) as usize;
        let text = format!("{value:.digits$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    } else {
        format!("{value:.*e}", (digits - 2).max(1) as usize)
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
        assert_eq!(Verdict::on(Some(0.6), None, Some(&goal)), Verdict::Short);
        assert_eq!(Verdict::on(Some(0.6), None, None), Verdict::Told);
        assert_eq!(Verdict::on(None, None, None), Verdict::Missed);
        let near = BandFile::Near { value: placed(2.0), by: placed(0.1) };
        assert_eq!(Verdict::on(Some(2.05), Some(&near), None), Verdict::Met);
        assert_eq!(signs(&near), "2 ± 0.1");
    }

    #[test]
    fn numbers_have_four_digits() {
        let cases = [(0.00123456, "0.001235"), (12.3456, "12.35"), (1234.0, "1234"), (98765.4, "98765")];
        for (value, text) in cases {
            assert_eq!(number(value), text);
        }
        assert_eq!((number(1.5e-7), number(0.3), number(0.0)), ("1.50e-7".into(), "0.3".into(), "0".into()));
    }
}
