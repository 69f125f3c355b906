//! Page of the manual that lists every command and option.

use std::fmt::Write;

use clap::{Arg, Command, CommandFactory};

use super::arguments::Arguments;

const HEAD: &str = "\
# Command line

<!-- Generated from the definition of the command line: change that, then run
     `UPDATE_REFERENCE=1 cargo test --lib command_line`. -->

`sphecs --help` and `sphecs COMMAND --help` print these tables. Exit codes have
[a page of their own](exit_codes.md), as have [environment variables](environment.md).
";

/// Returns the page, in Markdown.
fn page() -> String {
    let mut program = Arguments::command().disable_help_subcommand(true);
    program.build();
    let mut text = HEAD.to_owned();
    let summary = program.get_long_about().or(program.get_about()).map(ToString::to_string);
    let _infallible = write!(text, "\n{}\n\n| command | |\n|---|---|\n", summary.unwrap_or_default());
    let commands = || program.get_subcommands().filter(|command| !command.is_hide_set());
    for command in commands() {
        let name = command.get_name();
        let _infallible = writeln!(text, "| [`sphecs {name}`](#sphecs-{name}) | {} |", about(command));
    }
    notes(&mut text, &program);
    commands().for_each(|command| section(&mut text, command));
    text
}

fn about(command: &Command) -> String {
    command.get_about().map(ToString::to_string).unwrap_or_default()
}

fn section(text: &mut String, command: &Command) {
    let usage = command.clone().render_usage().to_string();
    let usage = usage.trim_start_matches("Usage:").trim();
    let _infallible =
        write!(text, "\n## sphecs {}\n\n{}.\n\n```text\n{usage}\n```\n", command.get_name(), about(command));
    let arguments: Vec<&Arg> =
        command.get_arguments().filter(|one| !one.is_hide_set() && one.get_id() != "help").collect();
    if !arguments.is_empty() {
        text.push_str("\n| argument | default | meaning |\n|---|---|---|\n");
        arguments.into_iter().for_each(|argument| row(text, argument));
    }
    notes(text, command);
}

fn row(text: &mut String, argument: &Arg) {
    let help = argument.get_help().map(ToString::to_string).unwrap_or_default();
    let (meaning, in_words) = without_default(&help);
    let values = argument.get_default_values().iter().map(|value| value.to_string_lossy().into_owned());
    let value = values.filter(|value| !value.is_empty()).map(|value| format!("`{value}`")).next();
    let takes_value = argument.get_action().takes_values();
    let default = match in_words.or_else(|| value.filter(|_| takes_value)) {
        Some(default) => default,
        None if argument.is_required_set() => "**required**".to_owned(),
        None => String::new(),
    };
    let allowed: Vec<String> = match takes_value {
        true => {
            argument.get_possible_values().iter().map(|value| format!("`{}`", value.get_name())).collect()
        }
        false => Vec::new(),
    };
    let allowed = if allowed.is_empty() { String::new() } else { format!(": {}", allowed.join(", ")) };
    let _infallible = writeln!(text, "| {} | {default} | {}{allowed} |", notation(argument), cell(&meaning));
}

/// Splits a help into its meaning and its default in words, `[default: …]`.
fn without_default(help: &str) -> (String, Option<String>) {
    let parts =
        help.split_once(" [default: ").and_then(|(before, rest)| Some((before, rest.split_once(']')?)));
    match parts {
        Some((before, (default, after))) => (format!("{before}{after}"), Some(default.to_owned())),
        None => (help.to_owned(), None),
    }
}

/// Returns an argument as it is written, such as `-o`, `--output <FILE>`.
fn notation(argument: &Arg) -> String {
    let names = argument.get_value_names().unwrap_or_default();
    let names: Vec<String> = names.iter().map(|name| format!("<{name}>")).collect();
    let value = if argument.get_action().takes_values() { names.join(" ") } else { String::new() };
    if let (Some(long), true) = (argument.get_long(), argument.is_require_equals_set()) {
        // The value may be left out.
        return format!("`--{long}[={value}]`");
    }
    match (argument.get_short(), argument.get_long()) {
        (Some(short), Some(long)) => format!("`-{short}`, `{}`", format!("--{long} {value}").trim_end()),
        (None, Some(long)) => format!("`{}`", format!("--{long} {value}").trim_end()),
        _ => format!("`{value}`"),
    }
}

/// A vertical line would end the cell of a table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

/// Adds examples and notes behind the options of a command.
fn notes(text: &mut String, command: &Command) {
    if let Some(notes) = command.get_after_help() {
        let _infallible = write!(text, "\n```text\n{}\n```\n", notes.to_string().trim());
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    #[test]
    fn the_page_of_the_command_line_is_up_to_date() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/book/src/reference/command_line.md");
        let page = super::page();
        if std::env::var_os("UPDATE_REFERENCE").is_some() {
            std::fs::write(&path, &page).expect("written");
        }
        let committed = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(
            committed == page,
            "{} is out of date: run `UPDATE_REFERENCE=1 cargo test --lib command_line`",
            path.display()
        );
    }
}
