//! The inputs of a step.

use nalgebra::Vector3;

use crate::contact::Colliders;
use crate::matching::Workspaces;
use crate::state::Interval;

/// Inputs of a step that all bodies share.
pub(crate) struct StepContext<'a> {
    /// Gravity in scene units per second squared.
    pub(crate) gravity: Vector3<f64>,
    /// Magnitude of the greatest gravity of a keyframe.
    pub(crate) greatest_gravity: f64,
    pub(crate) interval: Interval,
    /// Whether this is the first step of a frame.
    pub(crate) is_frame_start: bool,
    pub(crate) colliders: &'a Colliders,
    /// Whether bodies at rest fall asleep.
    pub(crate) sleep: bool,
    /// The workspaces of the threads, for the bodies that are a single task.
    pub(crate) workspaces: &'a Workspaces,
}
