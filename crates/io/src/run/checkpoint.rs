//! Writes and reads checkpoints, from which a run resumes. A checkpoint is a file in the directory of the
//! frames, with a checksum. A damaged file is rejected.

use std::io::Write;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::error::RunError;
use super::settings::Settings;
use crate::file::{self, parent, remove_if_present, sync_directory, write_durably};
use crate::frames::Record;
use supple::SimulationState;

/// Name of the checkpoint file, which is in the directory of the frames.
pub const CHECKPOINT: &str = "supple.checkpoint";

/// First bytes of every checkpoint file.
const MAGIC: [u8; 8] = *b"SUPPLECK";
/// Version of the format of checkpoints and of the states in them; other versions are rejected.
pub const CHECKPOINT_VERSION: u32 = 24;
/// Size of the header, in bytes: magic, version, length and checksum.
const HEADER: usize = 8 + 4 + 8 + 8;

/// The progress of a run after a frame: the settings of the run and the records of the files that it wrote.
/// The state of the simulation follows in the file.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Checkpoint {
    /// Settings that must be the same when the run resumes.
    pub(super) settings: Settings,
    /// Last completed frame, from 0.
    pub(super) frame: u32,
    /// Records of the written frames: one list per sequence, in the order of the frames.
    pub(super) frames: Vec<Vec<Record>>,
    /// Record of the statistics file up to the end of its rows; `None` without statistics.
    pub(super) stats: Option<Record>,
}

/// A checkpoint that was read from a file.
#[derive(Debug)]
pub(super) struct Saved {
    path: PathBuf,
    /// The checkpoint without the state.
    pub(super) checkpoint: Checkpoint,
    /// Encoded state. It is decoded after the settings are compared, because another version of the program
    /// can have another state.
    state: Vec<u8>,
}

impl Checkpoint {
    /// Writes the checkpoint and the state of the simulation to a directory, and replaces an existing
    /// checkpoint. Returns when the checkpoint is on disk.
    pub(super) fn write(&self, directory: &Path, state: &SimulationState) -> Result<(), RunError> {
        self.write_to(&path(directory), state)
    }

    /// As [`write`](Self::write), to the file `path`.
    pub(super) fn write_to(&self, path: &Path, state: &SimulationState) -> Result<(), RunError> {
        let encoded = postcard::to_stdvec(self)
            .and_then(|payload| postcard::to_extend(state, payload))
            .map_err(|error| RunError::io("encode", path, std::io::Error::other(error)))?;
        write(path, &encoded)
    }

    /// Removes the checkpoint of a directory, if there is one. Returns when the removal is on disk, so that no
    /// failure of the machine brings a checkpoint back whose frames are replaced.
    pub(super) fn remove(directory: &Path) -> Result<(), RunError> {
        let path = path(directory);
        remove_if_present(&path)
            .and_then(|was_present| if was_present { sync_directory(parent(&path)) } else { Ok(()) })
            .map_err(|error| RunError::io("remove", &path, error))
    }
}

impl Saved {
    /// Reads the checkpoint of a directory; `None` if there is no checkpoint. Returns an error if its settings
    /// are not `settings`, or if it does not have the frames of `sequences` sequences.
    pub(super) fn read(
        directory: &Path,
        settings: &Settings,
        sequences: usize,
    ) -> Result<Option<Self>, RunError> {
        let Some(saved) = Self::open(&path(directory))? else { return Ok(None) };
        if let Some(difference) = saved.checkpoint.settings.difference(settings) {
            return Err(RunError::Differs { path: saved.path, difference });
        }
        saved.checked(settings, sequences).map(Some)
    }

    /// Reads a checkpoint with any settings; `None` if there is no file.
    pub(super) fn open(path: &Path) -> Result<Option<Self>, RunError> {
        let Some(payload) = read(path)? else { return Ok(None) };
        match postcard::take_from_bytes::<Checkpoint>(&payload) {
            Ok((checkpoint, state)) => {
                Ok(Some(Self { path: path.to_owned(), checkpoint, state: state.to_vec() }))
            }
            Err(error) => Err(damaged(path, format!("its data cannot be decoded: {error}"))),
        }
    }

