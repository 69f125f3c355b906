//! `summary.json`: how a run stands or how it ended.

use std::path::Path;
use std::sync::OnceLock;

use serde::{Deserialize, Serialize};

use super::disk;
use super::error::OutputError;
use super::header::Header;
use sphecs_core::particles::zone::Zone;
use sphecs_engine::resources::ledger::Ledger;

/// Name of the file in the run folder.
pub const FILE: &str = "summary.json";

/// How a run stands or ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// Not ended, or killed without a chance to say so.
    #[default]
    Running,
    /// Reached its end.
    Completed,
    /// Stopped by Ctrl-C.
    Interrupted,
    /// Stopped by SIGTERM.
    Terminated,
    /// Stopped at the wall time that the user gave.
    #[serde(rename = "out of time")]
    OutOfTime,
    /// A value left its bounds.
    #[serde(rename = "blown up")]
    BlownUp,
    /// Stopped by another fault, such as a full disk or an empty reservoir.
    Failed,
}

impl Status {
    /// The word that `summary.json` has.
    pub fn word(self) -> &'static str {
        match self {
            Status::Running => "running",
            Status::Completed => "completed",
            Status::Interrupted => "interrupted",
            Status::Terminated => "terminated",
            Status::OutOfTime => "out of time",
            Status::BlownUp => "blown up",
            Status::Failed => "failed",
        }
    }
}

/// The ledger's counts as stored.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LedgerCounts {
    /// Particles at the start, reservoir included.
    pub initial: u64,
    /// Particles that an empty reservoir grew.
    pub grown: u64,
    /// Particles created other than from the reservoir.
    pub created: u64,
    /// Particles deleted.
    pub deleted: u64,
    /// Present fluid particles.
    pub fluid: u64,
    /// Present wall particles.
    pub wall: u64,
    /// Present inflow particles.
    pub inflow: u64,
    /// Present outflow particles.
    pub outflow: u64,
    /// Present reservoir particles.
    pub reservoir: u64,
    /// Inflow → fluid crossings of each inlet.
    pub entered: Vec<u64>,
    /// Fluid → inflow crossings of each inlet.
    pub entered_back: Vec<u64>,
    /// Fluid → outflow crossings of each outlet.
    pub left: Vec<u64>,
    /// Outflow → fluid crossings of each outlet.
    pub left_back: Vec<u64>,
    /// Whether total = initial + grown + created − deleted.
    pub balances: bool,
}

impl From<&Ledger> for LedgerCounts {
    fn from(ledger: &Ledger) -> Self {
        Self {
            initial: ledger.initial,
            grown: ledger.grown,
            created: ledger.created,
            deleted: ledger.deleted,
            fluid: ledger.count(Zone::Fluid),
            wall: ledger.count(Zone::Wall),
            inflow: ledger.count(Zone::Inflow),
            outflow: ledger.count(Zone::Outflow),
            reservoir: ledger.count(Zone::Reservoir),
            entered: ledger.entered.clone(),
            entered_back: ledger.entered_back.clone(),
            left: ledger.left.clone(),
            left_back: ledger.left_back.clone(),
            balances: ledger.balances(),
        }
    }
}

/// Wall-clock time of a stage.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StageTime {
    /// Stage.
    pub stage: String,
    /// Seconds of wall time.
    pub seconds: f64,
}

/// What tells one build of the program from another of the same version: the checksum of the running file, empty where it cannot be read.
pub fn this_build() -> &'static str {
    static BUILD: OnceLock<String> = OnceLock::new();
    BUILD.get_or_init(|| {
        let bytes = std::env::current_exe().and_then(std::fs::read);
        bytes.map_or_else(|_| String::new(), |bytes| format!("{:08x}", crc32fast::hash(&bytes)))
    })
}

/// The contents of `summary.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// How it stands or ended.
    pub status: Status,
    /// Why it ended before its end.
    #[serde(default)]
    pub message: Option<String>,
    /// What outlets were seen to do that they should not.
    #[serde(default)]
    pub notes: Vec<String>,
    /// The build of the program that ended it ([`this_build`]).
    #[serde(default)]
    pub build: String,
    /// Seconds of wall time.
    pub wall_time: f64,
    /// Steps done.
    pub steps: u64,
    /// Time reached, s.
    pub time: f64,
    /// Frames written.
    pub frames: u64,
    /// Threads.
    pub threads: usize,
    /// Name of the lanes (instruction set) that the pair sums ran on.
    pub lanes: String,
    /// Counts of particles.
    pub ledger: LedgerCounts,
    /// Wall time by stage, in the order of the step.
    pub stages: Vec<StageTime>,
    /// Facts of the run.
    pub run: Header,
}

impl Summary {
    /// Writes the file whole or not at all.
    ///
    /// # Errors
    /// [`OutputError`] when the system refuses.
    pub fn write(&self, folder: &Path) -> Result<(), OutputError> {
        let path = folder.join(FILE);
        let mut text = serde_json::to_string_pretty(self)
            .map_err(|error| OutputError::Damaged { path: path.clone(), what: error.to_string() })?;
        text.push('\n');
        disk::write_whole(&path, text.as_bytes())
    }

    /// Reads the file of a run folder.
    ///
    /// # Errors
    /// [`OutputError::NotARun`] without such a file, [`OutputError::Damaged`] when it does not read.
    pub fn read(folder: &Path) -> Result<Self, OutputError> {
        let path = folder.join(FILE);
        let text = match std::fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                return Err(OutputError::NotARun { path: folder.to_path_buf(), missing: FILE });
            }
            Err(error) => return Err(OutputError::io(&path, "read")(error)),
        };
        serde_json::from_str(&text).map_err(|error| OutputError::Damaged { path, what: error.to_string() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn summary_reads_back_as_written() {
        let folder = tempfile::tempdir().expect("a folder");
        let ledger = Ledger { initial: 10, grown: 2, by_zone: [5, 3, 2, 1, 1], ..Ledger::default() };
        let summary = Summary {
            status: Status::BlownUp,
            message: Some("density of particle 7 is NaN".to_owned()),
            ledger: LedgerCounts::from(&ledger),
            stages: vec![StageTime { stage: "rates".to_owned(), seconds: 1.5 }],
            ..Summary::default()
        };
        summary.write(folder.path()).expect("written");
        assert!(summary.ledger.balances);
        assert_eq!(Summary::read(folder.path()).expect("read"), summary);
    }

    #[test]
    fn folder_without_summary_is_not_a_run() {
        let folder = tempfile::tempdir().expect("a folder");
        let error = Summary::read(folder.path()).expect_err("refused").to_string();
        assert!(error.contains("is not a run"), "{error}");
    }
}
