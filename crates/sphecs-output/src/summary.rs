//! Contents of `summary.json`: state of a run or how it ended.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use std::sync::OnceLock;

use serde::{Deserialize, Serialize};

use super::disk;
use super::error::OutputError;
use super::header::Header;
use super::paths::SUMMARY;
use sphecs_core::particles::zone::Zone;
use sphecs_engine::resources::ledger::Ledger;

/// State of a run or reason of its end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// Not ended, or killed before it could write its end.
    #[default]
    Running,
    /// Reached its end.
    Completed,
    /// Stopped by Ctrl-C.
    Interrupted,
    /// Stopped by SIGTERM, SIGHUP or SIGXCPU.
    Terminated,
    /// Stopped at the wall-time limit.
    #[serde(rename = "out of time")]
    OutOfTime,
    /// A value left its bounds.
    #[serde(alias = "blown up")]
    Diverged,
    /// Stopped by another error, such as a full disk or an empty reservoir.
    Failed,
}

impl Status {
    /// Returns the word in `summary.json`.
    pub fn word(self) -> &'static str {
        match self {
            Status::Running => "running",
            Status::Completed => "completed",
            Status::Interrupted => "interrupted",
            Status::Terminated => "terminated",
            Status::OutOfTime => "out of time",
            Status::Diverged => "diverged",
            Status::Failed => "failed",
        }
    }
}

/// Counts of the ledger as stored.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LedgerCounts {
    /// Particles at the start, reservoir included.
    pub initial: u64,
    /// Particles by which an empty reservoir grew.
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
    /// True if total = initial + grown + created − deleted.
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
    /// Wall time, s.
    pub seconds: f64,
}

/// Returns the checksum of the running executable, which differs between builds of one version;
/// empty if unreadable.
pub fn this_build() -> &'static str {
    static BUILD: OnceLock<String> = OnceLock::new();
    BUILD.get_or_init(|| {
        std::env::current_exe()
            .and_then(|path| checksum(&path))
            .map_or_else(|_| String::new(), |checksum| format!("{checksum:08x}"))
    })
}

/// Returns the CRC-32 of a file, read in pieces: with line tables the executable has 150 MB, more
/// than most flows.
fn checksum(path: &Path) -> io::Result<u32> {
    let mut file = File::open(path)?;
    let mut hasher = crc32fast::Hasher::new();
    let mut piece = vec![0; 1 << 18];
    loop {
        match file.read(&mut piece)? {
            0 => return Ok(hasher.finalize()),
            count => hasher.update(&piece[..count]),
        }
    }
}

/// Contents of `summary.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// State or reason of the end.
    pub status: Status,
    /// Reason of an early end.
    #[serde(default)]
    pub message: Option<String>,
    /// Notes on outlets that did not act as intended.
    #[serde(default)]
    pub notes: Vec<String>,
    /// Build of the program that ended the run ([`this_build`]).
    #[serde(default)]
    pub build: String,
    /// Wall time, s.
    pub wall_time: f64,
    /// Steps done.
    pub steps: u64,
    /// Time reached, s.
    pub time: f64,
    /// Frames written.
    pub frames: u64,
    /// Number of threads of each rank.
    pub threads: usize,
    /// Number of ranks; 0 in a run that older programs ended.
    #[serde(default)]
    pub ranks: usize,
    /// Name of the lanes (instruction set) that the pair sums ran on.
    pub lanes: String,
    /// Counts of particles.
    pub ledger: LedgerCounts,
    /// Wall time by stage, in the order of the step.
    pub stages: Vec<StageTime>,
    /// Header of the run.
    pub run: Header,
}

impl Summary {
    /// Writes the file completely or not at all.
    ///
    /// # Errors
    /// [`OutputError`] when the write fails.
    pub fn write(&self, folder: &Path) -> Result<(), OutputError> {
        let path = folder.join(SUMMARY);
        let mut text = serde_json::to_string_pretty(self)
            .map_err(|error| OutputError::Damaged { path: path.clone(), what: error.to_string() })?;
        text.push('\n');
        disk::write_whole(&path, text.as_bytes())
    }

    /// Reads the file of a run folder.
    ///
    /// # Errors
    /// [`OutputError::NotARun`] without such a file, [`OutputError::Damaged`] when it cannot be
    /// parsed.
    pub fn read(folder: &Path) -> Result<Self, OutputError> {
        let path = folder.join(SUMMARY);
        let text = match std::fs::read_to_string(&path) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                return Err(OutputError::NotARun { path: folder.to_path_buf(), missing: SUMMARY });
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
            status: Status::Diverged,
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
