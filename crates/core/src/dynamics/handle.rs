//! Descriptions of pins and handles.

use super::goal::Goal;
use super::selection::Selection;
use crate::mesh::MeshAnimation;
use crate::motion::{Interpolation, Key};

/// A constraint that fixes selected lattice vertices at the positions that they have when it becomes active.
#[derive(Clone, Debug, PartialEq)]
pub struct Pin {
    /// The vertices to fix.
    pub selection: Selection,
    /// Time window in which the constraint is active. Default: from 0 s on, without end.
    pub window: TimeWindow,
    /// How strongly the vertices are pulled to their positions; `None`: the positions are prescribed.
    pub goal: Option<Goal>,
}

/// A constraint that moves selected lattice vertices.
#[derive(Clone, Debug, PartialEq)]
pub struct Handle {
    /// The vertices to move.
    pub selection: Selection,
    /// Their motion.
    pub motion: HandleMotion,
    /// Time window in which the constraint is active. Default: from 0 s on, without end.
    pub window: TimeWindow,
    /// How strongly the vertices are pulled along; `None`: their positions are prescribed.
    pub goal: Option<Goal>,
}

/// How a handle moves its lattice vertices.
#[derive(Clone, Debug, PartialEq)]
pub enum HandleMotion {
    /// Along keyframes: displacements from the positions that the vertices have when the handle becomes active, the
    /// captured positions, and rotations about the mean of the captured positions. `Vec<Key>` converts to linear
    /// keyframes.
    Keys(Vec<Key>, Interpolation),
    /// With an animated mesh: the positions of the vertices of the body's mesh at several times. The animation replaces
    /// the coordinates of the mesh that the body was built from, so that the scale and the placement of the body apply
    /// to it also.
    ///
    /// Each lattice vertex has a rigid fit to the mesh vertices around it, of those that the selection contains (of
    /// all, if it is a list of lattice vertices). The vertices are at the positions of the animation at each time,
    /// wherever the body was before: they jump in the first step if the animation does not begin in the pose of the
    /// body.
    Follow(MeshAnimation),
}

impl From<Vec<Key>> for HandleMotion {
    fn from(keys: Vec<Key>) -> Self {
        Self::Keys(keys, Interpolation::Linear)
    }
}

/// Time window in which a pin or a handle is active, in seconds.
///
/// The constraint captures the positions of its vertices at the start of the first step that starts at or
/// after `start`. It releases the vertices after the last step that ends at or before `end`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TimeWindow {
    /// Start of the window, finite. Default 0.
    pub start: f64,
    /// End of the window, greater than `start`. Default infinity.
    pub end: f64,
}

impl Default for TimeWindow {
    fn default() -> Self {
        Self { start: 0.0, end: f64::INFINITY }
    }
}
