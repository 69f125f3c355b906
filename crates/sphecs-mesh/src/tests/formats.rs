//! Files of all formats and dialects that must be read.

use glam::DVec3;

use super::shapes::{Ply, bar, cube, gear, sphere};
use crate::{Facets, Part, Surface, read};

fn volume(facets: Facets) -> f64 {
    Surface::new(vec![Part { name: "file".to_owned(), facets }], 1.0).unwrap().0.volume()
}

#[test]
fn all_formats_give_the_same_surface() {
    let shape = gear(7);
    let exact = shape.surface().volume();
    let files = [
        ("a.stl", shape.text_stl("gear").into_bytes()),
        ("a.obj", shape.obj().into_bytes()),
        ("a.ply", shape.ply(Ply::Text)),
        ("a.ply", shape.ply(Ply::Little)),
        ("a.ply", shape.ply(Ply::Big)),
    ];
    for (name, bytes) in files {
        // Numbers are written with all digits, and the order of the triangles is the same.
        let read = read(&bytes, name).unwrap();
        assert_eq!(read.triangles.len(), shape.triangles.len(), "{name}");
        assert!((volume(read) - exact).abs() < 1e-14, "{name}");
        // The content decides where the extension is wrong.
        assert!(crate::read(&bytes, "a.dat").is_ok() && crate::read(&bytes, "a.stl").is_ok(), "{name}");
    }
    // f32 has seven digits.
    assert!((volume(read(&shape.binary_stl(), "a.stl").unwrap()) - exact).abs() < 1e-6);
}

#[test]
fn solids_are_groups() {
    let text = cube().text_stl("in let").to_uppercase() + "\n" + &cube().text_stl("out");
    let facets = read(text.as_bytes(), "two.stl").unwrap();
    assert_eq!(facets.triangles.len(), 24);
    assert_eq!(facets.group_names, ["IN LET", "out"]);
    assert_eq!(facets.groups, [[0; 12], [1; 12]].concat());
}

#[test]
fn dialects_of_text_stl_are_read() {
    let text = cube().text_stl("");
    let dialects = [
        text.replace('\n', "\r\n"),
        text.replace('\n', "\r"),
        format!("\n   {}", text.replace(' ', "\t")),
        format!("\u{feff}{text}"),
        text.replace("normal 0 0 0", "normal nan -nan(ind) 1e999"),
        text.replace('\n', " "),
        text.replace("endsolid", "end solid"),
        text.replace("solid \n", "solid facet of a cube\n"),
        text.trim_end().to_owned(),
    ];
    for dialect in dialects {
        assert_eq!(read(dialect.as_bytes(), "a.stl").map(|read| read.triangles.len()), Ok(12), "{dialect}");
    }
    let one_line = text.replace('\n', " ").replacen("solid ", "solid cube of 1 ", 1);
    assert_eq!(read(one_line.as_bytes(), "a.stl").unwrap().group_names, ["cube of 1"]);
    let latin = [b"solid caf\xe9\n".to_vec(), text.into_bytes()[7..].to_vec()].concat();
    assert_eq!(read(&latin, "a.stl").unwrap().group_names, ["caf\u{fffd}"]);
}

#[test]
fn binary_stl_may_begin_with_solid() {
    let mut bytes = cube().binary_stl();
    bytes[..28].copy_from_slice(b"solid facet normal SolidWork");
    assert_eq!(read(&bytes, "a.stl").unwrap().triangles.len(), 12);
}

#[test]
fn obj_has_groups_polygons_and_negative_indices() {
    let text = "mtllib a.mtl\nv 0 0 0\nv 1 0 0 1.0\nv 1 1 0 0.5 0.5 0.5\nv 0 1 0\nvn 0 0 1\nvt 0 0\n\
                usemtl red\no box\nf 1/1/1 2/1/1 3/1/1 4/1/1\ng lid\ns off\nf -4//1 \\\n -3//-1 -2 # comment\n\
                f 5 1 2\ng\nf 1 2 3\nv 0 0 \\\n1\nl 1 2";
    let facets = read(text.as_bytes(), "a.obj").unwrap();
    assert_eq!(facets.triangles, [[0, 1, 2], [0, 2, 3], [0, 1, 2], [4, 0, 1], [0, 1, 2]]);
    assert_eq!(facets.group_names, ["box", "lid"]);
    assert_eq!(facets.groups, [0, 0, 1, 1, 1]);
    assert_eq!(facets.vertices[4], DVec3::Z);
}

