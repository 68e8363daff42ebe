//! Writes and reads checkpoints, from which a run resumes. A checkpoint is a file in the directory of the
//! frames, with a checksum. A damaged file is rejected.

use std::io::Write;
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::error::RunError;
use super::fingerprint::{difference, fnv1a};
use crate::file::write_atomically;
use supple::SimulationState;

/// Name of the checkpoint file, which is in the directory of the frames.
pub const CHECKPOINT: &str = "supple.checkpoint";

/// First bytes of every checkpoint file.
const MAGIC: [u8; 8] = *b"SUPPLECK";
/// Version of the format; files of other versions are rejected.
const VERSION: u32 = 4;
/// Size of the header, in bytes: magic, version, length and checksum.
const HEADER: usize = 8 + 4 + 8 + 8;

/// The state of a run after a frame.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Checkpoint {
    /// Fingerprint of the scene. Only a run with the same fingerprint can resume from this checkpoint.
    pub(super) fingerprint: String,
    /// SIMD level of the run that wrote the checkpoint.
    pub(super) level: String,
    /// Last completed frame, from 0.
    pub(super) frame: u32,
    /// State of the simulation: all data on which the next step depends.
    pub(super) state: SimulationState,
}

impl Checkpoint {
    /// Writes the checkpoint to a directory, and replaces an existing checkpoint.
    pub(super) fn write(&self, directory: &Path) -> Result<(), RunError> {
        write(&path(directory), self)
    }

    /// Reads the checkpoint of a directory; `None` if there is no checkpoint. Returns an error if its
    /// fingerprint is not `fingerprint`.
    pub(super) fn read(directory: &Path, fingerprint: &str) -> Result<Option<Self>, RunError> {
        let path = path(directory);
        let Some(checkpoint) = read::<Self>(&path)? else { return Ok(None) };
        match difference(&checkpoint.fingerprint, fingerprint) {
            None => Ok(Some(checkpoint)),
            Some(difference) => Err(RunError::Differs { path, difference }),
        }
    }

    /// Removes the checkpoint of a directory, if there is one.
    pub(super) fn remove(directory: &Path) -> Result<(), RunError> {
        let path = path(directory);
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                Err(RunError::io("remove", &path, error))
            }
            _ => Ok(()),
        }
    }
}

fn path(directory: &Path) -> PathBuf {
    directory.join(CHECKPOINT)
}

/// Writes the header and the encoded value to a file.
fn write<T: Serialize>(path: &Path, value: &T) -> Result<(), RunError> {
    let save = |file: &mut std::fs::File| {
        let payload = postcard::to_stdvec(value)
            .map_err(|error| std::io::Error::other(format!("cannot encode: {error}")))?;
        file.write_all(&MAGIC)?;
        file.write_all(&VERSION.to_le_bytes())?;
        file.write_all(&(payload.len() as u64).to_le_bytes())?;
        file.write_all(&fnv1a(&payload).to_le_bytes())?;
        file.write_all(&payload)
    };
    write_atomically(path, save).map_err(|source| RunError::io("write", path, source))
}

/// Reads the value of a file and checks the header. Returns `None` if there is no file.
fn read<T: DeserializeOwned>(path: &Path) -> Result<Option<T>, RunError> {
    let bytes = match std::fs::read(path) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(source) => return Err(RunError::io("read", path, source)),
    };
    let damaged = |problem: &str| RunError::Checkpoint { path: path.to_owned(), what: problem.to_owned() };
    if bytes.len() < HEADER || bytes[..8] != MAGIC {
        return Err(damaged("it is not a checkpoint of supple, or is incomplete"));
    }
    // Little endian.
    let number = |range: std::ops::Range<usize>| {
        bytes[range].iter().rev().fold(0_u64, |number, &byte| number << 8 | u64::from(byte))
    };
    let version = number(8..12);
    if version != u64::from(VERSION) {
        return Err(damaged(&format!("its format is version {version}, this program reads {VERSION}")));
    }
    let payload = &bytes[HEADER..];
    if payload.len() as u64 != number(12..20) {
        let expected = number(12..20);
        return Err(damaged(&format!("its data has {} bytes instead of {expected}", payload.len())));
    }
    if fnv1a(payload) != number(20..28) {
        return Err(damaged("its checksum does not match"));
    }
    postcard::from_bytes(payload)
        .map(Some)
        .map_err(|error| damaged(&format!("its data cannot be decoded: {error}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truncation_and_bit_flips_at_any_byte_are_detected() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("supple.checkpoint");
        assert!(read::<Vec<f32>>(&path).unwrap().is_none());
        let value = vec![1.0_f32, -2.5, f32::NAN];
        write(&path, &value).unwrap();
        let back: Vec<f32> = read(&path).unwrap().unwrap();
        assert!(back.iter().zip(&value).all(|(a, b)| a.to_bits() == b.to_bits()));

        let whole = std::fs::read(&path).unwrap();
        for length in 0..whole.len() {
            std::fs::write(&path, &whole[..length]).unwrap();
            assert!(matches!(read::<Vec<f32>>(&path), Err(RunError::Checkpoint { .. })), "{length}");
        }
        for at in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[at] ^= 0x20;
            std::fs::write(&path, &bytes).unwrap();
            assert!(matches!(read::<Vec<f32>>(&path), Err(RunError::Checkpoint { .. })), "{at}");
        }
    }
}
