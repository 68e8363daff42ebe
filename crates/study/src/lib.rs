//! Studies of supple: what accuracy costs.
//!
//! * [`Study`]: a scene at fixed physical stiffness and damping, over lattice resolution, half-width, steps, ways to keep
//!   the volume, and the naive sums. Each point has its run time a frame and its errors; the best are marked.
//! * [`SumsStudy`]: the summation alone.
//!
//! ```text
//! Scene -> Physical (material in lengths and seconds) -> matrix of Settings -> for each: a Point -> Report
//! ```
//!
//! The library prints nothing: whoever looks on is an [`Observer`].

#[cfg(test)]
mod block;
mod cells;
mod distance;
mod dynamics;
mod error;
mod free;
mod front;
mod look;
mod machine;
mod matrix;
mod moments;
mod motion;
mod naive;
mod observer;
mod output;
mod physical;
mod point;
mod points;
mod report;
mod setting;
pub mod stability;
mod study;
mod sums;
mod surface;
mod timing;

pub use distance::Distances;
pub use error::StudyError;
pub use free::Free;
pub use front::Front;
pub use machine::Machine;
pub use observer::{Observer, Progress};
pub use point::{Errors, Path, Point};
pub use report::Report;
pub use setting::Axis;
pub use study::{Outcome, Study};
pub use sums::{SumsError, SumsReport, SumsRow, SumsStudy};
pub use timing::{Sample, Spread, Timing};
