//! Commands and their arguments.

use std::ffi::{OsStr, OsString};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use clap::{Args, CommandFactory, Parser, Subcommand};

use super::check_arguments::{BenchArguments, ValidateArguments};
use super::export_arguments::ExportArguments;
use super::help_arguments::{CompletionsArguments, ExplainArguments, ManArguments, NewArguments};
use super::picture_arguments::{PlotArguments, RenderArguments};
use super::run_arguments::{ResumeArguments, RunArguments};
use super::sweep::SweepArguments;
use super::values::{assignment, picture_file, positive, slice};
use super::watch::WatchArguments;
use sphecs_output::picture::Slice;

/// Command line.
#[derive(Debug, Parser)]
#[command(
    name = "sphecs",
    version,
    about = "Smoothed particle hydrodynamics with open boundaries",
    long_about = "Smoothed particle hydrodynamics with open boundaries.\n\n\
        `sphecs SCENE` is short for `sphecs run SCENE` and takes its options (`sphecs run --help`).",
    after_help = "Examples:\n  \
        sphecs scenes/quickstart.ron\n  \
        sphecs new channel my_channel\n  \
        sphecs explain outlets.condition\n  \
        sphecs check scenes/constricted_r2.ron\n  \
        sphecs scenes/constricted_r2.ron --set fluid.sound_speed=1.0 --until 2 --out runs/slow_sound\n  \
        sphecs resume runs/quickstart\n  \
        sphecs render runs/quickstart --field vorticity -o vorticity.png\n  \
        sphecs plot runs/quickstart monitor.kinetic_energy -o energy.svg\n\n\
        Exit codes: 0 done, 1 a required band was missed or a strict check has notes, 2 bad input, 3 the flow diverged, 4 input or output failed, \
        75 wall-time limit reached, 129 terminal closed, 130 interrupted, 143 terminated, 152 processor time used up",
    subcommand_required = true,
    arg_required_else_help = true
)]
pub struct Arguments {
    /// Command.
    #[command(subcommand)]
    pub command: Command,
}

impl Arguments {
    /// Parses a command line, in which a scene without a command is run: `sphecs flow.ron` is
    /// `sphecs run flow.ron`.
    ///
    /// # Errors
    /// The error of clap, which also stands for requests of help and version.
    pub fn read(words: impl IntoIterator<Item = OsString>) -> Result<Self, clap::Error> {
        let mut words: Vec<OsString> = words.into_iter().collect();
        if words.get(1).is_some_and(|word| is_run_without_command(word)) {
            words.insert(1, "run".into());
        }
        Self::try_parse_from(words)
    }
}

/// Returns true if the first word is the scene or an option of a run.
///
/// Other words are left to clap, which suggests similar commands.
fn is_run_without_command(word: &OsStr) -> bool {
    let text = word.to_string_lossy();
    match text.strip_prefix('-') {
        Some(_) => !matches!(text.as_ref(), "-h" | "--help" | "-V" | "--version"),
        None if text.contains(['.', '/', '\\']) => true,
        // A folder here may be called as a command.
        None => Path::new(word).exists() && !is_command(&text),
    }
}

fn is_command(word: &str) -> bool {
    word == "help" || Arguments::command().find_subcommand(word).is_some()
}

/// Commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run a scene to its end
    Run(RunArguments),
    /// Resume a run that was stopped or killed, with bitwise identical results
    Resume(ResumeArguments),
    /// Run a scene for each combination of values, several runs at once
    Sweep(SweepArguments),
    /// Show the progress of a run in the terminal, or on a page
    Watch(WatchArguments),
    /// Check a scene before its run: resolution, speeds, time scales, run time, memory and disk
    Check(CheckArguments),
    /// Draw a field of a run: pictures, time means and movies
    Render(RenderArguments),
    /// Plot what runs measured, over time or along lines
    Plot(PlotArguments),
    /// Describe a run folder
    Info(InfoArguments),
    /// Write the frames of a run in the format of another program
    Export(ExportArguments),
    /// Pack the journal of a run that was killed into `particles.nc`
    Pack(PackArguments),
    /// Measure how fast the engine is on this machine
    Bench(BenchArguments),
    /// Run validation cases and compare them with their references
    Validate(ValidateArguments),
    /// Write a commented scene to begin with
    New(NewArguments),
    /// Explain a field or a choice of the scene file
    Explain(ExplainArguments),
    /// Print the JSON Schema of the scene file, for editors
    #[command(after_help = "Example:\n  sphecs schema > scene.schema.json\n\n\
        Editors complete and check the JSON or YAML twin of a scene by it. Units and defaults are in `x-unit` and `x-default`.")]
    Schema,
    /// Print the completions of the command line for a shell
    Completions(CompletionsArguments),
    /// Print the manual page, or write the pages of all commands
    Man(ManArguments),
}

/// Scene and changes to it.
#[derive(Args, Debug)]
pub struct SceneArguments {
    /// Scene file, RON
    #[arg(value_name = "SCENE")]
    pub scene: PathBuf,
    /// Change a value of the scene, as `fluid.sound_speed=1.0` or `outlets.0.depth=0.01`;
    /// repeatable
    #[arg(long = "set", value_name = "PATH=VALUE", value_parser = assignment)]
    pub sets: Vec<(String, String)>,
    /// Run at the scene's coarse smoke spacing, for a quick look; `--set spacing=…` has precedence
    #[arg(long)]
    pub smoke: bool,
}

/// `sphecs check`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    sphecs check scenes/constricted_r2.ron --set spacing=1.9e-3\n  \
    sphecs check scenes/quickstart.ron --picture quickstart.png --strict\n\n\
    Time and memory are measured by the first steps of the flow, which take about a second; nothing but the picture is written.")]
