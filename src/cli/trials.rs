//! Arguments of the commands that run known flows: `bench` and `validate`.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};

use sphecs_bench::cases::Case;

/// `sphecs bench`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    sphecs bench\n  \
    sphecs bench --case 3d-f32 --case 3d-f64 --threads 1,4,16\n\n\
    Nothing is read or written. Let the machine rest meanwhile: a figure is the fastest of some repetitions.")]
pub struct BenchArguments {
    /// Case to measure; repeatable [default: all but the large ones]
    #[arg(long = "case", value_name = "NAME", value_parser = cases())]
    pub cases: Vec<Case>,
    /// Threads to measure with; several with commas between [default: one, and all cores]
    #[arg(long, value_name = "N", value_delimiter = ',')]
    pub threads: Vec<NonZeroUsize>,
    /// Measure boxes of one and four million particles as well
    #[arg(long)]
    pub large: bool,
}

/// `sphecs validate`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    sphecs validate --quick\n  \
    sphecs validate --case poiseuille --out runs/poiseuille_check\n  \
    sphecs validate --case my_cases/pipe.ron\n\n\
    Leaves a page with plots for each case, and report.json. Exit code 1 when a band that must be met is missed.")]
pub struct ValidateArguments {
    /// Name of a case, or the path of a case file; repeatable [default: all]
    #[arg(long = "case", value_name = "NAME")]
    pub cases: Vec<String>,
    /// Run only what takes minutes
    #[arg(long, conflicts_with = "full")]
    pub quick: bool,
    /// Run everything, at published resolution
    #[arg(long)]
    pub full: bool,
    /// Folder for runs, pages and plots
    #[arg(long, value_name = "DIR", default_value = "runs/validation")]
    pub out: PathBuf,
    /// Take completed runs of the same scene and version from the folder, go on with interrupted ones
    #[arg(long)]
    pub reuse: bool,
    /// Threads to compute with, as many runs at a time [default: all cores]
    #[arg(long, value_name = "N")]
    pub threads: Option<NonZeroUsize>,
    /// Say what cases there are, and run none
    #[arg(long)]
    pub list: bool,
}

fn cases() -> impl TypedValueParser<Value = Case> {
    PossibleValuesParser::new(Case::ALL.map(|(name, _)| name))
        .try_map(|name| Case::named(&name).ok_or("is no case"))
}
