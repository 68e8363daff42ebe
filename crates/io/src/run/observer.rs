//! Defines the callbacks of a running job. Callers use them for progress bars, Ctrl-C and user callbacks.

use std::fmt;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use super::caution::Caution;
use super::error::RunError;
use super::prepare::{Input, Prepared, prepare};
use crate::escape::Escaped;
use crate::scene::Scene;
use supple::Simulation;

/// Receives the events of a running job and can stop it. `()` ignores all events.
pub trait Observer {
    /// Builds the simulation of a job, with [`prepare`]. An implementation can run it in another thread and give up
    /// waiting for it.
    ///
    /// # Errors
    ///
    /// Those of [`prepare`], and [`RunError::Stopped`], which stops the job before it writes anything.
    fn prepare(&mut self, scene: &Scene) -> Result<Prepared, RunError> {
        prepare(scene)
    }

    /// Called when the simulation is built. Its state is that of frame 0, or of the checkpoint that the job
    /// resumes from.
    ///
    /// An implementation may keep the simulation, and read and change it between frames, for example in
    /// [`Observer::frame`]. The simulation is locked while the job computes a frame. A checkpoint contains
    /// only those changes that are part of a [`SimulationState`](supple::SimulationState). `inputs` has the
    /// input of each body.
    fn built(&mut self, _simulation: &Arc<Mutex<Simulation>>, _inputs: &[Input]) {}

    /// Called after each frame of the pre-roll, before the files of an earlier run are removed. `done`: the share of the
    /// pre-roll that is simulated, above 0 to 1. The return value decides whether the job continues; otherwise it fails
    /// with [`RunError::Stopped`].
    fn preroll(&mut self, _done: f64) -> Flow {
        Flow::Continue
    }

    /// Called before the first frame of this run. Frames `first` to `last` follow, counted from 0.
    fn started(&mut self, _first: u32, _last: u32) {}

    /// Called after each frame. The frame has been written if [`Job::every`](super::Job::every) includes it.
    /// The return value decides whether the job continues.
    fn frame(&mut self, _progress: &Progress) -> Flow {
        Flow::Continue
    }

    /// Called with information for the user that does not stop the job.
    fn note(&mut self, _note: &Note) {}
}

impl Observer for () {}

/// Whether a job continues or stops.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// The job continues.
    Continue,
    /// The job ends after this frame. The written frames are kept, and the job can be resumed.
    Stop,
}

/// Progress of a job.
#[derive(Clone, Debug, PartialEq)]
pub struct Progress {
    /// Completed frame, from 0.
    pub frame: u32,
    /// Last frame of the job, from 0.
    pub last: u32,
    /// Simulated time of the frame, s.
    pub time: f64,
    /// Wall-clock time since the first frame of this run started.
    pub elapsed: Duration,
}

/// Information for the user that does not stop a job.
#[derive(Clone, Debug, PartialEq)]
pub enum Note {
    /// The job resumes after this frame.
    Resumed {
        /// Frame of the checkpoint, from 0.
        frame: u32,
    },
    /// The earlier run cannot be continued, so the job starts at frame 0: frames before the checkpoint are missing, or,
    /// with [`Resume::Auto`](super::Resume::Auto), the checkpoint does not fit the job.
    Restarted {
        /// Problem, such as a missing file or a changed setting.
        reason: String,
    },
    /// What the author of the scene probably does not expect.
    Caution(Caution),
}

impl Note {
    /// Returns the message of a job with this [`Job::start_frame`](super::Job::start_frame). Its frames have
    /// the numbers of the file names.
    pub fn message(&self, start_frame: u32) -> String {
        match self {
            Self::Resumed { frame } => {
                format!("resuming after frame {}", u64::from(start_frame) + u64::from(*frame))
            }
            Self::Restarted { reason } => {
                format!("{}; starting again from frame {start_frame}", Escaped(reason))
            }
            Self::Caution(caution) => caution.to_string(),
        }
    }
}

/// The message of a job that starts with number 0.
impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message(0))
    }
}
