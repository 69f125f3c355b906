//! Files that must be refused, each with a message that says what is, what must be and what to do.

use super::shapes::{Ply, cube};
use crate::read;

fn refuse(file: &str, bytes: &[u8], wanted: &[&str]) {
    let message = match read(bytes, file) {
        Ok(facets) => panic!("{file} was read: {facets:?}, must say {wanted:?}"),
        Err(fault) => fault.to_string(),
    };
    for part in wanted {
        assert!(message.contains(part), "{message}\nmust say `{part}`");
    }
    assert!(message.starts_with(file) && message.len() < 400, "{message}");
    let length = message.split_whitespace().count();
    assert!(length >= 6 && !message.contains("NaN corners"), "{message}");
}

#[test]
fn files_without_content_are_refused() {
    refuse("a.stl", b"", &["is empty", "export"]);
    refuse("a.obj", b" \r\n\t", &["is empty"]);
    refuse("a.ply", &[0; 100], &["is empty"]);
    refuse("a.stl", b"solid a\nendsolid a\n", &["has no triangles", "closed surface"]);
    let mut none = vec![b'x'; 84];
    none[80..].fill(0);
    refuse("a.stl", &none, &["has no triangles"]);
    refuse("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\n", &["has no triangles"]);
    refuse("a.obj", b"# nothing\n", &["has no triangles"]);
}

#[test]
fn other_formats_are_recognised() {
    let iges = format!("{:72}S      1\n{:72}S      2\n", "A part", "");
    let files: [(&[u8], &str); 14] = [
        (b"ISO-10303-21;\nHEADER;\n", "STEP"),
        (b"\n iso-10303-21;", "STEP"),
        (iges.as_bytes(), "IGES"),
        (b"PK\x03\x04 3D/3dmodel.model", "3MF"),
        (b"# vtk DataFile Version 3.0\n", "VTK"),
        (b"<VTKFile type=\"PolyData\">", "VTK"),
        (b"$MeshFormat\n4.1 0 8\n", "gmsh"),
        (b"<?xml version=\"1.0\"?>\n<COLLADA>", "COLLADA"),
        (b"<!DOCTYPE html><html>", "web page"),
        (b"\x1f\x8b\x08\0\0\0\0\0", "gunzip"),
        (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "CAD program"),
        (b"version https://git-lfs.github.com/spec/v1\noid", "git lfs pull"),
        (b"\xff\xfes\0o\0l\0i\0d\0", "UTF-16"),
        (b"OFF\n8 6 0\n", "OFF"),
    ];
    for (bytes, word) in files {
        for file in ["part.stl", "part.obj", "part.ply"] {
            refuse(file, bytes, &[word]);
        }
    }
    refuse("notes.txt", b"hello world, this is no mesh\n", &["not a mesh", "STL, OBJ or PLY"]);
    refuse("a.ply", b"plyformat ascii 1.0\n", &["does not begin with the line `ply`"]);
    refuse("a.obj", b"v 0 0 0\n\0\0\0", &["not text", "OBJ"]);
    refuse("a.obj", b"\x01\0\x02", &["not text", "OBJ"]);
}

#[test]
fn damaged_binary_stl_is_refused() {
    let bytes = cube().binary_stl();
    refuse("a.stl", "pipe, wall\n".repeat(40).as_bytes(), &["begins with `pipe,`", "`solid`"]);
    refuse("a.stl", &bytes[..400], &["byte 400", "says 12 facets", "684 bytes", "has 400", "truncated"]);
    refuse("a.stl", &b"made by a CAD program"[..], &["byte 21", "21 bytes long", "at least 84", "truncated"]);
    refuse("a.stl", &[&bytes[..], b"end"].concat(), &["has 687", "3 bytes follow the last facet"]);
    let mut huge = bytes.clone();
    huge[80..84].fill(0xff);
    refuse("a.stl", &huge, &["says 4294967295 facets", "214748364834 bytes", "has 684"]);
    let with = |facet: usize, value: f32| {
        let mut bytes = bytes.clone();
        let at = 84 + 50 * (facet - 1) + 16;
        bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
        bytes
    };
    refuse("a.stl", &with(9, f32::NAN), &["facet 9", "not a number", "export"]);
    refuse("a.stl", &with(12, f32::NEG_INFINITY), &["facet 12", "infinite"]);
    refuse("a.stl", &with(1, 3e38), &["facet 1", "3.00e38", "must be below 1e30"]);
    let mut solid = bytes[..300].to_vec();
    solid[..6].copy_from_slice(b"solid ");
    refuse("a.stl", &solid, &["says 12 facets", "truncated"]);
}

