//! Projects the motion of a component on rigid motions, and on rigid motions that satisfy linear conditions.

use std::ops::{Add, Mul, Sub};

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use super::sums::{RigidState, RigidVelocity};

/// A condition that has less than this fraction of the mobility of the unconstrained component left is already
/// determined by the earlier conditions.
const DETERMINED: f64 = 1e-9;

/// Principal inertia, as a fraction of the trace of the inertia tensor, below which an axis counts as that of points
/// on a line.
const LEAST_INERTIA: f64 = 1e-9;

/// Variance of a soft condition, as a fraction of the mobility of the unconstrained component. Soft conditions that
/// contradict each other, as those of two plates that press on a body do, give a compromise. The speeds of the compromise
/// are at most 1/(2 √`SOFTNESS`) = 2.2 times those in the conditions, however small the lever between them is.
const SOFTNESS: f64 = 0.05;

/// How strictly a condition is met.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Weight {
    /// Exactly.
    Exact,
    /// With the variance [`SOFTNESS`].
    Soft,
}

/// A rigid motion v + ω × (x - c), where c is the center of mass of a component, in cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RigidMotion {
    /// v, the velocity of the center of mass, in cells/s.
    pub(crate) linear: Vector3<f64>,
    /// ω, the angular velocity, in rad/s.
    pub(crate) angular: Vector3<f64>,
}

impl RigidMotion {
    /// Converts the motion to a velocity field about the body's origin. `center` is c. Returns zero if the motion is
    /// not finite.
    pub(super) fn about_origin(self, center: Vector3<f64>) -> RigidVelocity {
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

/// Projects a rigid motion, in the metric of the mass, on the rigid motions that satisfy linear conditions, which are
/// added one by one. It is the least-squares estimate with exact or uncertain data (Kalman 1960): a condition that
/// contradicts the earlier ones has no effect.
#[derive(Clone, Debug)]
pub(crate) struct Projection {
    /// (v, ω).
    motion: Vector6<f64>,
    /// Mobility of the component: (v, ω) per unit of impulse (p, l), restricted to the conditions so far.
    mobility: Matrix6<f64>,
    /// Mobility without conditions.
    free: Matrix6<f64>,
    center: Vector3<f64>,
}

impl Projection {
    /// Creates the projection of `motion` of a component, without conditions.
    pub(crate) fn new(component: &RigidState, motion: RigidMotion) -> Self {
        let mut mobility = Matrix6::zeros();
        mobility.fixed_view_mut::<3, 3>(0, 0).copy_from(&(Matrix3::identity() / component.mass));
        let mut angular = Matrix3::zeros();
        for (inertia, axis) in principal_axes(component.inertia()) {
            angular += axis * axis.transpose() / inertia;
        }
        mobility.fixed_view_mut::<3, 3>(3, 3).copy_from(&angular);
        let RigidMotion { linear, angular } = motion;
        let motion = Vector6::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z);
        Self { motion, mobility, free: mobility, center: component.center }
    }

    /// Adds the condition that the velocity of the component at `point`, in cells from the body's origin, has the
    /// component `speed` along the unit vector `direction`.
    pub(crate) fn fix_velocity(
        &mut self,
        point: Vector3<f64>,
        direction: Vector3<f64>,
        speed: f64,
        weight: Weight,
    ) {
        let moment = (point - self.center).cross(&direction);
        self.fix(stack(direction, moment), speed, weight);
    }

    /// Adds the condition that the angular velocity has the component `speed` along the unit vector `axis`.
    pub(crate) fn fix_spin(&mut self, axis: Vector3<f64>, speed: f64, weight: Weight) {
        self.fix(stack(Vector3::zeros(), axis), speed, weight);
    }

    /// Adds the conditions that the component moves like some of its vertices: `vertices` is the rigid state of these
    /// vertices, with unit masses. Vertices on a line leave the rotation about the line free, and a single vertex
    /// leaves all rotations free.
    pub(crate) fn fix_vertices(&mut self, vertices: &RigidState) {
        let RigidMotion { linear, angular } = vertices.motion(vertices.momentum);
        for c in 0..3 {
            self.fix_velocity(vertices.center, Vector3::ith(c, 1.0), linear[c], Weight::Exact);
        }
        for (_, axis) in principal_axes(vertices.inertia()) {
            self.fix_spin(axis, axis.dot(&angular), Weight::Exact);
        }
    }

    /// Adds the condition `row` · (v, ω) = `value`.
    fn fix(&mut self, row: Vector6<f64>, value: f64, weight: Weight) {
        let response = self.mobility * row;
        let (left, free) = (row.dot(&response), row.dot(&(self.free * row)));
        if left.is_nan() || left <= DETERMINED * free {
            return;
        }
        let softness = match weight {
            Weight::Exact => 0.0,
            Weight::Soft => SOFTNESS * free,
        };
        let gain = response / (left + softness);
        self.motion += gain * (value - row.dot(&self.motion));
        self.mobility -= gain * response.transpose();
    }

    /// Returns the projected motion.
    pub(crate) fn motion(&self) -> RigidMotion {
        let m = &self.motion;
        RigidMotion { linear: Vector3::new(m[0], m[1], m[2]), angular: Vector3::new(m[3], m[4], m[5]) }
    }
}

fn stack(linear: Vector3<f64>, angular: Vector3<f64>) -> Vector6<f64> {
    Vector6::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
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
