//! Errors of pins and handles.

use thiserror::Error;

use crate::mesh::AnimationError;
use crate::motion::MotionError;

/// The error that a pin or handle is invalid.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ConstraintError {
    /// The start of the window is not finite, or the end is not greater than the start.
    #[error("start is {start} and end is {end}; start must be finite and end greater than start")]
    TimeWindow {
        /// Start in seconds.
        start: f64,
        /// End in seconds.
        end: f64,
    },
    /// The keyframes are invalid.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// A handle follows an animation, and the body has no mesh.
    #[error(
        "the handle follows an animated mesh, and the body is a bare lattice without a mesh; build the body from the mesh, \
         or give keys"
    )]
    NoMesh,
    /// The animation that a handle follows is invalid for the body.
    #[error("the animation is invalid: {0}")]
    Animation(#[from] AnimationError),
    /// A position of the animation is so far away that the positions of neighboring vertices would round to the same
    /// number.
    #[error("the animation has a coordinate of {value:e}, too far: the limit is {limit:.3e}, 10^15 cells")]
    AnimationTooFar {
        /// The coordinate.
        value: f64,
        /// Largest valid magnitude.
        limit: f64,
    },
    /// The index of a pin or handle is out of range.
    #[error("there is no pin or handle {index}: the body has {count}")]
    NoSuchConstraint {
        /// The requested index.
        index: usize,
        /// Number of pins and handles that were added to the body, including released ones.
        count: usize,
    },
    /// The pin or handle was released.
    #[error("pin or handle {index} was released; add another one")]
    Released {
        /// The requested index.
        index: usize,
    },
}
