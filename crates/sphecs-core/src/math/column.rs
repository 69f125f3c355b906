//! Named columns of numbers: the form in which a state is saved and restored.
//!
//! A column has one of five types, so that every number is saved in the precision in which it is
//! computed. Columns are compared and written bit by bit: `==` on numbers would equate −0 and 0,
//! and a NaN would differ from itself.

/// Numbers of one type.
#[derive(Clone, Debug)]
pub enum Column {
    /// Double precision.
    F64(Vec<f64>),
    /// Single precision.
    F32(Vec<f32>),
    /// Counts and particle numbers.
    U32(Vec<u32>),
    /// Indices of patches.
    U16(Vec<u16>),
    /// Flags, zones, and records of bytes.
    U8(Vec<u8>),
}

/// Type of the values of a column.
pub trait Element: Copy + 'static {
    /// Wraps values into a column.
    fn into_column(values: Vec<Self>) -> Column;
    /// Returns the values of a column of this type; None for a column of another type.
    fn from_column(column: Column) -> Option<Vec<Self>>;
}

macro_rules! element {
    ($type:ty, $variant:ident) => {
        impl Element for $type {
            fn into_column(values: Vec<Self>) -> Column {
                Column::$variant(values)
            }

            fn from_column(column: Column) -> Option<Vec<Self>> {
                match column {
                    Column::$variant(values) => Some(values),
                    _ => None,
                }
            }
        }
    };
}

element!(f64, F64);
element!(f32, F32);
element!(u32, U32);
element!(u16, U16);
element!(u8, U8);

/// Values converted to bytes at a time when a column is written.
const CHUNK: usize = 4096;

impl Column {
    /// Returns the number of values.
    pub fn len(&self) -> usize {
        match self {
            Column::F64(values) => values.len(),
            Column::F32(values) => values.len(),
            Column::U32(values) => values.len(),
            Column::U16(values) => values.len(),
            Column::U8(values) => values.len(),
        }
    }

    /// Returns true if there is no value.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the size of all values, bytes.
    pub fn size(&self) -> u64 {
        let width = match self {
            Column::F64(_) => size_of::<f64>(),
            Column::F32(_) => size_of::<f32>(),
            Column::U32(_) => size_of::<u32>(),
            Column::U16(_) => size_of::<u16>(),
            Column::U8(_) => size_of::<u8>(),
        };
        (self.len() * width) as u64
    }

    /// Returns the name of the type, as written to files.
    pub fn type_name(&self) -> &'static str {
        match self {
            Column::F64(_) => "f64",
            Column::F32(_) => "f32",
            Column::U32(_) => "u32",
            Column::U16(_) => "u16",
            Column::U8(_) => "u8",
        }
    }

    /// Passes the bytes of all values to `take`, little-endian, chunk by chunk.
    ///
    /// # Errors
    /// The first error of `take`.
    pub fn bytes<E>(&self, mut take: impl FnMut(&[u8]) -> Result<(), E>) -> Result<(), E> {
        let mut buffer = Vec::with_capacity(8 * CHUNK);
        macro_rules! pieces {
            ($values:expr) => {
                for values in $values.chunks(CHUNK) {
                    buffer.clear();
                    values.iter().for_each(|value| buffer.extend_from_slice(&value.to_le_bytes()));
                    take(&buffer)?;
                }
            };
        }
        match self {
            Column::F64(values) => pieces!(values),
            Column::F32(values) => pieces!(values),
            Column::U32(values) => pieces!(values),
            Column::U16(values) => pieces!(values),
            Column::U8(values) => take(values)?,
        }
        Ok(())
    }

    /// Builds a column from the name of its type and the bytes of its values.
    ///
    /// None if the type is unknown or the number of bytes is not a multiple of its size.
    pub fn from_bytes(type_name: &str, bytes: &[u8]) -> Option<Self> {
        macro_rules! values {
            ($type:ty, $variant:ident) => {{
                let (values, rest) = bytes.as_chunks::<{ size_of::<$type>() }>();
                let values = values.iter().map(|bytes| <$type>::from_le_bytes(*bytes)).collect();
                rest.is_empty().then_some(Column::$variant(values))
            }};
        }
        match type_name {
            "f64" => values!(f64, F64),
            "f32" => values!(f32, F32),
            "u32" => values!(u32, U32),
            "u16" => values!(u16, U16),
            "u8" => Some(Column::U8(bytes.to_vec())),
            _ => None,
        }
    }
}

