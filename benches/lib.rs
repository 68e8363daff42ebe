//! What the benches share: bodies to measure, and the table that their figures end in.
//!
//! The cases themselves are in `cases/`, one file a subject.

pub mod bodies;
mod table;

pub use table::{Row, Table, Target};
