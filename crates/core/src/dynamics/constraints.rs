//! Constraints: pins and handles prescribe the positions and velocities of lattice vertices.

use nalgebra::{Point3, Vector3};
use thiserror::Error;

use super::{Key, Motion, MotionError, Pose, Selection};
use crate::state::{BodyState, Interval};

/// A constraint that fixes a part of a body at its positions at `start`.
#[derive(Clone, Debug, PartialEq)]
pub struct Pin {
    /// The part that is fixed.
    pub selection: Selection,
    /// Time in which the constraint is active. Default: from 0 s on, without end.
    pub window: TimeWindow,
}

/// A constraint that moves a part of a body along keys, relative to its pose at `start`.
#[derive(Clone, Debug, PartialEq)]
pub struct Handle {
    /// The part that is moved.
    pub selection: Selection,
    /// Displacements from the captured positions, and rotations about the captured center.
    pub keys: Vec<Key>,
    /// Time in which the constraint is active. Default: from 0 s on, without end.
    pub window: TimeWindow,
}

/// Time window in which a pin or a handle is active, in seconds.
///
/// The constraint captures its vertices at the start of the first step that starts at or after `start`. It
/// releases them after the last step that ends at or before `end`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TimeWindow {
    /// Start of the window; finite. Default 0.
    pub start: f64,
    /// End of the window, greater than `start`. Default infinity.
    pub end: f64,
}

impl Default for TimeWindow {
    fn default() -> Self {
        Self { start: 0.0, end: f64::INFINITY }
    }
}

/// A pin or a handle resolved to lattice vertices, with the positions that it captured.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Constraint {
    vertices: Vec<u32>,
    window: TimeWindow,
    motion: Option<Motion>,
    capture: Option<Capture>,
    /// Whether it is active in the current step.
    active: bool,
}

/// The positions of the constrained vertices when the constraint became active.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Capture {
    /// Center of the rotations: the mean of the positions, in world space.
    center: [f64; 3],
    /// World position of each constrained vertex, in the order of `vertices`.
    positions: Vec<[f64; 3]>,
}

impl Constraint {
    /// Creates a constraint on `vertices`: lattice vertices in increasing order, without duplicates. It is a
    /// handle if there are `keys`, else a pin.
    ///
    /// # Errors
    /// A window that is empty or not a number, or invalid keys.
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
        Ok(Self { vertices, window, motion, capture: None, active: false })
    }

    /// The constrained lattice vertices, in increasing order.
    pub fn vertices(&self) -> &[u32] {
        &self.vertices
    }

    /// Checks that each displacement is at most `limit` along each axis.
    pub(crate) fn check_limit(&self, limit: f64) -> Result<(), MotionError> {
        self.motion.iter().try_for_each(|motion| motion.check_limit(limit))
    }

    /// Deactivates the constraint permanently.
    fn release(&mut self) {
        self.window.end = f64::NEG_INFINITY;
    }

    /// Sets the motion, relative to the captured positions.
    fn set_motion(&mut self, motion: Motion) {
        self.motion = Some(motion);
    }

    /// Checks deserialized data: whether all indices and lengths fit a lattice of `vertices` vertices.
    fn is_valid(&self, vertices: usize) -> bool {
        self.vertices.iter().all(|&vertex| (vertex as usize) < vertices)
            && self.capture.as_ref().is_none_or(|capture| capture.positions.len() == self.vertices.len())
    }

    /// Begins a step: captures positions if the constraint becomes active for the first time. Returns whether
    /// it becomes active or inactive.
    ///
    /// The window is widened by 1e-6 steps, so that rounding of the step times does not exclude a step.
    fn begin(&mut self, step: Interval, state: &BodyState<'_>, slots: &[u32]) -> bool {
        let slack = 1e-6 * step.dt;
        let active = step.start >= self.window.start - slack && step.end <= self.window.end + slack;
        if active && self.capture.is_none() {
            self.capture = Some(Capture::of(&self.vertices, state, slots));
        }
        active != std::mem::replace(&mut self.active, active)
    }

    /// Ends a step: moves the vertices to `target(end)`. Their velocity is
    /// `(target(end) - target(start)) / dt`.
    fn apply(&self, step: Interval, state: &mut BodyState<'_>, slots: &[u32]) {
        let (true, Some(capture)) = (self.active, &self.capture) else { return };
        let to_local_velocity = 1.0 / (step.dt * state.frame.cell_size);
        let (start, end) = (self.pose(step.start), self.pose(step.end));
        let center = Point3::from(capture.center);
        // The velocity comes from differences of poses: differences of positions lose digits far from the
        // world's origin.
        let (rotation_change, translation_change) =
            (end.rotation - start.rotation, end.translate - start.translate);
        for (&vertex, &captured) in self.vertices.iter().zip(&capture.positions) {
            let captured = Point3::from(captured);
            let target = if self.motion.is_some() { end.apply(&center, &captured) } else { captured };
            let velocity: Vector3<f64> =
                (rotation_change * (captured - center) + translation_change) * to_local_velocity;
            let slot = slots[vertex as usize];
            state.set_position(slot, state.frame.to_local(&target));
            state.set_velocity(slot, velocity);
        }
    }

    fn pose(&self, time: f64) -> Pose {
        self.motion.as_ref().map_or_else(Pose::identity, |motion| motion.pose(time))
    }
}

