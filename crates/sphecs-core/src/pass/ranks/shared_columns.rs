//! Output columns as parts of a message: the rows of a block, column after column.

use crate::math::real::Real;
use crate::pass::blocks::SplittableColumns;

/// Number of an output column.
pub(in crate::pass) trait OutputNumber: bytemuck::Pod + Send + Sync {
    /// False for a number that only later passes over the same rows read: no message has it.
    const IS_SENT: bool = true;
}

impl<R: Real> OutputNumber for R {}

/// Output columns that a rank sends to the others.
pub(in crate::pass) trait SharedColumns: SplittableColumns {
    /// Returns the bytes of a row in a message; 0 for columns that are not in use.
    fn width(&self) -> usize;

    /// Writes the rows to the beginning of a message and returns the rest of it.
    fn write<'m>(&self, message: &'m mut [u8]) -> &'m mut [u8];

    /// Reads as many rows as the columns have, which [`Self::write`] wrote, and returns the rest of
    /// the message.
    fn read<'m>(&mut self, message: &'m [u8]) -> &'m [u8];
}

impl<T: OutputNumber> SharedColumns for &mut [T] {
    fn width(&self) -> usize {
        if T::IS_SENT && !self.is_empty() { size_of::<T>() } else { 0 }
    }

    fn write<'m>(&self, message: &'m mut [u8]) -> &'m mut [u8] {
        let (own, rest) = message.split_at_mut(self.width() * self.len());
        if T::IS_SENT {
            own.copy_from_slice(bytemuck::cast_slice(self));
        }
        rest
    }

    fn read<'m>(&mut self, message: &'m [u8]) -> &'m [u8] {
        let (own, rest) = message.split_at(self.width() * self.len());
        if T::IS_SENT {
            bytemuck::cast_slice_mut(self).copy_from_slice(own);
        }
        rest
    }
}

impl<C: SharedColumns, const N: usize> SharedColumns for [C; N] {
    fn width(&self) -> usize {
        self.iter().map(C::width).sum()
    }

    fn write<'m>(&self, message: &'m mut [u8]) -> &'m mut [u8] {
        self.iter().fold(message, |rest, column| column.write(rest))
    }

    fn read<'m>(&mut self, message: &'m [u8]) -> &'m [u8] {
        self.iter_mut().fold(message, |rest, column| column.read(rest))
    }
}

macro_rules! tuples {
    ($($name:ident $place:tt),*) => {
        impl<$($name: SharedColumns),*> SharedColumns for ($($name,)*) {
            fn width(&self) -> usize {
                [$(self.$place.width()),*].iter().sum()
            }

            fn write<'m>(&self, message: &'m mut [u8]) -> &'m mut [u8] {
                $(let message = self.$place.write(message);)*
                message
            }

            fn read<'m>(&mut self, message: &'m [u8]) -> &'m [u8] {
                $(let message = self.$place.read(message);)*
                message
            }
        }
    };
}
tuples!(A 0, B 1);
tuples!(A 0, B 1, C 2);
tuples!(A 0, B 1, C 2, E 3);

/// Part of a message with rows of `width` bytes.
///
/// Both sides cut it at the rows of the same blocks.
pub(super) struct MessageRows<'a> {
    /// The rows.
    pub bytes: &'a mut [u8],
    /// Bytes of a row.
    pub width: usize,
}

impl SplittableColumns for MessageRows<'_> {
    fn none() -> Self {
        Self { bytes: &mut [], width: 0 }
    }

    fn cut(self, row: usize) -> (Self, Self) {
        let Self { bytes, width } = self;
        let (low, high) = bytes.split_at_mut((row * width).min(bytes.len()));
        (Self { bytes: low, width }, Self { bytes: high, width })
    }
}
