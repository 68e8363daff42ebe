//! Soft bodies from any surface mesh, by lattice shape matching, that keep their volume.

mod body;
pub mod dynamics;
mod error;
pub mod frames;
mod lanes;
mod lattice;
mod matching;
pub mod mesh;
#[cfg(feature = "obj")]
pub mod obj;
mod parallel;
mod plan;
pub mod reference;
#[cfg(feature = "scene")]
pub mod run;
#[cfg(feature = "scene")]
pub mod scene;
mod simulation;
pub mod volume;

#[cfg(feature = "scene")]
pub use body::BodySnapshot;
pub use body::{
    ArrayError, Body, BodyBuilder, Damping, Material, Placement, RangeError, Reach, ShownSurface, Stiffness,
    ViewTimes,
};
pub use dynamics::{Collider, Handle, Key, Pin, Selection, Shape, Window};
pub use error::Error;
pub use lanes::Lanes;
pub use lattice::{
    CellPoints, Components, Embedding, FloatingPart, Lattice, LatticeError, LatticeOptions, LatticeReport,
    Resolution,
};
pub use matching::rotation::rotations;
pub use mesh::{Mesh, MeshError};
pub use parallel::simd_level;
pub use plan::{BodyPlan, Plan, PlannedStage, When};
#[cfg(feature = "scene")]
pub use simulation::SimulationState;
pub use simulation::{Simulation, SimulationBuilder};
pub use volume::{Correction, VolumeError, VolumeMeasure, VolumeMeasures, VolumeOptions, VolumeReport};
