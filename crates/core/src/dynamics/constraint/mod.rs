//! Defines a constraint: a pin or a handle, which prescribes the positions and velocities of lattice vertices. Module
//! `step` has its part in a step.

mod step;

use nalgebra::Vector3;

use super::constraint_error::ConstraintError;
use super::follow::{BodyMesh, Fits, Follow};
use super::goal::Goal;
use super::handle::TimeWindow;
use super::selection::Selection;
use crate::mesh::MeshAnimation;
use crate::motion::{Interpolation, Key, Motion, MotionError};
use crate::range::RangeError;

/// Least factor of the weight of a goal at a vertex that counts as 1: means of weights are rounded.
const HELD: f64 = 1.0 - 1e-6;

/// A pin or a handle of a body, resolved to lattice vertices, with the positions that it captured.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Constraint {
    /// See [`Constraint::index`].
    pub(super) index: usize,
    vertices: Vec<u32>,
    pub(super) window: TimeWindow,
    motion: Option<Motion>,
    /// Present if the constraint follows an animated mesh. It then has neither a motion nor captured positions.
    follow: Option<Follow>,
    capture: Option<Capture>,
    /// Whether the constraint is active in the current step.
    active: bool,
    /// Present if the constraint may pull its vertices in place of prescribing their positions.
    goal: Option<Goal>,
    /// Factor in (0, 1] of the weight of the goal at each vertex; `None` if all are 1. It needs a goal.
    weights: Option<Vec<f64>>,
    /// Whether the constraint prescribes the positions of the vertices with the factor 1 in the current step.
    holds: bool,
    /// The vertices that the constraint pulls in the current step, with their accelerations in scene units. Empty between
    /// steps.
    #[cfg_attr(feature = "serde", serde(skip))]
    pulls: Vec<(u32, [f64; 3])>,
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
        Ok(Self {
            index: 0,
            vertices,
            window,
            motion,
            follow: None,
            capture: None,
            active: false,
            goal: None,
            weights: None,
            holds: false,
            pulls: Vec::new(),
        })
    }

    /// Creates a handle on `vertices` that follows the mesh vertices `part` of an animation. Both are in increasing
    /// order, without duplicates and not empty.
    ///
    /// # Errors
    /// An invalid time window, or an animation with another number of vertices than the mesh.
    pub(crate) fn following(
        body: &BodyMesh<'_>,
        animation: &MeshAnimation,
        selection: &Selection,
        part: &[u32],
        vertices: Vec<u32>,
        window: TimeWindow,
    ) -> Result<Self, ConstraintError> {
        animation.check_vertices(body.mesh.vertices().len())?;
        let constraint = Self::new(vertices, window, None)?;
        let follow = Follow::new(Fits::new(body, animation, selection, part, &constraint.vertices));
        Ok(Self { follow: Some(follow), ..constraint })
    }

    /// Returns the constraint with another interpolation between the keyframes. It changes no pin.
    pub fn interpolated(mut self, interpolation: Interpolation) -> Self {
        self.motion = self.motion.map(|motion| motion.interpolated(interpolation));
        self
    }

    /// Returns the constraint with a soft goal; `None`: it prescribes positions.
    ///
    /// * `weights`: a factor in (0, 1] of the weight of the goal at each vertex. Without a goal it is the weight of a
    ///   default one. `None`: all are 1.
    ///
    /// # Errors
    /// A number of the goal out of range.
    pub fn softened(self, goal: Option<&Goal>, weights: Option<Vec<f64>>) -> Result<Self, RangeError> {
        goal.map_or(Ok(()), Goal::validate)?;
        let goal = goal.cloned().or_else(|| weights.is_some().then(Goal::default));
        Ok(Self { goal, weights, ..self })
    }

    /// Returns the soft goal; `None` if positions are prescribed.
    pub fn goal(&self) -> Option<&Goal> {
        self.goal.as_ref()
    }

    /// Returns the greatest frequency in Hz of a soft goal; 0 without one.
    pub(crate) fn goal_frequency(&self) -> f64 {
        let greatest = |goal: &Goal| match &self.weights {
            None => goal.greatest_frequency(1.0),
            Some(weights) => {
                // Vertices that are held are on no spring.
                let factors = weights.iter().map(|&factor| if factor < HELD { factor } else { 1.0 });
                factors.map(|factor| goal.greatest_frequency(factor)).fold(0.0, f64::max)
            }
        };
        self.goal.as_ref().map_or(0.0, greatest)
    }

    /// Returns whether the constraint prescribed the position of the vertex at a place of the list in the last step.
    fn holds_place(&self, place: usize) -> bool {
        self.holds && self.weights.as_ref().is_none_or(|weights| weights[place] >= HELD)
    }

    /// Returns whether the constraint prescribed the position of a vertex in the last step.
    pub(in crate::dynamics) fn holds(&self, vertex: u32) -> bool {
        self.vertices.binary_search(&vertex).is_ok_and(|place| self.holds_place(place))
    }

    /// Returns the vertices whose positions the constraint prescribed in the last step, in increasing order.
    pub(crate) fn held(&self) -> impl Iterator<Item = u32> {
        self.vertices_at(self.holds, |place| self.holds_place(place))
    }

    /// Returns the vertices at the places of the list for which `is_some` is true; none if `any` is false.
    fn vertices_at(&self, any: bool, is_some: impl Fn(usize) -> bool) -> impl Iterator<Item = u32> {
        let vertices = if any { &self.vertices[..] } else { &[] };
        vertices.iter().enumerate().filter(move |(place, _)| is_some(*place)).map(|(_, &vertex)| vertex)
    }

    /// Returns whether the constraint prescribed the positions of all its vertices in the last step.
    pub(crate) fn holds_all(&self) -> bool {
        self.holds && self.weights.is_none()
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

    /// Transfers the constraint to a lattice whose vertices were split: see `Constraints::transfer`.
    pub(super) fn transfer(&mut self, parents: &[u32]) {
        if self.follow.is_some() {
            return;
        }
        let held = (0..).zip(parents).filter_map(|(vertex, parent)| {
            self.vertices.binary_search(parent).ok().map(|place| (vertex, place))
        });
        let (vertices, places): (Vec<u32>, Vec<usize>) = held.unzip();
        if let Some(weights) = &mut self.weights {
            *weights = places.iter().map(|&place| weights[place]).collect();
        }
        if let Some(capture) = &mut self.capture {
            capture.positions = places.into_iter().map(|place| capture.positions[place]).collect();
        }
        self.vertices = vertices;
    }

    /// Returns to the time before the first step: the constraint is not active, and has captured nothing.
    pub(super) fn restart(&mut self) {
        (self.capture, self.active, self.holds) = (None, false, false);
        self.pulls.clear();
    }

    /// Returns whether the constraint follows an animation.
    pub(super) fn is_following(&self) -> bool {
        self.follow.is_some()
    }

    /// Returns whether the constraint holds the vertices of `other` from the same time on, with another motion or end.
    pub(super) fn continues(&self, other: &Self) -> bool {
        !other.is_released() && self.vertices == other.vertices && self.window.start == other.window.start
    }

    /// Takes the captured positions of a constraint that this one [continues](Self::continues).
    pub(super) fn continue_from(&mut self, other: &Self) {
        (self.active, self.holds) = (other.active, other.holds);
        self.capture = other.capture.clone().filter(|_| self.follow.is_none());
    }

    /// Returns the time window.
    pub fn window(&self) -> TimeWindow {
        self.window
    }

    /// Returns the keyframes of a handle; `None` for a pin, and for a handle that follows an animation.
    pub fn keys(&self) -> Option<&[Key]> {
        self.motion.as_ref().map(Motion::keys)
    }

    /// Returns the animation that a handle follows, and the selection that it was created with; `None` for a pin and
    /// for a handle with keyframes.
    pub fn followed(&self) -> Option<(&MeshAnimation, &Selection)> {
        self.follow.as_ref().and_then(Follow::source)
    }

    /// Replaces the motion by keyframes. If the constraint followed an animation, it captures positions in the next
    /// step.
    pub(super) fn set_motion(&mut self, motion: Motion) {
        self.motion = Some(motion);
        self.follow = None;
    }

    /// Returns the greatest speed of a vertex, in scene units per second. `radius`: of the body.
    pub(crate) fn greatest_speed(&self, radius: f64) -> f64 {
        let keys = self.motion.as_ref().map_or(0.0, |motion| motion.greatest_speed(radius));
        self.follow.as_ref().map_or(keys, Follow::greatest_speed)
    }

    /// Returns the greatest displacement of the vertices along a direction.
    pub(crate) fn greatest_displacement(&self, direction: &Vector3<f64>) -> f64 {
        let keys = self.keys().into_iter().flatten();
        let keys = keys.map(|key| Vector3::from(key.translate).dot(direction)).fold(0.0, f64::max);
        self.follow.as_ref().map_or(keys, |follow| follow.greatest_displacement(direction))
    }

    /// Returns when and how far a handle with keyframes moves its vertices in the step in which it becomes active,
    /// beyond where they are: the time in seconds and a distance in scene units. `radius`: distance from the center
    /// at which the rotation counts. `None` for pins and animations.
    pub fn jump(&self, radius: f64) -> Option<(f64, f64)> {
        let time = self.window.start;
        let pose = self.motion.as_ref()?.euler_pose(time);
        let angle = pose.rotate.iter().map(|degrees| degrees.to_radians().abs()).fold(0.0, f64::max);
        Some((time, Vector3::from(pose.translate).norm() + radius * angle.min(std::f64::consts::PI)))
    }

    /// Returns the interpolation between the keyframes of a handle; `None` for a pin, and for a handle that follows an
    /// animation.
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
        let pulls = self.pulls.capacity() * size_of::<(u32, [f64; 3])>()
            + self.weights.as_ref().map_or(0, |weights| size_of_val(weights.as_slice()));
        size_of_val(self.vertices.as_slice())
            + captured
            + pulls
            + self.follow.as_ref().map_or(0, Follow::bytes)
    }

    /// Checks deserialized data. Returns whether all indices and lengths are valid for a lattice of
    /// `vertex_count` vertices.
    pub(super) fn is_valid(&self, vertex_count: usize) -> bool {
        self.vertices.iter().all(|&vertex| (vertex as usize) < vertex_count)
            && self.capture.as_ref().is_none_or(|capture| capture.positions.len() == self.vertices.len())
            && self.weights.as_ref().is_none_or(|weights| {
                self.goal.is_some()
                    && weights.len() == self.vertices.len()
                    && weights.iter().all(|weight| *weight > 0.0 && *weight <= 1.0)
            })
    }

    /// Takes the animation of a serialized constraint from a constraint that follows the same one.
    pub(super) fn resolve(&mut self, other: &Self) {
        if let (Some(own), Some(other)) = (&mut self.follow, &other.follow) {
            own.resolve(other);
        }
    }

    /// Returns whether the constraint has the animation that it follows, if it follows one and was not released.
    pub(super) fn is_resolved(&self) -> bool {
        self.is_released()
            || self.follow.as_ref().is_none_or(|follow| follow.is_resolved(self.vertices.len()))
    }
}
