//! Wavefront OBJ files: `v`, `f`, `g` and `o`; other statements do not concern the surface.
//!
//! A facet belongs to the last `g`, or to the last `o` where no `g` with a name follows it.
//! Indices below zero count back from the last vertex before the face.

use glam::DVec3;

use super::polygon::{check_corners, triangulate};
use super::text::{Word, Words};
use crate::facets::{Facets, GroupNames};
use crate::fault::{Fault, Place};

/// First words of lines that are used or passed over.
const STATEMENTS: [&str; 34] = [
    "v", "vn", "vt", "vp", "f", "fo", "g", "o", "s", "l", "p", "mtllib", "usemtl", "usemap", "maplib", "mg",
    "cstype", "deg", "bmat", "step", "curv", "curv2", "surf", "parm", "trim", "hole", "scrv", "sp", "end",
    "con", "bevel", "c_interp", "d_interp", "lod",
];

/// Returns true for a word that begins a line of an OBJ file.
pub(super) fn is_statement(word: &[u8]) -> bool {
    word.starts_with(b"#") || STATEMENTS.iter().any(|statement| statement.as_bytes() == word)
}

fn is_face(word: &[u8]) -> bool {
    matches!(word, b"f" | b"fo")
}

/// Reads the facets of a file.
pub(super) fn read(bytes: &[u8], file: &str) -> Result<Facets, Fault> {
    // First all vertices: a face may come before the vertices that it names.
    let (vertices, triangles) = read_vertices(bytes, file)?;
    let facets = Facets {
        vertices,
        triangles: Vec::with_capacity(triangles),
        groups: Vec::with_capacity(triangles),
        group_names: Vec::new(),
    };
    let groups = GroupNames::default();
    let words = Words::new(bytes);
    let mut reader = Reader {
        words,
        file,
        facets,
        groups,
        name: String::new(),
        group: None,
        passed: 0,
        corners: Vec::new(),
    };
    loop {
        if let Some(word) = reader.words.next_on_line() {
            reader.statement(word)?;
        }
        if !reader.words.next_line() {
            break;
        }
    }
    let mut facets = reader.facets;
    facets.group_names = reader.groups.into_names();
    Ok(facets)
}

/// Returns the vertices and the number of triangles that the faces will have.
fn read_vertices(bytes: &[u8], file: &str) -> Result<(Vec<DVec3>, usize), Fault> {
    let mut words = Words::new(bytes);
    let mut vertices = Vec::new();
    let mut triangles = 0;
    loop {
        let word = words.next_on_line();
        if word.is_some_and(|word| is_face(word.bytes)) {
            let mut corners = 0;
            while words.next_on_joined_lines().is_some() {
                corners += 1;
            }
            triangles += usize::saturating_sub(corners, 2);
        } else if let Some(word) = word.filter(|word| word.bytes == b"v") {
            let mut vertex = DVec3::ZERO;
            for axis in 0..3 {
                let Some(word) = words.next_on_joined_lines() else {
                    let message =
                        format!("has a vertex with {axis} coordinates, must have 3: export the file again");
                    return Err(Fault::new(file, word.place, message));
                };
                vertex[axis] = word.coordinate(file)?;
            }
            if vertices.len() >= u32::MAX as usize {
                return Err(Fault::new(file, word.place, "is beyond 4.29e9 vertices: reduce the mesh"));
            }
            vertices.push(vertex);
        }
        if !words.next_line() {
            return Ok((vertices, triangles));
        }
    }
}

struct Reader<'a> {
    words: Words<'a>,
    file: &'a str,
    facets: Facets,
    groups: GroupNames,
    /// Name of the group of the facets that follow, and its index once there is a facet.
    name: String,
    group: Option<u16>,
    /// Vertices before the statement.
    passed: usize,
    /// Corners of the face that is being read.
    corners: Vec<u32>,
}

impl Reader<'_> {
    fn statement(&mut self, word: Word<'_>) -> Result<(), Fault> {
        match word.bytes {
            b"v" => {
                self.passed += 1;
                while self.words.next_on_joined_lines().is_some() {}
            }
            bytes if is_face(bytes) => return self.face(word.place),
            b"g" | b"o" => {
                let name = String::from_utf8_lossy(self.words.rest_of_line()).into_owned();
                // `g` without a name or with `default` ends a group: the object continues.
                if word.bytes == b"o" || !(name.is_empty() || name == "default") {
                    self.name = name;
                    self.group = None;
                }
            }
            bytes if is_statement(bytes) => {
                while self.words.rest_of_line().ends_with(b"\\") && self.words.next_line() {}
            }
            _ => {
                let message = format!(
                    "has the statement `{}`, must be one of OBJ such as `v` or `f`: export the file again",
                    word.quoted()
                );
                return Err(Fault::new(self.file, word.place, message));
            }
        }
        Ok(())
    }

    fn face(&mut self, place: Place) -> Result<(), Fault> {
        self.corners.clear();
        while let Some(word) = self.words.next_on_joined_lines() {
            if word.bytes.starts_with(b"#") {
                break;
            }
            let corner = self.index(word)?;
            self.corners.push(corner);
        }
        check_corners(self.corners.len() as u64, self.facets.vertices.len())
            .map_err(|message| Fault::new(self.file, place, format!("has a face with {message}")))?;
        let group = match self.group {
            Some(group) => group,
            None => self.groups.index(self.name.clone()).ok_or_else(|| {
                Fault::new(self.file, place, "is beyond 65 536 groups: join groups in the CAD")
            })?,
        };
        self.group = Some(group);
        let Facets { vertices, triangles, groups, .. } = &mut self.facets;
        triangulate(&self.corners, vertices, |triangle| {
            triangles.push(triangle);
            groups.push(group);
        });
        Ok(())
    }

    /// Returns the index of the vertex that a corner `v`, `v/vt`, `v//vn` or `v/vt/vn` names.
    fn index(&self, word: Word<'_>) -> Result<u32, Fault> {
        let fault = |message: String| Err(Fault::new(self.file, word.place, message));
        let end = word.bytes.iter().position(|byte| *byte == b'/').unwrap_or(word.bytes.len());
        let text = std::str::from_utf8(&word.bytes[..end]).unwrap_or_default();
        let Ok(number) = text.parse::<i64>() else {
            let quoted = word.quoted();
            return fault(format!(
                "has `{quoted}` where the number of a vertex must be: export the file again"
            ));
        };
        let count = self.facets.vertices.len();
        let index = if number < 0 { number.checked_add(self.passed as i64) } else { number.checked_sub(1) };
        match index.and_then(|index| usize::try_from(index).ok()).filter(|index| *index < count) {
            Some(index) => Ok(index as u32),
            None if number == 0 => {
                fault("has vertex 0 in a face, numbers begin at 1: export the file again".to_owned())
            }
            None => fault(format!(
                "has vertex {number} in a face, must be within the {count} of the file: it is truncated or \
                 damaged, export it again"
            )),
        }
    }
}
