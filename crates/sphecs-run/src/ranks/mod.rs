//! Ranks of a run: simulations of one scene that share the pair passes, each with its own threads.
//!
//! Rank 0 is the run itself, with its output and its signals. Every other rank gets scene and state
//! from it before the first step, and follows it to its end (`sphecs_engine::simulation`). So every
//! run and every checkpoint may have another number of ranks.
//!
//! - [`in_process`]: ranks that are threads of this process, for `--ranks`
//! - `launcher`: ranks that `mpirun` has started
//! - `mpi`: ranks that are processes, with the feature `mpi`

pub mod in_process;
pub mod launcher;
#[cfg(feature = "mpi")]
pub mod mpi;

use crate::error::RunError;
#[cfg(feature = "mpi")]
use mpi::of_job;
use sphecs_engine::simulation::{Simulation, SimulationBuilder};

/// Ranks of a run.
#[derive(Clone, Debug)]
pub enum RankSource {
    /// Ranks in this process; their number, ≥ 1.
    InProcess(usize),
    /// The processes of an MPI job.
    #[cfg(feature = "mpi")]
    Mpi(std::sync::Arc<mpi::Session>),
}

impl Default for RankSource {
    fn default() -> Self {
        Self::InProcess(1)
    }
}

impl RankSource {
    /// Returns the ranks of this process; None if it followed another one to its end.
    ///
    /// `given` is the number of ranks on the command line, `threads` that of threads of each.
    ///
    /// # Errors
    /// [`RunError::Ranks`] under a launcher of MPI, for a number of ranks beside it, and for a
    /// program without MPI.
    pub fn of_process(given: Option<usize>, threads: Option<usize>) -> Result<Option<Self>, RunError> {
        let Some(launched) = launcher::launched() else {
            return Ok(Some(Self::InProcess(given.unwrap_or(1))));
        };
        if given.is_some() {
            return Err(RunError::Ranks(
                "`--ranks`: the launcher has started the ranks, give the number to it alone".to_owned(),
            ));
        }
        of_job(launched, threads)
    }

    /// Returns the number of ranks.
    pub fn count(&self) -> usize {
        match self {
            Self::InProcess(ranks) => *ranks,
            #[cfg(feature = "mpi")]
            Self::Mpi(session) => session.size(),
        }
    }

    /// Returns the number of ranks in this process.
    pub fn in_this_process(&self) -> usize {
        match self {
            Self::InProcess(ranks) => *ranks,
            #[cfg(feature = "mpi")]
            Self::Mpi(_) => 1,
        }
    }

    /// Returns the number of threads of this rank; `given` is that of each, None: all cores,
    /// shared among the ranks of this process.
    ///
    /// An MPI job binds each of its processes to the cores that it may use.
    pub fn threads(&self, given: Option<usize>) -> Option<usize> {
        match self {
            Self::InProcess(0 | 1) => given,
            Self::InProcess(ranks) => {
                let cores = std::thread::available_parallelism().map_or(1, std::num::NonZeroUsize::get);
                Some(given.unwrap_or((cores / ranks).max(1)))
            }
            #[cfg(feature = "mpi")]
            Self::Mpi(_) => given,
        }
    }

    /// Returns a builder of the simulation of rank 0: several ranks have no components.
    pub(crate) fn begin(&self, builder: SimulationBuilder) -> SimulationBuilder {
        if self.count() > 1 { builder.without_components() } else { builder }
    }

    /// Starts the other ranks, which follow a simulation from its present state on.
    ///
    /// # Errors
    /// [`RunError::Threads`] when the system refuses a thread.
    pub(crate) fn start(&self, simulation: &mut Simulation) -> Result<Followers, RunError> {
        Ok(match self {
            Self::InProcess(ranks) => {
                let threads = rayon::current_num_threads();
                Followers::InProcess { _threads: in_process::Followers::start(simulation, *ranks, threads)? }
            }
            #[cfg(feature = "mpi")]
            Self::Mpi(session) => {
                session.lead(simulation);
                Followers::Mpi
            }
        })
    }
}

/// Refuses an MPI job.
#[cfg(not(feature = "mpi"))]
fn of_job(launched: launcher::Launched, _: Option<usize>) -> Result<Option<RankSource>, RunError> {
    let count = launched.size;
    Err(RunError::Ranks(format!(
        "this program was built without MPI, but {count} processes of it were started: build it with \
         `--features mpi`, or start one process, with `--ranks {count}` for ranks in it"
    )))
}

/// The other ranks of a run; those of this process have ended when this is dropped.
#[derive(Debug)]
pub(crate) enum Followers {
    /// Threads of this process.
    InProcess {
        /// Their pools.
        _threads: in_process::Followers,
    },
    /// Processes of an MPI job.
    #[cfg(feature = "mpi")]
    Mpi,
}
