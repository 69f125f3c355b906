//! Arguments of `run` and `resume`.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::Args;

use super::arguments::SceneArguments;
use super::values::{assignment, finite, positive, result_folder};

/// `sphecs run`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    sphecs run scenes/quickstart.ron --threads 2\n  \
    sphecs run scenes/duct3d.ron --smoke --steps 20 --out runs/duct_trial --force\n  \
    sphecs run scenes/square_bend.ron --max-walltime 23:50:00 --checkpoint-every 30min\n\n\
    Ctrl-C, SIGTERM, SIGHUP or SIGXCPU finishes the step, writes a checkpoint and a last frame and closes the files; \
    a second Ctrl-C or SIGTERM kills the run.\n\
    SIGUSR1 or SIGUSR2 writes a checkpoint and the run continues. `sphecs resume` resumes a run that was stopped or killed.")]
pub struct RunArguments {
    #[command(flatten)]
    #[expect(
        missing_docs,
        reason = "a doc comment on a flattened group would become the help of the command"
    )]
    pub input: SceneArguments,
    /// Folder for the results [default: `runs/` and the name of the scene]
    #[arg(long, value_name = "DIR", value_parser = result_folder())]
    pub out: Option<PathBuf>,
    #[command(flatten)]
    #[expect(
        missing_docs,
        reason = "a doc comment on a flattened group would become the help of the command"
    )]
    pub limits: LimitArguments,
    /// Replace an earlier run in the folder
    #[arg(long)]
    pub force: bool,
    /// Start although the free memory is too small for the particles, or the free disk space for
    /// the results
    #[arg(long)]
    pub allow_oversize: bool,
    #[command(flatten)]
    #[expect(
        missing_docs,
        reason = "a doc comment on a flattened group would become the help of the command"
    )]
    pub verbosity: VerbosityArguments,
}

/// `sphecs resume`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    sphecs resume runs/square_bend --max-walltime 23:50:00\n  \
    sphecs resume runs/quickstart --until 4\n  \
    sphecs resume runs/quickstart --set output.every=0.01\n\n\
    The output is first cut back to the last checkpoint, so that no time is repeated or omitted.\n\
    Values that --set may change: time.end, output.every, output.monitor_every, output.checkpoint_every.")]
pub struct ResumeArguments {
    /// Run folder
    #[arg(value_name = "RUN")]
    pub run: PathBuf,
    /// Change a value of the scene that does not affect the flow, as `time.end=4.0`; repeatable
    #[arg(long = "set", value_name = "PATH=VALUE", value_parser = assignment)]
    pub sets: Vec<(String, String)>,
    #[command(flatten)]
    #[expect(
        missing_docs,
        reason = "a doc comment on a flattened group would become the help of the command"
    )]
    pub limits: LimitArguments,
    /// Resume on another instruction set than that of the checkpoint: results will differ bitwise
    #[arg(long)]
    pub allow_other_isa: bool,
    #[command(flatten)]
    #[expect(
        missing_docs,
        reason = "a doc comment on a flattened group would become the help of the command"
    )]
    pub verbosity: VerbosityArguments,
}

/// Threads, end and checkpoints of a run.
#[derive(Args, Debug)]
pub struct LimitArguments {
    /// Number of threads of each rank [default: all cores, shared among the ranks]; results are
    /// bitwise identical for any number
    #[arg(long, value_name = "N")]
    pub threads: Option<NonZeroUsize>,
    /// Number of ranks in this process, each with a domain of its own
    /// [default: 1]; results are bitwise identical for any number
    #[arg(long, value_name = "N")]
    pub ranks: Option<NonZeroUsize>,
    /// Stop at this time, s [default: end of the scene, or of the run that is resumed]
    #[arg(long, value_name = "T", value_parser = positive, allow_negative_numbers = true)]
    pub until: Option<f64>,
    /// Stop after this many steps, counted from the start of the run
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub steps: Option<u64>,
    /// Wall time between checkpoints, as `90s`, `10min`, `2h` or `0:10:00` [default: that of the
    /// scene, else 10min]
    #[arg(long, value_name = "WALLTIME", value_parser = wall_time)]
    pub checkpoint_every: Option<f64>,
    /// Wall time after which the run writes a checkpoint, closes its files and exits with code 75,
    /// as `23:50:00` or `4h`
    #[arg(long, value_name = "WALLTIME", value_parser = wall_time)]
    pub max_walltime: Option<f64>,
}

/// Amount of text on standard output.
#[derive(Args, Debug)]
pub struct VerbosityArguments {
    /// Print nothing but errors
    #[arg(long, short, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Print a line for every frame and checkpoint
    #[arg(long, short)]
    pub verbose: bool,
}

/// Returns a wall time in s from a number with its unit, or `h:mm:ss` as batch systems write it.
fn wall_time(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let seconds = if text.contains(':') {
        let mut parts = text.split(':').map(|part| part.parse::<u32>().map(f64::from));
        let [Some(Ok(hours)), Some(Ok(minutes)), Some(Ok(seconds)), None] =
            [parts.next(), parts.next(), parts.next(), parts.next()]
        else {
            return Err("must be `hours:minutes:seconds`, as `23:50:00`".to_owned());
        };
        3600.0 * hours + 60.0 * minutes + seconds
    } else {
        let digits = text.trim_end_matches(char::is_alphabetic);
        let unit = match &text[digits.len()..] {
            "s" => 1.0,
            "min" => 60.0,
            "h" => 3600.0,
            _ => {
                return Err(
                    "must have a unit: `90s`, `10min`, `2h`, or be `hours:minutes:seconds`".to_owned()
                );
            }
        };
        finite(digits)? * unit
    };
    if seconds > 0.0 { Ok(seconds) } else { Err("must be above zero".to_owned()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wall_times_need_a_unit() {
        for (text, seconds) in
            [("90s", 90.0), ("10min", 600.0), ("1.5h", 5400.0), ("23:50:00", 85_800.0), ("0.2 s", 0.2)]
        {
            assert_eq!(wall_time(text), Ok(seconds), "{text}");
        }
        for text in ["10", "10m", "-3min", "0h", "1:30", "1:2:3:4", "::", "nan s", ""] {
            assert!(wall_time(text).is_err(), "`{text}` was accepted");
        }
    }
}
