//! Stiff and extreme cases of `supple`'s soft bodies: each is run, measured, and held to a bound that it states.
//!
//! A [`Case`] is a value: what is done, what is expected and why, its bounds, and the simulation that takes its
//! [`Figures`]. [`cases`] gives all of them, [`run_all`] runs them. Bodies are made of cells, each simulation has one
//! thread, and nothing is drawn by chance that is not the same in each run.

mod bodies;
mod case;
mod cases;
mod energy;
mod figures;
mod measure;
mod report;
mod rigid;
mod run;
mod trial;

pub use case::{Bound, Case, Effort, Outcome};
pub use cases::cases;
pub use figures::Figures;
pub use measure::Measure;
pub use report::{Report, Row};
pub use run::{Ran, run_all};
