//! Provides the benchmarks with bodies to measure and with the table of results.
//!
//! The cases are in `cases/`, one file per subject.

pub mod bodies;
mod table;

pub use table::{Row, Table, Target};
