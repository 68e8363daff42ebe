//! The vertices of a rigid body that pins and handles hold. They are joints: a single vertex is a ball joint, vertices on
//! a line are a hinge, and all others prescribe the pose.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use crate::dynamics::momentum::{RigidState, Sums};

/// Second moment of the held vertices, as a fraction of the sum of all three, below which they have no extent along an
/// axis.
const LEAST_EXTENT: f64 = 1e-9;

/// A vertex that a pin or handle holds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HeldVertex {
    /// Position from the center of mass in the rest pose, in cells.
    pub(crate) offset: Vector3<f64>,
    /// Target at the end of the step, in cells from the body's origin.
    pub(crate) target: Vector3<f64>,
    /// Velocity of the target, in cells/s.
    pub(crate) velocity: Vector3<f64>,
}

/// What the held vertices leave free.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Freedom {
    /// Nothing is held.
    Free,
    /// The rotation about a point.
    Ball,
    /// The rotation about a line.
    Hinge,
    /// Nothing.
    Fixed,
}

/// The held vertices of a step, as a whole.
#[derive(Clone, Copy, Debug)]
pub(super) struct Joint {
    pub(super) freedom: Freedom,
    /// Mean offset from the center of mass in the rest pose.
    pub(super) offset: Vector3<f64>,
    /// Mean target.
    pub(super) target: Vector3<f64>,
    /// Mean velocity of the targets.
    pub(super) velocity: Vector3<f64>,
}

impl Joint {
    pub(super) fn new(held: &[HeldVertex]) -> Self {
        let count = held.len().max(1) as f64;
        let mean =
            |vector: fn(&HeldVertex) -> Vector3<f64>| held.iter().map(vector).sum::<Vector3<f64>>() / count;
        let (offset, target, velocity) = (mean(|v| v.offset), mean(|v| v.target), mean(|v| v.velocity));
        Self { freedom: freedom(held, &offset), offset, target, velocity }
    }

    /// Returns the rotation nearest to `rotation` with which the vertices are nearest to their targets.
    pub(super) fn fitted(&self, held: &[HeldVertex], rotation: UnitQuaternion<f64>) -> UnitQuaternion<f64> {
        let arms =
            |vertex: &HeldVertex| (rotation * (vertex.offset - self.offset), vertex.target - self.target);
        match self.freedom {
            Freedom::Free | Freedom::Ball => rotation,
            Freedom::Hinge => {
                // The vertex farthest from the middle; the first one of several.
                let farthest =
                    held.iter().map(arms).fold((Vector3::zeros(), Vector3::zeros()), |far, arm| {
                        if arm.0.norm_squared() > far.0.norm_squared() { arm } else { far }
                    });
                UnitQuaternion::rotation_between(&farthest.0, &farthest.1)
                    .map_or(rotation, |turn| turn * rotation)
            }
            Freedom::Fixed => {
                let covariance: Matrix3<f64> =
                    held.iter().map(arms).map(|(arm, target)| target * arm.transpose()).sum();
                nearest_rotation(covariance).map_or(rotation, |turn| turn * rotation)
            }
        }
    }
}

/// Returns the motion of the vertices, with unit masses and their velocities at the positions `place`.
pub(super) fn motion_of(
    held: &[HeldVertex],
    motion: impl Fn(&HeldVertex) -> (Vector3<f64>, Vector3<f64>),
) -> RigidState {
    let mut sums = Sums::default();
    for (position, velocity) in held.iter().map(motion) {
        sums.add_vertex(1.0, position.into(), velocity.into());
    }
    sums.rigid_state(held.len() as f64)
}

/// Returns what vertices with the mean offset `mean` leave free.
fn freedom(held: &[HeldVertex], mean: &Vector3<f64>) -> Freedom {
    if held.is_empty() {
        return Freedom::Free;
    }
    let moment = |vertex: &HeldVertex| (vertex.offset - mean) * (vertex.offset - mean).transpose();
    let moments: Matrix3<f64> = held.iter().map(moment).sum();
    let extents = moments.symmetric_eigenvalues();
    let limit = LEAST_EXTENT * moments.trace();
    match extents.iter().filter(|extent| **extent > limit).count() {
        0 => Freedom::Ball,
        1 => Freedom::Hinge,
        _ => Freedom::Fixed,
    }
}

/// Returns the rotation R that maximises the trace of Rᵀ A (Kabsch 1976); `None` if A is not finite.
fn nearest_rotation(covariance: Matrix3<f64>) -> Option<UnitQuaternion<f64>> {
    if !covariance.iter().all(|x| x.is_finite()) {
        return None;
    }
    let svd = covariance.svd(true, true);
    let (u, v) = (svd.u?, svd.v_t?);
    // The singular values decrease, so that the last axis of points on a plane is free.
    let sign = (u.determinant() * v.determinant()).signum();
    let rotation = u * Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, sign)) * v;
    Some(UnitQuaternion::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(rotation)))
}
