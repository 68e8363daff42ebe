//! Stiff and extreme cases. Each case is run, measured and checked against its bounds.
//!
//! ```text
//! cases (bodies built from cells) -> trial (a measured simulation) -> a Row for each case -> report
//! ```
//!
//! Each simulation uses one thread. Random numbers have fixed seeds.

mod bodies;
mod case;
mod cases;
mod report;
mod trial;

pub use case::{Bound, Case, Figures, Measure, Row, Suite};
pub use cases::cases;
pub use report::{StabilityReport, StabilityStudy};
