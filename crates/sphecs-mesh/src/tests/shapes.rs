//! Surfaces with known area and volume, and their files.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::{Facets, Part, Report, Surface};

/// Vertices, and triangles counter-clockwise seen from outside.
#[derive(Clone)]
pub(super) struct Shape {
    pub vertices: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
}

impl Shape {
    pub(super) fn surface(&self) -> Surface {
        Surface::from_triangles(self.vertices.clone(), self.triangles.clone()).unwrap()
    }

    pub(super) fn facets(&self) -> Facets {
        Facets {
            vertices: self.vertices.clone(),
            triangles: self.triangles.clone(),
            groups: vec![0; self.triangles.len()],
            group_names: vec![String::new()],
        }
    }

    pub(super) fn repaired(&self) -> (Surface, Report) {
        Surface::new(vec![Part { name: "part".to_owned(), facets: self.facets() }], 1.0).unwrap()
    }

    pub(super) fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|vertex| self.vertices[vertex as usize])
    }

    pub(super) fn moved(mut self, by: DVec3) -> Self {
        self.vertices.iter_mut().for_each(|vertex| *vertex += by);
        self
    }

    pub(super) fn scaled(mut self, factor: DVec3) -> Self {
        self.vertices.iter_mut().for_each(|vertex| *vertex *= factor);
        self
    }

    pub(super) fn turned(mut self) -> Self {
        self.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        self
    }

    pub(super) fn with(mut self, other: &Shape) -> Self {
        let first = self.vertices.len() as u32;
        self.vertices.extend(&other.vertices);
        self.triangles.extend(other.triangles.iter().map(|triangle| triangle.map(|v| v + first)));
        self
    }

    /// Returns the shape as a binary STL file.
    pub(super) fn binary_stl(&self) -> Vec<u8> {
        let mut bytes = vec![b'x'; 80];
        bytes.extend((self.triangles.len() as u32).to_le_bytes());
        for triangle in 0..self.triangles.len() {
            bytes.extend([0; 12]);
            for x in self.corners(triangle).iter().flat_map(|corner| corner.to_array()) {
                bytes.extend((x as f32).to_le_bytes());
            }
            bytes.extend([0; 2]);
        }
        bytes
    }

    /// Returns the shape as one solid of a text STL file.
    pub(super) fn text_stl(&self, name: &str) -> String {
        let mut text = format!("solid {name}\n");
        for triangle in 0..self.triangles.len() {
            text.push_str("  facet normal 0 0 0\n    outer loop\n");
            for [x, y, z] in self.corners(triangle).map(|corner| corner.to_array()) {
                text.push_str(&format!("      vertex {x} {y} {z}\n"));
            }
            text.push_str("    endloop\n  endfacet\n");
        }
        text + &format!("endsolid {name}\n")
    }
}

/// Encoding of a PLY file.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Ply {
    Text,
    Little,
    Big,
}

impl Shape {
    /// Returns the shape as an OBJ file.
    pub(super) fn obj(&self) -> String {
        let mut text = String::from("# a comment\no part\n");
        for vertex in &self.vertices {
            text.push_str(&format!("v {} {} {}\n", vertex.x, vertex.y, vertex.z));
        }
        for [a, b, c] in &self.triangles {
            text.push_str(&format!("f {} {} {}\n", a + 1, b + 1, c + 1));
        }
        text
    }

