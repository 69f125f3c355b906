//! Header of a PLY file: format, elements and their properties.

use super::text::{Word, Words};
use crate::fault::{Fault, Place};

/// Most elements and properties: a header has a few tens.
const MOST: usize = 1000;

/// Encoding of the values behind the header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Text,
    LittleEndian,
    BigEndian,
}

/// Type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn of(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    /// Returns the size in a binary file, bytes.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// Property of an element.
#[derive(Clone, Debug)]
pub(super) struct Property {
    pub name: Vec<u8>,
    pub scalar: Scalar,
    /// Type of the count of a list; None for a single number.
    pub list: Option<Scalar>,
}

/// Kind of rows behind the header.
#[derive(Clone, Debug)]
pub(super) struct Element {
    pub name: Vec<u8>,
    pub count: u64,
    pub properties: Vec<Property>,
}

impl Element {
    /// Returns the least number of bytes of a row: of a list, its count.
    pub(super) fn smallest_row(&self, encoding: Encoding) -> u64 {
        let size = |property: &Property| match encoding {
            // A digit and a blank.
            Encoding::Text => 2,
            _ => property.list.unwrap_or(property.scalar).size() as u64,
        };
        self.properties.iter().map(size).sum()
    }
}

/// Header of a file.
#[derive(Clone, Debug)]
pub(super) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
}

/// Returns true for a file that begins with the line `ply`.
pub(super) fn is_ply(bytes: &[u8]) -> bool {
    bytes.starts_with(b"ply") && bytes.get(3).is_none_or(u8::is_ascii_whitespace)
}

/// Reads the header and leaves `words` at the end of its last line.
pub(super) fn read(words: &mut Words<'_>, file: &str) -> Result<Header, Fault> {
    words.next_line();
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    let mut properties = 0;
    loop {
        let place = words.place();
        let fault = |message: String| Err(Fault::new(file, place, message));
        let word = words.next_on_line();
        match word.map(|word| word.bytes) {
            Some(b"format") => encoding = Some(read_encoding(words, file)?),
            Some(b"comment" | b"obj_info") | None => {}
            Some(b"element") => elements.push(read_element(words, file)?),
            Some(b"property") => {
                let property = read_property(words, file)?;
                let Some(element) = elements.last_mut() else {
                    return fault("has a `property` before any `element`: export the file again".to_owned());
                };
                element.properties.push(property);
                properties += 1;
            }
            Some(b"end_header") => break,
            Some(other) => {
                let quoted = super::text::quoted(other);
                return fault(format!(
                    "has `{quoted}` in the header, must be `element`, `property` or `end_header`: export again"
                ));
            }
        }
        if elements.len().max(properties) > MOST {
            return fault(format!("has more than {MOST} elements or properties: export the file again"));
        }
        if !words.next_line() {
            let message = "ends before `end_header`: the file is truncated, export it again";
            return Err(Fault::new(file, words.place(), message));
        }
    }
    match encoding {
        Some(encoding) => Ok(Header { encoding, elements }),
        None => Err(Fault::new(
            file,
            Place::Whole,
            "has no `format` in its header, must be `format ascii 1.0` or `format binary_little_endian 1.0`: \
             export again",
        )),
    }
}

/// Returns the next word of the line, or the fault that it is missing.
fn word<'a>(words: &mut Words<'a>, wanted: &str, file: &str) -> Result<Word<'a>, Fault> {
    words.next_on_line().ok_or_else(|| {
        let message = format!("ends where {wanted} must be: export the file again");
        Fault::new(file, words.place(), message)
    })
}

fn read_encoding(words: &mut Words<'_>, file: &str) -> Result<Encoding, Fault> {
    let word = word(words, "the format", file)?;
    match word.bytes {
        b"ascii" => Ok(Encoding::Text),
        b"binary_little_endian" => Ok(Encoding::LittleEndian),
        b"binary_big_endian" => Ok(Encoding::BigEndian),
        _ => Err(Fault::new(
            file,
            word.place,
            format!(
                "has the format `{}`, must be `ascii`, `binary_little_endian` or `binary_big_endian`: export again",
                word.quoted()
            ),
        )),
    }
}

fn read_element(words: &mut Words<'_>, file: &str) -> Result<Element, Fault> {
    let name = word(words, "the name of the element", file)?.bytes.to_vec();
    let number = word(words, "the number of rows", file)?;
    let count = std::str::from_utf8(number.bytes).ok().and_then(|text| text.parse().ok());
    let count = count.ok_or_else(|| {
        let message =
            format!("has `{}` where a number of rows must be: export the file again", number.quoted());
        Fault::new(file, number.place, message)
    })?;
    Ok(Element { name, count, properties: Vec::new() })
}

fn read_property(words: &mut Words<'_>, file: &str) -> Result<Property, Fault> {
    let first = word(words, "the type of the property", file)?;
    let list = if first.bytes == b"list" {
        let word = word(words, "the type of the count", file)?;
        Some(integer(word, file)?)
    } else {
        None
    };
    let kind = if list.is_some() { word(words, "the type of the list", file)? } else { first };
    let scalar = scalar(kind, file)?;
    let name = word(words, "the name of the property", file)?.bytes.to_vec();
    Ok(Property { name, scalar, list })
}

fn scalar(word: Word<'_>, file: &str) -> Result<Scalar, Fault> {
    Scalar::of(word.bytes).ok_or_else(|| {
        let message = format!(
            "has the type `{}`, must be char, uchar, short, ushort, int, uint, float or double: export again",
            word.quoted()
        );
        Fault::new(file, word.place, message)
    })
}

fn integer(word: Word<'_>, file: &str) -> Result<Scalar, Fault> {
    match scalar(word, file)? {
        Scalar::F32 | Scalar::F64 => {
            let message = "counts a list in floating point, must be an integer type: export the file again";
            Err(Fault::new(file, word.place, message))
        }
        scalar => Ok(scalar),
    }
}
