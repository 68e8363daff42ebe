//! Descriptions of colliders: shapes with friction, restitution and keyframes.

use nalgebra::Point3;

use super::collision_mesh::CollisionMesh;
use super::fault::ColliderFault;
use super::shape::Shape;
use crate::mesh::Mesh;
use crate::motion::{Interpolation, Key, Motion, Pose, Switch, direction};
use crate::range::Range;

/// Rigid obstacle that bodies cannot enter.
#[derive(Clone, Debug, PartialEq)]
pub struct Collider {
    /// Shape.
    pub shape: Shape,
    /// Coulomb friction coefficient, >= 0: the greatest ratio of tangential to normal impulse. Default 0.5;
    /// 0: no friction.
    pub friction: f64,
    /// Ratio of the normal speed of the touching points after an impact to that before it, [0, 1]. Default 0.
    /// The rest of the body bounces by its elasticity, for any restitution: undamped, a soft body rises to most of the
    /// height of its fall at 0 as well. The damping of the body determines how high it bounces. At 1 the surface
    /// separates as fast as it approached; the body still rises less high than it fell, because the impact makes it
    /// vibrate. An impact slower than the speed of two steps of free fall does not bounce.
    pub restitution: f64,
    /// Coefficient of rolling resistance of bodies on the collider, >= 0, in place of that of the
    /// [body](crate::TouchingOptions::rolling_resistance). Default: `None`, that of the body; 0: bodies roll freely.
    pub rolling_resistance: Option<f64>,
    /// Distance outside of the surface at which bodies touch the collider, in scene units, >= 0; default 0. It is added
    /// to that of the [body](crate::TouchingOptions::thickness). An open mesh keeps at least a distance of 0.05 cells.
    pub thickness: f64,
    /// Keyframes of the motion of the shape about its center. Default: no keyframes; the collider is at rest.
    pub keys: Vec<Key>,
    /// Interpolation between the keyframes. Default: linear.
    pub interpolation: Interpolation,
    /// Whether the collider is enabled, at all times or along keyframes. Default: always. A disabled collider touches
    /// nothing: it has no contacts, limits no displayed surface, and rays do not meet it. It takes no time in a step,
    /// except for the deformation of an animated mesh. It moves on along its keyframes, and counts in the automatic
    /// number of steps, because it may be enabled later. Bodies that sleep near a collider wake up when it is enabled
    /// or disabled, and a body that is inside of it when it is enabled leaves it whole.
    pub enabled: Switch,
}

impl Collider {
    /// Creates a collider at rest with the default friction and restitution.
    pub fn new(shape: Shape) -> Self {
        Self {
            shape,
            friction: 0.5,
            restitution: 0.0,
            rolling_resistance: None,
            thickness: 0.0,
            keys: Vec::new(),
            interpolation: Interpolation::Linear,
            enabled: true.into(),
        }
    }

    /// Creates the half space below the plane through `point`; `normal` points to the free side.
    pub fn plane(point: [f64; 3], normal: [f64; 3]) -> Self {
        Self::new(Shape::Plane { point, normal })
    }

    /// Creates a ball.
    pub fn sphere(center: [f64; 3], radius: f64) -> Self {
        Self::new(Shape::Sphere { center, radius })
    }

    /// Creates a box, rotated by Euler angles in degrees about the fixed axes x, then y, then z.
    pub fn cuboid(center: [f64; 3], half_extents: [f64; 3], rotate: [f64; 3]) -> Self {
        Self::new(Shape::Box { center, half_extents, rotate })
    }

    /// Creates a capsule about the segment from `a` to `b`.
    pub fn capsule(a: [f64; 3], b: [f64; 3], radius: f64) -> Self {
        Self::new(Shape::Capsule { a, b, radius })
    }

