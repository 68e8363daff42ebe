//! Writes unstructured grids of VTK (`.vtu`, Kitware, VTK file formats, version 1.0 with 64-bit sizes) and collections of
//! them in time (`.pvd`).
//!
//! ```text
//! XML     numbers of points and cells, and for each array its type, its name and its offset
//! "_"     the arrays, each after its size in bytes as u64, little endian
//! XML     the end
//! ```

mod cells;
mod collection;
mod grid;

pub(crate) use cells::Cells;
pub(crate) use collection::collection;
pub(crate) use grid::{Data, Grid};
