//! Emitters of a scene file.

use serde::Deserialize;

use super::{InletVelocityFile, Number, ShapeFile, Text};
use crate::notation::tree::Span;
use crate::notation::typed::Spanned;

/// A surface of a wall or mover through which fluid enters along the normal.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename = "Emitter", deny_unknown_fields)]
pub struct EmitterFile {
    /// Name for outputs and messages, default `emitter 0` and so on.
    #[serde(default)]
    pub name: Option<Text>,
    /// Name of the mover, of the wall part, or of the solid, group or file of a mesh in the domain
    /// or in a mover whose surface emits, default the walls.
    #[serde(default)]
    pub on: Option<Text>,
    /// Region in which the surface emits, of a mover in its place without displacement; default all
    /// of `on`.
    #[serde(default)]
    pub region: Option<Spanned<ShapeFile>>,
    /// Velocity of the fluid relative to the surface, along the normal: `Normal`, `TimeTable`,
    /// `MassFlow` or `MassFlux`. Profiles are functions of the place without displacement.
    pub velocity: Spanned<InletVelocityFile>,
    /// Depth of its inflow zone inside the solid, m, rounded up to whole spacings; default a little
    /// more than the support.
    #[serde(default)]
    pub depth: Option<Number>,
}

impl EmitterFile {
    /// Returns its place in the file.
    pub fn place(&self) -> Span {
        let given = self.on.as_ref().or(self.name.as_ref()).map(|text| text.span);
        given.or(self.region.as_ref().map(|region| region.head)).unwrap_or(self.velocity.head)
    }
}
