//! Soft bodies from any surface mesh, by lattice shape matching, that keep their volume.

pub mod frames;
mod lanes;
pub mod mesh;
#[cfg(feature = "obj")]
pub mod obj;

pub use lanes::Lanes;
pub use mesh::{Mesh, MeshError};
