//! Constraints: pins and handles override positions and carry the velocity of their motion.

use nalgebra::{Point3, Vector3};
use thiserror::Error;

use super::{Key, Motion, MotionError, Pose, Selection};
use crate::state::{BodyState, Interval};

/// A part of a body held as it is at `start`.
#[derive(Clone, Debug, PartialEq)]
pub struct Pin {
    /// What is held.
    pub selection: Selection,
    /// When. Default: from the start, for ever.
    pub window: TimeWindow,
}

/// A part of a body moved along keys, relative to the pose that it has at `start`.
#[derive(Clone, Debug, PartialEq)]
pub struct Handle {
    /// What is moved.
    pub selection: Selection,
    /// Displacements from the captured pose, rotations about the captured center.
    pub keys: Vec<Key>,
    /// When. Default: from the start, for ever.
    pub window: TimeWindow,
}

/// When a pin or a handle is active, in seconds.
///
/// It captures its vertices at the start of the first step that starts at or after `start`, and releases them after
/// the last step that ends at or before `end`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct TimeWindow {
    /// Finite. Default 0.
    pub start: f64,
    /// Greater than `start`. Default infinity: for ever.
    pub end: f64,
}

impl Default for TimeWindow {
    fn default() -> Self {
        Self { start: 0.0, end: f64::INFINITY }
    }
}

/// A pin or a handle resolved to lattice vertices, with the poses that it captured.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Constraint {
    vertices: Vec<u32>,
    window: TimeWindow,
    motion: Option<Motion>,
    capture: Option<Capture>,
    /// Whether it is active in the step that was begun last.
    active: bool,
}

/// The positions of the held vertices when the constraint became active.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Capture {
    /// Mean of the positions: the center of the rotations, world space.
    center: [f64; 3],
    /// World position of each held vertex, in the order of `vertices`.
    positions: Vec<[f64; 3]>,
}

impl Constraint {
    /// A constraint on `vertices` (lattice vertices in increasing order, each once); a pin without `keys`.
    ///
    /// # Errors
    /// An empty or non-numeric window, or keys that are no motion.
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

    /// The held lattice vertices, in increasing order.
    pub fn vertices(&self) -> &[u32] {
        &self.vertices
    }

    /// Checks that it moves no further than `limit` along an axis.
    pub(crate) fn within(&self, limit: f64) -> Result<(), MotionError> {
        self.motion.iter().try_for_each(|motion| motion.within(limit))
    }

    /// Releases it for good.
    fn release(&mut self) {
        self.window.end = f64::NEG_INFINITY;
    }

    /// Sets the motion, relative to the captured pose.
    fn set_motion(&mut self, motion: Motion) {
        self.motion = Some(motion);
    }

    /// Whether it fits a lattice of `vertices` vertices: deserialised data may not.
    fn is_whole(&self, vertices: usize) -> bool {
        self.vertices.iter().all(|&vertex| (vertex as usize) < vertices)
            && self.capture.as_ref().is_none_or(|capture| capture.positions.len() == self.vertices.len())
    }

    /// Begins a step: captures positions where it becomes active. Returns whether it becomes active or inactive.
    /// A step that misses a limit of the window by rounding alone counts as within it.
    fn begin(&mut self, step: Interval, state: &BodyState<'_>, slots: &[u32]) -> bool {
        let slack = 1e-6 * step.dt;
        let active = step.start >= self.window.start - slack && step.end <= self.window.end + slack;
        if active && self.capture.is_none() {
            self.capture = Some(Capture::of(&self.vertices, state, slots));
        }
        active != std::mem::replace(&mut self.active, active)
    }

