//! Soft bodies from any surface mesh, by lattice shape matching, that keep their volume.

mod lanes;
mod lattice;
pub mod mesh;
#[cfg(feature = "obj")]
pub mod obj;
pub mod reference;

pub use lanes::Lanes;
pub use lattice::{
    CellPoints, Components, Embedding, FloatingPart, Lattice, LatticeError, LatticeOptions, LatticeReport,
    Resolution,
};
pub use mesh::{Mesh, MeshError};