impl Capture {
    fn of(vertices: &[u32], state: &BodyState<'_>, slots: &[u32]) -> Self {
        let world = |&vertex: &u32| state.frame.to_world(state.position(slots[vertex as usize]));
        let positions: Vec<[f64; 3]> = vertices.iter().map(|v| world(v).into()).collect();
        // A mean of offsets from one of the points loses no digits far from the world's origin.
        let base = positions.first().map_or_else(Point3::origin, |&p| Point3::from(p));
        let sum: Vector3<f64> = positions.iter().map(|&p| Point3::from(p) - base).sum();
        let center = base + sum / positions.len().max(1) as f64;
        Self { center: center.into(), positions }
    }
}

/// An invalid pin or handle.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ConstraintError {
    /// The window is empty or not a number.
    #[error("start is {start} and end is {end}; start must be finite and end greater than start")]
    TimeWindow {
        /// Start in seconds.
        start: f64,
        /// End in seconds.
        end: f64,
    },
    /// The keys are invalid.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// The index of a pin or handle is out of range.
    #[error("there is no pin or handle {index}: the body has {count}")]
    NoSuchConstraint {
        /// The requested index.
        index: usize,
        /// Number of pins and handles of the body.
        count: usize,
    },
}

/// The constraint stage: the pins and handles of one body. Where they overlap, the later one has priority.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Constraints {
    constraints: Vec<Constraint>,
    held: Vec<bool>,
}

impl Constraints {
    /// Memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let captured = |capture: &Capture| size_of_val(capture.positions.as_slice());
        let each = self.constraints.iter().map(|constraint| {
            size_of_val(constraint.vertices.as_slice()) + constraint.capture.as_ref().map_or(0, captured)
        });
        self.held.len() + size_of_val(self.constraints.as_slice()) + each.sum::<usize>()
    }

    /// Creates the stage for a lattice of `vertex_count` vertices.
    pub fn new(vertex_count: usize, constraints: Vec<Constraint>) -> Self {
        Self { constraints, held: vec![false; vertex_count] }
    }

    /// Adds a constraint, which has priority over the existing ones.
    pub fn add(&mut self, constraint: Constraint) {
        self.constraints.push(constraint);
    }

    /// Deactivates a constraint permanently.
    ///
    /// # Errors
    /// An index out of range.
    pub fn release(&mut self, index: usize) -> Result<(), ConstraintError> {
        self.get_mut(index)?.release();
        Ok(())
    }

    /// Replaces the motion of a constraint. It is relative to the captured positions.
    ///
    /// # Errors
    /// An index out of range.
    pub fn set_motion(&mut self, index: usize, motion: Motion) -> Result<(), ConstraintError> {
        self.get_mut(index)?.set_motion(motion);
        Ok(())
    }

    fn get_mut(&mut self, index: usize) -> Result<&mut Constraint, ConstraintError> {
        let count = self.constraints.len();
        self.constraints.get_mut(index).ok_or(ConstraintError::NoSuchConstraint { index, count })
    }

    /// Checks deserialized data: whether all indices and lengths fit a lattice of `vertices` vertices.
    pub(crate) fn is_valid(&self, vertices: usize) -> bool {
        self.held.len() == vertices && self.constraints.iter().all(|constraint| constraint.is_valid(vertices))
    }

    /// The constraints in the order in which they were added; later ones have priority.
    pub fn list(&self) -> &[Constraint] {
        &self.constraints
    }

    /// Begins a step, before positions change: constraints that become active for the first time capture the
    /// positions of their vertices. Returns whether [`held`](Self::held) has changed; it is valid to the end
    /// of the step.
    ///
    /// `slots` is the slot of each lattice vertex.
    pub fn begin(&mut self, step: Interval, state: &BodyState<'_>, slots: &[u32]) -> bool {
        let mut changed = false;
        for constraint in &mut self.constraints {
            changed |= constraint.begin(step, state, slots);
        }
        if changed {
            self.held.fill(false);
            for &vertex in
                self.constraints.iter().filter(|constraint| constraint.active).flat_map(Constraint::vertices)
            {
                self.held[vertex as usize] = true;
            }
        }
        changed
    }

    /// Ends a step: sets the position and the velocity of each constrained vertex from the motion of its
    /// constraint.
    pub fn apply(&self, step: Interval, state: &mut BodyState<'_>, slots: &[u32]) {
        for constraint in &self.constraints {
            constraint.apply(step, state, slots);
        }
    }

    /// Whether each lattice vertex is constrained in the current step.
    pub fn held(&self) -> &[bool] {
        &self.held
    }

    /// Whether any constraint is active in the current step.
    pub fn any_active(&self) -> bool {
        self.constraints.iter().any(|constraint| constraint.active)
    }
}
