//! Floor 6: reads the world, never writes it.
//!
//! A run writes into a [`RunFolder`](folder::RunFolder): frames go to a journal of one whole file per instant,
//! rows to CSV files that are flushed line by line, so that a kill at any moment loses nothing that was
//! reported as written. [`pack`](pack::pack) turns both into `particles.nc`, `monitor.nc` and `probes.nc`.
//! A [checkpoint] goes the same way behind the frames, and holds all that the run needs to go on.
//! Of a flow that [blew up](blow_up) it keeps what stood around the particle that showed it.
//! [`Results`](results::Results) reads packed and unfinished runs alike, for pictures, export and people.

pub mod blow_up;
pub mod checkpoint;
pub mod disk;
pub mod error;
pub mod folder;
pub mod forces;
pub mod frame;
pub mod header;
pub mod info;
pub mod journal;
pub mod lock;
pub mod monitor;
mod netcdf;
pub mod pack;
pub mod picture;
pub mod probes;
pub mod results;
pub mod summary;
mod table;
pub mod vtk;
