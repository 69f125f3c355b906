//! Readers of mesh files: STL (binary and text), OBJ and PLY.
//!
//! The content decides on the format, then the extension. The readers are our own: `stl_io` 0.11
//! silently loses the second solid of a file and takes ` solid` for binary; `tobj` 4 and
//! `ply-rs-bw` 4 give no line, column or byte of a fault.
//!
//! No count in a file is believed before it fits the size of the file, so that memory stays
//! proportional to the bytes read.

mod foreign;
mod stl;
mod text;

use crate::facets::Facets;
use crate::fault::{Fault, Place};

/// First words of a line of an OBJ file.
const OBJ_WORDS: [&str; 14] =
    ["v", "vn", "vt", "vp", "f", "g", "o", "s", "l", "p", "mtllib", "usemtl", "mg", "shadow_obj"];

/// Reads the facets of an STL, OBJ or PLY file.
///
/// `file` is the name of the file: its extension decides where the content does not, and faults
/// carry it.
///
/// # Errors
/// A [`Fault`] with its place if the file is empty, truncated, of another format, or has values
/// that are not finite numbers or indices of its vertices.
pub fn read(bytes: &[u8], file: &str) -> Result<Facets, Fault> {
    let whole = |message: &str| Err(Fault::new(file, Place::Whole, message));
    if bytes.iter().all(|byte| byte.is_ascii_whitespace() || *byte == 0) {
        return whole("is empty, must hold triangles: export the surface again");
    }
    if let Some(message) = foreign::recognise(bytes) {
        return whole(message);
    }
    let extension = file.rsplit_once('.').map(|(_, end)| end.to_ascii_lowercase()).unwrap_or_default();
    let first = text::first_word(bytes).to_ascii_lowercase();
    let is_text = !bytes.contains(&0);
    let facets = if stl::is_binary(bytes) {
        stl::read_binary(bytes, file)
    } else if first == b"solid" && is_text {
        stl::read_text(bytes, file)
    } else if extension == "stl" {
        stl::read_binary(bytes, file)
    } else {
        return whole("is not a mesh that can be read, must be STL, OBJ or PLY: export it as one of these");
    }?;
    if facets.triangles.is_empty() {
        return whole("has no triangles, must hold a closed surface: export the surface again");
    }
    Ok(facets)
}
