//! Vectors and poses of Rapier, which are glam's in f32, as nalgebra's in f64, and back.

use nalgebra::{Isometry3, Matrix3, Quaternion, Translation3, UnitQuaternion, Vector3};
use rapier3d::math::{Pose, Rotation, Vector};
use rapier3d::parry::mass_properties::MassProperties;

/// A motion, or an impulse with an angular impulse about the center of mass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Twist {
    pub(crate) linear: Vector3<f64>,
    pub(crate) angular: Vector3<f64>,
}

impl std::ops::Add for Twist {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { linear: self.linear + other.linear, angular: self.angular + other.angular }
    }
}

impl std::ops::Sub for Twist {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self { linear: self.linear - other.linear, angular: self.angular - other.angular }
    }
}

impl Twist {
    /// Returns whether the impulses, and the forces that give them in `dt` seconds, are finite numbers of Rapier.
    pub(crate) fn fits(&self, dt: f64) -> bool {
        let fits = |impulse: Vector3<f64>| narrow(impulse).is_finite() && narrow(impulse / dt).is_finite();
        fits(self.linear) && fits(self.angular)
    }
}

pub(crate) fn wide(vector: Vector) -> Vector3<f64> {
    Vector3::new(vector.x, vector.y, vector.z).map(f64::from)
}

pub(crate) fn narrow(vector: Vector3<f64>) -> Vector {
    Vector::new(vector.x as f32, vector.y as f32, vector.z as f32)
}

pub(crate) fn wide_pose(pose: &Pose) -> Isometry3<f64> {
    Isometry3::from_parts(Translation3::from(wide(pose.translation)), wide_rotation(pose.rotation))
}

fn wide_rotation(rotation: Rotation) -> UnitQuaternion<f64> {
    let [x, y, z, w] = [rotation.x, rotation.y, rotation.z, rotation.w].map(f64::from);
    // In f64 the quaternion is a unit one only to the rounding errors of f32.
    UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z))
}

/// The mass of a Rapier body in f64. Rapier stores the inverses of the mass and of the principal moments.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mass {
    pub(crate) mass: f64,
    /// Center of mass in the frame of the body.
    pub(crate) center: Vector3<f64>,
    /// Inertia tensor in the frame of the body. A principal moment that Rapier takes as infinite is 0.
    pub(crate) inertia: Matrix3<f64>,
}

impl Mass {
    pub(crate) fn new(properties: &MassProperties) -> Self {
        let inverse = |x: f64| if x > 0.0 { 1.0 / x } else { 0.0 };
        let moments = wide(properties.inv_principal_inertia).map(inverse);
        let frame = wide_rotation(properties.principal_inertia_local_frame);
        let inertia = rotated(&Matrix3::from_diagonal(&moments), &frame);
        Self {
            mass: inverse(f64::from(properties.inv_mass)),
            center: wide(properties.local_com),
            inertia: (inertia + inertia.transpose()) / 2.0,
        }
    }

    /// Returns the inertia tensor in world space.
    pub(crate) fn inertia_at(&self, rotation: &UnitQuaternion<f64>) -> Matrix3<f64> {
        rotated(&self.inertia, rotation)
    }
}

/// Returns a tensor that is turned with its body.
fn rotated(tensor: &Matrix3<f64>, rotation: &UnitQuaternion<f64>) -> Matrix3<f64> {
    let rotation = rotation.to_rotation_matrix();
    rotation.matrix() * tensor * rotation.matrix().transpose()
}
