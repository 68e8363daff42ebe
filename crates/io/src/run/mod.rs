//! Runs a scene: simulates it, and writes frames, statistics and checkpoints.
//!
//! ```text
//! Job with its Scene -> resume: choose frame 0, or the frame after a checkpoint with the same settings and
//!                       intact frames
//!                    -> continuation: or the frame after a kept state, with the changes that a state can take
//!                    -> prepare: read the meshes, build the simulation, choose the steps per frame
//!                    -> start: lock the output directory, simulate the pre-roll, open the files
//!                    -> advance: step in the pace of the time scale, write frames, statistics and checkpoints
//!                    -> manifest: list the files
//!                    -> report
//! ```
//!
//! The command line and the Python module both call [`Job::run`]. Progress bars, Ctrl-C and Python callbacks
//! are implementations of [`Observer`].

mod advance;
mod animations;
mod caution;
mod changes;
mod checkpoint;
mod continuation;
mod deviation;
mod error;
mod fingerprint;
mod flush;
mod job;
mod lock;
mod manifest;
mod observer;
mod output;
mod overlap;
mod pace;
mod prepare;
mod preroll;
mod recording;
mod report;
mod resume;
mod settings;
mod start;
mod states;
mod stats;

pub use caution::Caution;
pub use checkpoint::{CHECKPOINT, CHECKPOINT_VERSION};
pub use deviation::{Crushed, Softened, UnkeptVolume, VOLUME_THRESHOLD, VolumeRemedy};
pub use error::RunError;
pub use fingerprint::{difference, fingerprint};
pub use job::{Job, PAGE, Resume};
pub use lock::LOCK;
pub use manifest::MANIFEST;
pub use observer::{Flow, Note, Observer, Progress};
pub use overlap::Overlap;
pub use prepare::{Input, Prepared, colliders, prepare};
pub use preroll::preroll;
pub use recording::{Recording, RecordingOptions};
pub use report::{BodyReport, Outcome, RunReport};
pub use stats::Row;
