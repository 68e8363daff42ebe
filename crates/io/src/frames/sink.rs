//! Defines [`FrameSink`], through which a run writes its frames in any format.

use std::cell::OnceCell;
use std::fmt::Debug;
use std::path::PathBuf;

use supple::{Body, Displayed, Simulation, VolumeReport};

use super::{FormatOptions, OutputError, Pieces, Record, Source};
use crate::space::FileSpace;

/// A run whose files are opened.
#[derive(Debug)]
pub(crate) struct FrameRun<'a> {
    /// Simulation of the run.
    pub(crate) simulation: &'a Simulation,
    /// Inputs, one per body.
    pub(crate) sources: Vec<Source<'a>>,
    /// Name of the run.
    pub(crate) name: String,
    /// Rate at which the files are played, in frames per second.
    pub(crate) fps: f64,
    /// Coordinates of the files.
    pub(crate) space: FileSpace,
    /// Settings of its formats.
    pub(crate) options: FormatOptions,
    /// Number of frames of an earlier run that the files keep; `None` for new files.
    pub(crate) kept: Option<u64>,
}

/// A body in a frame.
#[derive(Debug)]
pub(crate) struct BodyFrame<'a> {
    /// Number of the frame.
    pub(crate) number: u64,
    /// Positions in the coordinates of the files, one per mesh vertex.
    pub(crate) positions: &'a [[f32; 3]],
    /// Normals in the coordinates of the files, one per mesh vertex; empty if no sink of the body needs them.
    pub(crate) normals: &'a [[f32; 3]],
    /// The pieces of a broken body.
    pub(crate) pieces: Option<Pieces<'a>>,
    /// Simulated seconds per second of the frames.
    pub(crate) pace: f64,
    /// The body, in the coordinates of the simulation.
    pub(crate) body: &'a Body,
    /// The evaluated body, in the coordinates of the simulation.
    pub(crate) displayed: &'a Displayed<'a>,
    /// Volumes, in the coordinates of the simulation; empty until they are needed.
    pub(crate) volumes: OnceCell<VolumeReport>,
}

impl BodyFrame<'_> {
    /// Returns the volumes of the body. Evaluates them in the first call.
    pub(crate) fn volumes(&self) -> &VolumeReport {
        self.volumes.get_or_init(|| self.displayed.volume_report())
    }
}

/// How the frames of a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ending {
    /// After its last frame.
    Complete,
    /// Before its last frame: a later run can continue it.
    Stopped,
}

/// Writes the frames of a sequence: those of one body, or of all bodies of a run.
pub(crate) trait FrameSink: Debug + Send + Sync {
    /// Returns whether the sink uses [`BodyFrame::normals`].
    fn needs_normals(&self) -> bool {
        false
    }

    /// Adds the next body to the frame. Returns the record of the frame if it is complete, because it has one body.
    fn push_body(&mut self, body: &BodyFrame<'_>) -> Result<Option<Record>, OutputError>;

    /// Completes the frame after its last body. Returns its record unless [`FrameSink::push_body`] did.
    fn finish_frame(&mut self, _simulation: &Simulation) -> Result<Option<Record>, OutputError> {
        Ok(None)
    }

    /// Removes the bodies of a frame that is not complete.
    fn discard(&mut self) {}

    /// Returns the paths of the files that were written since the last call.
    fn take_unsynced(&mut self) -> Vec<PathBuf>;

    /// Gives the files their final form and names. Returns lines about them for the summary of the run.
    fn finish(self: Box<Self>, ending: Ending) -> Result<Vec<String>, OutputError>;
}