#[test]
fn ply_types_and_order_of_elements_do_not_matter() {
    let text = "ply\r\nformat ascii 1.0\r\nelement face 1\r\nproperty list uint8 uint vertex_index\r\n\
                element vertex 4\r\nproperty float32 z\r\nproperty int8 y\r\nproperty short x\r\nelement empty 9\r\n\
                end_header\r\n4 0 1 2 3\r\n0.5 0 0\r\n0.5 0 1\r\n0.5 1 1\r\n0.5 1 0";
    let facets = read(text.as_bytes(), "a.ply").unwrap();
    assert_eq!(facets.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(facets.vertices[2], DVec3::new(1.0, 1.0, 0.5));
}

#[test]
fn header_of_binary_ply_may_end_in_any_way() {
    let bytes = cube().ply(Ply::Little);
    let header = bytes.windows(11).position(|window| window == b"end_header\n").unwrap() + 11;
    let (text, rest) = (String::from_utf8_lossy(&bytes[..header]).into_owned(), &bytes[header..]);
    // The first value is 7, so no end of line; the second file has one as its first value.
    for end in ["\n", "\r\n", "\r"] {
        for first in [7, b'\n'] {
            let mut bytes = text.replace('\n', end).into_bytes();
            bytes.push(first);
            bytes.extend(&rest[1..]);
            let facets = read(&bytes, "a.ply");
            assert_eq!(facets.map(|facets| facets.triangles.len()), Ok(12), "{end:?} {first}");
        }
    }
}

#[test]
fn parts_are_closed_together_and_named() {
    let sides = |range: std::ops::Range<usize>, names: &[&str]| {
        let mut facets = cube().facets();
        facets.triangles = facets.triangles[range].to_vec();
        facets.group_names = names.iter().map(|name| (*name).to_owned()).collect();
        facets.groups = (0..facets.triangles.len()).map(|at| (at % names.len()) as u16).collect();
        facets
    };
    let part = |name: &str, facets: Facets| Part { name: name.to_owned(), facets };
    let parts = vec![
        part("in", sides(0..2, &["Mesh"])),
        part("out", sides(2..4, &["Mesh"])),
        part("wall", sides(4..12, &["in", ""])),
    ];
    let (surface, report) = Surface::new(parts, 1e-3).unwrap();
    assert!(report.is_closed(), "{:?}", report.lines());
    assert_eq!(surface.group_names(), ["in", "out", "wall:in", "wall"]);
    assert_eq!(surface.group("out"), Some(1));
    assert!((surface.group_area(1) - 1e-6).abs() < 1e-18);
    assert!((surface.volume() - 1e-9).abs() < 1e-21);
    assert_eq!(surface.bounds(), (DVec3::ZERO, DVec3::splat(1e-3)));
    let alone = Surface::new(vec![part("pipe", sides(0..12, &["lid", ""]))], 1.0).unwrap().0;
    assert_eq!(alone.group_names(), ["lid", "pipe"]);
}

/// Files of two million triangles: each is read in a time proportional to its size.
#[test]
fn large_files_are_read() {
    let shape = sphere(708);
    let count = shape.triangles.len();
    assert_eq!(read(&shape.binary_stl(), "a.stl").unwrap().triangles.len(), count);
    assert_eq!(read(shape.text_stl("a").as_bytes(), "a.stl").unwrap().triangles.len(), count);
    assert_eq!(read(shape.obj().as_bytes(), "a.obj").unwrap().triangles.len(), count);
    for encoding in [Ply::Text, Ply::Little, Ply::Big] {
        assert_eq!(read(&shape.ply(encoding), "a.ply").unwrap().triangles.len(), count);
    }
}

#[test]
fn large_surfaces_are_welded_and_repaired() {
    let shape = sphere(708);
    let facets = read(&shape.binary_stl(), "a.stl").unwrap();
    let (surface, report) = Surface::new(vec![Part { name: "a".to_owned(), facets }], 1.0).unwrap();
    assert_eq!(surface.vertices().len(), shape.vertices.len());
    assert!(report.is_closed() && report.components == 1, "{:?}", report.lines());
    assert!((surface.volume() - bar(DVec3::ONE).surface().volume() * 4.1888).abs() < 5e-5);
}
