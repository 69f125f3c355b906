//! Recognition of files that are often given in place of a mesh.

/// Beginnings of files with the sentence about each.
const BEGINNINGS: [(&[u8], &str); 22] = [
    (b"ISO-10303", "is a STEP file (exact CAD geometry), must be a mesh: export it from the CAD as STL"),
    (
        b"PK\x03\x04",
        "is a ZIP archive (3MF, or a compressed mesh), must be a mesh: unpack it or export as STL",
    ),
    (b"# vtk DataFile", "is a VTK file, must be STL, OBJ or PLY: convert it, for example with ParaView"),
    (b"<VTKFile", "is a VTK file, must be STL, OBJ or PLY: convert it, for example with ParaView"),
    (
        b"$MeshFormat",
        "is a gmsh file, must be STL, OBJ or PLY: export the surface with `gmsh -2 -format stl`",
    ),
    (b"<?xml", "is an XML file (AMF, COLLADA, VTK or X3D), must be STL, OBJ or PLY: export it as STL"),
    (b"<!DOCTYPE", "is a web page, must be a mesh: the download may have failed, get the file itself"),
    (b"<html", "is a web page, must be a mesh: the download may have failed, get the file itself"),
    (b"glTF", "is a binary glTF file, must be STL, OBJ or PLY: export it as STL"),
    (b"DBRep_DrawableShape", "is a BREP file (exact CAD geometry), must be a mesh: export it as STL"),
    (b"CASCADE Topology", "is a BREP file (exact CAD geometry), must be a mesh: export it as STL"),
    (b"Kaydara FBX", "is an FBX file, must be STL, OBJ or PLY: export it as STL"),
    (b"\x89HDF", "is an HDF5 file (CGNS, MED or XDMF data), must be a mesh: export its surface as STL"),
    (b"\x1f\x8b", "is compressed with gzip, must be a mesh: unpack it with `gunzip`"),
    (b"7z\xbc\xaf", "is a 7-Zip archive, must be a mesh: unpack it"),
    (b"BZh9", "is compressed with bzip2, must be a mesh: unpack it with `bunzip2`"),
    (
        b"\xd0\xcf\x11\xe0",
        "is a document of a CAD program (SolidWorks or similar), must be a mesh: export as STL",
    ),
    (b"version https://git-lfs", "is a Git LFS pointer, must be the mesh itself: run `git lfs pull`"),
    (b"\xff\xfe", "is text in UTF-16, must be ASCII or UTF-8: save it in another encoding"),
    (b"\xfe\xff", "is text in UTF-16, must be ASCII or UTF-8: save it in another encoding"),
    (b"%PDF", "is a PDF document, must be a mesh: export the CAD model as STL"),
    (b"OFF", "is an OFF file, must be STL, OBJ or PLY: convert it, for example with MeshLab"),
];

/// Columns of an IGES line; the 73rd has the letter of the section.
const IGES_COLUMNS: usize = 73;

/// Returns the sentence about a file of a known other format; None for any other.
pub(super) fn recognise(bytes: &[u8]) -> Option<&'static str> {
    let text = bytes.trim_ascii_start();
    let begins = |beginning: &[u8]| {
        text.get(..beginning.len()).is_some_and(|found| found.eq_ignore_ascii_case(beginning))
    };
    if let Some((_, message)) = BEGINNINGS.iter().find(|(beginning, _)| begins(beginning)) {
        return Some(message);
    }
    let is_iges = bytes.get(IGES_COLUMNS - 1) == Some(&b'S')
        && bytes.get(IGES_COLUMNS..IGES_COLUMNS + 7).is_some_and(|number| number.trim_ascii() == b"1")
        && bytes[..IGES_COLUMNS].iter().all(|byte| (b' '..=b'~').contains(byte));
    is_iges.then_some("is an IGES file (exact CAD geometry), must be a mesh: export it from the CAD as STL")
}
