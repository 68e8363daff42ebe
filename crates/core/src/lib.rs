//! Soft bodies from any surface mesh, by lattice shape matching, that keep their volume.

pub mod dynamics;
mod lanes;
mod lattice;
pub mod mesh;
#[cfg(feature = "obj")]
pub mod obj;
pub mod reference;
#[cfg(feature = "scene")]
pub mod run;
#[cfg(feature = "scene")]
pub mod scene;

pub use lanes::Lanes;
pub use lattice::{Components, FloatingPart, Lattice, LatticeError, LatticeReport};
pub use mesh::{Mesh, MeshError};
