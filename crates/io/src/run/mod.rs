//! Runs a scene: from scene data to frames on disk, with checkpoints.
//!
//! ```text
//! Job (Scene) -> prepare: meshes, lattices, simulation, substeps
//!             -> start: at frame 0, or after a checkpoint with the same fingerprint; under a lock
//!             -> advance: steps, frames, stats, checkpoints
//!             -> report
//! ```
//!
//! Both the command line and Python call [`Job::run`]. They implement progress bars, Ctrl-C and callbacks in
//! an [`Observer`].

mod advance;
mod checkpoint;
mod error;
mod fingerprint;
mod job;
mod lock;
mod observer;
mod prepare;
mod report;
mod start;
mod stats;
pub mod substeps;

pub use checkpoint::CHECKPOINT;
pub use error::RunError;
pub use fingerprint::{difference, fingerprint};
pub use job::Job;
pub use lock::LOCK;
pub use observer::{Flow, Note, Observer, Progress};
pub use prepare::{Input, Prepared, prepare};
pub use report::{BodyReport, Outcome, RunReport};
pub use stats::Row;
