//! Output layer: reads the simulation, never changes it.
//!
//! A run writes into a [`RunFolder`](folder::RunFolder). Frames go to a journal with one complete
//! file per frame, rows to CSV files that are flushed line by line. A kill at any moment loses
//! nothing that was reported as written. [`pack`](pack::pack) turns both into `particles.nc`,
//! `monitor.nc` and `probes.nc`.
//!
//! A [checkpoint] is written after the frames that it counts and holds everything that the run
//! needs to resume. A flow that diverged leaves the particles around the first invalid one
//! ([`divergence`]). [`Results`](results::Results) reads packed and unfinished runs for pictures,
//! `sphecs info` and the exports: [`tracks`], [`vtkhdf`], [`vtk`] and [grids](fields::resampling).

pub mod checkpoint;
pub mod cut_back;
pub mod disk;
pub mod divergence;
pub mod drawing;
pub mod error;
pub mod fields;
pub mod folder;
pub mod forces;
pub mod frame;
pub mod header;
pub mod info;
pub mod journal;
pub mod live;
pub mod lock;
mod mean_interval;
mod meshes;
pub mod monitor;
mod netcdf;
mod numbered_files;
pub mod pack;
pub mod paths;
pub mod picture;
pub mod plot;
pub mod probes;
pub mod results;
pub mod start;
pub mod summary;
mod table;
pub mod tracks;
pub mod vtk;
pub mod vtkhdf;
pub mod walls;
