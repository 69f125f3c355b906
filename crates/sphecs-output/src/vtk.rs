//! Particles as VTK unstructured grids with a `.pvd` series for ParaView.
//!
//! Each frame becomes a file of points without reservoir particles and absent slots; the walls at
//! rest are written once, to `walls.vtu`. Arrays are compressed by zlib in blocks, as inline
//! base64: a third larger than appended raw bytes, but well-formed XML that every reader accepts.
//! The positions are f64, as in `particles.nc`. One file of all frames is [`super::vtkhdf`].

use std::fs::{self, File};
use std::io::{BufWriter, Read, Write};
use std::path::{Path, PathBuf};

use base64::engine::general_purpose::STANDARD;
use base64::write::EncoderWriter;
use rayon::iter::ParallelIterator;
use rayon::slice::ParallelSlice;

use super::disk;
use super::error::OutputError;
use super::frame::Frame;
use super::header::Header;
use super::netcdf::deflated;
use super::results::Results;

/// Files of an export.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Export {
    /// Series, to be opened in ParaView.
    pub series: PathBuf,
    /// Number of frames of an earlier, longer export that were removed.
    pub removed: usize,
}

/// Writes all frames into a folder and removes those of an earlier, longer export. Calls `done`
/// with the number of frames written and of all.
///
/// # Errors
/// [`OutputError`] when the run has no frames, or a file cannot be read or written.
pub fn export_vtu(
    results: &Results,
    folder: &Path,
    mut done: impl FnMut(usize, usize),
) -> Result<Export, OutputError> {
    if results.is_empty() {
        return Err(results.no_frames());
    }
    fs::create_dir_all(folder).map_err(OutputError::io(folder, "make the folder"))?;
    let mut series = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n",
    );
    for index in 0..results.len() {
        let frame = results.frame(index)?;
        if index == 0 {
            let walls: Vec<usize> = frame.fixed_walls().collect();
            write_grid(&folder.join("walls.vtu"), &results.header, &frame, &walls, false)?;
        }
        let name = frame_name(index);
        write_grid(&folder.join(&name), &results.header, &frame, &frame.present(), true)?;
        series += &format!("<DataSet timestep=\"{}\" part=\"0\" file=\"{name}\"/>\n", frame.time);
        done(index + 1, results.len());
    }
    series += "</Collection>\n</VTKFile>\n";
    let path = folder.join("particles.pvd");
    disk::write_whole(&path, series.as_bytes())?;
    Ok(Export { series: path, removed: remove_from(folder, results.len())? })
}

fn frame_name(index: usize) -> String {
    format!("particles-{index:05}.vtu")
}

/// Removes the frames of an earlier export from an index on and returns their number.
///
/// A file is taken for one by its name and its first lines; any other file stays.
fn remove_from(folder: &Path, first: usize) -> Result<usize, OutputError> {
    let io = |doing| OutputError::io(folder, doing);
    let mut removed = 0;
    for entry in fs::read_dir(folder).map_err(io("read"))? {
        let path = entry.map_err(io("read"))?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let index = name.strip_prefix("particles-").and_then(|name| name.strip_suffix(".vtu")?.parse().ok());
        if index.is_some_and(|index| index >= first && frame_name(index) == name) && is_exported(&path) {
            fs::remove_file(&path).map_err(OutputError::io(&path, "remove"))?;
            removed += 1;
        }
    }
    Ok(removed)
}

/// Returns true for a grid of moving particles that this module wrote.
fn is_exported(path: &Path) -> bool {
    let begins = |text: &str| {
        let mut head = vec![0; text.len()];
        File::open(path).and_then(|mut file| file.read_exact(&mut head)).is_ok() && head == text.as_bytes()
    };
    begins(HEAD) || begins(&HEAD.replace(COMPRESSOR, ""))
}

/// Attribute of compressed files, which those of earlier versions lack.
const COMPRESSOR: &str = " compressor=\"vtkZLibDataCompressor\"";

/// First lines of a grid of moving particles.
const HEAD: &str = "<?xml version=\"1.0\"?>\n\
    <VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\" \
    compressor=\"vtkZLibDataCompressor\">\n\
    <UnstructuredGrid>\n\
    <FieldData><DataArray type=\"Float64\" Name=\"TimeValue\"";

fn write_grid(
    path: &Path,
    header: &Header,
    frame: &Frame,
    slots: &[usize],
    moving: bool,
) -> Result<(), OutputError> {
    let written = File::create(disk::fresh_partial(path)).and_then(|file| {
        let mut out = BufWriter::new(file);
        grid(&mut out, header, frame, slots, moving)?;
        out.flush()
    });
    match written {
        Ok(()) => disk::commit(path),
        Err(cause) => {
            disk::discard(path);
            Err(OutputError::io(path, "write")(cause))
        }
    }
}

