//! Gridded fields and wall quantities with every setting, for the tests of the builder.

use crate::builder::{FieldPlane, Fields, WallQuantities};

/// Returns gridded fields with every setting.
pub(super) fn gridded_fields() -> Fields {
    Fields::default()
        .spacing("R/10")
        .every(0.1)
        .mean((0.0, "R"))
        .mean_every(0.01)
        .volume(true)
        .plane(FieldPlane::new("mid", (0.0, 0.0), (1.0, 0.0)))
}

/// Returns wall quantities with every setting.
pub(super) fn wall_quantities() -> WallQuantities {
    WallQuantities::default().every(0.1).mean((0.0, "R")).mean_every(0.01).part("lid")
}
