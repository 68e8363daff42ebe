//! Rigid motions of a component.

use std::ops::{Add, Mul, Sub};

use nalgebra::{Matrix3, Vector3, Vector6};

/// Principal inertia, as a fraction of the trace of the inertia tensor, below which an axis counts as that of points
/// on a line.
const LEAST_INERTIA: f64 = 1e-9;

/// A rigid motion v + ω × (x - c), where c is the center of mass of a component, in cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::dynamics) struct RigidMotion {
    /// v, the velocity of the center of mass, in cells/s.
    pub(in crate::dynamics) linear: Vector3<f64>,
    /// ω, the angular velocity, in rad/s.
    pub(in crate::dynamics) angular: Vector3<f64>,
}

impl RigidMotion {
    /// No motion.
    pub(in crate::dynamics) const ZERO: Self =
        Self { linear: Vector3::new(0.0, 0.0, 0.0), angular: Vector3::new(0.0, 0.0, 0.0) };

    /// Creates the motion with the components (v, ω).
    pub(in crate::dynamics) fn from_components(m: &Vector6<f64>) -> Self {
        Self { linear: Vector3::new(m[0], m[1], m[2]), angular: Vector3::new(m[3], m[4], m[5]) }
    }

    /// Returns the components (v, ω).
    pub(in crate::dynamics) fn components(&self) -> Vector6<f64> {
        stack(&self.linear, &self.angular)
    }

    /// Converts the motion to a velocity field about the body's origin. `center` is c. Returns zero if the motion is
    /// not finite.
    pub(in crate::dynamics) fn about_origin(self, center: Vector3<f64>) -> RigidVelocity {
        let at_origin = self.linear - self.angular.cross(&center);
        let is_finite = at_origin.iter().chain(self.angular.iter()).all(|x| x.is_finite());
        if !is_finite {
            return RigidVelocity::default();
        }
        RigidVelocity {
            linear: at_origin.map(|v| v as f32).into(),
            angular: self.angular.map(|v| v as f32).into(),
        }
    }
}

impl Add for RigidMotion {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { linear: self.linear + other.linear, angular: self.angular + other.angular }
    }
}

impl Sub for RigidMotion {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self { linear: self.linear - other.linear, angular: self.angular - other.angular }
    }
}

impl Mul<f64> for RigidMotion {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self { linear: self.linear * factor, angular: self.angular * factor }
    }
}

/// A rigid velocity field v + ω × x, where x is a position in cells from the body's origin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct RigidVelocity {
    /// v, the velocity at the body's origin, in cells/s.
    pub(in crate::dynamics) linear: [f32; 3],
    /// ω, the angular velocity, in rad/s.
    pub(in crate::dynamics) angular: [f32; 3],
}

/// Returns the six components of two vectors.
pub(in crate::dynamics) fn stack(a: &Vector3<f64>, b: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(a.x, a.y, a.z, b.x, b.y, b.z)
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
