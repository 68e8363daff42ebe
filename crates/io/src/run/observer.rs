//! What looks on while a job runs: progress bars, Ctrl-C and callbacks sit outside the library.

use std::fmt;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use super::prepare::Input;
use supple::Simulation;

/// Looks on while a job runs, and may ask it to stop. `()` looks away.
pub trait Observer {
    /// The simulation is built; it is at frame 0, or at the frame of the checkpoint that the job goes on after.
    ///
    /// Whoever keeps it may look at it and change it between frames, for one in [`Observer::frame`]; while the job is
    /// at work on a frame it is locked. What is changed is in the checkpoints as far as it is in a
    /// [`SimulationState`](supple::SimulationState). `inputs` are the files of its bodies.
    fn built(&mut self, _simulation: &Arc<Mutex<Simulation>>, _inputs: &[Input]) {}

    /// The first frame is about to be simulated: frames `first` to `last` lie ahead.
    fn started(&mut self, _first: u32, _last: u32) {}

    /// A frame is done, and written if it is one that is kept.
    fn frame(&mut self, _progress: &Progress) -> Flow {
        Flow::Continue
    }

    /// Something that a user should know, but that stops nothing.
    fn note(&mut self, _note: &Note) {}
}

impl Observer for () {}

/// Whether a job goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// It goes on.
    Continue,
    /// It ends after this frame; what is written is kept, and the job can be resumed.
    Stop,
}

/// How far a job is.
#[derive(Clone, Debug, PartialEq)]
pub struct Progress {
    /// The frame that is done, counted from 0.
    pub frame: u32,
    /// The last frame.
    pub last: u32,
    /// The simulated time of the frame, s.
    pub time: f64,
    /// Wall-clock time since this run began.
    pub elapsed: Duration,
}

/// Something that a user should know.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Note {
    /// The job goes on after this frame.
    Resumed {
        /// The frame of the checkpoint.
        frame: u32,
    },
    /// Frames before the checkpoint are not there, so that the job starts from frame 0.
    StartsAgain {
        /// What was looked for.
        reason: String,
    },
    /// The checkpoint was written with other vector instructions: the last bits may differ.
    OtherLevel {
        /// Those of the checkpoint.
        before: String,
        /// Those of this machine.
        now: String,
    },
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Resumed { frame } => write!(f, "going on after frame {frame}"),
            Self::StartsAgain { reason } => write!(f, "{reason}; starting again from frame 0"),
            Self::OtherLevel { before, now } => write!(
                f,
                "the checkpoint was written with {before}, this machine uses {now}: \
                 frames may differ in their last bits from an uninterrupted run"
            ),
        }
    }
}
