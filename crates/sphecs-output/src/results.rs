//! Results of a run, packed or not, read for pictures, export and `sphecs info`.

use std::path::{Path, PathBuf};

use super::error::OutputError;
use super::frame::Frame;
use super::header::Header;
use super::journal::frame_paths;
use super::meshes;
use super::netcdf::particles::{FrameTime, ParticleFile};
use super::paths::{
    self, DIVERGENCE_NETCDF, FIELDS, FORCES_NETCDF, JOURNAL, MONITOR_NETCDF, PACKED_JOURNAL, PARTICLES,
    PROBES_NETCDF, SCENE, SUMMARY, TABLES,
};
use super::summary::Summary;
use sphecs_core::format::significant;

/// Returns the header of a run with the text of its scene and tables.
///
/// # Errors
/// [`OutputError::NotARun`] when the folder has no run, or [`OutputError`] with path and cause.
pub fn read_header(folder: &Path) -> Result<Header, OutputError> {
    let path = folder.join(SCENE);
    let mut header = Summary::read(folder)?.run;
    header.text = std::fs::read_to_string(&path).map_err(OutputError::io(&path, "read"))?;
    let path = folder.join(TABLES);
    if path.exists() {
        let text = std::fs::read(&path).map_err(OutputError::io(&path, "read"))?;
        header.tables = serde_json::from_slice(&text)
            .map_err(|error| OutputError::Damaged { path, what: error.to_string() })?;
    }
    header.meshes = meshes::read(folder, &header)?;
    Ok(header)
}

/// Run opened for reading.
#[derive(Debug)]
pub struct Results {
    /// Run folder.
    pub folder: PathBuf,
    /// State of the run or how it ended.
    pub summary: Summary,
    /// Header of the run.
    pub header: Header,
    walls: Frame,
    frames: Vec<(Source, f64)>,
    packed: Option<ParticleFile>,
}

#[derive(Debug)]
enum Source {
    Packed(usize),
    Journal(PathBuf),
}

impl Results {
    /// Opens the run in a folder.
    ///
    /// # Errors
    /// [`OutputError::NotARun`] when the folder has no run, or [`OutputError`] with path and cause.
    pub fn open(folder: &Path) -> Result<Self, OutputError> {
        let mut results = Self {
            folder: folder.to_path_buf(),
            summary: Summary::read(folder)?,
            header: read_header(folder)?,
            walls: Frame::default(),
            frames: Vec::new(),
            packed: None,
        };
        // If there is a journal, it has all frames, and `particles.nc` is an incomplete copy left
        // by a kill.
        let journal = folder.join(JOURNAL);
        if journal.exists() {
            let walls = paths::walls(&journal);
            if walls.exists() {
                results.walls = ParticleFile::open(&walls)?.walls()?;
            }
            for path in frame_paths(&journal)? {
                let file = ParticleFile::open(&path)?;
                let time = file.times.first().copied().unwrap_or(f64::NAN);
                results.frames.push((Source::Journal(path), time));
            }
            return Ok(results);
        }
        let path = folder.join(PARTICLES);
        if path.exists() {
            let file = ParticleFile::open(&path)?;
            results.walls = file.walls()?;
            let times = file.times.iter().enumerate();
            results.frames = times.map(|(index, &time)| (Source::Packed(index), time)).collect();
            results.packed = Some(file);
        }
        Ok(results)
    }

    /// Returns the number of frames.
    pub fn len(&self) -> usize {
        self.frames.len()
    }

    /// Returns true if there are no frames.
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// Returns the times of the frames, s.
    pub fn times(&self) -> Vec<f64> {
        self.frames.iter().map(|&(_, time)| time).collect()
    }

    /// Returns true if the frames are in `particles.nc`.
    pub fn is_packed(&self) -> bool {
        self.packed.is_some()
    }

