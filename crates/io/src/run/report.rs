//! How a job ended, as plain data.

use std::path::PathBuf;
use std::time::Duration;

use supple::{BodyRef, VolumeReport};

/// How a job ended.
#[derive(Clone, Debug, PartialEq)]
pub struct RunReport {
    /// The folder of the frames.
    pub directory: PathBuf,
    /// Whether it is finished.
    pub outcome: Outcome,
    /// The frame after which this run went on, counted from 0; `None` if it started from frame 0.
    pub resumed_after: Option<u32>,
    /// The last frame that is done, counted from 0.
    pub last: u32,
    /// Frames that this run simulated, frame 0 included.
    pub simulated: u32,
    /// Frames that this run wrote, of all bodies together.
    pub written: u32,
    /// Steps in a frame.
    pub substeps: u32,
    /// Wall-clock time of this run, from reading the meshes on.
    pub elapsed: Duration,
    /// One for each body; none if nothing was done.
    pub bodies: Vec<BodyReport>,
}

/// Whether a job is finished.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// All its frames are there.
    Finished,
    /// It was asked to stop, and can be resumed.
    Stopped,
    /// All its frames were there before; nothing was written.
    AlreadyFinished,
}

/// What became of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyReport {
    /// Its name.
    pub name: String,
    /// Lattice vertices.
    pub lattice_vertices: usize,
    /// Its volume at the last frame.
    pub volume: VolumeReport,
}

impl BodyReport {
    pub(super) fn of(body: BodyRef<'_>) -> Self {
        Self {
            name: body.name().to_owned(),
            lattice_vertices: body.lattice().len(),
            volume: body.volume_report(),
        }
    }
}
