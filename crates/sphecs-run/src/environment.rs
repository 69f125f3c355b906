//! Environment variables that change a run, which libraries ignore if they are misspelt.

use sphecs_core::math::lanes::InstructionSet;
use sphecs_output::error::OutputError;

/// Checks the values of `SPHECS_LANES` and `RAYON_NUM_THREADS`.
///
/// # Errors
/// [`OutputError::Request`] with the variable, its value and the values allowed.
pub fn check() -> Result<(), OutputError> {
    let value = |name| std::env::var_os(name).unwrap_or_default().to_string_lossy().into_owned();
    let refused = |name: &str, what: String| {
        OutputError::Request(format!("environment variable `{name}`: {what}; or unset it"))
    };
    let (lanes, threads) = ("SPHECS_LANES", "RAYON_NUM_THREADS");
    InstructionSet::named(&value(lanes)).map_err(|what| refused(lanes, what))?;
    let number = value(threads);
    if !number.is_empty() && number.parse::<usize>().is_err() {
        return Err(refused(threads, format!("is `{number}`, must be a whole number")));
    }
    Ok(())
}
