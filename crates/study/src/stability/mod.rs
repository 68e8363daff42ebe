//! Runs stiff and extreme cases, measures them, and checks them against bounds.
//!
//! | file | contents |
//! |---|---|
//! | `cases`, `bodies` | the cases, one file per family; the bodies that they use |
//! | `trial` | a simulation whose figures are measured while it runs |
//! | `case` | a case with its figures and bounds, and its result |
//! | `report` | the results of all cases as a table and as JSON |
//!
//! Each simulation uses one thread. Random numbers have fixed seeds.

mod bodies;
mod case;
mod cases;
mod report;
mod trial;

pub use case::{Bound, Case, Figures, Measure, Row};
pub use cases::cases;
pub use report::{StabilityReport, StabilityStudy};

pub use crate::suite::Suite;
