//! The error type of the crate. [`Error`] wraps the error types of the modules. [`StateError`] can wrap an [`Error`].

use crate::contact::ColliderError;
use crate::dynamics::{ConstraintError, FieldError, LinkError, RigidError, SelectionError};
use crate::lattice::LatticeError;
use crate::mesh::MeshError;
use crate::range::RangeError;
use crate::state::ArrayError;
use crate::volume::VolumeError;

/// Any error of this crate.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A simulation without bodies.
    #[error("a simulation needs at least one body")]
    NoBody,
    /// A link ties a body that is to be removed.
    #[error("the body {name:?} cannot be removed, because a link ties it")]
    LinkedBody {
        /// Name of the body.
        name: String,
    },
    /// A field or a link names a body that the simulation does not have.
    #[error(
        "a {what} names the body {name:?}, which the simulation does not have; its bodies are {bodies:?}"
    )]
    NoSuchBody {
        /// `field` or `link`.
        what: &'static str,
        /// Name of the body.
        name: String,
        /// Names of the bodies of the simulation.
        bodies: Vec<String>,
    },
    /// An invalid field.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// An invalid link.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// A link that cannot be built.
    #[error("link {index}: {source}")]
    InLink {
        /// Index of the link, in the order of the builder.
        index: usize,
        /// Cause.
        source: Box<Error>,
    },
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
    /// A thickness of more than half of the longest side of the body.
    #[error(
        "thickness = {thickness} is out of range: it must be at most {limit}, half of the longest side of the body; \
         it is a length in the units of the scene"
    )]
    Thickness {
        /// The thickness.
        thickness: f64,
        /// Half of the longest side of the bounding box.
        limit: f64,
    },
    /// An array with the wrong length or an invalid value.
    #[error(transparent)]
    Array(#[from] ArrayError),
    /// An invalid or empty selection of a pin, a handle or a force.
    #[error(transparent)]
    Selection(#[from] SelectionError),
    /// An invalid pin or handle.
    #[error(transparent)]
    Constraint(#[from] ConstraintError),
    /// A setting or a change that a rigid body does not have.
    #[error(transparent)]
    Rigid(#[from] RigidError),
    /// A volume correction that the body does not allow.
    #[error(transparent)]
    Volume(#[from] VolumeError),
    /// A zone with another strength, of a body that does not break.
    #[error(
        "the zone has a strength_factor, and the body does not break; give the body fracture, or leave it out"
    )]
    NoFracture,
    /// A zone with another yield strain, of a body that is not plastic.
    #[error(
        "the zone has a yield_factor, and the body is not plastic; give the body plastic, or leave it out"
    )]
    NotPlastic,
    /// An invalid collider.
    #[error(transparent)]
    Collider(#[from] ColliderError),
    /// A saved state that does not match the bodies.
    #[error("the state does not match the simulation: {0}")]
    State(#[from] StateError),
}

/// A saved state that does not match the body or simulation.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StateError {
    /// A different number of bodies.
    #[error("the number of bodies is {bodies} in the simulation and {found} in the state")]
    Bodies {
        /// Number of bodies in the simulation.
        bodies: usize,
        /// Number of bodies in the state.
        found: usize,
    },
    /// An invalid time or step length.
    #[error("the state has an invalid time or step length")]
    Time,
    /// Invalid keyframes of gravity.
    #[error("the state has invalid keyframes of gravity")]
    Gravity,
    /// A driven collider that the simulation does not have.
    #[error("the simulation has {colliders} colliders, but in the state collider {index} is driven")]
    Collider {
        /// Number of colliders in the simulation.
        colliders: usize,
        /// Index of the driven collider in the state, from 0.
        index: usize,
    },
    /// A driven collider with an invalid pose.
    #[error("collider {index} has an invalid pose in the state")]
    Drive {
        /// Index of the collider, from 0.
        index: usize,
    },
    /// Invalid supports of bodies by each other.
    #[error("the state has invalid supports of bodies by each other")]
    Supports,
    /// A different cell size.
    #[error("body {body:?} has the cell size {cell_size}, but the state has {found}")]
    CellSize {
        /// Name of the body.
        body: String,
        /// Cell size of the body.
        cell_size: f64,
        /// Cell size of the state.
        found: f64,
    },
    /// A different lattice: another number of connected components, or of blocks of eight lattice vertices.
    #[error("body {body:?} has {blocks} blocks of lattice vertices, but the state has {found}")]
    Lattice {
        /// Name of the body.
        body: String,
        /// Number of blocks of the body.
        blocks: usize,
        /// Number of blocks of the state.
        found: usize,
    },
    /// Plastic shapes without plasticity, or plasticity without plastic shapes.
    #[error("body {body:?}: the plastic shapes of the state do not match its material")]
    Plastic {
        /// Name of the body.
        body: String,
    },
    /// Pins, handles, inflation, forces or contacts of another body.
    #[error("body {body:?}: the state has {what} of another body")]
    Vertices {
        /// Name of the body.
        body: String,
        /// `pins and handles`, `inflation`, `forces` or `contacts`.
        what: &'static str,
    },
    /// A handle follows an animation that the body does not have.
    #[error(
        "body {body:?}: handle {index} of the state follows an animation, which a state does not contain; add a handle with \
         the same selection and animation before the state is restored"
    )]
    Animation {
        /// Name of the body.
        body: String,
        /// Index of the handle.
        index: usize,
    },
    /// Settings that are invalid for the body.
    #[error("body {body:?}: {source}")]
    Settings {
        /// Name of the body.
        body: String,
        /// The reason.
        source: Box<Error>,
    },
}
