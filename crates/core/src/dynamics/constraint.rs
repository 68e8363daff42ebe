//! Defines a constraint: a pin or a handle, which prescribes the positions and velocities of lattice vertices.

use nalgebra::{Point3, Vector3};
use thiserror::Error;

use super::{Interpolation, Key, Motion, MotionError, Pose, Selection};
use crate::state::{BodyState, Interval};

/// A constraint that fixes selected lattice vertices at the positions that they have when it becomes active.
#[derive(Clone, Debug, PartialEq)]
pub struct Pin {
    /// The vertices to fix.
    pub selection: Selection,
    /// Time window in which the constraint is active. Default: from 0 s on, without end.
    pub window: TimeWindow,
}

/// A constraint that moves selected lattice vertices along keyframes. The motion is relative to the positions
/// that the vertices have when the constraint becomes active: the captured positions.
#[derive(Clone, Debug, PartialEq)]
pub struct Handle {
    /// The vertices to move.
    pub selection: Selection,
    /// Keyframes: displacements from the captured positions, and rotations about the mean of the captured
    /// positions.
    pub keys: Vec<Key>,
    /// Interpolation between the keyframes. Default: linear.
    pub interpolation: Interpolation,
    /// Time window in which the constraint is active. Default: from 0 s on, without end.
    pub window: TimeWindow,
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

/// A pin or a handle of a body, resolved to lattice vertices, with the positions that it captured.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Constraint {
    /// See [`Constraint::index`].
    pub(super) index: usize,
    vertices: Vec<u32>,
    pub(super) window: TimeWindow,
    pub(super) motion: Option<Motion>,
    capture: Option<Capture>,
    /// Whether the constraint is active in the current step.
    active: bool,
}

/// The positions of the vertices of a constraint when the constraint became active.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Capture {
    /// Center of the rotations, in world space: the mean of the positions.
    center: [f64; 3],
    /// World position of each vertex, in the order of `Constraint::vertices`.
    positions: Vec<[f64; 3]>,
}

impl Constraint {
    /// Creates a constraint on `vertices`: lattice vertices in increasing order, without duplicates. If there
    /// are keyframes `keys`, the constraint is a handle, otherwise a pin.
    ///
    /// # Errors
    /// If the start of the window is not finite, the end is not greater than the start, or the keyframes are
    /// invalid.
    pub fn new(
        vertices: Vec<u32>,
        window: TimeWindow,
        keys: Option<&[Key]>,
    ) -> Result<Self, ConstraintError> {
        let TimeWindow { start, end } = window;
        if !start.is_finite() || end.is_nan() || end <= start {
            return Err(ConstraintError::TimeWindow { start, end });
        }
        let motion = keys.map(|keys| Motion::new(keys.to_vec())).transpose()?;
        Ok(Self { index: 0, vertices, window, motion, capture: None, active: false })
    }

    /// Returns the constraint with another interpolation between the keyframes. It changes no pin.
    pub fn interpolated(mut self, interpolation: Interpolation) -> Self {
        self.motion = self.motion.map(|motion| motion.interpolated(interpolation));
        self
    }

    /// Returns the index of the constraint: its position, from 0, among all constraints that were added to
    /// the body, including released ones. The index never changes.
    pub fn index(&self) -> usize {
        self.index
    }

    /// Returns the lattice vertices of the constraint, in increasing order.
    pub fn vertices(&self) -> &[u32] {
        &self.vertices
    }

    /// Returns the time window.
    pub fn window(&self) -> TimeWindow {
        self.window
    }

    /// Returns the keyframes of a handle, or `None` for a pin.
    pub fn keys(&self) -> Option<&[Key]> {
        self.motion.as_ref().map(Motion::keys)
    }

    /// Returns the motion of a handle, or `None` for a pin.
    pub(crate) fn motion(&self) -> Option<&Motion> {
        self.motion.as_ref()
    }

    /// Returns the interpolation between the keyframes of a handle, or `None` for a pin.
    pub fn interpolation(&self) -> Option<Interpolation> {
        self.motion.as_ref().map(Motion::interpolation)
    }

    /// Returns whether the constraint was active in the last step.
    pub fn is_active(&self) -> bool {
        self.active
    }

    /// Checks that the components of each displacement have a magnitude of at most `limit`.
    pub(crate) fn check_limit(&self, limit: f64) -> Result<(), MotionError> {
        self.motion.iter().try_for_each(|motion| motion.check_limit(limit))
    }

