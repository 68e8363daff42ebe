//! What a run needs to go on, beside its frames.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::container;
use super::error::RunError;
use super::fingerprint;
use supple::SimulationState;

/// The name of the checkpoint in the folder of the frames.
pub const CHECKPOINT: &str = "supple.checkpoint";

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
        container::write(&path(folder), self)
    }

    /// Reads the checkpoint of a folder, if there is one, and checks that it is of this motion.
    pub(super) fn read(folder: &Path, fingerprint: &str) -> Result<Option<Self>, RunError> {
        let path = path(folder);
        let Some(checkpoint) = container::read::<Self>(&path)? else { return Ok(None) };
        match fingerprint::difference(&checkpoint.fingerprint, fingerprint) {
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
