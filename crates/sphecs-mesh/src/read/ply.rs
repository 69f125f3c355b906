//! PLY files: text, little-endian and big-endian.
//!
//! Used are the properties `x`, `y` and `z` of the element `vertex` and the list `vertex_indices`
//! or `vertex_index` of the element `face`, of any type. All others are passed over.

use glam::DVec3;

use super::ply_header::{self as header, Element, Encoding, Header, Scalar};
use super::polygon::{check_corners, triangulate};
use super::text::Words;
use crate::facets::{Facets, coordinate_fault};
use crate::fault::{Fault, Place};

/// Most bytes behind the last row of a binary file, all blank.
const MOST_BLANKS: usize = 4;

/// Reads the facets of a file.
pub(super) fn read(bytes: &[u8], file: &str) -> Result<Facets, Fault> {
    let mut words = Words::new(bytes);
    let header = header::read(&mut words, file)?;
    check_elements(&header, file)?;
    let mut values = Values { words, bytes, at: 0, encoding: header.encoding, file };
    values.begin();
    let mut facets = Facets { group_names: vec![String::new()], ..Facets::default() };
    // Faces may come before the vertices that they name.
    let mut faces = None;
    for element in &header.elements {
        values.check_count(element)?;
        match element.name.as_slice() {
            b"vertex" => values.vertices(element, &mut facets.vertices)?,
            b"face" if facets.vertices.is_empty() => {
                faces = Some((element, values.clone()));
                values.skip(element)?;
            }
            b"face" => values.faces(element, &mut facets)?,
            _ => values.skip(element)?,
        }
    }
    values.check_end()?;
    if let Some((element, mut values)) = faces {
        values.faces(element, &mut facets)?;
    }
    Ok(facets)
}

/// Checks that there are coordinates and corners, each once.
fn check_elements(header: &Header, file: &str) -> Result<(), Fault> {
    let fault = |message: &str| Err(Fault::new(file, Place::Whole, message));
    let of_name = |name: &'static [u8]| header.elements.iter().filter(move |element| element.name == name);
    let (vertices, faces) = (of_name(b"vertex").count(), of_name(b"face").count());
    if faces == 0 || of_name(b"face").any(|element| element.count == 0) {
        return fault(
            "has vertices and no faces, must be a surface: a point cloud cannot be used, export the surface",
        );
    }
    if vertices != 1 || faces != 1 {
        return fault("must have the elements `vertex` and `face`, each once: export the file again");
    }
    let has = |name: &[u8]| {
        let mut properties = of_name(b"vertex").flat_map(|element| &element.properties);
        properties.any(|property| property.name == name && property.list.is_none())
    };
    if !(has(b"x") && has(b"y") && has(b"z")) {
        return fault("has vertices without one of the properties x, y and z: export the file again");
    }
    let mut properties = of_name(b"face").flat_map(|element| &element.properties);
    if !properties.any(is_corners) {
        return fault("has faces without a list `vertex_indices`: export the file again");
    }
    Ok(())
}

fn is_corners(property: &header::Property) -> bool {
    property.list.is_some() && matches!(property.name.as_slice(), b"vertex_indices" | b"vertex_index")
}

/// Reads the numbers behind the header.
#[derive(Clone)]
struct Values<'a> {
    /// Position in a text file; the end of the header of a binary file.
    words: Words<'a>,
    bytes: &'a [u8],
    /// Position in a binary file.
    at: usize,
    encoding: Encoding,
    file: &'a str,
}

