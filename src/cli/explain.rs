//! Commands `explain` and `schema`: the reference of the scene file.

use super::failure::{DONE, Failure};
use super::help_arguments::ExplainArguments;
use sphecs_run::console::Console;
use sphecs_scene::manual::{Manual, json_schema};

/// Prints meaning, type, unit, default, choices and an example of a path.
///
/// # Errors
/// [`Failure::Path`] with the nearest name.
pub fn explain(arguments: &ExplainArguments) -> Result<u8, Failure> {
    let text = Manual::read().explain(&arguments.path)?;
    Console::Normal.print(text.trim_end());
    Ok(DONE)
}

/// Prints the JSON Schema of the scene file.
///
/// # Errors
/// None; the result is that of every command.
pub fn schema() -> Result<u8, Failure> {
    // The alternate form of a JSON value is indented.
    Console::Normal.print(&format!("{:#}", json_schema()));
    Ok(DONE)
}
