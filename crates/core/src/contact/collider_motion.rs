//! The motion of a collider: at rest, along keyframes, or driven to a pose.

use crate::motion::{Drive, EulerPose, Motion, Pose};
use crate::state::Interval;

/// Motion of a collider.
#[derive(Clone, Debug)]
pub(super) enum ColliderMotion {
    Rest,
    Keys(Motion),
    /// Driven to a pose. Boxed, because `Drive` is larger than the other variants.
    Driven(Box<Drive>),
}

impl ColliderMotion {
    pub(super) fn driven(drive: Drive) -> Self {
        Self::Driven(Box::new(drive))
    }

    pub(super) fn from_keys(motion: Option<Motion>) -> Self {
        motion.map_or(Self::Rest, Self::Keys)
    }

    /// Returns the poses before and after a step.
    pub(super) fn euler_poses(&self, step: Interval) -> [EulerPose; 2] {
        match self {
            Self::Rest => [EulerPose::default(); 2],
            Self::Keys(motion) => [step.start, step.end].map(|time| motion.euler_pose(time)),
            Self::Driven(drive) => [drive.current(), drive.after(step.dt)],
        }
    }

    /// Returns the pose at `time` in seconds, which is the current time.
    pub(super) fn pose(&self, time: f64) -> Pose {
        match self {
            Self::Rest => Pose::identity(),
            Self::Keys(motion) => motion.pose(time),
            Self::Driven(drive) => drive.current().pose(),
        }
    }

    /// Returns the poses before and after a step, and whether the collider moves. Keyframes always count as
    /// motion.
    pub(super) fn poses(&self, step: Interval) -> ([Pose; 2], bool) {
        match self {
            Self::Rest => ([Pose::identity(); 2], false),
            Self::Keys(_) => (self.euler_poses(step).map(|pose| pose.pose()), true),
            Self::Driven(_) => {
                let [start, end] = self.euler_poses(step);
                ([start.pose(), end.pose()], start != end)
            }
        }
    }
}
