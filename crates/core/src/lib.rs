//! Soft bodies from any surface mesh, by lattice shape matching, that keep their volume.

pub mod dynamics;
mod lanes;
pub mod mesh;
#[cfg(feature = "obj")]
pub mod obj;

pub use lanes::Lanes;
#[cfg(feature = "scene")]
pub mod scene;
pub use mesh::{Mesh, MeshError};
mod lattice;
pub mod reference;

pub use lanes::Lanes;
pub use lattice::{Components, FloatingPart, Lattice, LatticeError, LatticeReport};
