//! Running a scene: from data to frames on disk, with checkpoints.
//!
//! ```text
//! Scene -> prepare (meshes, lattices, simulation) -> Job::run: steps, frames, statistics, checkpoints
//! ```
//!
//! Both the command line and Python call [`Job::run`]; progress bars, Ctrl-C and callbacks sit outside,
//! in an [`Observer`].

mod container;
mod error;
mod fingerprint;
mod hash;
mod lock;
mod observer;
mod sequence;
mod stats;
pub mod substeps;

pub use error::RunError;
pub use lock::LOCK;
pub use observer::{Flow, Note, Observer, Progress};
pub use sequence::Numbering;
pub use stats::Row;
