//! Soft bodies from any surface mesh, by lattice shape matching, that keep their volume.

mod lanes;

pub use lanes::Lanes;
#[cfg(feature = "scene")]
pub mod scene;
