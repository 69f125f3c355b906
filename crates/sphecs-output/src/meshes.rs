//! Files of meshes and outlines in the run folder, `meshes/`: each under its number and name.

use std::fs;
use std::path::Path;

use sha2::{Digest, Sha256};

use super::disk;
use super::error::OutputError;
use super::header::{Header, hexadecimal};
use super::paths::MESHES;
use sphecs_scene::meshes::MeshFile;

/// Returns the SHA-256 of a mesh file, hexadecimal.
pub(crate) fn hash_of(mesh: &MeshFile) -> String {
    hexadecimal(&Sha256::digest(&mesh.bytes))
}

/// Returns the name of the file of a mesh in a run folder.
fn file_name(index: usize, path: &str) -> String {
    let name = path.rsplit(['/', '\\']).next().unwrap_or_default();
    format!("{index}-{name}")
}

/// Writes the mesh files of a run, if it has any.
///
/// # Errors
/// [`OutputError::Io`] when a write fails.
pub(crate) fn write(run: &Path, header: &Header) -> Result<(), OutputError> {
    if header.meshes.is_empty() {
        return Ok(());
    }
    let folder = run.join(MESHES);
    fs::create_dir_all(&folder).map_err(OutputError::io(&folder, "make the folder"))?;
    for (index, mesh) in header.meshes.iter().enumerate() {
        disk::write_whole(&folder.join(file_name(index, &mesh.path)), &mesh.bytes)?;
    }
    Ok(())
}

/// Returns the mesh files of a run.
///
/// # Errors
/// [`OutputError`] when one cannot be read or was changed.
pub(crate) fn read(run: &Path, header: &Header) -> Result<Vec<MeshFile>, OutputError> {
    let read = |(index, (path, hash)): (usize, &(String, String))| {
        let file = run.join(MESHES).join(file_name(index, path));
        let bytes = fs::read(&file).map_err(OutputError::io(&file, "read"))?;
        let mesh = MeshFile { path: path.clone(), bytes: bytes.into() };
        if hash_of(&mesh) == *hash {
            Ok(mesh)
        } else {
            Err(OutputError::Damaged { path: file, what: "was changed after the run started".to_owned() })
        }
    };
    header.mesh_hashes.iter().enumerate().map(read).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_return_unchanged_or_not_at_all() {
        let folder = tempfile::tempdir().expect("a folder");
        let meshes: Vec<MeshFile> = [("cad/pipe.stl", &b"solid"[..]), ("valve/pipe.stl", b"\x00\xff")]
            .map(|(path, bytes)| MeshFile { path: path.to_owned(), bytes: bytes.into() })
            .to_vec();
        let mesh_hashes = meshes.iter().map(|mesh| (mesh.path.clone(), hash_of(mesh))).collect();
        let header = Header { meshes: meshes.clone(), mesh_hashes, ..Header::default() };
        write(folder.path(), &header).expect("written");
        assert_eq!(read(folder.path(), &header).expect("read"), meshes);
        fs::write(folder.path().join("meshes/1-pipe.stl"), b"\x00\xfe").expect("changed");
        let fault = read(folder.path(), &header).expect_err("changed").to_string();
        assert!(fault.contains("1-pipe.stl") && fault.contains("changed"), "{fault}");
    }
}
