//! What can go wrong, stage by stage.

use crate::body::{ArrayError, RangeError};
use crate::contact::ColliderError;
use crate::dynamics::{KinematicsError, SelectionError};
use crate::lattice::LatticeError;
use crate::mesh::MeshError;
use crate::volume::VolumeError;

/// Any error of this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A simulation of no bodies.
    #[error("a simulation needs at least one body")]
    NoBody,
    /// A mesh, or its file.
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
    /// What a pin, a handle or a force takes.
    #[error(transparent)]
    Selection(#[from] SelectionError),
    /// A pin or a handle.
    #[error(transparent)]
    Kinematics(#[from] KinematicsError),
    /// The volume correction.
    #[error(transparent)]
    Volume(#[from] VolumeError),
    /// A collider.
    #[error(transparent)]
    Collider(#[from] ColliderError),
    /// A state that is not of these bodies.
    #[error("the state does not fit: {0}")]
    State(String),
}
