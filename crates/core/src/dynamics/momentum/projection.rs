//! Projects the motion of a component on rigid motions that satisfy linear conditions.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use super::rigid::principal_axes;
use super::sums::RigidState;
use crate::state::Twist;

/// A condition that has less than this fraction of the mobility of the unconstrained component left is already
/// determined by the earlier conditions.
const DETERMINED: f64 = 1e-9;

/// Variance of a soft condition, as a fraction of the mobility of the unconstrained component. Soft conditions that
/// contradict each other, for example of two plates that press on a body, give a compromise. The speeds of the
/// compromise are at most 1/(2 √`SOFTNESS`) = 2.2 times those in the conditions, however small the lever between them
/// is.
pub(in crate::dynamics) const SOFTNESS: f64 = 0.05;

/// The change of a rigid motion (v, ω) by an impulse (p, l).
#[derive(Clone, Debug)]
pub(in crate::dynamics) struct Mobility {
    /// Change per unit of impulse that the conditions allow.
    allowed: Matrix6<f64>,
    /// Change per unit of impulse without conditions.
    free: Matrix6<f64>,
}

/// The change of a rigid motion by an impulse along a row, and the speeds of this change along the row.
#[derive(Clone, Copy, Debug)]
pub(in crate::dynamics) struct Response {
    /// Change that the conditions allow; zero if the conditions already determine the speed along the row.
    pub(in crate::dynamics) motion: Vector6<f64>,
    /// Speed of `motion` along the row.
    pub(in crate::dynamics) speed: f64,
    /// Speed without conditions.
    pub(in crate::dynamics) free_speed: f64,
}

impl Mobility {
    /// Creates the mobility of a body without conditions. `inertia` is the inertia tensor about the center of mass.
    pub(in crate::dynamics) fn of_body(mass: f64, inertia: &Matrix3<f64>) -> Self {
        let mut free = Matrix6::zeros();
        free.fixed_view_mut::<3, 3>(0, 0).copy_from(&(Matrix3::identity() / mass));
        let mut angular = Matrix3::zeros();
        for (inertia, axis) in principal_axes(inertia) {
            angular += axis * axis.transpose() / inertia;
        }
        free.fixed_view_mut::<3, 3>(3, 3).copy_from(&angular);
        Self { allowed: free, free }
    }

    /// Creates the mobility of the rotations alone: the change of ω by an angular impulse.
    pub(in crate::dynamics) fn of_angular(angular: &Matrix3<f64>) -> Self {
        let mut free = Matrix6::zeros();
        free.fixed_view_mut::<3, 3>(3, 3).copy_from(angular);
        Self { allowed: free, free }
    }

    /// Returns the change of ω by an angular impulse of 1 about `axis`.
    pub(in crate::dynamics) fn turn(&self, axis: Vector3<f64>) -> Vector3<f64> {
        self.allowed.fixed_view::<3, 3>(3, 3) * axis
    }

    /// Returns the mobility in other units: `length` and `mass` are the old units of length and mass in the new ones.
    /// The units of v and ω are old lengths per second, and radians per second.
    pub(in crate::dynamics) fn in_units(mut self, length: f64, mass: f64) -> Self {
        // An angular impulse has two lengths, a linear one has one, and a velocity has one.
        let lengths = |index: usize| if index < 3 { 0 } else { -1 };
        for matrix in [&mut self.allowed, &mut self.free] {
            for (row, column) in (0..6).flat_map(|row| (0..6).map(move |column| (row, column))) {
                matrix[(row, column)] *= length.powi(lengths(row) + lengths(column)) / mass;
            }
        }
        self
    }

    /// Returns the change of the motion by a unit impulse along `row`, without conditions.
    pub(in crate::dynamics) fn free_change(&self, row: &Vector6<f64>) -> Vector6<f64> {
        self.free * row
    }

