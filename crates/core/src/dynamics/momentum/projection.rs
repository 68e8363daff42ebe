//! Projects the motion of a component on rigid motions that satisfy linear conditions.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use super::rigid::{RigidMotion, principal_axes};
use super::sums::RigidState;

/// A condition that has less than this fraction of the mobility of the unconstrained component left is already
/// determined by the earlier conditions.
const DETERMINED: f64 = 1e-9;

/// Variance of a soft condition, as a fraction of the mobility of the unconstrained component. Soft conditions that
/// contradict each other, as those of two plates that press on a body do, give a compromise. The speeds of the compromise
/// are at most 1/(2 √`SOFTNESS`) = 2.2 times those in the conditions, however small the lever between them is.
pub(crate) const SOFTNESS: f64 = 0.05;

/// How strictly a condition is met.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Weight {
    /// Exactly.
    Exact,
    /// With the variance [`SOFTNESS`].
    Soft,
}

/// Projects a rigid motion, in the metric of the mass, on the rigid motions that satisfy linear conditions, which are
/// added one by one. It is the least-squares estimate with exact or uncertain data (Kalman 1960): an exact condition
/// that contradicts earlier exact ones has no effect.
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

    /// Returns the change of (v, ω) per unit of impulse (p, l) that the conditions allow.
    pub(crate) fn mobility(&self) -> &Matrix6<f64> {
        &self.mobility
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
