//! Rigid velocity fields of a component, and its principal axes.

use nalgebra::{Matrix3, Vector3};

use crate::state::Twist;

/// Principal inertia, as a fraction of the trace of the inertia tensor, below which an axis counts as that of points
/// on a line.
const LEAST_INERTIA: f64 = 1e-9;

/// A rigid velocity field v + ω × x, where x is a position in cells from the body's origin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct RigidVelocity {
    /// v, the velocity at the body's origin, in cells/s.
    pub(in crate::dynamics) linear: [f32; 3],
    /// ω, the angular velocity, in rad/s.
    pub(in crate::dynamics) angular: [f32; 3],
}

impl RigidVelocity {
    /// Converts a motion about the center of mass of a component, `center`, to a velocity field about the body's origin.
    /// Returns zero if the motion is not finite.
    pub(in crate::dynamics) fn of(motion: Twist, center: Vector3<f64>) -> Self {
        let at_origin = motion.linear - motion.angular.cross(&center);
        let is_finite = at_origin.iter().chain(motion.angular.iter()).all(|x| x.is_finite());
        if !is_finite {
            return Self::default();
        }
        Self { linear: at_origin.map(|v| v as f32).into(), angular: motion.angular.map(|v| v as f32).into() }
    }
}

/// Returns the principal inertias and axes, without the axis of points on a line.
pub(super) fn principal_axes(inertia: &Matrix3<f64>) -> impl Iterator<Item = (f64, Vector3<f64>)> {
    let scale = inertia.trace();
    let is_valid = scale > 0.0 && scale.is_finite();
    let eigen = is_valid.then(|| (inertia / scale).symmetric_eigen());
    eigen.into_iter().flat_map(move |eigen| {
        let axes = [0, 1, 2].map(|k| (eigen.eigenvalues[k], eigen.eigenvectors.column(k).into_owned()));
        axes.into_iter()
            .filter(|(value, _)| *value > LEAST_INERTIA)
            .map(move |(value, axis)| (value * scale, axis))
    })
}
