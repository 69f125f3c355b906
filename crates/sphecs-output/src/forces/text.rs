//! Lines of text on the force coefficients of a body, at the end of a run and in `sphecs info`.

use super::means::Means;
use sphecs_core::format::{significant, with_digits};

/// Returns mean and amplitude of the coefficients with the Strouhal number, the scatter of the raw
/// series, and a remark on the Strouhal number if there is one.
pub fn lines(means: &Means) -> Vec<String> {
    let Some((from, to)) = means.covered() else {
        return vec!["no coefficients: the run has not reached the interval of the mean".to_owned()];
    };
    let get = |name: &str| significant(means.get(name));
    let (drag, lift) = (get("c_d_mean"), get("c_l_mean"));
    let interval = format!("from {} to {} s", significant(from), significant(to));
    let first = match means.line() {
        Some(line) => format!(
            "c_d = {drag} ± {}, c_l = {lift} ± {}, St = {} ({} 1/s), {} periods {interval}",
            get("c_d_fitted_amplitude"),
            get("c_l_fitted_amplitude"),
            get("strouhal"),
            significant(line.frequency),
            with_digits(line.periods, 2),
        ),
        None => format!("c_d = {drag}, c_l = {lift} {interval}"),
    };
    let raw = format!(
        "with sound and noise: c_d ± {}, rms {}; c_l ± {}, rms {}",
        get("c_d_amplitude"),
        get("c_d_rms"),
        get("c_l_amplitude"),
        get("c_l_rms")
    );
    [first, raw, means.remark()].into_iter().filter(|line| !line.is_empty()).collect()
}