    /// Returns whether the constraint was released. The end of its window is then negative infinity, which is
    /// no valid end of another window.
    pub(crate) fn is_released(&self) -> bool {
        self.window.end == f64::NEG_INFINITY
    }

    /// Returns the memory of the lists in bytes.
    pub(super) fn bytes(&self) -> usize {
        let captured = self.capture.as_ref().map_or(0, |capture| size_of_val(capture.positions.as_slice()));
        size_of_val(self.vertices.as_slice()) + captured
    }

    /// Checks deserialized data. Returns whether all indices and lengths are valid for a lattice of
    /// `vertex_count` vertices.
    pub(super) fn is_valid(&self, vertex_count: usize) -> bool {
        self.vertices.iter().all(|&vertex| (vertex as usize) < vertex_count)
            && self.capture.as_ref().is_none_or(|capture| capture.positions.len() == self.vertices.len())
    }

    /// Returns whether the constraint does not move, begin or end in a step, and was not released.
    pub(super) fn is_static(&self, step: Interval) -> bool {
        let moves = || self.pose(step.start) != self.pose(step.end);
        !self.is_released() && self.acts_in(step) == self.active && !(self.active && moves())
    }

    /// Returns whether the constraint is active in a step.
    ///
    /// The window is widened by 1e-6 step lengths at each end, so that rounding of the step times does not
    /// exclude a step.
    fn acts_in(&self, step: Interval) -> bool {
        let slack = 1e-6 * step.dt;
        step.start >= self.window.start - slack && step.end <= self.window.end + slack
    }

    /// Begins a step: captures positions if the constraint becomes active for the first time. Returns whether
    /// the constraint becomes active or inactive.
    pub(super) fn begin(&mut self, step: Interval, state: &BodyState<'_>, slots: &[u32]) -> bool {
        let active = self.acts_in(step);
        if active && self.capture.is_none() {
            self.capture = Some(Capture::new(&self.vertices, state, slots));
        }
        active != std::mem::replace(&mut self.active, active)
    }

    /// Returns, for each vertex, its index, its target position at the end of a step, in world space, and the change of
    /// the target position during the step. Nothing without captured positions.
    pub(crate) fn targets(&self, step: Interval) -> impl Iterator<Item = (u32, Point3<f64>, Vector3<f64>)> {
        let (start, end) = (self.pose(step.start), self.pose(step.end));
        // The change is computed from differences of poses, because differences of positions lose digits far from the
        // origin of world space.
        let (rotation_change, translation_change) =
            (end.rotation - start.rotation, end.translate - start.translate);
        let captures = self.capture.iter().flat_map(|capture| {
            let center = Point3::from(capture.center);
            capture.positions.iter().map(move |&captured| (center, Point3::from(captured)))
        });
        self.vertices.iter().zip(captures).map(move |(&vertex, (center, captured))| {
            let target = if self.motion.is_some() { end.apply(&center, &captured) } else { captured };
            (vertex, target, rotation_change * (captured - center) + translation_change)
        })
    }

    /// Ends a step: moves the vertices to their target positions at the end of the step. Their velocity is
    /// the change of the target position during the step, divided by dt.
    pub(super) fn apply(&self, step: Interval, state: &mut BodyState<'_>, slots: &[u32]) {
        if !self.active {
            return;
        }
        let to_local_velocity = 1.0 / (step.dt * state.frame.cell_size);
        for (vertex, target, change) in self.targets(step) {
            let slot = slots[vertex as usize];
            state.set_position(slot, state.frame.to_local(&target));
            state.set_velocity(slot, change * to_local_velocity);
        }
    }

    /// Returns the pose at `time`, in seconds. For a pin, it is the identity.
    fn pose(&self, time: f64) -> Pose {
        self.motion.as_ref().map_or_else(Pose::identity, |motion| motion.pose(time))
    }
}

impl Capture {
    /// Captures the current positions of `vertices`.
    fn new(vertices: &[u32], state: &BodyState<'_>, slots: &[u32]) -> Self {
        let world = |&vertex: &u32| state.frame.to_world(state.position(slots[vertex as usize]));
        let positions: Vec<[f64; 3]> = vertices.iter().map(|v| world(v).into()).collect();
        // The mean is computed from offsets to one of the points, because it then loses no digits far from
        // the origin of world space.
        let base = positions.first().map_or_else(Point3::origin, |&p| Point3::from(p));
        let sum: Vector3<f64> = positions.iter().map(|&p| Point3::from(p) - base).sum();
        let center = base + sum / positions.len().max(1) as f64;
        Self { center: center.into(), positions }
    }
}

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
