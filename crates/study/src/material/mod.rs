//! Measures what a material does, and compares it with the law or the target: elasticity, damping, rest, contact and
//! the run time of resting and damped bodies.
//!
//! | file | contents |
//! |---|---|
//! | `cases` | the cases, one file per family |
//! | `bodies`, `shapes` | the bodies that they use |
//! | `theory`, `regions` | laws of bars; factors of a lattice with regions |
//! | `trace` | frequency and decay of a recorded motion |
//! | `case` | a case with its quantities, laws and targets, and its result |
//! | `report` | the results of all cases as a table and as JSON |
//!
//! Each simulation uses one thread, except for the run times, which are measured with two.

mod bodies;
mod case;
mod cases;
mod regions;
mod report;
mod shapes;
mod theory;
mod trace;

pub use case::{Case, Quantity, Row, Target};
pub use cases::cases;
pub use report::{MaterialReport, MaterialStudy};

pub use crate::suite::Suite;
