//! STL files: binary, and text with any number of solids, whose names are the groups.
//!
//! A file is binary if its length is 84 + 50 n bytes for the n in bytes 80 to 83, whatever its
//! header says: some CAD programs begin the header of binary files with `solid`.

use glam::DVec3;

use super::text::{Word, Words};
use crate::facets::{Facets, GroupNames, coordinate_fault};
use crate::fault::{Fault, Place};

/// Bytes before the first facet of a binary file: a header of 80 and the count.
const HEAD: usize = 84;
/// Bytes of a facet: normal and three corners in f32, and a number of two bytes.
const FACET: usize = 50;

/// Returns the number of facets that a binary file says it has; None below 84 bytes.
fn declared(bytes: &[u8]) -> Option<u64> {
    let count = bytes.get(HEAD - 4..HEAD)?;
    Some(u64::from(u32::from_le_bytes([count[0], count[1], count[2], count[3]])))
}

/// Returns true if the length of a file is that of a binary STL file with its number of facets.
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    declared(bytes).is_some_and(|count| bytes.len() as u64 == HEAD as u64 + FACET as u64 * count)
}

/// Reads a binary file.
pub(super) fn read_binary(bytes: &[u8], file: &str) -> Result<Facets, Fault> {
    check_length(bytes, file)?;
    let count = (bytes.len() - HEAD) / FACET;
    let mut facets = Facets {
        vertices: Vec::with_capacity(3 * count),
        triangles: Vec::with_capacity(count),
        groups: Vec::with_capacity(count),
        group_names: vec![String::new()],
    };
    for (index, facet) in bytes[HEAD..].chunks_exact(FACET).enumerate() {
        let number = |at: usize| {
            let at = 12 + 4 * at;
            f64::from(f32::from_le_bytes([facet[at], facet[at + 1], facet[at + 2], facet[at + 3]]))
        };
        let corner = |corner: usize| DVec3::from_array([0, 1, 2].map(|axis| number(3 * corner + axis)));
        let fault = |message: String| Fault::new(file, Place::Facet(index as u64 + 1), message);
        if let Some(message) = (0..9).find_map(|at| coordinate_fault(number(at))) {
            return Err(fault(message));
        }
        let pushed = facets.push_triangle([corner(0), corner(1), corner(2)], 0);
        pushed.ok_or_else(|| fault(TOO_MANY_VERTICES.to_owned()))?;
    }
    Ok(facets)
}

const TOO_MANY_VERTICES: &str = "is beyond 4.29e9 vertices: reduce the mesh";

/// Checks that the length of a binary file is that of the facets it says it has.
fn check_length(bytes: &[u8], file: &str) -> Result<(), Fault> {
    let length = bytes.len() as u64;
    let end = Place::Byte(length);
    let Some(count) = declared(bytes) else {
        let message = format!(
            "is {length} bytes long and does not begin with `solid`; a binary STL file has at least \
             {HEAD}: it is truncated or another format, export it again"
        );
        return Err(Fault::new(file, end, message));
    };
    let needed = HEAD as u64 + FACET as u64 * count;
    let message = match length.cmp(&needed) {
        std::cmp::Ordering::Equal => return Ok(()),
        std::cmp::Ordering::Less => format!(
            "says {count} facets, which need {needed} bytes, and has {length}: it is truncated or not an STL \
             file, copy or export it again"
        ),
        std::cmp::Ordering::Greater => format!(
            "says {count} facets, which need {needed} bytes, and has {length}: {} bytes follow the last \
             facet, export it again",
            length - needed
        ),
    };
    Err(Fault::new(file, end, message))
}

/// Reads a text file with all its solids.
pub(super) fn read_text(bytes: &[u8], file: &str) -> Result<Facets, Fault> {
    let mut reader = TextReader { words: Words::new(bytes), file };
    let mut facets = Facets::default();
    let mut groups = GroupNames::default();
    while let Some(word) = reader.words.next() {
        if !word.is("solid") {
            return Err(reader.unexpected(Some(word), "`solid` or the end of the file"));
        }
        reader.solid(word, &mut facets, &mut groups)?;
    }
    facets.group_names = groups.into_names();
    Ok(facets)
}

struct TextReader<'a> {
    words: Words<'a>,
    file: &'a str,
}

impl<'a> TextReader<'a> {
    /// Reads a solid behind its first word, up to and with `endsolid`.
    fn solid(&mut self, start: Word<'a>, facets: &mut Facets, groups: &mut GroupNames) -> Result<(), Fault> {
        let name = String::from_utf8_lossy(self.words.rest_of_line_before(["facet", "normal"])).into_owned();
        let group = groups.index(name).ok_or_else(|| {
            Fault::new(self.file, start.place, "is beyond 65 536 solids: join solids in the CAD")
        })?;
        loop {
            let word = self.words.next();
            match word {
                Some(word) if word.is("facet") => {
                    let corners = self.facet()?;
                    let pushed = facets.push_triangle(corners, group);
                    pushed.ok_or_else(|| Fault::new(self.file, word.place, TOO_MANY_VERTICES))?;
                }
                Some(word) if word.is("endsolid") => {
                    self.words.rest_of_line();
                    return Ok(());
                }
                Some(word) if word.is("end") => {
                    self.expect("solid")?;
                    self.words.rest_of_line();
                    return Ok(());
                }
                word => return Err(self.unexpected(word, "`facet` or `endsolid`")),
            }
        }
    }

    /// Reads a facet behind its first word. Its normal is not used: the corners have it.
    fn facet(&mut self) -> Result<[DVec3; 3], Fault> {
        self.expect("normal")?;
        for _ in 0..3 {
            let word = self.words.next();
            if word.is_none_or(|word| word.is("outer") || word.is("vertex")) {
                return Err(self.unexpected(word, "a number of the normal"));
            }
        }
        self.expect("outer")?;
        self.expect("loop")?;
        let mut corners = [DVec3::ZERO; 3];
        for corner in &mut corners {
            self.expect("vertex")?;
            for axis in 0..3 {
                let Some(word) = self.words.next() else { return Err(self.unexpected(None, "a coordinate")) };
                corner[axis] = word.coordinate(self.file)?;
            }
        }
        self.expect("endloop")?;
        self.expect("endfacet")?;
        Ok(corners)
    }

    fn expect(&mut self, keyword: &str) -> Result<(), Fault> {
        match self.words.next() {
            Some(word) if word.is(keyword) => Ok(()),
            word => Err(self.unexpected(word, &format!("`{keyword}`"))),
        }
    }

    fn unexpected(&self, word: Option<Word<'_>>, wanted: &str) -> Fault {
        let (place, message) = match word {
            None => {
                let message = format!("ends where {wanted} must be: the file is truncated, export it again");
                (self.words.place(), message)
            }
            Some(word) if word.is("vertex") => (
                word.place,
                format!(
                    "has `vertex` where {wanted} must be: a facet has three corners, export as triangles"
                ),
            ),
            Some(word) if self.words.clone().next().is_none() => (
                word.place,
                format!(
                    "ends with `{}` where {wanted} must be: the file is truncated, export it again",
                    word.quoted()
                ),
            ),
            Some(word) => {
                (word.place, format!("has `{}` where {wanted} must be: export the file again", word.quoted()))
            }
        };
        Fault::new(self.file, place, message)
    }
}
