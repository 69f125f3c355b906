//! Command `new`: a commented scene to begin with.

use std::fs::OpenOptions;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use clap::ValueEnum;

use super::failure::{DONE, Failure};
use super::help_arguments::{NewArguments, Template};
use sphecs_output::error::OutputError;
use sphecs_run::console::Console;

/// Writes a scene, and prints what to do with it.
///
/// # Errors
/// [`Failure::Output`] if the file exists or cannot be written.
pub fn new(arguments: &NewArguments) -> Result<u8, Failure> {
    let path = path_of(&arguments.name)?;
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let io = |doing, cause| OutputError::Io { path: path.clone(), doing, cause };
    let mut file = match OpenOptions::new().write(true).create_new(true).open(&path) {
        Ok(file) => file,
        Err(cause) if cause.kind() == ErrorKind::AlreadyExists => {
            let refused = "exists already and is never replaced: give another name";
            return Err(OutputError::Request(format!("`{}`: {refused}", path.display())).into());
        }
        Err(cause) => return Err(io("create the file", cause).into()),
    };
    if let Err(cause) = file.write_all(arguments.template.named(&name).as_bytes()) {
        // Half a scene would be refused as faulty later, and its name as taken.
        let _not_removed = std::fs::remove_file(&path);
        return Err(io("write", cause).into());
    }
    Console::Normal.print(&format!("{path}, run it by: sphecs run {path}", path = path.display()));
    Ok(DONE)
}

/// Returns the file of a name, which may have a folder and the ending `.ron`.
fn path_of(name: &Path) -> Result<PathBuf, OutputError> {
    let Some(file) = name.file_name().filter(|file| !file.to_string_lossy().starts_with('.')) else {
        let must = "must be the name of a file, as `my_channel`";
        return Err(OutputError::Request(format!("`{}`: {must}", name.display())));
    };
    let mut file = file.to_owned();
    if Path::new(&file).extension().is_none_or(|ending| ending != "ron") {
        file.push(".ron");
    }
    Ok(name.with_file_name(file))
}

impl Template {
    /// Returns the scene as it is shipped.
    pub fn text(self) -> &'static str {
        match self {
            Template::Channel => include_str!("../../assets/templates/channel.ron"),
            Template::Pipe => include_str!("../../assets/templates/pipe.ron"),
            Template::Bend => include_str!("../../assets/templates/bend.ron"),
            Template::Cylinder => include_str!("../../assets/templates/cylinder.ron"),
            Template::Cavity => include_str!("../../assets/templates/cavity.ron"),
        }
    }

    /// Returns the scene with the commands of its head for a file of another name.
    fn named(self, name: &str) -> String {
        let own = self.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default();
        let is_command = |line: &&str| line.starts_with("//     sphecs ");
        let commands = |line: &str| {
            let files = [
                (format!("{own}.ron"), format!("{name}.ron")),
                (format!("{own}.png"), format!("{name}.png")),
            ];
            let line = line.replace(&format!("runs/{own}"), &format!("runs/{name}"));
            files.iter().fold(line, |line, (from, to)| line.replace(from, to))
        };
        let lines =
            self.text().lines().map(|line| if is_command(&line) { commands(line) } else { line.to_owned() });
        lines.map(|line| line + "\n").collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_to_files_of_scenes() {
        let path = |name: &str| path_of(Path::new(name)).expect(name);
        assert_eq!(path("flow"), Path::new("flow.ron"));
        assert_eq!(path("flows/flow.ron"), Path::new("flows/flow.ron"));
        assert_eq!(path("flow.v2"), Path::new("flow.v2.ron"));
        for name in ["", "..", "/", ".ron"] {
            assert!(path_of(Path::new(name)).is_err(), "`{name}` was accepted");
        }
    }

    #[test]
    fn commands_of_the_head_have_the_new_name() {
        for template in Template::value_variants() {
            let text = template.named("my_flow");
            assert!(text.contains("//     sphecs run my_flow.ron\n"), "{text}");
            assert!(text.contains("runs/my_flow --field"), "{text}");
            assert_eq!(text.lines().count(), template.text().lines().count());
        }
    }
}
