//! Output columns as parts of a message: the rows of a cell, column after column.

use std::ops::Range;

use crate::math::real::Real;
use crate::pass::blocks::SplittableColumns;

/// Number of an output column.
pub(in crate::pass) trait OutputNumber: bytemuck::Pod + Send + Sync {
    /// False for a number that only later passes over the same rows read: no message has it.
    const IS_SENT: bool = true;
}

impl<R: Real> OutputNumber for R {}

/// Output columns that a rank sends to the others.
pub(in crate::pass) trait SharedColumns: SplittableColumns + Sync {
    /// Returns the bytes of a row in a message; 0 for columns that are not in use.
    fn width(&self) -> usize;

    /// Appends some rows to a message.
    fn write(&self, rows: Range<usize>, message: &mut Vec<u8>);

    /// Reads rows that [`Self::write`] wrote, and returns the rest of the message.
    fn read<'m>(&mut self, rows: Range<usize>, message: &'m [u8]) -> &'m [u8];
}

impl<T: OutputNumber> SharedColumns for &mut [T] {
    fn width(&self) -> usize {
        if T::IS_SENT && !self.is_empty() { size_of::<T>() } else { 0 }
    }

    fn write(&self, rows: Range<usize>, message: &mut Vec<u8>) {
        if self.width() > 0 {
            message.extend_from_slice(bytemuck::cast_slice(&self[rows]));
        }
    }

    fn read<'m>(&mut self, rows: Range<usize>, message: &'m [u8]) -> &'m [u8] {
        let (own, rest) = message.split_at(self.width() * rows.len());
        if self.width() > 0 {
            bytemuck::cast_slice_mut(&mut self[rows]).copy_from_slice(own);
        }
        rest
    }
}

impl<C: SharedColumns, const N: usize> SharedColumns for [C; N] {
    fn width(&self) -> usize {
        self.iter().map(C::width).sum()
    }

    fn write(&self, rows: Range<usize>, message: &mut Vec<u8>) {
        self.iter().for_each(|column| column.write(rows.clone(), message));
    }

    fn read<'m>(&mut self, rows: Range<usize>, message: &'m [u8]) -> &'m [u8] {
        self.iter_mut().fold(message, |rest, column| column.read(rows.clone(), rest))
    }
}

macro_rules! tuples {
    ($($name:ident $place:tt),*) => {
        impl<$($name: SharedColumns),*> SharedColumns for ($($name,)*) {
            fn width(&self) -> usize {
                [$(self.$place.width()),*].iter().sum()
            }

            fn write(&self, rows: Range<usize>, message: &mut Vec<u8>) {
                $(self.$place.write(rows.clone(), message);)*
            }

            fn read<'m>(&mut self, rows: Range<usize>, message: &'m [u8]) -> &'m [u8] {
                $(let message = self.$place.read(rows.clone(), message);)*
                message
            }
        }
    };
}
tuples!(A 0, B 1);
tuples!(A 0, B 1, C 2);
tuples!(A 0, B 1, C 2, E 3);
