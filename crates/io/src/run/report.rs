//! Defines the report of a job, as plain data.

use std::path::PathBuf;
use std::time::Duration;

use super::deviation::{Crushed, Softened, UnkeptVolume};
use supple::{BodyRef, VolumeReport};

/// Report of a job.
#[derive(Clone, Debug, PartialEq)]
pub struct RunReport {
    /// Directory of the frames.
    pub directory: PathBuf,
    /// Whether the job is finished, stopped, or was finished before.
    pub outcome: Outcome,
    /// Frame after which this run resumed, from 0; `None` if it started at frame 0.
    pub resumed_after: Option<u32>,
    /// Last completed frame, from 0.
    pub last: u32,
    /// Number of frames that this run simulated, including frame 0.
    pub simulated: u32,
    /// Number of frames that this run wrote; a frame of all bodies counts once.
    pub written: u32,
    /// Steps per frame; 0 if the job was already finished.
    pub substeps: u32,
    /// Wall-clock time of this run, including the time for reading the input.
    pub elapsed: Duration,
    /// One report per body; empty if the job was already finished.
    pub bodies: Vec<BodyReport>,
    /// Lines about files that hold the frames approximately or incompletely: the error of a GLB file, and images that it
    /// cannot have.
    pub files: Vec<String>,
}

/// Outcome of a run of a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// All frames are complete.
    Finished,
    /// The observer stopped the job; it can be resumed.
    Stopped,
    /// All frames existed before this run, which wrote nothing.
    AlreadyFinished,
}

impl Outcome {
    /// Returns the name: `finished`, `stopped` or `already finished`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Finished => "finished",
            Self::Stopped => "stopped",
            Self::AlreadyFinished => "already finished",
        }
    }
}

/// Report of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyReport {
    /// Name of the body.
    pub name: String,
    /// Number of lattice vertices.
    pub lattice_vertices: usize,
    /// Volume after the last completed frame.
    pub volume: VolumeReport,
    /// The frames of this run in which the volume was not kept; `None` if it was kept in all frames, or is not
    /// preserved.
    pub unkept_volume: Option<UnkeptVolume>,
    /// The frames of this run in which the body was shown with cells inside out; `None` if there are none.
    pub crushed: Option<Crushed>,
    /// Specified and effective frequency, if the steps are too long for the `frequency` of the body;
    /// otherwise `None`.
    pub softened: Option<Softened>,
}

impl BodyReport {
    pub(super) fn new(
        body: BodyRef<'_>,
        unkept_volume: Option<UnkeptVolume>,
        crushed: Option<Crushed>,
        softened: Option<Softened>,
    ) -> Self {
        Self {
            name: body.name().to_owned(),
            lattice_vertices: body.lattice().len(),
            volume: body.volume_report(),
            unkept_volume,
            crushed,
            softened,
        }
    }
}
