//! Access to the columns that the pair passes leave for each other.
//!
//! [`Written`] holds columns of one writer. The writer is a type that only the module of its pass
//! can construct, so no other code changes them. A reader is named by a type as well, and the table
//! of [`Reads`] below lists the passes that may read. A further reader does not compile until it is
//! in the table, which shows which pass has to run before it.

use std::marker::PhantomData;

use super::gradients::Gradients;
use super::strain::Strain;
use super::stress::Stress;
use super::wall_friction::WallFriction;
use super::wall_sides::WallSides;
use super::wall_velocity::WallVelocity;

/// Columns `C` that the pass `W` writes.
#[derive(Debug)]
pub struct Written<C, W> {
    columns: C,
    writer: PhantomData<W>,
}

/// A reader of what the pass `W` writes.
pub trait Reads<W> {}

/// Rates of the scheme `Wcsph`, as a reader.
pub(super) struct WcsphRates;

/// Rates of the scheme `EdacTvf`, as a reader.
pub(super) struct EdacRates;

/// Rates of either scheme, as a reader.
pub(super) struct FusedInputsReader;

/// Force on a body, as a reader.
pub(super) struct BodySums;

/// Pressures of the walls, as a reader.
pub(super) struct WallPressures;

/// Systems and outputs, as readers: they run after all passes of a step.
#[derive(Clone, Copy, Debug)]
pub struct AfterPasses;

impl Reads<WallVelocity> for Gradients {}
impl Reads<WallVelocity> for WcsphRates {}
impl Reads<WallVelocity> for EdacRates {}
impl Reads<WallSides> for FusedInputsReader {}
impl Reads<WallSides> for WallPressures {}
impl Reads<WallSides> for BodySums {}
impl Reads<WallSides> for Gradients {}
impl Reads<Gradients> for Stress {}
impl Reads<Strain> for WcsphRates {}
impl Reads<Stress> for WcsphRates {}
impl Reads<WallFriction> for WallFriction {}
impl<W> Reads<W> for AfterPasses {}

impl<C, W> Written<C, W> {
    /// Returns columns that nothing has written yet.
    pub(super) fn new(columns: C) -> Self {
        Self { columns, writer: PhantomData }
    }

    /// Returns the columns to their writer.
    #[inline(always)]
    pub fn write(&mut self, _writer: W) -> &mut C {
        &mut self.columns
    }

    /// Returns the columns to a reader.
    #[inline(always)]
    pub fn read(&self, _reader: impl Reads<W>) -> &C {
        &self.columns
    }

    /// Returns the columns to a test that chooses their values.
    #[cfg(test)]
    pub(super) fn choose(&mut self) -> &mut C {
        &mut self.columns
    }
}
