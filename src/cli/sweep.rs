//! `sphecs sweep`: its arguments and the command.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::Args;

use super::arguments::SceneArguments;
use super::failure::{DONE, FLOW, Failure};
use super::values::result_folder;
use sphecs_core::format::grouped;
use sphecs_run::console::Console;
use sphecs_run::memory;
use sphecs_run::sweep::{Sweep, SweepAxis, axis};

/// `sphecs sweep`.
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    sphecs sweep scenes/quickstart.ron --smoke --grid fluid.viscosity=1e-5,1e-6 --grid constants.v0=0.1,0.2\n  \
    sphecs sweep scenes/quickstart.ron --grid 'outlets.0.condition=Hybrid(),WaveEquation()' --list\n\n\
    Each combination of the values is a run in a folder named by them; `sweep.csv` lists folders and values. The same command \
    continues a sweep that was stopped, and makes what further values add. On a cluster each task of a job array makes one run:\n  \
    sbatch --array=0-3 --wrap 'sphecs sweep flow.ron --grid spacing=2e-3,1e-3 --grid constants.v0=0.1,0.2 --only $SLURM_ARRAY_TASK_ID'")]
pub struct SweepArguments {
    #[command(flatten)]
    #[expect(
        missing_docs,
        reason = "a doc comment on a flattened group would become the help of the command"
    )]
    pub input: SceneArguments,
    /// Values of a path of the scene, as `spacing=2e-3,1e-3`; commas inside brackets and quotes are
    /// part of a value; repeatable
    #[arg(long = "grid", value_name = "PATH=VALUES", value_parser = axis, required = true)]
    pub axes: Vec<SweepAxis>,
    /// Folder of the sweep [default: `runs/`, the name of the scene and `_sweep`]
    #[arg(long, value_name = "DIR", value_parser = result_folder())]
    pub out: Option<PathBuf>,
    /// Number of threads, as many runs at once [default: all cores]
    #[arg(long, value_name = "N")]
    pub threads: Option<NonZeroUsize>,
    /// Make only the run of this index, from 0
    #[arg(long, value_name = "INDEX")]
    pub only: Option<usize>,
    /// Print indices and folders of the runs and make none
    #[arg(long)]
    pub list: bool,
    /// Make complete runs again
    #[arg(long)]
    pub force: bool,
}

/// Makes the runs of a sweep, or lists them.
///
/// # Errors
/// [`Failure::Sweep`] with the faults of a scene, and files that cannot be written.
pub fn sweep(arguments: &SweepArguments) -> Result<u8, Failure> {
    let name = arguments.input.scene.file_stem().unwrap_or_default().to_string_lossy();
    let sweep = Sweep {
        scene: arguments.input.scene.clone(),
        smoke: arguments.input.smoke,
        sets: arguments.input.sets.clone(),
        axes: arguments.axes.clone(),
        folder: arguments.out.clone().unwrap_or_else(|| PathBuf::from("runs").join(format!("{name}_sweep"))),
        threads: arguments.threads.map(NonZeroUsize::get),
        only: arguments.only,
        reuse: !arguments.force,
        memory: memory::available(),
        console: Console::Normal,
    };
    if arguments.list {
        for (index, run) in sweep.runs()?.iter().enumerate() {
            Console::Normal.print(&format!("{index:>5}  {}", sweep.folder.join(&run.name).display()));
        }
        return Ok(DONE);
    }
    let end = sweep.make()?;
    let (completed, diverged) = (grouped(end.completed as u64), end.diverged.len());
    let ends = if diverged == 0 { String::new() } else { format!(", {diverged} diverged") };
    let runs = if end.completed == 1 { "run" } else { "runs" };
    Console::Normal.print(&format!("{completed} {runs} completed{ends}: {}", sweep.folder.display()));
    Ok(match end.signal {
        Some(signal) => signal.exit_code(),
        None if diverged > 0 => FLOW,
        None => DONE,
    })
}
