//! Output of a run: its times, probes and gridded fields.

use super::body::ForcesEvery;
use super::field_grid::FieldOutput;
use super::probe::Probe;
use super::wall_points::WallOutput;

/// Output of a run and its times.
#[derive(Clone, Debug)]
pub struct OutputSettings {
    /// Interval between frames, s.
    pub every: f64,
    /// Interval between rows of `monitor.nc`, s.
    pub monitor_every: f64,
    /// Interval between checkpoints, s of wall time.
    pub checkpoint_every: f64,
    /// Interval at which the forces on bodies are written.
    pub forces: ForcesEvery,
    /// Probes.
    pub probes: Vec<Probe>,
    /// Fields on grids; None: not written.
    pub fields: Option<FieldOutput>,
    /// Pressure and shear stress at the walls; None: not written.
    pub walls: Option<WallOutput>,
}