impl Values<'_> {
    /// Moves behind the last line of the header.
    fn begin(&mut self) {
        let end = self.words.offset();
        // `\r\n` only if the first line ends so: behind `\r` or `\n`, `\n` is a value.
        let is_pair = self.bytes.get(3..5) == Some(b"\r\n") && self.bytes.get(end..end + 2) == Some(b"\r\n");
        self.at = (end + if is_pair { 2 } else { 1 }).min(self.bytes.len());
    }

    fn place(&self) -> Place {
        match self.encoding {
            Encoding::Text => self.words.place(),
            _ => Place::Byte(self.at as u64),
        }
    }

    fn fault<T>(&self, place: Place, message: String) -> Result<T, Fault> {
        Err(Fault::new(self.file, place, message))
    }

    fn remaining(&self) -> u64 {
        let at = if self.encoding == Encoding::Text { self.words.offset() } else { self.at };
        (self.bytes.len() - at) as u64
    }

    /// Checks that the rows of an element fit into the rest of the file.
    fn check_count(&self, element: &Element) -> Result<(), Fault> {
        let row = element.smallest_row(self.encoding);
        // The last number of a text has no blank behind it.
        let has = self.remaining() + 1;
        if element.count.checked_mul(row).is_some_and(|needed| needed <= has)
            && element.count <= u64::from(u32::MAX)
        {
            return Ok(());
        }
        let message = format!(
            "says {} rows of `{}`, which need at least {} bytes, and has {}: it is truncated or damaged, export \
             it again",
            element.count,
            String::from_utf8_lossy(&element.name),
            u128::from(element.count) * u128::from(row),
            self.remaining()
        );
        self.fault(self.place(), message)
    }

    /// Reads a number of a type, with its place.
    fn number(&mut self, scalar: Scalar) -> Result<(f64, Place), Fault> {
        let place = self.place();
        if self.encoding == Encoding::Text {
            let Some(word) = self.words.next() else {
                return self.fault(place, "ends where a number must be: the file is truncated".to_owned());
            };
            let value = std::str::from_utf8(word.bytes).ok().and_then(|text| text.parse::<f64>().ok());
            return match value {
                Some(value) => Ok((value, word.place)),
                None => {
                    let quoted = word.quoted();
                    self.fault(word.place, format!("has `{quoted}` where a number must be: export again"))
                }
            };
        }
        let size = scalar.size();
        let Some(bytes) = self.bytes.get(self.at..self.at + size) else {
            let message = format!(
                "needs {size} bytes for a number and has {}: the file is truncated, copy or export it again",
                self.remaining()
            );
            return self.fault(place, message);
        };
        self.at += size;
        let mut raw = [0; 8];
        raw[..size].copy_from_slice(bytes);
        if self.encoding == Encoding::BigEndian {
            raw[..size].reverse();
        }
        Ok((decode(raw, scalar), place))
    }

    /// Reads the count of a list and checks that the list fits into the rest of the file.
    fn list_length(&mut self, count: Scalar, item: Scalar) -> Result<u64, Fault> {
        let (length, place) = self.number(count)?;
        let smallest = if self.encoding == Encoding::Text { 2 } else { item.size() as u64 };
        let most = (self.remaining() + 1) / smallest;
        if length >= 0.0 && length.fract() == 0.0 && length <= most as f64 {
            return Ok(length as u64);
        }
        let message = format!(
            "has a list of {length} numbers, the rest of the file has at most {most}: export it again"
        );
        self.fault(place, message)
    }

    /// Passes over a property.
    fn skip_property(&mut self, property: &header::Property) -> Result<(), Fault> {
        let count = match property.list {
            Some(count) => self.list_length(count, property.scalar)?,
            None => 1,
        };
        self.pass_over(count, property.scalar)
    }

    /// Passes over some numbers.
    fn pass_over(&mut self, count: u64, scalar: Scalar) -> Result<(), Fault> {
        if self.encoding != Encoding::Text && count * scalar.size() as u64 <= self.remaining() {
            self.at += count as usize * scalar.size();
            return Ok(());
        }
        for _ in 0..count {
            self.number(scalar)?;
        }
        Ok(())
    }

    /// Returns the number of triangles of the faces that follow.
    fn count_triangles(&self, element: &Element) -> Result<u64, Fault> {
        let mut ahead = self.clone();
        let mut triangles = 0;
        for _ in 0..element.count {
            for property in &element.properties {
                match property.list.filter(|_| is_corners(property)) {
                    Some(count) => {
                        let length = ahead.list_length(count, property.scalar)?;
                        triangles += length.saturating_sub(2);
                        ahead.pass_over(length, property.scalar)?;
                    }
                    None => ahead.skip_property(property)?,
                }
            }
        }
        Ok(triangles)
    }

    /// Passes over the rows of an element.
    fn skip(&mut self, element: &Element) -> Result<(), Fault> {
        // Without properties there is nothing to pass over, however many rows there are.
        if element.properties.is_empty() {
            return Ok(());
        }
        for _ in 0..element.count {
            for property in &element.properties {
                self.skip_property(property)?;
            }
        }
        Ok(())
    }

    fn vertices(&mut self, element: &Element, vertices: &mut Vec<DVec3>) -> Result<(), Fault> {
        vertices.reserve_exact(element.count as usize);
        for _ in 0..element.count {
            let mut vertex = DVec3::ZERO;
            for property in &element.properties {
                let axis = [b"x", b"y", b"z"].iter().position(|name| property.name == name.as_slice());
                match axis.filter(|_| property.list.is_none()) {
                    Some(axis) => {
                        let (value, place) = self.number(property.scalar)?;
                        if let Some(message) = coordinate_fault(value) {
                            let number = vertices.len() + 1;
                            return self.fault(place, format!("vertex {number} {message}"));
                        }
                        vertex[axis] = value;
                    }
                    None => self.skip_property(property)?,
                }
            }
            vertices.push(vertex);
        }
        Ok(())
    }

    fn faces(&mut self, element: &Element, facets: &mut Facets) -> Result<(), Fault> {
        let mut corners: Vec<u32> = Vec::new();
        let triangles = self.count_triangles(element)? as usize;
        facets.triangles.reserve_exact(triangles);
        facets.groups.reserve_exact(triangles);
        for face in 1..=element.count {
            for property in &element.properties {
                match property.list.filter(|_| is_corners(property)) {
                    Some(count) => {
                        self.corners(face, count, property.scalar, facets.vertices.len(), &mut corners)?;
                    }
                    None => self.skip_property(property)?,
                }
            }
            let Facets { vertices, triangles, groups, .. } = facets;
            triangulate(&corners, vertices, |triangle| {
                triangles.push(triangle);
                groups.push(0);
            });
        }
        Ok(())
    }

    /// Reads the corners of a face.
    fn corners(
        &mut self,
        face: u64,
        count: Scalar,
        item: Scalar,
        vertices: usize,
        corners: &mut Vec<u32>,
    ) -> Result<(), Fault> {
        corners.clear();
        let place = self.place();
        let length = self.list_length(count, item)?;
        if let Err(message) = check_corners(length, vertices) {
            return self.fault(place, format!("face {face} has {message}"));
        }
        for _ in 0..length {
            let (index, place) = self.number(item)?;
            if !(index >= 0.0 && index < vertices as f64 && index.fract() == 0.0) {
                let message = format!(
                    "face {face} has vertex {index}, must be below {vertices}: it is damaged, export it again"
                );
                return self.fault(place, message);
            }
            corners.push(index as u32);
        }
        Ok(())
    }

    /// Checks that nothing follows the last row.
    fn check_end(&mut self) -> Result<(), Fault> {
        let place = self.place();
        if self.encoding == Encoding::Text {
            return match self.words.next() {
                Some(word) => self.fault(
                    word.place,
                    format!(
                        "has `{}` behind the last row: the counts are wrong, export again",
                        word.quoted()
                    ),
                ),
                None => Ok(()),
            };
        }
        let rest = &self.bytes[self.at..];
        if rest.len() <= MOST_BLANKS && rest.iter().all(u8::is_ascii_whitespace) {
            return Ok(());
        }
        let message =
            format!("has {} bytes behind the last row: the counts are wrong, export again", rest.len());
        self.fault(place, message)
    }
}

/// Returns the number that little-endian bytes are.
fn decode(raw: [u8; 8], scalar: Scalar) -> f64 {
    let [a, b, c, d, ..] = raw;
    match scalar {
        Scalar::I8 => f64::from(a as i8),
        Scalar::U8 => f64::from(a),
        Scalar::I16 => f64::from(i16::from_le_bytes([a, b])),
        Scalar::U16 => f64::from(u16::from_le_bytes([a, b])),
        Scalar::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
        Scalar::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
        Scalar::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
        Scalar::F64 => f64::from_le_bytes(raw),
    }
}