    /// Creates a mesh as it is: a solid if it is closed, a thin shell if it is open. For a mesh that is scaled or
    /// placed, and for several colliders of one mesh, see [`Shape::Mesh`].
    ///
    /// # Errors
    /// [`ColliderFault::NoArea`] if no triangle has an area.
    pub fn mesh(mesh: Mesh) -> Result<Self, ColliderFault> {
        let (mesh, zero) = (CollisionMesh::new(mesh)?, [0.0; 3]);
        Ok(Self::new(Shape::Mesh { mesh, scale: 1.0, rotate: zero, translate: zero }))
    }

    /// Checks the numbers and the keyframes.
    ///
    /// # Errors
    /// Fails for a number out of its range, for a plane with a normal of zero, and for invalid keyframes, for
    /// example if they are not in order.
    pub fn validate(&self) -> Result<(), ColliderFault> {
        self.validated_motion().map(drop)
    }

    /// Checks the numbers and the keyframes, and returns the motion along the keyframes; `None` without
    /// keyframes.
    pub(super) fn validated_motion(&self) -> Result<Option<Motion>, ColliderFault> {
        self.check_numbers()?;
        let has_keys = !self.keys.is_empty();
        let motion = has_keys.then(|| Motion::new(self.keys.clone())).transpose()?;
        Ok(motion.map(|motion| motion.interpolated(self.interpolation)))
    }

    /// Returns the signed distance of points from the shape at a time, as a function: see [`Shape::signed_distance`].
    ///
    /// # Errors
    /// The errors of [`Collider::validate`].
    pub fn signed_distance_at(&self, time: f64) -> Result<impl Fn([f64; 3]) -> f64, ColliderFault> {
        let pose = self.validated_motion()?.map_or_else(Pose::identity, |motion| motion.pose(time));
        let center = self.shape.center();
        Ok(move |point| {
            let local = center + pose.rotation.tr_mul(&(Point3::from(point) - center - pose.translate));
            self.shape.signed_distance(local.into()).distance
        })
    }

    fn check_numbers(&self) -> Result<(), ColliderFault> {
        let check = |name, values: &[f64], range, valid: Range| {
            let invalid = values.iter().find(|value| !valid.contains(**value));
            invalid.map_or(Ok(()), |&value| Err(ColliderFault::OutOfRange { name, value, range }))
        };
        let finite = |name, values: &[f64]| check(name, values, "it must be finite", Range::FINITE);
        let positive = |name, values: &[f64]| {
            finite(name, values)?;
            check(name, values, "it must be greater than 0", Range::POSITIVE)
        };
        match &self.shape {
            Shape::Plane { point, normal } => {
                finite("point", point)?;
                finite("normal", normal)?;
                direction(*normal).ok_or(ColliderFault::ZeroNormal)?;
            }
            Shape::Sphere { center, radius } => {
                finite("center", center)?;
                positive("radius", &[*radius])?;
            }
            Shape::Box { center, half_extents, rotate } => {
                finite("center", center)?;
                finite("rotate", rotate)?;
                positive("half_extents", half_extents)?;
            }
            Shape::Capsule { a, b, radius } => {
                finite("a", a)?;
                finite("b", b)?;
                positive("radius", &[*radius])?;
            }
            Shape::Mesh { scale, rotate, translate, .. } => {
                positive("scale", &[*scale])?;
                finite("rotate", rotate)?;
                finite("translate", translate)?;
            }
        }
        finite("friction", &[self.friction])?;
        finite("restitution", &[self.restitution])?;
        if let Some(coefficient) = self.rolling_resistance {
            finite("rolling_resistance", &[coefficient])?;
            check("rolling_resistance", &[coefficient], "its range is 0 and above", Range::NOT_NEGATIVE)?;
        }
        finite("thickness", &[self.thickness])?;
        check("thickness", &[self.thickness], "its range is 0 and above", Range::NOT_NEGATIVE)?;
        check("friction", &[self.friction], "its range is 0 and above", Range::NOT_NEGATIVE)?;
        check("restitution", &[self.restitution], "its range is 0 to 1", Range::FRACTION)
    }
}