    /// Returns the file.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Returns an error if the checkpoint does not have the frames of `sequences` sequences.
    pub(super) fn checked(self, settings: &Settings, sequences: usize) -> Result<Self, RunError> {
        let checkpoint = &self.checkpoint;
        let frames = (checkpoint.frame / checkpoint.settings.every.max(1)) as usize + 1;
        let is_complete = checkpoint.frames.len() == sequences
            && checkpoint.frames.iter().all(|records| records.len() == frames)
            && checkpoint.stats.is_some() == settings.stats.is_some();
        if !is_complete {
            return Err(damaged(&self.path, "it does not list all frames".to_owned()));
        }
        Ok(self)
    }

    /// Decodes the state of the simulation.
    pub(super) fn state(&self) -> Result<SimulationState, RunError> {
        postcard::from_bytes(&self.state)
            .map_err(|error| damaged(&self.path, format!("its state cannot be decoded: {error}")))
    }
}

fn damaged(path: &Path, problem: String) -> RunError {
    RunError::Checkpoint { path: path.to_owned(), what: problem }
}

fn path(directory: &Path) -> PathBuf {
    directory.join(CHECKPOINT)
}

/// Writes the header and the payload to a file.
fn write(path: &Path, payload: &[u8]) -> Result<(), RunError> {
    let save = |file: &mut std::fs::File| {
        file.write_all(&MAGIC)?;
        file.write_all(&CHECKPOINT_VERSION.to_le_bytes())?;
        file.write_all(&(payload.len() as u64).to_le_bytes())?;
        file.write_all(&Record::of(payload).hash.to_le_bytes())?;
        file.write_all(payload)
    };
    write_durably(path, save).map_err(|source| RunError::io("write", path, source))
}

/// Reads the payload of a file and checks the header. Returns `None` if there is no file.
fn read(path: &Path) -> Result<Option<Vec<u8>>, RunError> {
    let mut bytes = match file::read(path, u64::MAX) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(source) => return Err(RunError::io("read", path, source)),
    };
    let damaged = |problem: &str| damaged(path, problem.to_owned());
    if bytes.len() < HEADER || bytes[..8] != MAGIC {
        return Err(damaged("it is not a checkpoint of supple, or is incomplete"));
    }
    // Little endian.
    let number = |range: std::ops::Range<usize>| {
        bytes[range].iter().rev().fold(0_u64, |number, &byte| number << 8 | u64::from(byte))
    };
    let version = number(8..12);
    if version != u64::from(CHECKPOINT_VERSION) {
        return Err(damaged(&format!(
            "its format is version {version}, this program reads {CHECKPOINT_VERSION}"
        )));
    }
    let payload = &bytes[HEADER..];
    if payload.len() as u64 != number(12..20) {
        let expected = number(12..20);
        return Err(damaged(&format!("its data has {} instead of {expected} bytes", payload.len())));
    }
    if Record::of(payload).hash != number(20..28) {
        return Err(damaged("its checksum does not match"));
    }
    Ok(Some(bytes.split_off(HEADER)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truncation_and_bit_flips_at_any_byte_are_detected() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("supple.checkpoint");
        assert!(read(&path).unwrap().is_none());
        write(&path, b"payload").unwrap();
        assert_eq!(read(&path).unwrap().unwrap(), b"payload");

        let whole = std::fs::read(&path).unwrap();
        for length in 0..whole.len() {
            std::fs::write(&path, &whole[..length]).unwrap();
            assert!(matches!(read(&path), Err(RunError::Checkpoint { .. })), "{length}");
        }
        for at in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[at] ^= 0x20;
            std::fs::write(&path, &bytes).unwrap();
            assert!(matches!(read(&path), Err(RunError::Checkpoint { .. })), "{at}");
        }
    }
}