    /// Returns the shape as a PLY file with elements and properties that are not used.
    pub(super) fn ply(&self, encoding: Ply) -> Vec<u8> {
        let format = match encoding {
            Ply::Text => "ascii",
            Ply::Little => "binary_little_endian",
            Ply::Big => "binary_big_endian",
        };
        let mut bytes = format!(
            "ply\nformat {format} 1.0\ncomment caf\u{e9}\nelement material 2\nproperty uchar red\n\
             property list uchar short uv\nelement vertex {}\nproperty double x\nproperty uchar quality\n\
             property double y\nproperty double z\nelement face {}\nproperty list uchar int vertex_indices\n\
             property ushort flags\nend_header\n",
            self.vertices.len(),
            self.triangles.len()
        )
        .into_bytes();
        let mut put = |value: f64, size: usize| {
            let raw = match size {
                8 => value.to_le_bytes().to_vec(),
                size => (value as i32).to_le_bytes()[..size].to_vec(),
            };
            match encoding {
                Ply::Text => bytes.extend(format!("{value} ").bytes()),
                Ply::Little => bytes.extend(raw),
                Ply::Big => bytes.extend(raw.iter().rev()),
            }
        };
        for _ in 0..2 {
            [(7.0, 1), (2.0, 1), (-3.0, 2), (4.0, 2)].iter().for_each(|(value, size)| put(*value, *size));
        }
        for vertex in &self.vertices {
            for (value, size) in [(vertex.x, 8), (9.0, 1), (vertex.y, 8), (vertex.z, 8)] {
                put(value, size);
            }
        }
        for triangle in &self.triangles {
            put(3.0, 1);
            triangle.iter().for_each(|vertex| put(f64::from(*vertex), 4));
            put(1.0, 2);
        }
        bytes
    }
}

/// Cuboid from the origin to a corner, in m.
pub(super) fn bar(size: DVec3) -> Shape {
    let vertex = |i: usize| DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64) * size;
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Shape {
        vertices: (0..8).map(vertex).collect(),
        triangles: quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect(),
    }
}

pub(super) fn cube() -> Shape {
    bar(DVec3::ONE)
}

/// Unit sphere of 2n meridians and n parallels: 4 n (n − 1) triangles.
pub(super) fn sphere(n: u32) -> Shape {
    let mut vertices = vec![DVec3::Z, -DVec3::Z];
    for j in 1..n {
        for i in 0..2 * n {
            let (theta, phi) = (PI * f64::from(j) / f64::from(n), PI * f64::from(i) / f64::from(n));
            vertices.push(DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()));
        }
    }
    let at = |i: u32, j: u32| 2 + (j - 1) * 2 * n + i % (2 * n);
    let mut triangles = Vec::new();
    for i in 0..2 * n {
        triangles.push([0, at(i, 1), at(i + 1, 1)]);
        triangles.push([1, at(i + 1, n - 1), at(i, n - 1)]);
        for j in 1..n - 1 {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            triangles.extend([[a, c, b], [a, d, c]]);
        }
    }
    Shape { vertices, triangles }
}

/// Gear: a prism with teeth, whose flat ends are fans around the axis.
pub(super) fn gear(teeth: u32) -> Shape {
    let count = 4 * teeth;
    let mut vertices = vec![DVec3::ZERO, DVec3::new(0.0, 0.0, 0.3)];
    for i in 0..count {
        let radius = if i % 4 < 2 { 1.0 } else { 0.8 };
        let phi = TAU * f64::from(i) / f64::from(count);
        for z in [0.0, 0.3] {
            vertices.push(DVec3::new(radius * phi.cos(), radius * phi.sin(), z));
        }
    }
    let at = |i: u32, top: u32| 2 + 2 * (i % count) + top;
    let mut triangles = Vec::new();
    for i in 0..count {
        triangles.push([0, at(i + 1, 0), at(i, 0)]);
        triangles.push([1, at(i, 1), at(i + 1, 1)]);
        triangles.push([at(i, 0), at(i + 1, 0), at(i + 1, 1)]);
        triangles.push([at(i, 0), at(i + 1, 1), at(i, 1)]);
    }
    Shape { vertices, triangles }
}

/// Pseudorandom numbers in [0, 1).
pub(super) struct Random(pub u64);

impl Random {
    pub(super) fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(super) fn vector(&mut self) -> DVec3 {
        DVec3::new(self.unit(), self.unit(), self.unit())
    }
}