#[test]
fn damaged_text_stl_is_refused() {
    let text = cube().text_stl("cube");
    let bytes = text.as_bytes();
    let first = "facet normal 0 0 0\n    outer loop\n      vertex 0 0 0\n";
    let with = |from: &str, to: &str| text.replacen(from, to, 1).into_bytes();
    refuse("a.stl", &bytes[..bytes.len() - 15], &["a.stl:85:11", "`endsolid`", "truncated"]);
    refuse("a.stl", &bytes[..140], &["ends with", "`norma`", "truncated"]);
    refuse("a.stl", &with("vertex 0 1 0", "vertex 0 nan 0"), &["a.stl:5:16", "not a number"]);
    refuse("a.stl", &with("vertex 0 1 0", "vertex 0 -inf 0"), &["a.stl:5:16", "infinite"]);
    refuse("a.stl", &with("vertex 0 1 0", "vertex 0 1e999 0"), &["infinite"]);
    refuse("a.stl", &with("vertex 0 1 0", "vertex 0 1e31 0"), &["1.00e31", "below 1e30"]);
    refuse("a.stl", &with("vertex 0 1 0", "vertex 0 1,5 0"), &["`1,5`", "decimal point"]);
    refuse("a.stl", &with("vertex 0 1 0", "vertex 0 1"), &["a.stl:6:7", "`vertex`", "coordinate"]);
    refuse("a.stl", &with("endloop", "vertex 2 2 2\nendloop"), &["a.stl:7:5", "three corners"]);
    refuse("a.stl", &with("endloop", "endlop"), &["`endlop`", "`endloop` must be"]);
    refuse("a.stl", &with("endfacet", ""), &["`facet`", "`endfacet` must be"]);
    refuse("a.stl", &with("normal 0 0 0", "normal 0 0"), &["a.stl:3:5", "normal"]);
    refuse("a.stl", &with("outer loop", "loop"), &["`outer` must be"]);
    refuse("a.stl", &with(first, "facet normal 0 0 0\n"), &["`outer` must be"]);
    refuse("a.stl", &[bytes, b"more"].concat(), &["`more`", "`solid` or the end"]);
    refuse("a.stl", b"solid a\n\xff\xfe\xfd", &["a.stl:2:1", "`facet` or `endsolid`"]);
    let long = [b"solid a\n".to_vec(), vec![b'x'; 10_000]].concat();
    refuse("a.stl", &long, &["xxx…", "`facet`"]);
    let solids: String = (0..65_537).map(|at| format!("solid s{at}\nendsolid\n")).collect();
    refuse("a.stl", solids.as_bytes(), &["65 536 solids"]);
}

#[test]
fn damaged_obj_is_refused() {
    let vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let with = |line: &str| format!("{vertices}{line}\n").into_bytes();
    refuse("a.obj", &with("f 1 2 4"), &["a.obj:4:7", "vertex 4", "3 of the file"]);
    refuse("a.obj", &with("f 1 2 0"), &["a.obj:4:7", "vertex 0", "begin at 1"]);
    refuse("a.obj", &with("f 1 2 -4"), &["vertex -4", "3 of the file"]);
    refuse("a.obj", &with("f 1 2 99999999999999999999"), &["number of a vertex"]);
    refuse("a.obj", &with("f 1 2 -9223372036854775808"), &["vertex -9223372036854775808"]);
    refuse("a.obj", &with("f 1 2"), &["a.obj:4:1", "2 corners", "at least 3"]);
    refuse("a.obj", &with("f 1 2 3 1 2 3 1"), &["a.obj:4:1", "7 corners for 3 vertices"]);
    refuse("a.obj", &with("f 1 2 a"), &["`a`", "number of a vertex"]);
    refuse("a.obj", &with("f 1 2 /3"), &["`/3`", "number of a vertex"]);
    refuse("a.obj", &with("v 1 2"), &["a.obj:4:1", "2 coordinates", "must have 3"]);
    refuse("a.obj", &with("v 1 2 nan"), &["a.obj:4:7", "not a number"]);
    refuse("a.obj", &with("v 1 2 1e40"), &["1.00e40", "below 1e30"]);
    refuse("a.obj", &with("v 1 2 0x10"), &["`0x10`", "coordinate"]);
    refuse("a.obj", &with("vertex 1 2 3"), &["a.obj:4:1", "`vertex`", "statement"]);
    let groups: String = (0..65_537).map(|at| format!("g g{at}\nf 1 2 3\n")).collect();
    refuse("a.obj", &with(&groups), &["65 536 groups"]);
}

