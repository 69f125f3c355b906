//! Readers of mesh files: STL (binary and text), OBJ and PLY.
//!
//! The content decides on the format, then the extension. The readers are our own: `stl_io` 0.11
//! silently loses the second solid of a file and takes ` solid` for binary; `tobj` 4 and
//! `ply-rs-bw` 4 give no line, column or byte of a fault.
//!
//! No count in a file is believed before it fits the size of the file, so that memory stays
//! proportional to the bytes read.

mod foreign;
mod obj;
mod ply;
mod ply_header;
mod polygon;
mod stl;
mod text;

use crate::facets::Facets;
use crate::fault::{Fault, Place};

/// Bytes of a file that show whether it is text: in a binary STL file, up to the second facet.
const BEGINNING: usize = 134;

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
    let first = text::first_word(bytes);
    // A zero byte behind the beginning of a text is damage, which has a line.
    let is_text = !bytes[..bytes.len().min(BEGINNING)].contains(&0);
    let facets = if stl::is_binary(bytes) {
        stl::read_binary(bytes, file)
    } else if ply_header::is_ply(bytes) {
        ply::read(bytes, file)
    } else if extension == "ply" {
        return whole("does not begin with the line `ply`: it is damaged or another format, export it again");
    } else if is_text && first.eq_ignore_ascii_case(b"solid") {
        stl::read_text(bytes, file)
    } else if is_text && (extension == "obj" || obj::is_statement(first)) {
        obj::read(bytes, file)
    } else if extension == "obj" {
        return whole("has bytes that are not text, an OBJ file is text: it is damaged, export it again");
    } else if extension == "stl" && is_text && bytes.len() > BEGINNING {
        let message = format!(
            "begins with `{}`, a text STL file must begin with `solid`: it is damaged or another format, export \
             it again",
            text::quoted(first)
        );
        return whole(&message);
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
