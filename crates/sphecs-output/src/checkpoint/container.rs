//! File format of a checkpoint.
//!
//! ```text
//! magic      8 bytes, "\x89sphecs\n"
//! version    u32, of this layout
//! facts      u32 length, MessagePack, u32 CRC-32
//! count      u32, number of columns
//! column     u16 length and UTF-8 of the name, u8 length and name of the type, u64 bytes,
//!            values, u32 CRC-32 of all that
//! digest     32 bytes, SHA-256 of all before it
//! ```
//!
//! Little-endian, columns in their order. The CRC of a block locates damage, the digest covers the
//! whole file. The digest ends the file in every version. So a flipped bit in the version number is
//! distinguishable from a file of another version.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use sha2::{Digest, Sha256};

use super::{Checkpoint, Facts};
use sphecs_core::math::column::{Column, Columns};
use sphecs_engine::saved_state::{decode_record, encode_record};

/// Version of the file format and of the columns of a state, raised with every change of either.
pub const VERSION: u32 = 6;

const MAGIC: [u8; 8] = *b"\x89sphecs\n";
const DIGEST: usize = 32;

/// Reason why the run cannot resume from a file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Rejection {
    /// The file differs from the one written.
    #[error("is damaged: {0}")]
    Damaged(String),
    /// The file is intact but does not belong to the run.
    #[error("{0}")]
    Foreign(String),
    /// Another version of the program wrote it.
    #[error(
        "has schema version {found}, this sphecs reads version {VERSION}: resume with the version of sphecs that wrote it"
    )]
    Version {
        /// Version of the file.
        found: u32,
    },
}

/// Writer that computes the checksums.
struct ChecksumWriter<W> {
    to: W,
    whole: Sha256,
    block: crc32fast::Hasher,
}

impl<W: Write> ChecksumWriter<W> {
    fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.block.update(bytes);
        self.whole.update(bytes);
        self.to.write_all(bytes)
    }

    /// Ends a block with its CRC-32.
    fn end_block(&mut self) -> io::Result<()> {
        let sum = std::mem::take(&mut self.block).finalize();
        self.put(&sum.to_le_bytes())?;
        self.block.reset();
        Ok(())
    }
}

/// Writes a checkpoint.
///
/// # Errors
/// The error of the system.
pub fn write(checkpoint: &Checkpoint, to: impl Write) -> io::Result<()> {
    write_version(checkpoint, VERSION, to)
}

fn write_version(checkpoint: &Checkpoint, version: u32, to: impl Write) -> io::Result<()> {
    let mut file = ChecksumWriter { to, whole: Sha256::new(), block: crc32fast::Hasher::new() };
    file.put(&MAGIC)?;
    file.put(&version.to_le_bytes())?;
    let facts = encode_record(&checkpoint.facts);
    file.put(&(facts.len() as u32).to_le_bytes())?;
    file.put(&facts)?;
    file.end_block()?;
    file.put(&(checkpoint.state.iter().count() as u32).to_le_bytes())?;
    for (name, column) in checkpoint.state.iter() {
        file.block.reset();
        file.put(&(name.len() as u16).to_le_bytes())?;
        file.put(name.as_bytes())?;
        let type_name = column.type_name();
        file.put(&[type_name.len() as u8])?;
        file.put(type_name.as_bytes())?;
        file.put(&column.size().to_le_bytes())?;
        column.bytes(|bytes| file.put(bytes))?;
        file.end_block()?;
    }
    let digest = file.whole.finalize();
    file.to.write_all(&digest)?;
    file.to.flush()
}

/// Writes the file of a checkpoint without making it durable.
///
/// # Errors
/// The error of the system.
pub(super) fn write_file(checkpoint: &Checkpoint, path: &Path) -> io::Result<()> {
    write(checkpoint, BufWriter::with_capacity(1 << 20, File::create(path)?))
}

/// Reader of consecutive bytes.
struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize, what: &str) -> Result<&'a [u8], Rejection> {
        let end = self.at.checked_add(count).filter(|end| *end <= self.bytes.len());
        let end = end.ok_or_else(|| Rejection::Damaged(format!("it ends within {what}")))?;
        let taken = &self.bytes[self.at..end];
        self.at = end;
        Ok(taken)
    }

    fn number<const N: usize>(&mut self, what: &str) -> Result<u64, Rejection> {
        let mut bytes = [0; 8];
        bytes[..N].copy_from_slice(self.take(N, what)?);
        Ok(u64::from_le_bytes(bytes))
    }

    fn text(&mut self, length: u64, what: &str) -> Result<&'a str, Rejection> {
        let bytes = self.take(length as usize, what)?;
        std::str::from_utf8(bytes).map_err(|_| Rejection::Damaged(format!("{what} is not text")))
    }

    /// Checks the CRC-32 of the block from `start` on.
    fn end_block(&mut self, start: usize, what: &str) -> Result<(), Rejection> {
        let found = crc32fast::hash(&self.bytes[start..self.at]);
        match self.number::<4>(what)? {
            sum if sum == u64::from(found) => Ok(()),
            _ => Err(Rejection::Damaged(format!("the checksum of {what} is wrong"))),
        }
    }
}

