//! What a run needs to go on, beside its frames: a file that holds one value whole or is refused.

use std::io::Write;
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::error::RunError;
use super::fingerprint::{difference, fnv1a};
use crate::file::write_whole;
use supple::SimulationState;

/// The name of the checkpoint in the folder of the frames.
pub const CHECKPOINT: &str = "supple.checkpoint";

/// Says what the file is.
const MAGIC: [u8; 8] = *b"SUPPLECK";
/// Counts the changes of what a checkpoint holds; older files are refused.
const VERSION: u32 = 3;
/// Magic, version, length and checksum.
const HEADER: usize = 8 + 4 + 8 + 8;

/// The state of a run after a frame.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Checkpoint {
    /// What the run must share with one that goes on from here.
    pub(super) fingerprint: String,
    /// The vector instructions that were used.
    pub(super) level: String,
    /// The frame that was done, counted from 0.
    pub(super) frame: u32,
    /// Everything that the next step depends on.
    pub(super) state: SimulationState,
}

impl Checkpoint {
    /// Writes the checkpoint of a folder over the one that is there.
    pub(super) fn write(&self, folder: &Path) -> Result<(), RunError> {
        write(&path(folder), self)
    }

    /// Reads the checkpoint of a folder, if there is one, and checks that it is of this motion.
    pub(super) fn read(folder: &Path, fingerprint: &str) -> Result<Option<Self>, RunError> {
        let path = path(folder);
        let Some(checkpoint) = read::<Self>(&path)? else { return Ok(None) };
        match difference(&checkpoint.fingerprint, fingerprint) {
            None => Ok(Some(checkpoint)),
            Some(difference) => Err(RunError::Differs { path, difference }),
        }
    }

    /// Removes the checkpoint of a folder, if there is one: its frames are about to be replaced.
    pub(super) fn remove(folder: &Path) -> Result<(), RunError> {
        let path = path(folder);
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                Err(RunError::io("remove", &path, error))
            }
            _ => Ok(()),
        }
    }
}

fn path(folder: &Path) -> PathBuf {
    folder.join(CHECKPOINT)
}

/// Writes a header, a length, a checksum and a value.
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
    write_whole(path, save).map_err(|source| RunError::io("write", path, source))
}

/// Reads a value back; `None` if there is no file.
fn read<T: DeserializeOwned>(path: &Path) -> Result<Option<T>, RunError> {
    let bytes = match std::fs::read(path) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(source) => return Err(RunError::io("read", path, source)),
    };
    let damaged = |what: &str| RunError::Checkpoint { path: path.to_owned(), what: what.to_owned() };
    if bytes.len() < HEADER || bytes[..8] != MAGIC {
        return Err(damaged("it is not a checkpoint of supple, or only its beginning"));
    }
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
        return Err(damaged(&format!("it holds {} bytes of {expected}", payload.len())));
    }
    if fnv1a(payload) != number(20..28) {
        return Err(damaged("its checksum does not match"));
    }
    postcard::from_bytes(payload).map(Some).map_err(|error| damaged(&format!("it does not decode: {error}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_damaged_file_is_refused_wherever_it_is_damaged() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("supple.checkpoint");
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
