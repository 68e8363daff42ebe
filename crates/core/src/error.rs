//! The error type of the crate. [`Error`] wraps the error types of the modules.

use crate::body::{ArrayError, StateError};
use crate::contact::ColliderError;
use crate::dynamics::{ConstraintError, SelectionError};
use crate::lattice::LatticeError;
use crate::mesh::MeshError;
use crate::range::RangeError;
use crate::volume::VolumeError;

/// Any error of this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A simulation without bodies.
    #[error("a simulation needs at least one body")]
    NoBody,
    /// Automatic steps per frame without frames per second.
    #[error("substeps = \"auto\" needs fps, the number of frames per second")]
    AutoSubstepsWithoutFps,
    /// An invalid mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A lattice that cannot be built.
    #[error(transparent)]
    Lattice(#[from] LatticeError),
    /// A number out of range.
    #[error(transparent)]
    Range(#[from] RangeError),
    /// An array with the wrong length or an invalid value.
    #[error(transparent)]
    Array(#[from] ArrayError),
    /// An invalid or empty selection of a pin, a handle or a force.
    #[error(transparent)]
    Selection(#[from] SelectionError),
    /// An invalid pin or handle.
    #[error(transparent)]
    Constraint(#[from] ConstraintError),
    /// A volume correction that the body does not allow.
    #[error(transparent)]
    Volume(#[from] VolumeError),
    /// An invalid collider.
    #[error(transparent)]
    Collider(#[from] ColliderError),
    /// A saved state that does not match the bodies.
    #[error("the state does not match the simulation: {0}")]
    State(#[from] StateError),
}
