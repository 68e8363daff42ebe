//! Soft bodies from any surface mesh, by lattice shape matching, that keep their volume.

mod lanes;
pub use lanes::Lanes;
pub mod mesh;
#[cfg(feature = "obj")]
pub mod obj;

pub use mesh::{Mesh, MeshError};
mod lattice;
pub mod reference;

pub use lattice::{Components, Embedding, FloatingPart, Lattice, LatticeError, LatticeOptions, LatticeReport, Resolution};
mod parallel;
pub mod volume;

pub use volume::{Correction, VolumeError, VolumeMeasure, VolumeMeasures, VolumeOptions, VolumeReport};