    /// Ends a step: moves the held vertices to `target(end)`, with the velocity `(target(end) - target(start)) / dt`.
    fn apply(&self, step: Interval, state: &mut BodyState<'_>, slots: &[u32]) {
        let (true, Some(capture)) = (self.active, &self.capture) else { return };
        let to_local_velocity = 1.0 / (step.dt * state.frame.cell_size);
        let (start, end) = (self.pose(step.start), self.pose(step.end));
        let center = Point3::from(capture.center);
        // Differences of poses, not of positions: no rounding far from the origin of the world.
        let (turned, moved) = (end.rotation - start.rotation, end.translate - start.translate);
        for (&vertex, &captured) in self.vertices.iter().zip(&capture.positions) {
            let captured = Point3::from(captured);
            let target = if self.motion.is_some() { end.apply(&center, &captured) } else { captured };
            let velocity: Vector3<f64> = (turned * (captured - center) + moved) * to_local_velocity;
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
        let place = |&vertex: &u32| state.frame.to_world(state.position(slots[vertex as usize]));
        let positions: Vec<[f64; 3]> = vertices.iter().map(|v| place(v).into()).collect();
        // The mean of the offsets from one of the points keeps its digits far from the origin of the world.
        let base = positions.first().map_or_else(Point3::origin, |&p| Point3::from(p));
        let sum: Vector3<f64> = positions.iter().map(|&p| Point3::from(p) - base).sum();
        let center = base + sum / positions.len().max(1) as f64;
        Self { center: center.into(), positions }
    }
}

/// Why a pin or a handle cannot be.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ConstraintError {
    /// The window is empty or not a number.
    #[error("start = {start}, end = {end}: start must be finite and end greater than start")]
    TimeWindow {
        /// Start in seconds.
        start: f64,
        /// End in seconds.
        end: f64,
    },
    /// The keys are no motion.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// There is no such pin or handle.
    #[error("there is no pin or handle {index}: the body has {count}")]
    NoSuchConstraint {
        /// The index asked for.
        index: usize,
        /// How many there are.
        count: usize,
    },
}

/// The stage: the pins and handles of one body. Where they overlap, the later one wins.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Constraints {
    constraints: Vec<Constraint>,
    held: Vec<bool>,
}

impl Constraints {
    /// Memory that they take.
    pub(crate) fn bytes(&self) -> usize {
        let captured = |capture: &Capture| size_of_val(capture.positions.as_slice());
        let of_each = self.constraints.iter().map(|constraint| {
            size_of_val(constraint.vertices.as_slice()) + constraint.capture.as_ref().map_or(0, captured)
        });
        self.held.len() + size_of_val(self.constraints.as_slice()) + of_each.sum::<usize>()
    }

    /// The stage for a lattice of `vertex_count` vertices.
    pub fn new(vertex_count: usize, constraints: Vec<Constraint>) -> Self {
        Self { constraints, held: vec![false; vertex_count] }
    }

    /// Adds a constraint, which wins over those before it.
    pub fn add(&mut self, constraint: Constraint) {
        self.constraints.push(constraint);
    }

    /// Releases a constraint for good.
    ///
    /// # Errors
    /// If there is no such constraint.
    pub fn release(&mut self, index: usize) -> Result<(), ConstraintError> {
        self.get_mut(index)?.release();
        Ok(())
    }

    /// Gives a constraint another motion, relative to the captured pose.
    ///
    /// # Errors
    /// If there is no such constraint.
    pub fn set_motion(&mut self, index: usize, motion: Motion) -> Result<(), ConstraintError> {
        self.get_mut(index)?.set_motion(motion);
        Ok(())
    }

    fn get_mut(&mut self, index: usize) -> Result<&mut Constraint, ConstraintError> {
        let count = self.constraints.len();
        self.constraints.get_mut(index).ok_or(ConstraintError::NoSuchConstraint { index, count })
    }

    /// Whether it fits a lattice of `vertices` vertices: deserialised data may not.
    pub(crate) fn is_whole(&self, vertices: usize) -> bool {
        self.held.len() == vertices && self.constraints.iter().all(|constraint| constraint.is_whole(vertices))
    }

    /// The constraints in order; later ones win.
    pub fn list(&self) -> &[Constraint] {
        &self.constraints
    }

    /// Begins a step, before positions change: constraints that become active capture the positions of their vertices.
    /// [`held`](Self::held) is valid from here to the end of the step. Returns whether it has changed.
    ///
    /// `slots` has the slot of each lattice vertex.
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

    /// Ends a step: held vertices get the position and the velocity of the motion of their constraint.
    pub fn apply(&self, step: Interval, state: &mut BodyState<'_>, slots: &[u32]) {
        for constraint in &self.constraints {
            constraint.apply(step, state, slots);
        }
    }

    /// For each lattice vertex, whether a constraint holds it in the step that was begun last.
    pub fn held(&self) -> &[bool] {
        &self.held
    }

    /// Whether any constraint is active in the step that was begun last.
    pub fn any_active(&self) -> bool {
        self.constraints.iter().any(|constraint| constraint.active)
    }
}
