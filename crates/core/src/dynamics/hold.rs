//! Pins and handles: what they hold, when, and how it moves.

use nalgebra::{Point3, Vector3};

use super::{Key, KinematicsError, Motion, MotionError, Pose, Selection};
use crate::state::{BodyState, Interval};

/// A part of a body held as it is at `from`.
#[derive(Clone, Debug, PartialEq)]
pub struct Pin {
    /// What is held.
    pub selection: Selection,
    /// When. Default: from the start, for ever.
    pub window: Window,
}

/// A part of a body moved along keys, relative to the pose that it has at `from`.
#[derive(Clone, Debug, PartialEq)]
pub struct Handle {
    /// What is moved.
    pub selection: Selection,
    /// Displacements from the captured pose, rotations about the captured centre.
    pub keys: Vec<Key>,
    /// When. Default: from the start, for ever.
    pub window: Window,
}

/// When a pin or a handle holds, in seconds.
///
/// It captures what it holds at the start of the first step that starts at or after `from`, and lets go after
/// the last step that ends at or before `until`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Window {
    /// Finite. Default 0.
    pub from: f64,
    /// Greater than `from`. Default infinity: for ever.
    pub until: f64,
}

impl Default for Window {
    fn default() -> Self {
        Self { from: 0.0, until: f64::INFINITY }
    }
}

/// A pin or a handle that has been resolved to lattice vertices, and what it found when it began.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Hold {
    vertices: Vec<u32>,
    window: Window,
    motion: Option<Motion>,
    capture: Option<Capture>,
    /// Whether it holds in the step that was begun last.
    acts: bool,
}

/// What a hold found when it began.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Capture {
    /// Mean of the positions: the centre of the hold's rotations, world space.
    centre: [f64; 3],
    /// World position of each held vertex, in the order of the hold's vertices.
    positions: Vec<[f64; 3]>,
}

impl Hold {
    /// Holds `vertices` (lattice vertices in increasing order, each once), still without `keys`.
    ///
    /// # Errors
    /// An empty or non-numeric window, or keys that are no motion.
    pub fn new(vertices: Vec<u32>, window: Window, keys: Option<&[Key]>) -> Result<Self, KinematicsError> {
        let Window { from, until } = window;
        if !from.is_finite() || until.is_nan() || until <= from {
            return Err(KinematicsError::Window { from, until });
        }
        let motion = keys.map(|keys| Motion::new(keys.to_vec())).transpose()?;
        Ok(Self { vertices, window, motion, capture: None, acts: false })
    }

    /// The held lattice vertices, in increasing order.
    pub fn vertices(&self) -> &[u32] {
        &self.vertices
    }

    /// Whether it moves no further than `limit` along an axis.
    pub(crate) fn within(&self, limit: f64) -> Result<(), MotionError> {
        self.motion.iter().try_for_each(|motion| motion.within(limit))
    }

    /// Whether it holds in the step that was begun last.
    pub(super) fn acts(&self) -> bool {
        self.acts
    }

    /// Holds no more, for good.
    pub(super) fn release(&mut self) {
        self.window.until = f64::NEG_INFINITY;
    }

    /// Moves in another way, relative to what was captured.
    pub(super) fn set_motion(&mut self, motion: Motion) {
        self.motion = Some(motion);
    }

    /// Whether it is of a lattice of so many vertices, as one read from a file may not be.
    pub(super) fn is_whole(&self, vertices: usize) -> bool {
        self.vertices.iter().all(|&vertex| (vertex as usize) < vertices)
            && self.capture.as_ref().is_none_or(|capture| capture.positions.len() == self.vertices.len())
    }

    /// Opens a step: captures where it is what it begins to hold. Says whether it holds where it did not, or the
    /// other way round. A step that misses a limit of the window by rounding alone counts as within it.
    pub(super) fn begin(&mut self, step: Interval, state: &BodyState<'_>, slots: &[u32]) -> bool {
        let slack = 1e-6 * step.dt;
        let acts = step.start >= self.window.from - slack && step.end <= self.window.until + slack;
        if acts && self.capture.is_none() {
            self.capture = Some(Capture::of(&self.vertices, state, slots));
        }
        acts != std::mem::replace(&mut self.acts, acts)
    }

    /// Closes a step: what it holds goes to where it has it at the end, with the velocity of its motion,
    /// `(target(end) - target(start)) / dt`.
    pub(super) fn apply(&self, step: Interval, state: &mut BodyState<'_>, slots: &[u32]) {
        let (true, Some(capture)) = (self.acts, &self.capture) else { return };
        let to_local_velocity = 1.0 / (step.dt * state.frame.cell_size);
        let (start, end) = (self.pose(step.start), self.pose(step.end));
        let centre = Point3::from(capture.centre);
        // Differences of poses and not of places: no rounding at a million cells from the world's origin.
        let (turned, moved) = (end.rotation - start.rotation, end.translate - start.translate);
        for (&vertex, &captured) in self.vertices.iter().zip(&capture.positions) {
            let captured = Point3::from(captured);
            let target = if self.motion.is_some() { end.apply(&centre, &captured) } else { captured };
            let velocity: Vector3<f64> = (turned * (captured - centre) + moved) * to_local_velocity;
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
        // The mean of the offsets from one of the points, which keeps its digits far from the world's origin.
        let base = positions.first().map_or_else(Point3::origin, |&p| Point3::from(p));
        let sum: Vector3<f64> = positions.iter().map(|&p| Point3::from(p) - base).sum();
        let centre = base + sum / positions.len().max(1) as f64;
        Self { centre: centre.into(), positions }
    }
}
