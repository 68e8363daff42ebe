//! Records the size and the hash of written frames, so that a resumed run can recognize them.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::{Xxh3Default, xxh3_64};

/// Size of the buffer for reading files, in bytes.
const BUFFER: usize = 1 << 20;

/// Size and hash of a file, or of a range of a file. The hash detects damage and edits, but not deliberate
/// collisions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Record {
    /// Number of bytes.
    pub(crate) bytes: u64,
    /// 64-bit XXH3 hash of the bytes.
    pub(crate) hash: u64,
}

impl Record {
    /// Returns the record of `bytes`.
    pub(crate) fn of(bytes: &[u8]) -> Self {
        Self { bytes: bytes.len() as u64, hash: xxh3_64(bytes) }
    }

    /// Reads `bytes` bytes of a file from offset `start` on, and returns their record. The record has fewer
    /// bytes if the file ends before.
    pub(super) fn of_range(path: &Path, start: u64, bytes: u64) -> io::Result<Self> {
        let mut file = File::open(path)?;
        file.seek(SeekFrom::Start(start))?;
        let mut range = file.take(bytes);
        let mut buffer = vec![0; BUFFER.min(bytes as usize)];
        let mut recorder = Recorder::default();
        loop {
            match range.read(&mut buffer) {
                Ok(0) => return Ok(recorder.record()),
                Ok(length) => recorder.append(&buffer[..length]),
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
    }
}

/// Returns the hash of all frames, from their records.
pub(super) fn hash_of_frames(records: &[Record]) -> u64 {
    let mut recorder = Recorder::default();
    for record in records {
        recorder.append(&record.bytes.to_le_bytes());
        recorder.append(&record.hash.to_le_bytes());
    }
    recorder.record().hash
}

/// Which properties of the files are compared with the records.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Compare {
    /// The sizes.
    Sizes,
    /// The sizes and the hashes of the contents.
    Contents,
}

/// Computes the [`Record`] of bytes that are written in pieces.
#[derive(Clone, Default)]
pub(crate) struct Recorder {
    bytes: u64,
    hasher: Xxh3Default,
}

impl Recorder {
    /// Appends the next bytes.
    pub(crate) fn append(&mut self, bytes: &[u8]) {
        self.bytes += bytes.len() as u64;
        self.hasher.update(bytes);
    }

    /// Returns the number of bytes so far.
    pub(crate) fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Returns the record of all bytes so far.
    pub(crate) fn record(&self) -> Record {
        Record { bytes: self.bytes, hash: self.hasher.digest() }
    }
}

impl std::fmt::Debug for Recorder {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.record().fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_pieces_and_ranges_of_files_have_the_same_record() {
        let bytes: Vec<u8> =
            (0..3_000_000_u32).map(|number| (number.wrapping_mul(number) >> 7) as u8).collect();
        let expected = Record::of(&bytes[5..]);
        let mut recorder = Recorder::default();
        bytes[5..].chunks(1000).for_each(|chunk| recorder.append(chunk));
        assert_eq!(recorder.record(), expected);
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), &bytes).unwrap();
        assert_eq!(Record::of_range(file.path(), 5, expected.bytes).unwrap(), expected);
        assert_eq!(Record::of_range(file.path(), 5, 1 << 30).unwrap(), expected);
        assert_ne!(Record::of_range(file.path(), 4, expected.bytes).unwrap(), expected);
    }

    /// The expected hash of no bytes is a test vector of XXH3.
    #[test]
    fn the_hash_matches_the_published_vector() {
        assert_eq!(Record::of(b""), Record { bytes: 0, hash: 0x2d06_8005_38d3_94c2 });
    }
}
