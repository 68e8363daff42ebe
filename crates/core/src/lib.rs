//! Soft bodies from any surface mesh, by lattice shape matching, that keep their volume.

mod lanes;
mod lattice;
pub mod reference;

pub use lanes::Lanes;
pub use lattice::{Components, FloatingPart, Lattice, LatticeError, LatticeReport};
