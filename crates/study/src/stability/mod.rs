//! Stiff and extreme cases: each is run, measured, and held to bounds that it states.
//!
//! ```text
//! cases (bodies, made of cells) -> trial (a simulation that is watched) -> a Row for each case -> Report
//! ```
//!
//! Each simulation has one thread, and random numbers are the same in each run.

mod bodies;
mod case;
mod cases;
mod report;
mod trial;

pub use case::{Bound, Case, Figures, Measure, Row, Suite};
pub use cases::cases;
pub use report::{StabilityReport, StabilityStudy};