    /// Returns the index of the frame nearest to a time, s.
    ///
    /// # Errors
    /// [`OutputError::Request`] when there is no frame, or the time is before the first or after
    /// the last one by more than the longest interval between two.
    pub fn nearest(&self, time: f64) -> Result<usize, OutputError> {
        let distance = |index: &usize| (self.frames[*index].1 - time).abs();
        let found = (0..self.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let found = found.ok_or_else(|| self.no_frames())?;
        let times = self.times();
        let interval = times.windows(2).map(|pair| pair[1] - pair[0]).fold(1e-6 * time.abs(), f64::max);
        let ends = [times.first(), times.last()].map(|end| end.copied().unwrap_or_default());
        if (ends[0] - interval..=ends[1] + interval).contains(&time) {
            return Ok(found);
        }
        let [first, last, time] = [ends[0], ends[1], time].map(significant);
        Err(OutputError::Request(format!(
            "`{}`: has no frame near t = {time} s, its frames are from {first} to {last} s",
            self.folder.display()
        )))
    }

    /// Refuses to replace a file that the run itself has written.
    ///
    /// # Errors
    /// [`OutputError::Request`] for such a file.
    pub(crate) fn refuse_own_file(&self, path: &Path) -> Result<(), OutputError> {
        let own = [PARTICLES, FIELDS, MONITOR_NETCDF, PROBES_NETCDF, FORCES_NETCDF, DIVERGENCE_NETCDF];
        let Ok(found) = path.canonicalize() else { return Ok(()) };
        let is_own = |name: &&str| self.folder.join(name).canonicalize().is_ok_and(|file| file == found);
        match own.into_iter().find(is_own) {
            Some(name) => Err(OutputError::Request(format!(
                "`{}`: is the `{name}` of the run, which is not replaced; give another file by `-o`",
                path.display()
            ))),
            None => Ok(()),
        }
    }

    /// Returns the error of a run without frames.
    pub fn no_frames(&self) -> OutputError {
        OutputError::Request(format!("`{}`: has no frames yet", self.folder.display()))
    }

    /// Returns the error of an interval, s, without frames.
    pub(crate) fn no_frames_between(&self, from: f64, to: f64) -> OutputError {
        let times = self.times();
        let ends = [times.first(), times.last()].map(|end| end.copied().unwrap_or_default());
        let [first, last, from, to] = [ends[0], ends[1], from, to].map(significant);
        OutputError::Request(format!(
            "`{}`: has no frame from {from} to {to} s, its frames are from {first} to {last} s",
            self.folder.display()
        ))
    }

    /// Returns a frame, walls included; of a wall particle only position and part are known.
    ///
    /// # Errors
    /// [`OutputError`] with path and cause.
    pub fn frame(&self, index: usize) -> Result<Frame, OutputError> {
        self.read(index, |file, at| file.frame(at, &self.walls))
    }

    /// Returns zones and passages of a frame, on request with positions.
    ///
    /// # Errors
    /// [`OutputError`] with path and cause.
    pub(crate) fn occupancy(&self, index: usize, with_positions: bool) -> Result<Frame, OutputError> {
        self.read(index, |file, at| file.occupancy(at, with_positions))
    }

    /// Returns the time of a frame.
    ///
    /// # Errors
    /// [`OutputError`] with path and cause.
    pub(crate) fn frame_time(&self, index: usize) -> Result<FrameTime, OutputError> {
        self.read(index, ParticleFile::frame_time)
    }

    /// Reads something of a frame from its file, in which it has another index.
    fn read<T>(
        &self,
        index: usize,
        from: impl Fn(&ParticleFile, usize) -> Result<T, OutputError>,
    ) -> Result<T, OutputError> {
        let Some((source, _)) = self.frames.get(index) else {
            return Err(OutputError::Request(format!(
                "`{}`: has no frame {index}, must be from 0 to {}",
                self.folder.display(),
                self.len().saturating_sub(1)
            )));
        };
        match (source, &self.packed) {
            (Source::Packed(index), Some(file)) => from(file, *index),
            (Source::Journal(path), _) => match ParticleFile::open(path) {
                // The run was packed in the meantime.
                Err(_) if !path.exists() => from(&ParticleFile::open(&self.folder.join(PARTICLES))?, index),
                file => from(&file?, 0),
            },
            (Source::Packed(_), None) => Err(self.no_frames()),
        }
    }

    /// Returns the size of all frames on the disk, bytes.
    pub fn bytes(&self) -> u64 {
        let size = |path: &Path| std::fs::metadata(path).map_or(0, |data| data.len());
        let packed = self.folder.join(PARTICLES);
        if self.is_packed() {
            return size(&packed);
        }
        self.frames
            .iter()
            .map(|(source, _)| match source {
                Source::Journal(path) => size(path),
                Source::Packed(_) => 0,
            })
            .sum()
    }
}

/// Returns true if a folder holds a run of sphecs; only such folders are replaced.
pub fn is_run(folder: &Path) -> bool {
    let has = |name: &str| folder.join(name).exists();
    has(SCENE) && (has(SUMMARY) || has(PARTICLES) || has(JOURNAL) || has(PACKED_JOURNAL))
}
