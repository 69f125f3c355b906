//! Facets of one mesh file as they were read: nothing is welded, dropped or turned.

use std::collections::HashMap;

use glam::DVec3;

/// Largest magnitude of a coordinate in the unit of the file: its fifth power is finite in f64.
pub(crate) const LARGEST_COORDINATE: f64 = 1e30;

/// Indexed triangles of one file, in the unit of the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Facets {
    /// Positions in the unit of the file, finite.
    pub vertices: Vec<DVec3>,
    /// Indices into `vertices`, three a triangle; counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Index into `group_names` of each triangle.
    pub groups: Vec<u16>,
    /// Names of solids, groups or objects in order of appearance; an empty name where none is
    /// given.
    pub group_names: Vec<String>,
}

impl Facets {
    /// Appends a triangle with vertices of its own, as STL files have them.
    pub(crate) fn push_triangle(&mut self, corners: [DVec3; 3], group: u16) -> Option<()> {
        let first = u32::try_from(self.vertices.len()).ok()?;
        first.checked_add(2)?;
        self.vertices.extend(corners);
        self.triangles.push([first, first + 1, first + 2]);
        self.groups.push(group);
        Some(())
    }

    /// Checks that indices are in their range and coordinates finite.
    pub(crate) fn check(&self) -> Result<(), String> {
        let (vertices, groups) = (self.vertices.len(), self.group_names.len());
        if self.groups.len() != self.triangles.len() {
            return Err(format!(
                "has {} groups for {} triangles, must have one each",
                self.groups.len(),
                self.triangles.len()
            ));
        }
        if let Some(index) = self.triangles.iter().flatten().find(|index| **index as usize >= vertices) {
            return Err(format!("has a triangle with vertex {index}, must be below {vertices}"));
        }
        if let Some(group) = self.groups.iter().find(|group| usize::from(**group) >= groups) {
            return Err(format!("has a triangle of group {group}, must be below {groups}"));
        }
        let message = self.vertices.iter().flat_map(|vertex| vertex.to_array()).find_map(coordinate_fault);
        message.map_or(Ok(()), Err)
    }
}

/// Names of groups with their indices, while a file is read.
#[derive(Debug, Default)]
pub(crate) struct GroupNames {
    names: Vec<String>,
    indices: HashMap<String, u16>,
}

impl GroupNames {
    /// Returns the index of a name, which is added if it is not known.
    ///
    /// None beyond 65 536 names.
    pub(crate) fn index(&mut self, name: String) -> Option<u16> {
        if let Some(index) = self.indices.get(&name) {
            return Some(*index);
        }
        let index = u16::try_from(self.names.len()).ok()?;
        self.names.push(name.clone());
        self.indices.insert(name, index);
        Some(index)
    }

    /// Returns the names in the order of their indices.
    pub(crate) fn into_names(self) -> Vec<String> {
        self.names
    }
}

/// Returns the sentence for a coordinate that cannot be used; None for a usable one.
pub(crate) fn coordinate_fault(value: f64) -> Option<String> {
    if value.is_nan() {
        return Some("has a coordinate that is not a number (NaN): export the file again".to_owned());
    }
    if value.is_infinite() {
        return Some("has an infinite coordinate: every coordinate must be finite, export again".to_owned());
    }
    (value.abs() > LARGEST_COORDINATE).then(|| {
        format!("has a coordinate of {value:.2e}, must be below {LARGEST_COORDINATE:.0e}: export again")
    })
}
