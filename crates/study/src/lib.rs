//! Studies of supple: error against run time, and stability in stiff and extreme cases.
//!
//! * [`Study`]: a scene at fixed physical stiffness and damping, for several lattice resolutions,
//!   half-widths, steps per frame, volume corrections and summations. Each point has its run time per frame
//!   and its errors; the points on the Pareto fronts are marked.
//! * [`SumsStudy`]: accuracy and run time of the summation alone.
//! * [`stability`]: stiff and extreme cases, each checked against bounds.
//!
//! The library prints nothing; it reports progress to an [`Observer`].

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