/// Returns the checkpoint in the bytes of a file.
///
/// # Errors
/// [`Rejection`] with the reason.
pub fn read(bytes: &[u8]) -> Result<Checkpoint, Rejection> {
    let damaged = |what: &str| Rejection::Damaged(what.to_owned());
    if bytes.is_empty() {
        return Err(damaged("it is empty"));
    }
    let Some(rest) = bytes.len().checked_sub(DIGEST) else {
        return Err(damaged("it is cut off"));
    };
    let (body, digest) = bytes.split_at(rest);
    let mut reader = Reader { bytes: body, at: 0 };
    if reader.take(MAGIC.len(), "its magic number")? != MAGIC {
        return Err(damaged("it does not start like a checkpoint"));
    }
    let version = reader.number::<4>("its version")? as u32;
    // The digest does not depend on the blocks, and takes a large part of the time.
    let is_intact = || Sha256::digest(body).as_slice() == digest;
    let (is_intact, checkpoint) = rayon::join(is_intact, || match version {
        VERSION => blocks(&mut reader).map(Some),
        _ => Ok(None),
    });
    match checkpoint? {
        None if is_intact => Err(Rejection::Version { found: version }),
        // The blocks locate damage; the digest also covers bytes outside them.
        Some(checkpoint) if is_intact && reader.at == body.len() => Ok(checkpoint),
        _ => Err(damaged("its digest is wrong")),
    }
}

fn blocks(reader: &mut Reader<'_>) -> Result<Checkpoint, Rejection> {
    let start = 0;
    let length = reader.number::<4>("its facts")?;
    let facts = reader.take(length as usize, "its facts")?;
    reader.end_block(start, "its facts")?;
    let facts: Facts = decode_record(facts)
        .map_err(|what| Rejection::Damaged(format!("its facts cannot be read: {what}")))?;
    let mut state = Columns::default();
    for _ in 0..reader.number::<4>("its number of columns")? {
        let start = reader.at;
        let length = reader.number::<2>("the name of a column")?;
        let name = reader.text(length, "the name of a column")?;
        let what = format!("column `{}`", name.escape_debug());
        let length = reader.number::<1>(&what)?;
        let type_name = reader.text(length, &what)?;
        let length = reader.number::<8>(&what)?;
        let length =
            usize::try_from(length).map_err(|_| Rejection::Damaged(format!("{what} is too long")))?;
        let values = reader.take(length, &what)?;
        reader.end_block(start, &what)?;
        let column = Column::from_bytes(type_name, values)
            .ok_or_else(|| Rejection::Damaged(format!("{what} has an unknown type")))?;
        if state.iter().any(|(known, _)| known == name) {
            return Err(Rejection::Damaged(format!("{what} occurs twice")));
        }
        state.put_column(name, column);
    }
    Ok(Checkpoint { facts, state })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checkpoint() -> Checkpoint {
        let mut state = Columns::default();
        state.put("arrays.position.0", vec![0.1, -0.0, f64::NAN]);
        state.put("arrays.velocity.0", vec![1.0_f32, -2.0]);
        state.put("arrays.id", vec![7_u32, 8, 9]);
        state.put("record.clock", b"\x83record".to_vec());
        let facts = Facts { scene_sha256: "ab".repeat(32), time: 0.25, step: 12, ..Facts::default() };
        Checkpoint { facts, state }
    }

    fn bytes(version: u32) -> Vec<u8> {
        let mut bytes = Vec::new();
        write_version(&checkpoint(), version, &mut bytes).expect("written to memory");
        bytes
    }

    #[test]
    fn checkpoint_reads_back_as_written() {
        assert_eq!(read(&bytes(VERSION)), Ok(checkpoint()));
    }

    #[test]
    fn every_flipped_bit_and_every_truncation_is_detected() {
        let intact = bytes(VERSION);
        for at in 0..intact.len() {
            for bit in 0..8 {
                let mut flipped = intact.clone();
                flipped[at] ^= 1 << bit;
                assert!(matches!(read(&flipped), Err(Rejection::Damaged(_))), "bit {bit} of byte {at}");
            }
            assert!(matches!(read(&intact[..at]), Err(Rejection::Damaged(_))), "cut at {at}");
        }
        let longer = [intact.clone(), vec![0]].concat();
        assert!(matches!(read(&longer), Err(Rejection::Damaged(_))));
    }

    #[test]
    fn damaged_block_is_named() {
        let intact = bytes(VERSION);
        let name = b"arrays.velocity.0";
        let at = intact.windows(name.len()).position(|window| window == name).expect("its name");
        let mut flipped = intact;
        // The name is followed by a length, a type of three letters and eight bytes of length.
        flipped[at + name.len() + 13] ^= 4;
        let message = read(&flipped).expect_err("damaged").to_string();
        assert!(message.contains("arrays.velocity.0") && message.contains("checksum"), "{message}");
    }

    #[test]
    fn other_version_is_named_with_ours() {
        let message = read(&bytes(VERSION + 6)).expect_err("another version").to_string();
        assert!(
            message.contains(&format!("version {}", VERSION + 6))
                && message.contains(&format!("version {VERSION}")),
            "{message}"
        );
    }
}
