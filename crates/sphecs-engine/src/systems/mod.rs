//! Systems, which run in the sets of the schedules.
//!
//! - `advance`: parts of a step that the schemes share
//! - [`body_forces`]: force and torque on the bodies of a scene
//! - [`boundaries`]: inflow, outflow and wall particles
//! - [`divergence`]: detection of a diverging flow
//! - [`edac`]: the scheme `EdacTvf`
//! - [`force_fields`]: forces that a user adds for all fluid particles at once
//! - [`forces`]: the body force, and forces that a user adds
//! - [`monitor`]: integral quantities of the flow
//! - [`neighbours`]: the sort of the particles into cells
//! - [`sampling`]: fields at points and mass flows between two steps
//! - [`transitions`]: changes of zone
//! - [`wcsph`]: the scheme `Wcsph`

pub(crate) mod advance;
pub mod body_forces;
pub mod boundaries;
pub mod divergence;
pub mod edac;
pub mod force_fields;
pub mod forces;
pub mod monitor;
pub mod neighbours;
pub mod sampling;
pub mod transitions;
pub mod wcsph;