pub struct CheckArguments {
    #[command(flatten)]
    #[expect(
        missing_docs,
        reason = "a doc comment on a flattened group would become the help of the command"
    )]
    pub input: SceneArguments,
    /// Draw walls, zones, openings and probes with their names into this PNG file
    #[arg(long, value_name = "FILE", value_parser = picture_file())]
    pub picture: Option<PathBuf>,
    /// Plane of the picture of a 3D scene, as `z` or `y=0.01` (m) [default: z in the middle]
    #[arg(long, value_name = "AXIS[=AT]", value_parser = slice, requires = "picture")]
    pub slice: Option<Slice>,
    /// Exit with code 1 if there are notes
    #[arg(long)]
    pub strict: bool,
    /// End of the run, s [default: end of the scene]
    #[arg(long, value_name = "T", value_parser = positive, allow_negative_numbers = true)]
    pub until: Option<f64>,
    /// Number of threads of the timed steps [default: all cores]
    #[arg(long, value_name = "N")]
    pub threads: Option<NonZeroUsize>,
    /// Leave out the timed steps
    #[arg(long)]
    pub no_timing: bool,
    /// Report the shares of that many ranks in the particles, and the speed-up that they allow
    #[arg(long, value_name = "N", default_value = "1")]
    pub ranks: NonZeroUsize,
}

/// `sphecs info`.
#[derive(Args, Debug)]
pub struct InfoArguments {
    /// Run folder
    #[arg(value_name = "RUN")]
    pub run: PathBuf,
}

/// `sphecs pack`.
#[derive(Args, Debug)]
pub struct PackArguments {
    /// Run folder
    #[arg(value_name = "RUN")]
    pub run: PathBuf,
}

#[cfg(test)]
mod tests {
    use std::num::NonZeroUsize;

    use super::*;

    fn parse(line: &str) -> Result<Command, clap::Error> {
        Arguments::read(line.split(' ').map(OsString::from)).map(|arguments| arguments.command)
    }

    fn refused(line: &str, word: &str) {
        let message = parse(line).expect_err(line).to_string();
        assert!(message.contains(word), "`{line}` gave:\n{message}");
    }

    #[test]
    fn definition_is_consistent() {
        Arguments::command().debug_assert();
    }

    #[test]
    fn scene_without_command_is_run() {
        for line in [
            "sphecs flow.ron --set fluid.sound_speed=1.0 --set title=\"a=b\" --threads 2 -v",
            "sphecs --threads 2 -v --set fluid.sound_speed=1.0 --set title=\"a=b\" flow.ron",
            "sphecs run flow.ron --set fluid.sound_speed=1.0 --set title=\"a=b\" --threads 2 -v",
        ] {
            let Command::Run(run) = parse(line).expect(line) else {
                panic!("`{line}` is not a run");
            };
            assert_eq!(run.input.scene, PathBuf::from("flow.ron"));
            let expected = [("fluid.sound_speed", "1.0"), ("title", "\"a=b\"")];
            assert!(run.input.sets.iter().map(|(path, value)| (path.as_str(), value.as_str())).eq(expected));
            assert_eq!(run.limits.threads.map(NonZeroUsize::get), Some(2));
            assert!(
                run.verbosity.verbose && !run.verbosity.quiet && !run.force && run.limits.steps.is_none()
            );
        }
    }

    #[test]
    fn bench_takes_cases_and_numbers_of_threads() {
        let Command::Bench(bench) =
            parse("sphecs bench --case 2d-f32 --case channel --threads 1,4").expect("a bench")
        else {
            panic!("not a bench");
        };
        assert_eq!(bench.cases.iter().map(|case| case.name()).collect::<Vec<_>>(), ["2d-f32", "channel"]);
        assert_eq!(bench.threads.iter().map(|threads| threads.get()).collect::<Vec<_>>(), [1, 4]);
        assert!(!bench.large);
        let Command::Bench(bench) = parse("sphecs bench --large").expect("a bench") else {
            panic!("not a bench");
        };
        assert!(bench.large && bench.cases.is_empty() && bench.threads.is_empty());
    }

    #[test]
    fn invalid_arguments_are_refused_with_the_valid_ones() {
        refused("sphecs", "Usage");
        refused("sphecs chekc flow.ron", "check");
        refused("sphecs --threads 2", "SCENE");
        refused("sphecs flow.ron --set spacing", "path=value");
        refused("sphecs flow.ron --until -1", "--until");
        refused("sphecs flow.ron --until nan", "finite");
        refused("sphecs flow.ron --steps 0", "--steps");
        refused("sphecs flow.ron --threads 0", "--threads");
        refused("sphecs flow.ron --checkpoint-every 10", "unit");
        refused("sphecs flow.ron --max-walltime 0:00:00", "above zero");
        refused("sphecs resume", "RUN");
        refused("sphecs resume runs/a --smoke", "--smoke");
        refused("sphecs flow.ron --quiet -v", "cannot be used with");
        refused("sphecs check flow.ron --picture flow.jpg", "`.png`");
        refused("sphecs flow.ron --out flow.nc", "a folder");
        refused("sphecs validate --out report.JSON", "a folder");
        refused("sphecs bench --case 4d", "3d-sps-f64");
        refused("sphecs bench --threads 0", "--threads");
        refused("sphecs flow.ron --treads 2", "--threads");
        refused("sphecs new chanel flow", "channel");
        refused("sphecs new channel", "NAME");
        refused("sphecs completions basch", "bash");
    }
}
