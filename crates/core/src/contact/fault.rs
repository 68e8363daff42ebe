//! Errors of colliders.

use thiserror::Error;

use crate::mesh::{AnimationError, Scale};
use crate::motion::MotionError;

/// An invalid collider of a scene.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
#[error("collider {collider}: {fault}")]
pub struct ColliderError {
    /// Index of the collider, from 0.
    pub collider: usize,
    /// The fault.
    pub fault: ColliderFault,
}

/// Fault of a collider.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ColliderFault {
    /// A number is not finite or out of its range.
    #[error("{name} is {value}; {range}")]
    OutOfRange {
        /// Field of the collider or its shape.
        name: &'static str,
        /// Value of the field.
        value: f64,
        /// Valid range of the field, as a clause.
        range: &'static str,
    },
    /// The normal of a plane is zero.
    #[error("the plane's normal is zero; give the direction of the free side")]
    ZeroNormal,
    /// No triangle of a mesh has an area.
    #[error("no triangle of the mesh has an area, in {faces} faces; give a mesh with a surface")]
    NoArea {
        /// Number of faces of the mesh.
        faces: usize,
    },
    /// The scale of a mesh is out of range, or the scaled mesh has no extent or leaves the range of `f32`.
    #[error("the mesh can't be scaled by {scale}: {reason}")]
    Scale {
        /// The scale.
        scale: Scale,
        /// The reason.
        reason: String,
    },
    /// The inside of a mesh is to be free, but the mesh is open.
    #[error(
        "`inside` needs a closed mesh, and {open_edges} edges of this one are open; close it, or leave `inside` out: an \
         open mesh holds bodies on either side"
    )]
    OpenRoom {
        /// Number of open edges.
        open_edges: usize,
    },
    /// The animation of a mesh is invalid.
    #[error("the animation is invalid: {0}")]
    Animation(#[from] AnimationError),
    /// The keyframes are invalid.
    #[error(transparent)]
    Motion(#[from] MotionError),
}
