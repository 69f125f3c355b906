//! Named columns of numbers: the form in which a state is kept and carried.
//!
//! A column has one of five types, so that every number is kept in the precision in which it is the truth. Columns compare and
//! are written by their bits: `==` on numbers would take −0 for 0 and a NaN for something else than itself.

/// Numbers of one type.
#[derive(Clone, Debug)]
pub enum Column {
    /// Double precision.
    F64(Vec<f64>),
    /// Single precision.
    F32(Vec<f32>),
    /// Counts and numbers of particles.
    U32(Vec<u32>),
    /// Indices of patches.
    U16(Vec<u16>),
    /// Flags, zones, and records of bytes.
    U8(Vec<u8>),
}

/// A type that columns are made of.
pub trait Element: Copy + 'static {
    /// Values as a column.
    fn into_column(values: Vec<Self>) -> Column;
    /// The values of a column of this type; None of any other.
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

/// Numbers that become bytes at a time when a column is written.
const CHUNK: usize = 4096;

impl Column {
    /// Number of values.
    pub fn len(&self) -> usize {
        match self {
            Column::F64(values) => values.len(),
            Column::F32(values) => values.len(),
            Column::U32(values) => values.len(),
            Column::U16(values) => values.len(),
            Column::U8(values) => values.len(),
        }
    }

    /// Whether there is no value.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Bytes of all values.
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

    /// Name of the type, as stored.
    pub fn type_name(&self) -> &'static str {
        match self {
            Column::F64(_) => "f64",
            Column::F32(_) => "f32",
            Column::U32(_) => "u32",
            Column::U16(_) => "u16",
            Column::U8(_) => "u8",
        }
    }

    /// Hands over the bytes of all values, little-endian, in pieces.
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

    /// The column of a type's name from the bytes of its values; None if the name is unknown or the bytes are no multiple.
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
        let same_bits = |(a, b): (&f64, &f64)| a.to_bits() == b.to_bits();
        match (self, other) {
            (Column::F64(a), Column::F64(b)) => a.len() == b.len() && a.iter().zip(b).all(same_bits),
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

/// Columns by their names, in the order in which they were put.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Columns(Vec<(String, Column)>);

/// Why columns are not what their reader expects.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct ColumnMismatch(pub String);

impl Columns {
    /// Adds values under a name.
    ///
    /// # Panics
    /// If the name is taken: two owners would overwrite each other's state.
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

    /// Takes the values of a name out.
    ///
    /// # Errors
    /// [`ColumnMismatch`] if there are none, or they are of another type.
    pub fn take<T: Element>(&mut self, name: &str) -> Result<Vec<T>, ColumnMismatch> {
        let at = self.0.iter().position(|(known, _)| known == name);
        let at = at.ok_or_else(|| ColumnMismatch(format!("it has no column `{name}`")))?;
        let (_, column) = self.0.remove(at);
        let found = column.type_name();
        let expected = T::into_column(Vec::new()).type_name();
        let misfit = || ColumnMismatch(format!("its column `{name}` is of type {found}, must be {expected}"));
        T::from_column(column).ok_or_else(misfit)
    }

    /// Takes out the values of a name, of which there must be so many.
    ///
    /// # Errors
    /// [`ColumnMismatch`] as [`Self::take`], or if there are more or fewer.
    pub fn take_exactly<T: Element>(&mut self, name: &str, count: usize) -> Result<Vec<T>, ColumnMismatch> {
        let values = self.take::<T>(name)?;
        match values.len() {
            found if found == count => Ok(values),
            found => {
                Err(ColumnMismatch(format!("its column `{name}` has {found} values, must have {count}")))
            }
        }
    }

    /// The columns with their names.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Column)> {
        self.0.iter().map(|(name, column)| (name.as_str(), column))
    }

    /// Bytes of all values.
    pub fn size(&self) -> u64 {
        self.0.iter().map(|(_, column)| column.size()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_survive_the_way_to_bytes_and_back() {
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
            let written: Result<(), ()> = column.bytes(|piece| {
                bytes.extend_from_slice(piece);
                Ok(())
            });
            written.expect("nothing refuses");
            assert_eq!(Column::from_bytes(column.type_name(), &bytes).expect("whole"), column);
            if column.type_name() != "u8" && !bytes.is_empty() {
                assert_eq!(Column::from_bytes(column.type_name(), &bytes[1..]), None);
            }
        }
        assert_ne!(Column::F64(vec![0.0]), Column::F64(vec![-0.0]), "zeros of two signs are two states");
    }

    #[test]
    fn what_does_not_fit_is_named() {
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
