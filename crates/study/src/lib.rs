//! Studies of supple: error against run time, stability in stiff and extreme cases, and materials.
//!
//! * [`Study`]: runs a scene at constant physical stiffness and damping with several lattice resolutions,
//!   half-widths, steps per frame, volume corrections and summations. A point of the study is the scene with
//!   one such setting. Run time per frame and errors are measured for each point, and the points on the
//!   Pareto fronts (no other point is both faster and more accurate) are marked.
//! * [`SumsStudy`]: measures accuracy and run time of the summation alone.
//! * [`stability`]: runs stiff and extreme cases and checks each against bounds.
//! * [`material`]: measures elasticity, damping and rest, and compares them with their laws and targets.
//!
//! The library prints nothing; it reports progress to an [`Observer`].

mod elasticity;
mod error;
mod machine;
pub mod material;
mod observer;
mod output;
mod scene;
mod shape;
pub mod stability;
mod suite;
mod sums;
mod timing;

pub use error::StudyError;
pub use machine::Machine;
pub use observer::{Observer, Outcome, Progress};
pub use scene::{Axis, Distances, Errors, Free, Front, Path, Point, Report, Study};
pub use sums::{SumsError, SumsReport, SumsRow, SumsStudy};
pub use timing::{Sample, Spread, Timing};
