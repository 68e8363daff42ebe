//! Defines the motion to a target pose by which a collider is driven from step to step.

use super::keyframes::EulerPose;
use crate::range::{RangeError, in_range};

/// Largest valid magnitude of a target displacement and angle. Differences of such numbers are finite.
const LIMIT: f64 = 1e15;

/// The motion takes its last step if it ends within this fraction of a step after the step. A duration of `n`
/// steps leaves a rounding error of about `n²` 2^-53 steps, so for `n` up to 90,000 it takes `n` steps.
const ROUNDING: f64 = 1e-6;

/// A linear motion from the current pose to a target pose, and rest at the target.
///
/// It advances with the steps and does not refer to the time of the simulation, so that it continues when the
/// time or the step length is set. The Euler angles are interpolated, as in a [`Motion`](super::Motion).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Drive {
    current: EulerPose,
    target: EulerPose,
    /// Time until the target is reached, in seconds. If it is at most one step, the next step reaches it.
    remaining: f64,
}

impl Drive {
    /// Creates the motion from `current` to `target`, which takes `duration` seconds, at least one step;
    /// `None`: one step.
    ///
    /// # Errors
    /// A component of `target` that is not finite or exceeds 1e15 in magnitude, or a duration that is not
    /// finite and greater than zero.
    pub(crate) fn new(
        current: EulerPose,
        target: EulerPose,
        duration: Option<f64>,
    ) -> Result<Self, RangeError> {
        for (name, values) in [("translate", target.translate), ("rotate", target.rotate)] {
            for x in values {
                in_range(name, x, x.abs() <= LIMIT, "finite and at most 1e15 in magnitude")?;
            }
        }
        if let Some(seconds) = duration {
            in_range("duration", seconds, seconds > 0.0, "a time in seconds, finite and greater than 0")?;
        }
        Ok(Self { current, target, remaining: duration.unwrap_or(0.0) })
    }

    /// Returns the pose before the next step.
    pub(crate) fn current(&self) -> EulerPose {
        self.current
    }

    /// Returns the pose after the next step, of `dt` seconds.
    pub(crate) fn after(&self, dt: f64) -> EulerPose {
        if self.is_last_step(dt) { self.target } else { self.current.lerp(&self.target, dt / self.remaining) }
    }

    /// Advances by a step of `dt` seconds.
    pub(crate) fn advance(&mut self, dt: f64) {
        let remaining = if self.is_last_step(dt) { 0.0 } else { self.remaining - dt };
        *self = Self { current: self.after(dt), remaining, ..*self };
    }

    fn is_last_step(&self, dt: f64) -> bool {
        self.remaining <= dt * (1.0 + ROUNDING)
    }

    /// Returns whether the values are valid; deserialized values may not be.
    pub(crate) fn is_valid(&self) -> bool {
        let Self { current, target, remaining } = self;
        let poses = [current.translate, current.rotate, target.translate, target.rotate];
        poses.as_flattened().iter().all(|x| x.is_finite()) && remaining.is_finite() && *remaining >= 0.0
    }
}