fn grid(
    out: &mut impl Write,
    header: &Header,
    frame: &Frame,
    slots: &[usize],
    moving: bool,
) -> std::io::Result<()> {
    let count = slots.len();
    writeln!(out, "<?xml version=\"1.0\"?>")?;
    writeln!(
        out,
        "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\"{COMPRESSOR}>"
    )?;
    writeln!(out, "<UnstructuredGrid>")?;
    if moving {
        writeln!(
            out,
            "<FieldData><DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">{}</DataArray></FieldData>",
            frame.time
        )?;
    }
    writeln!(out, "<Piece NumberOfPoints=\"{count}\" NumberOfCells=\"{count}\">")?;
    writeln!(out, "<PointData>")?;
    if moving {
        let velocity: Vec<f32> =
            slots.iter().flat_map(|&slot| [0, 1, 2].map(|axis| frame.velocity[axis][slot])).collect();
        array(out, "velocity", 3, &velocity)?;
        array(out, "density", 1, &pick(&frame.density, slots))?;
        array(out, "pressure", 1, &pick(&frame.pressure, slots))?;
        array(out, "tag", 1, &pick(&frame.tag, slots))?;
        array(out, "passage", 1, &pick(&frame.passage, slots))?;
    } else {
        array(out, "wall_part", 1, &pick(&frame.patch, slots))?;
    }
    array(out, "zone", 1, &pick(&frame.zone, slots))?;
    let ids: Vec<u32> = slots.iter().map(|&slot| slot as u32).collect();
    array(out, "particle_id", 1, &ids)?;
    for (name, value) in header.particle_constants() {
        array(out, name, 1, &vec![value; count])?;
    }
    writeln!(out, "</PointData>\n<Points>")?;
    let places: Vec<f64> =
        slots.iter().flat_map(|&slot| [0, 1, 2].map(|axis| frame.position[axis][slot])).collect();
    array(out, "Points", 3, &places)?;
    writeln!(out, "</Points>\n<Cells>")?;
    // A vertex cell per point: filters of ParaView work on cells.
    let numbers = |first: i64| (first..first + count as i64).collect::<Vec<i64>>();
    array(out, "connectivity", 1, &numbers(0))?;
    array(out, "offsets", 1, &numbers(1))?;
    array(out, "types", 1, &vec![1_u8; count])?;
    writeln!(out, "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>")
}

fn pick<T: Copy>(column: &[T], slots: &[usize]) -> Vec<T> {
    slots.iter().map(|&slot| column[slot]).collect()
}

/// Number type of VTK.
trait VtkNumber: Copy {
    const NAME: &'static str;
    fn put(self, out: &mut Vec<u8>);
}

macro_rules! vtk_number {
    ($($number:ty => $name:literal),*) => {
        $(impl VtkNumber for $number {
            const NAME: &'static str = $name;
            fn put(self, out: &mut Vec<u8>) {
                out.extend_from_slice(&self.to_le_bytes());
            }
        })*
    };
}

vtk_number!(u8 => "UInt8", u16 => "UInt16", u32 => "UInt32", i64 => "Int64", f32 => "Float32", f64 => "Float64");

/// Bytes of a block that is compressed.
const BLOCK: usize = 1 << 17;

/// Writes an array: a head as base64, then its compressed blocks as base64. The head has the number
/// of blocks, their length, that of the last one if it is shorter, else 0, and the compressed
/// lengths of all, as UInt64.
fn array<T: VtkNumber>(
    out: &mut impl Write,
    name: &str,
    components: usize,
    values: &[T],
) -> std::io::Result<()> {
    write!(
        out,
        "<DataArray type=\"{}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"binary\">",
        T::NAME
    )?;
    let mut bytes = Vec::with_capacity(size_of_val(values));
    values.iter().for_each(|value| value.put(&mut bytes));
    let blocks: Vec<Vec<u8>> = bytes.par_chunks(BLOCK).map(deflated).collect();
    let head = [blocks.len(), BLOCK, bytes.len() % BLOCK];
    let lengths = head.into_iter().chain(blocks.iter().map(Vec::len));
    let head: Vec<u8> = lengths.flat_map(|length| (length as u64).to_le_bytes()).collect();
    encode(out, &[head])?;
    encode(out, &blocks)?;
    writeln!(out, "</DataArray>")
}

/// Writes bytes as one base64 text.
fn encode(out: &mut impl Write, parts: &[Vec<u8>]) -> std::io::Result<()> {
    let mut encoder = EncoderWriter::new(out, &STANDARD);
    parts.iter().try_for_each(|part| encoder.write_all(part))?;
    encoder.finish().map(|_| ())
}

#[cfg(test)]
mod tests {
    use base64::Engine;

    use super::*;

    #[test]
    fn array_is_a_head_and_compressed_blocks() {
        let mut text = Vec::new();
        array(&mut text, "zone", 1, &vec![7_u8; BLOCK + 5]).expect("written");
        let text = String::from_utf8(text).expect("text");
        let inner = text.split(['>', '<']).nth(2).expect("the content");
        let blocks = [deflated(&vec![7; BLOCK]), deflated(&[7; 5])];
        let numbers = [2, BLOCK, 5, blocks[0].len(), blocks[1].len()];
        let head: Vec<u8> = numbers.iter().flat_map(|&number| (number as u64).to_le_bytes()).collect();
        assert_eq!(inner, STANDARD.encode(head) + &STANDARD.encode(blocks.concat()));
    }

    #[test]
    fn grids_of_earlier_versions_are_known() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("particles-00000.vtu");
        for (text, known) in [
            (HEAD.to_owned(), true),
            (HEAD.replace(COMPRESSOR, ""), true),
            (HEAD.replace("1.0", "2.0"), false),
        ] {
            fs::write(&path, text).expect("written");
            assert_eq!(is_exported(&path), known);
        }
    }

    #[test]
    fn grid_has_only_the_given_slots() {
        let mut frame = Frame::absent(4);
        frame.zone[..3].copy_from_slice(&[0, 1, 4]);
        let mut text = Vec::new();
        grid(&mut text, &Header::default(), &frame, &[0], true).expect("written");
        let text = String::from_utf8(text).expect("text");
        assert!(text.contains("NumberOfPoints=\"1\" NumberOfCells=\"1\""));
        assert!(text.starts_with(HEAD));
        assert_eq!(text.matches("<DataArray").count(), text.matches("</DataArray>").count());
    }
}