impl PartialEq for Column {
    fn eq(&self, other: &Self) -> bool {
        let have_equal_bits = |(a, b): (&f64, &f64)| a.to_bits() == b.to_bits();
        match (self, other) {
            (Column::F64(a), Column::F64(b)) => a.len() == b.len() && a.iter().zip(b).all(have_equal_bits),
            (Column::F32(a), Column::F32(b)) => {
                a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
            }
            (Column::U32(a), Column::U32(b)) => a == b,
            (Column::U16(a), Column::U16(b)) => a == b,
            (Column::U8(a), Column::U8(b)) => a == b,
            _ => false,
        }
    }
}

/// Columns by name, in the order in which they were added.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Columns(Vec<(String, Column)>);

/// Difference between the saved columns and those that the reader expects.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct ColumnMismatch(pub String);

impl Columns {
    /// Adds values under a name.
    ///
    /// # Panics
    /// If the name is already used, as two owners would overwrite each other's state.
    pub fn put<T: Element>(&mut self, name: impl Into<String>, values: Vec<T>) {
        self.put_column(name, T::into_column(values));
    }

    /// Adds a column under a name.
    ///
    /// # Panics
    /// As [`Self::put`].
    pub fn put_column(&mut self, name: impl Into<String>, column: Column) {
        let name = name.into();
        assert!(self.0.iter().all(|(known, _)| *known != name), "two columns have the name `{name}`");
        self.0.push((name, column));
    }

    /// Removes the column of a name and returns its values.
    ///
    /// # Errors
    /// [`ColumnMismatch`] if there is no such column, or its type differs.
    pub fn take<T: Element>(&mut self, name: &str) -> Result<Vec<T>, ColumnMismatch> {
        let at = self.0.iter().position(|(known, _)| known == name);
        let at = at.ok_or_else(|| ColumnMismatch(format!("column `{name}` is missing")))?;
        let (_, column) = self.0.remove(at);
        let found = column.type_name();
        let expected = T::into_column(Vec::new()).type_name();
        let mismatch =
            || ColumnMismatch(format!("column `{name}` has the type {found}, must have {expected}"));
        T::from_column(column).ok_or_else(mismatch)
    }

    /// Removes the column of a name, which must have `count` values, and returns them.
    ///
    /// # Errors
    /// [`ColumnMismatch`] as for [`Self::take`], or if the number of values differs.
    pub fn take_exactly<T: Element>(&mut self, name: &str, count: usize) -> Result<Vec<T>, ColumnMismatch> {
        let values = self.take::<T>(name)?;
        match values.len() {
            found if found == count => Ok(values),
            found => Err(ColumnMismatch(format!("column `{name}` has {found} values, must have {count}"))),
        }
    }

    /// Iterates over names and columns.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Column)> {
        self.0.iter().map(|(name, column)| (name.as_str(), column))
    }

    /// Returns the size of all values, bytes.
    pub fn size(&self) -> u64 {
        self.0.iter().map(|(_, column)| column.size()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conversion_to_bytes_and_back_keeps_every_bit() {
        let columns = [
            Column::F64(vec![-0.0, f64::NAN, f64::from_bits(0x7ff0_0000_0000_0001), 1.0 / 3.0]),
            Column::F32(vec![f32::INFINITY, -0.0, f32::from_bits(0x7fc0_1234)]),
            Column::U32((0..10_000).collect()),
            Column::U16(vec![7, u16::MAX]),
            Column::U8(b"record".to_vec()),
            Column::F64(Vec::new()),
        ];
        for column in columns {
            let mut bytes = Vec::new();
            let written: Result<(), ()> = column.bytes(|chunk| {
                bytes.extend_from_slice(chunk);
                Ok(())
            });
            written.expect("the closure never fails");
            assert_eq!(Column::from_bytes(column.type_name(), &bytes).expect("whole"), column);
            if column.type_name() != "u8" && !bytes.is_empty() {
                assert_eq!(Column::from_bytes(column.type_name(), &bytes[1..]), None);
            }
        }
        assert_ne!(Column::F64(vec![0.0]), Column::F64(vec![-0.0]), "0 and −0 are different states");
    }

    #[test]
    fn mismatch_names_the_column() {
        let mut columns = Columns::default();
        columns.put("x", vec![1.0, 2.0]);
        columns.put("zone", vec![1_u8]);
        assert_eq!(columns.size(), 17);
        let message = columns.take::<u16>("zone").expect_err("another type").to_string();
        assert!(message.contains("`zone`") && message.contains("u8") && message.contains("u16"), "{message}");
        let message = columns.take_exactly::<f64>("x", 3).expect_err("too few").to_string();
        assert!(message.contains("`x` has 2 values, must have 3"), "{message}");
        assert!(columns.take::<f64>("y").expect_err("missing").to_string().contains("`y`"));
    }
}
