//! Soft bodies from any surface mesh, by lattice shape matching, that keep their volume.

pub mod dynamics;
mod lanes;

pub use lanes::Lanes;
