//! Studies of supple: what accuracy costs, and what stiff and extreme cases do.
//!
//! * [`Study`]: a scene at fixed physical stiffness and damping, over lattice resolution, half-width, steps, volume
//!   corrections and the naive sums. Each point has its run time per frame and its errors; the best are marked.
//! * [`SumsStudy`]: the summation alone.
//! * [`stability`]: stiff and extreme cases, each against a bound.
//!
//! The library prints nothing: an [`Observer`] is told of the progress.

mod error;
mod machine;
mod observer;
mod output;
mod scene;
pub mod stability;
mod sums;
mod timing;

pub use error::StudyError;
pub use machine::Machine;
pub use observer::{Observer, Outcome, Progress};
pub use scene::{Axis, Distances, Errors, Free, Front, Path, Point, Report, Study};
pub use sums::{SumsError, SumsReport, SumsRow, SumsStudy};
pub use timing::{Sample, Spread, Timing};
