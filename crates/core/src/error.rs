//! All errors of the crate: one enum for each stage, wrapped by [`Error`].

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
    /// A simulation of no bodies.
    #[error("a simulation needs at least one body")]
    NoBody,
    /// A mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The lattice.
    #[error(transparent)]
    Lattice(#[from] LatticeError),
    /// A number out of its range.
    #[error(transparent)]
    Range(#[from] RangeError),
    /// An array that does not fit.
    #[error(transparent)]
    Array(#[from] ArrayError),
    /// The selection of a pin, a handle or a force.
    #[error(transparent)]
    Selection(#[from] SelectionError),
    /// A pin or a handle.
    #[error(transparent)]
    Constraint(#[from] ConstraintError),
    /// The volume correction.
    #[error(transparent)]
    Volume(#[from] VolumeError),
    /// A collider.
    #[error(transparent)]
    Collider(#[from] ColliderError),
    /// A state of other bodies.
    #[error("the state does not fit: {0}")]
    State(#[from] StateError),
}
