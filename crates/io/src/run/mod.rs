//! Running a scene: from data to frames on disk, with checkpoints.
//!
//! ```text
//! Scene -> prepare (meshes, lattices, simulation; substeps) -> Job -> start (fresh, or after a checkpoint of the
//! same fingerprint; one at a time by its lock) -> advance: steps, frames, stats, checkpoint -> report
//! ```
//!
//! Both the command line and Python call [`Job::run`]; progress bars, Ctrl-C and callbacks sit outside,
//! in an [`Observer`].

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
