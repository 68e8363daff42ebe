//! The motion of a rigid body.

use std::ops::{Add, Mul, Sub};

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3, Vector6};

/// Pose and momenta of a rigid body, in f64. The positions, velocities and rotations of the lattice vertices follow from
/// them.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct RigidPose {
    /// Center of mass, in cells from the body's origin.
    center: [f64; 3],
    /// Rotation from the rest pose: a unit quaternion (x, y, z, w).
    rotation: [f64; 4],
    /// Velocity of the center of mass, in cells/s.
    velocity: [f64; 3],
    /// Angular momentum about the center of mass; mass in units of a full cell's mass, lengths in cells.
    angular_momentum: [f64; 3],
}

impl RigidPose {
    /// Creates the pose of a body without motion.
    pub(crate) fn at_rest(center: Vector3<f64>, rotation: UnitQuaternion<f64>) -> Self {
        let mut pose = Self {
            center: center.into(),
            rotation: [0.0; 4],
            velocity: [0.0; 3],
            angular_momentum: [0.0; 3],
        };
        pose.set_rotation(rotation);
        pose
    }

    /// Returns the center of mass, in cells from the body's origin.
    pub(crate) fn center(&self) -> Vector3<f64> {
        self.center.into()
    }

    pub(crate) fn set_center(&mut self, center: Vector3<f64>) {
        self.center = center.into();
    }

    /// Returns the rotation from the rest pose.
    pub(crate) fn rotation(&self) -> UnitQuaternion<f64> {
        let [x, y, z, w] = self.rotation;
        UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z))
    }

    /// Sets the rotation, with the rounding errors of its norm removed.
    pub(crate) fn set_rotation(&mut self, rotation: UnitQuaternion<f64>) {
        let Quaternion { coords } = *UnitQuaternion::new_normalize(rotation.into_inner());
        self.rotation = coords.into();
    }

    /// Returns the velocity of the center of mass, in cells/s.
    pub(crate) fn velocity(&self) -> Vector3<f64> {
        self.velocity.into()
    }

    pub(crate) fn set_velocity(&mut self, velocity: Vector3<f64>) {
        self.velocity = velocity.into();
    }

    /// Returns the angular momentum about the center of mass.
    pub(crate) fn angular_momentum(&self) -> Vector3<f64> {
        self.angular_momentum.into()
    }

    pub(crate) fn set_angular_momentum(&mut self, momentum: Vector3<f64>) {
        self.angular_momentum = momentum.into();
    }

    /// Sets the momenta to zero.
    pub(crate) fn stop(&mut self) {
        (self.velocity, self.angular_momentum) = ([0.0; 3], [0.0; 3]);
    }

    /// Checks deserialized data.
    pub(super) fn is_valid(&self) -> bool {
        let vectors = [self.center, self.velocity, self.angular_momentum];
        let norm = self.rotation.iter().map(|x| x * x).sum::<f64>();
        vectors.iter().flatten().all(|x| x.is_finite()) && (norm - 1.0).abs() < 1e-6
    }
}

/// A rigid displacement, or a rigid motion: the translation of the center of mass and the rotation about it, in cells and
/// radians, or per second. Also an impulse and an angular impulse about the center of mass, and the row of a condition on
/// both. In scene units where bodies are coupled.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Twist {
    pub(crate) linear: Vector3<f64>,
    pub(crate) angular: Vector3<f64>,
}

impl Twist {
    /// Creates the motion with the components (v, ω).
    pub(crate) fn from_components(m: &Vector6<f64>) -> Self {
        Self { linear: Vector3::new(m[0], m[1], m[2]), angular: Vector3::new(m[3], m[4], m[5]) }
    }

    /// Returns the components (v, ω).
    pub(crate) fn components(&self) -> Vector6<f64> {
        let Self { linear: v, angular: w } = self;
        Vector6::new(v.x, v.y, v.z, w.x, w.y, w.z)
    }

    /// Returns the velocity of a point at `arm` from the center of mass.
    pub(crate) fn velocity_at(&self, arm: &Vector3<f64>) -> Vector3<f64> {
        self.linear + self.angular.cross(arm)
    }
}

impl Add for Twist {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { linear: self.linear + other.linear, angular: self.angular + other.angular }
    }
}

impl Sub for Twist {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self { linear: self.linear - other.linear, angular: self.angular - other.angular }
    }
}

impl Mul<f64> for Twist {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self { linear: self.linear * factor, angular: self.angular * factor }
    }
}

/// The change of the motion of a rigid body by an impulse. Masses are in units of a full cell's mass, lengths in cells.
///
/// ```text
/// change of v = linear p + coupling l      change of ω = couplingᵀ p + angular l
/// ```
///
/// with the impulse p and the angular impulse l about the center of mass. The coupling is zero unless the body is held.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RigidMobility {
    /// Center of mass, in cells from the body's origin.
    pub(crate) center: Vector3<f64>,
    /// Distance from the center within which all lattice vertices are, in cells.
    pub(crate) bounding_radius: f64,
    pub(crate) linear: Matrix3<f64>,
    pub(crate) coupling: Matrix3<f64>,
    pub(crate) angular: Matrix3<f64>,
}

impl RigidMobility {
    /// Returns the change of the motion by an impulse.
    pub(crate) fn change(&self, impulse: &Twist) -> Twist {
        let Twist { linear, angular } = impulse;
        Twist {
            linear: self.linear * linear + self.coupling * angular,
            angular: self.coupling.tr_mul(linear) + self.angular * angular,
        }
    }
}
