//! Commands `completions` and `man`, from the definition of the command line.

use std::io::{self, Write};

use clap::CommandFactory;

use super::arguments::Arguments;
use super::failure::{DONE, Failure};
use super::help_arguments::{CompletionsArguments, ManArguments};
use sphecs_output::error::OutputError;
use sphecs_run::console::Console;

/// Prints the completions for a shell.
///
/// # Errors
/// None; the result is that of every command.
pub fn completions(arguments: &CompletionsArguments) -> Result<u8, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut Arguments::command(), "sphecs", &mut script);
    print(&script);
    Ok(DONE)
}

/// Prints the manual page, or writes the pages of all commands.
///
/// # Errors
/// [`Failure::Output`] if a page cannot be written.
pub fn man(arguments: &ManArguments) -> Result<u8, Failure> {
    match &arguments.dir {
        None => {
            let mut page = Vec::new();
            let rendered = clap_mangen::Man::new(Arguments::command()).render(&mut page);
            rendered.expect("a write into memory succeeds");
            print(&page);
        }
        Some(folder) => {
            let io = |cause| OutputError::Io { path: folder.clone(), doing: "write the manual pages", cause };
            std::fs::create_dir_all(folder).map_err(io)?;
            clap_mangen::generate_to(Arguments::command(), folder).map_err(io)?;
            Console::Normal.print(&format!("manual pages in {}", folder.display()));
        }
    }
    Ok(DONE)
}

/// Prints a script; a reader that is gone is not an error.
fn print(text: &[u8]) {
    let mut out = io::stdout().lock();
    let _reader_gone = out.write_all(text).and_then(|()| out.flush());
}

#[cfg(test)]
mod tests {
    use clap_complete::Shell;

    use super::*;

    #[test]
    fn every_shell_completes_the_commands() {
        for shell in [Shell::Bash, Shell::Zsh, Shell::Fish] {
            let mut script = Vec::new();
            clap_complete::generate(shell, &mut Arguments::command(), "sphecs", &mut script);
            let script = String::from_utf8(script).expect("text");
            for word in ["explain", "validate", "smoke"] {
                assert!(script.contains(word), "{shell}: no `{word}`");
            }
        }
    }

    #[test]
    fn the_manual_page_lists_the_commands() {
        let mut page = Vec::new();
        clap_mangen::Man::new(Arguments::command()).render(&mut page).expect("written");
        let page = String::from_utf8(page).expect("text");
        assert!(page.contains("explain") && page.contains("Exit codes"), "{page}");
    }
}
