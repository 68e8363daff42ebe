//! A constraint in a step: what it captures, and where and how it moves its vertices.

use std::borrow::Cow;

use nalgebra::{Point3, Vector3};

use super::{Capture, Constraint};
use crate::dynamics::follow::Follow;
use crate::motion::Pose;
use crate::parallel::Executor;
use crate::state::{BodyState, Interval};

impl Constraint {
    /// Returns whether the constraint does not move, begin or end in a step, and was not released.
    pub(in crate::dynamics) fn is_static(&self, step: Interval) -> bool {
        let follows = || self.follow.as_ref().is_some_and(|follow| follow.moves(step));
        let weight_changes = || self.goal.as_ref().is_some_and(|goal| goal.changes_in(step));
        let moves = || self.pose(step.start) != self.pose(step.end) || follows() || weight_changes();
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

    /// Begins a step: captures positions if the constraint becomes active for the first time, or computes the targets
    /// of an animation, and the accelerations of a soft goal. Returns whether the constraint begins or ends to prescribe
    /// positions.
    pub(in crate::dynamics) fn begin(
        &mut self,
        step: Interval,
        (state, slots): (&BodyState<'_>, &[u32]),
        executor: &Executor,
    ) -> bool {
        let active = self.acts_in(step);
        if active && let Some(follow) = &mut self.follow {
            follow.begin(step, executor);
        } else if active && self.capture.is_none() {
            self.capture = Some(Capture::new(&self.vertices, state, slots));
        }
        self.active = active;
        let holds = active && self.goal.as_ref().is_none_or(|goal| goal.is_hard(step.start));
        let changes = holds != std::mem::replace(&mut self.holds, holds);
        if active && !self.holds_all() {
            let mut pulls = std::mem::take(&mut self.pulls);
            pulls.clear();
            let accelerations = self.accelerations(step, state, slots);
            pulls.extend(accelerations.map(|(vertex, acceleration)| (vertex, acceleration.into())));
            self.pulls = pulls;
        }
        changes
    }

    /// Returns, for each vertex that is not held, the acceleration by a soft goal in a step, from the positions before the
    /// step. If the constraint follows an animation, the step must be the one that began last.
    pub(crate) fn accelerations(
        &self,
        step: Interval,
        state: &BodyState<'_>,
        slots: &[u32],
    ) -> impl Iterator<Item = (u32, Vector3<f64>)> {
        let goal = self.goal.as_ref().filter(|goal| self.weights.is_some() || !goal.is_hard(step.start));
        goal.into_iter().flat_map(move |goal| {
            let uniform = goal.factors(step.start, step.dt, 1.0);
            self.targets(step).enumerate().filter(|(place, _)| !self.holds_place(*place)).map(
                move |(place, (vertex, target, change))| {
                    let [stiffness, damping] = match &self.weights {
                        None => uniform,
                        Some(weights) => goal.factors(step.start, step.dt, weights[place]),
                    };
                    let slot = slots[vertex as usize];
                    // Differences in local coordinates keep the accuracy far from the origin of world space.
                    let distance = state.position(slot) - state.frame.to_local(&target);
                    let distance = distance * state.frame.cell_size + change;
                    let velocity = state.velocity(slot) * state.frame.cell_size - change / step.dt;
                    (vertex, -(distance * stiffness + velocity * damping))
                },
            )
        })
    }

    /// Returns the vertices that a soft goal pulls in the current step, with their accelerations.
    pub(in crate::dynamics) fn pulls(&self) -> impl Iterator<Item = (u32, Vector3<f64>)> {
        self.pulls.iter().map(|&(vertex, pull)| (vertex, pull.into()))
    }

    /// Forgets the accelerations, which were applied.
    pub(in crate::dynamics) fn clear_pulls(&mut self) {
        self.pulls.clear();
    }

    /// Returns the vertices that a soft goal pulls in the current step.
    pub(in crate::dynamics) fn pulled(&self) -> impl Iterator<Item = u32> {
        self.vertices_at(self.active && !self.holds_all(), |place| !self.holds_place(place))
    }

    /// Returns the constraint at the beginning of another step, for [`targets`](Self::targets).
    pub(crate) fn in_step(&self, step: Interval, executor: &Executor) -> Cow<'_, Self> {
        let mut constraint = Cow::Borrowed(self);
        if self.follow.is_some()
            && let Some(follow) = &mut constraint.to_mut().follow
        {
            follow.begin(step, executor);
        }
        constraint
    }

    /// Returns, for each vertex, its index, its target position at the end of a step, in world space, and the change of
    /// the target position during the step. Nothing without captured positions. If the constraint follows an animation,
    /// the step must be the one that began last.
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
        let captured = captures.map(move |(center, captured)| {
            let target = if self.motion.is_some() { end.apply(&center, &captured) } else { captured };
            (target, rotation_change * (captured - center) + translation_change)
        });
        let targets = captured.chain(self.follow.iter().flat_map(Follow::targets));
        self.vertices.iter().zip(targets).map(|(&vertex, (target, change))| (vertex, target, change))
    }

    /// Ends a step: moves the vertices to their target positions at the end of the step. Their velocity is
    /// the change of the target position during the step, divided by dt.
    pub(in crate::dynamics) fn apply(&self, step: Interval, state: &mut BodyState<'_>, slots: &[u32]) {
        if !self.holds {
            return;
        }
        let to_local_velocity = 1.0 / (step.dt * state.frame.cell_size);
        for (place, (vertex, target, change)) in self.targets(step).enumerate() {
            if !self.holds_place(place) {
                continue;
            }
            let slot = slots[vertex as usize];
            state.set_position(slot, state.frame.to_local(&target));
            state.set_velocity(slot, change * to_local_velocity);
        }
    }

    /// Returns the pose at `time`, in seconds. Without keyframes, it is the identity.
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
