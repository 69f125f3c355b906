//! Processes of this run that a launcher such as `mpirun` has started.

use crate::error::RunError;

/// Place of this process among those that a launcher started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Launched {
    /// Number of this process, from 0.
    pub rank: usize,
    /// Number of processes.
    pub size: usize,
}

/// Variables with the rank and the number of processes: of Open MPI, of MPICH and what is made from
/// it, and of Slurm with PMIx.
const VARIABLES: [[&str; 2]; 3] = [
    ["OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"],
    ["PMI_RANK", "PMI_SIZE"],
    ["PMIX_RANK", "SLURM_STEP_NUM_TASKS"],
];

/// Refuses several processes of a command that they do not share.
///
/// # Errors
/// [`RunError::Ranks`] if a launcher started several.
pub fn check(is_shared: bool) -> Result<(), RunError> {
    match launched() {
        Some(Launched { size, .. }) if !is_shared => Err(RunError::Ranks(format!(
            "{size} processes of this command were started, which would all do the same: start one; \
             only `run` and `resume` share their work"
        ))),
        _ => Ok(()),
    }
}

/// Returns the place of this process where a launcher started several; None if it is alone.
pub fn launched() -> Option<Launched> {
    found(|name| std::env::var(name).ok())
}

fn found(value: impl Fn(&str) -> Option<String>) -> Option<Launched> {
    let number = |name: &str| value(name)?.parse::<usize>().ok();
    let launched =
        VARIABLES.iter().find_map(|[rank, size]| Some(Launched { rank: number(rank)?, size: number(size)? }));
    launched.filter(|launched| launched.size > 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn launchers_are_recognised() {
        let from = |set: &[(&str, &str)]| {
            found(|name| set.iter().find(|(set, _)| *set == name).map(|(_, value)| (*value).to_owned()))
        };
        assert_eq!(from(&[]), None);
        assert_eq!(from(&[("PMI_RANK", "0"), ("PMI_SIZE", "1")]), None);
        let third = Some(Launched { rank: 2, size: 4 });
        assert_eq!(from(&[("PMI_RANK", "2"), ("PMI_SIZE", "4")]), third);
        assert_eq!(from(&[("OMPI_COMM_WORLD_RANK", "2"), ("OMPI_COMM_WORLD_SIZE", "4")]), third);
        assert_eq!(from(&[("PMIX_RANK", "2"), ("SLURM_STEP_NUM_TASKS", "4")]), third);
        assert_eq!(from(&[("SLURM_STEP_NUM_TASKS", "4")]), None);
    }
}