#[test]
fn damaged_ply_headers_are_refused() {
    let text = String::from_utf8_lossy(&cube().ply(Ply::Text)).into_owned();
    let with = |from: &str, to: &str| text.replacen(from, to, 1).into_bytes();
    refuse("a.ply", b"ply\n", &["ends before `end_header`", "truncated"]);
    refuse("a.ply", &with("end_header", "comment"), &["in the header", "`end_header`"]);
    refuse("a.ply", &with("format ascii 1.0\n", ""), &["no `format`", "ascii"]);
    refuse("a.ply", &with("ascii", "utf8"), &["a.ply:2:8", "`utf8`", "binary_big_endian"]);
    refuse("a.ply", &with("uchar red", "half red"), &["`half`", "uchar"]);
    refuse("a.ply", &with("list uchar", "list float"), &["floating point", "integer type"]);
    refuse("a.ply", &with("vertex 8", "vertex many"), &["`many`", "number of rows"]);
    refuse("a.ply", &with("vertex 8", "vertex -8"), &["`-8`", "number of rows"]);
    refuse("a.ply", &with("element vertex 8\n", ""), &["element", "vertex"]);
    refuse("a.ply", &with("double y", "double Y"), &["x, y and z"]);
    refuse("a.ply", &with("vertex_indices", "corners"), &["`vertex_indices`"]);
    refuse("a.ply", &with("face 12", "face 0"), &["no faces", "point cloud"]);
    refuse("a.ply", &with("element material 2\n", ""), &["before any `element`"]);
    refuse("a.ply", &with("property uchar red", "property"), &["type of the property"]);
    let many = "property float w\n".repeat(2000);
    refuse("a.ply", &with("property uchar red\n", &many), &["more than 1000"]);
}

#[test]
fn damaged_ply_values_are_refused() {
    let text = String::from_utf8_lossy(&cube().ply(Ply::Text)).into_owned();
    let with = |from: &str, to: &str| text.replacen(from, to, 1).into_bytes();
    refuse("a.ply", &with("vertex 8", "vertex 800000"), &["says 800000 rows of `vertex`", "truncated"]);
    refuse("a.ply", &with("face 12", "face 18446744073709551615"), &["says 18446744073709551615 rows"]);
    refuse("a.ply", &with("vertex 8", "vertex 9"), &["must"]);
    refuse("a.ply", &with(" 0 9 0 0 ", " 0 9 zero 0 "), &["`zero`", "number must be"]);
    refuse("a.ply", &with(" 0 9 0 0 ", " 0 9 nan 0 "), &["vertex 1", "not a number"]);
    refuse("a.ply", &with("3 0 2 3 1", "3 0 2 8 1"), &["face 1 has vertex 8", "below 8"]);
    refuse("a.ply", &with("3 0 2 3 1", "3 0 -2 3 1"), &["face 1 has vertex -2"]);
    refuse("a.ply", &with("3 0 2 3 1", "3 0 2.5 3 1"), &["face 1 has vertex 2.5"]);
    refuse("a.ply", &with("3 0 2 3 1", "2 0 2 1"), &["face 1 has 2 corners"]);
    refuse("a.ply", &with("3 0 2 3 1", "-1 0 2 1"), &["list of -1 numbers"]);
    refuse("a.ply", &[text.as_bytes(), b"5"].concat(), &["`5` behind the last row"]);
    refuse("a.ply", &text.as_bytes()[..text.len() - 4], &["ends where a number must be", "truncated"]);
    let binary = cube().ply(Ply::Big);
    let length = binary.len();
    refuse("a.ply", &binary[..length - 1], &["byte", "needs 2 bytes", "has 1", "truncated"]);
    refuse("a.ply", &[&binary[..], &[1; 8]].concat(), &["8 bytes behind the last row"]);
    let mut list = binary.clone();
    list[length - 12 * 15] = 255;
    refuse("a.ply", &list, &["list of 255 numbers"]);
}
