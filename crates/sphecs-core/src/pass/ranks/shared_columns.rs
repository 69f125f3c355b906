//! Output columns as rows of a message.

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

    /// Writes the rows into a message whose rows are `stride` bytes long, each from byte `at` on.
    fn write(&self, message: &mut [u8], stride: usize, at: usize);

    /// Reads the rows that [`Self::write`] wrote.
    fn read(&mut self, message: &[u8], stride: usize, at: usize);
}

impl<T: OutputNumber> SharedColumns for &mut [T] {
    fn width(&self) -> usize {
        if T::IS_SENT && !self.is_empty() { size_of::<T>() } else { 0 }
    }

    fn write(&self, message: &mut [u8], stride: usize, at: usize) {
        if self.width() > 0 {
            for (value, row) in self.iter().zip(message.chunks_exact_mut(stride)) {
                row[at..at + size_of::<T>()].copy_from_slice(bytemuck::bytes_of(value));
            }
        }
    }

    fn read(&mut self, message: &[u8], stride: usize, at: usize) {
        if self.width() > 0 {
            for (value, row) in self.iter_mut().zip(message.chunks_exact(stride)) {
                *value = bytemuck::pod_read_unaligned(&row[at..at + size_of::<T>()]);
            }
        }
    }
}

impl<C: SharedColumns, const N: usize> SharedColumns for [C; N] {
    fn width(&self) -> usize {
        self.iter().map(C::width).sum()
    }

    fn write(&self, message: &mut [u8], stride: usize, mut at: usize) {
        for column in self {
            column.write(message, stride, at);
            at += column.width();
        }
    }

    fn read(&mut self, message: &[u8], stride: usize, mut at: usize) {
        for column in self {
            column.read(message, stride, at);
            at += column.width();
        }
    }
}

macro_rules! tuples {
    ($($name:ident $place:tt),*) => {
        impl<$($name: SharedColumns),*> SharedColumns for ($($name,)*) {
            fn width(&self) -> usize {
                [$(self.$place.width()),*].iter().sum()
            }

            fn write(&self, message: &mut [u8], stride: usize, at: usize) {
                let mut next = at;
                $(
                    self.$place.write(message, stride, next);
                    next += self.$place.width();
                )*
                debug_assert!(next <= stride, "a row of columns is as long as a row of the message");
            }

            fn read(&mut self, message: &[u8], stride: usize, at: usize) {
                let mut next = at;
                $(
                    self.$place.read(message, stride, next);
                    next += self.$place.width();
                )*
                debug_assert!(next <= stride, "a row of columns is as long as a row of the message");
            }
        }
    };
}
tuples!(A 0, B 1);
tuples!(A 0, B 1, C 2);
tuples!(A 0, B 1, C 2, E 3);

/// Rows of a message that a rank sends.
pub(super) struct MessageRows<'a> {
    /// The rows, each `stride` bytes long.
    pub bytes: &'a mut [u8],
    /// Bytes of a row, > 0.
    pub stride: usize,
}

impl SplittableColumns for MessageRows<'_> {
    fn none() -> Self {
        Self { bytes: &mut [], stride: 1 }
    }

    fn cut(self, row: usize) -> (Self, Self) {
        let Self { bytes, stride } = self;
        let (low, high) = bytes.split_at_mut((row * stride).min(bytes.len()));
        (Self { bytes: low, stride }, Self { bytes: high, stride })
    }
}