    /// Returns the response to a unit impulse along `row`.
    pub(in crate::dynamics) fn response(&self, row: &Vector6<f64>) -> Response {
        let motion = self.allowed * row;
        let (speed, free_speed) = (row.dot(&motion), row.dot(&(self.free * row)));
        if speed.is_finite() && speed > DETERMINED * free_speed {
            Response { motion, speed, free_speed }
        } else {
            Response { motion: Vector6::zeros(), speed: 0.0, free_speed }
        }
    }
}

/// Projects a rigid motion, in the metric of the mass, on the rigid motions that satisfy linear conditions, which are
/// added one by one. It is the least-squares estimate with exact or uncertain data (Kalman 1960): an exact condition
/// that contradicts earlier exact ones has no effect.
#[derive(Clone, Debug)]
pub(in crate::dynamics) struct Projection {
    /// (v, ω).
    motion: Vector6<f64>,
    mobility: Mobility,
    center: Vector3<f64>,
}

impl Projection {
    /// Creates the projection of `motion` of a component, without further conditions. `center` is its center of mass.
    pub(in crate::dynamics) fn new(mobility: Mobility, motion: Twist, center: Vector3<f64>) -> Self {
        Self { motion: motion.components(), mobility, center }
    }

    /// Adds the condition that the velocity of the component at `point`, in cells from the body's origin, has the
    /// component `speed` along the unit vector `direction`.
    pub(in crate::dynamics) fn fix_velocity(
        &mut self,
        point: Vector3<f64>,
        direction: Vector3<f64>,
        speed: f64,
    ) {
        let moment = (point - self.center).cross(&direction);
        self.fix(Twist { linear: direction, angular: moment }.components(), speed, 0.0);
    }

    /// Adds the condition that the angular velocity has the component `speed` along the unit vector `axis`.
    pub(in crate::dynamics) fn fix_spin(&mut self, axis: Vector3<f64>, speed: f64) {
        self.fix(Twist { angular: axis, ..Twist::default() }.components(), speed, 0.0);
    }

    /// Adds the conditions that the component moves like some of its vertices: `vertices` is the rigid state of these
    /// vertices, with unit masses. Vertices on a line leave the rotation about the line free, and a single vertex
    /// leaves all rotations free.
    pub(in crate::dynamics) fn fix_vertices(&mut self, vertices: &RigidState) {
        let Twist { linear, angular } = vertices.motion(vertices.momentum);
        for c in 0..3 {
            self.fix_velocity(vertices.center, Vector3::ith(c, 1.0), linear[c]);
        }
        for (_, axis) in principal_axes(&vertices.inertia) {
            self.fix_spin(axis, axis.dot(&angular));
        }
    }

    /// Adds the soft condition `row` · (v, ω) = `value`. Returns its variance, or 0 if earlier conditions determine the
    /// speed along the row. The impulse that meets it is (`value` - `row` · (v, ω)) / variance, with the projected motion.
    pub(in crate::dynamics) fn fix_softly(&mut self, row: Vector6<f64>, value: f64) -> f64 {
        self.fix(row, value, SOFTNESS)
    }

    /// Adds the condition `row` · (v, ω) = `value`, and returns its variance. `softness`: this variance as a fraction of the
    /// mobility of the unconstrained component.
    fn fix(&mut self, row: Vector6<f64>, value: f64, softness: f64) -> f64 {
        let Response { motion, speed, free_speed } = self.mobility.response(&row);
        if speed == 0.0 {
            return 0.0;
        }
        let softness = softness * free_speed;
        let gain = motion / (speed + softness);
        self.motion += gain * (value - row.dot(&self.motion));
        self.mobility.allowed -= gain * motion.transpose();
        softness
    }

    /// Returns the change of the projected motion by impulses.
    pub(in crate::dynamics) fn mobility(&self) -> &Mobility {
        &self.mobility
    }

    /// Returns the projected motion.
    pub(in crate::dynamics) fn motion(&self) -> Twist {
        Twist::from_components(&self.motion)
    }
}
