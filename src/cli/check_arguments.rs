//! Arguments of `bench` and `validate`.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};

use super::values::result_folder;
use sphecs_bench::cases::BenchCase;

/// `sphecs bench`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    sphecs bench\n  \
    sphecs bench --case 3d-f32 --case 3d-f64 --threads 1,4,16\n  \
    sphecs bench --case channel --threads 1 --ranks 2,4\n\n\
    No files are read or written. Results are the fastest of several repetitions; keep the machine free of other load.")]
pub struct BenchArguments {
    /// Case to measure; repeatable [default: all but the large ones]
    #[arg(long = "case", value_name = "NAME", value_parser = cases())]
    pub cases: Vec<BenchCase>,
    /// Numbers of threads, separated by commas [default: one, and all cores]
    #[arg(long, value_name = "N", value_delimiter = ',')]
    pub threads: Vec<NonZeroUsize>,
    /// Numbers of ranks, separated by commas, each with each number of threads [default: 1]
    #[arg(long, value_name = "N", value_delimiter = ',')]
    pub ranks: Vec<NonZeroUsize>,
    /// Also measure boxes of one and four million particles
    #[arg(long)]
    pub large: bool,
}

/// `sphecs validate`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    sphecs validate --quick\n  \
    sphecs validate --case poiseuille --out runs/poiseuille_check\n  \
    sphecs validate --case my_cases/pipe.ron\n\n\
    Writes a page with plots for each case, and report.json. Exit code 1 when a required band is missed.")]
pub struct ValidateArguments {
    /// Name of a case, or the path of a case file; repeatable [default: all]
    #[arg(long = "case", value_name = "NAME")]
    pub cases: Vec<String>,
    /// Run only cases that take minutes
    #[arg(long, conflicts_with = "full")]
    pub quick: bool,
    /// Run all cases, at published resolution
    #[arg(long)]
    pub full: bool,
    /// Folder for runs, pages and plots
    #[arg(long, value_name = "DIR", default_value = "runs/validation", value_parser = result_folder())]
    pub out: PathBuf,
    /// Reuse completed runs of the same scene and version in the folder, resume interrupted ones
    #[arg(long)]
    pub reuse: bool,
    /// Number of threads and of concurrent runs [default: all cores]
    #[arg(long, value_name = "N")]
    pub threads: Option<NonZeroUsize>,
    /// List the cases without running any
    #[arg(long)]
    pub list: bool,
}

fn cases() -> impl TypedValueParser<Value = BenchCase> {
    PossibleValuesParser::new(BenchCase::ALL.map(|(name, _)| name))
        .try_map(|name| BenchCase::named(&name).ok_or("is not a case"))
}
