//! Colliders: shapes with friction and restitution, at rest or in motion, and the validated colliders of a
//! scene.

use nalgebra::{Matrix3, Point3, Vector3};
use thiserror::Error;

use super::shape::{PosedShape, Shape};
use crate::dynamics::{Key, Motion, MotionError, Pose, direction};
use crate::state::{BodyFrame, Interval};

/// Rigid obstacle that bodies cannot enter.
#[derive(Clone, Debug, PartialEq)]
pub struct Collider {
    /// Shape.
    pub shape: Shape,
    /// Coulomb friction coefficient, >= 0: the greatest ratio of tangential to normal impulse. Default 0.5;
    /// 0: no friction.
    pub friction: f64,
    /// Ratio of the normal speed after an impact to the normal speed before it, [0, 1]. Default 0: no bounce.
    /// At 1 the surface separates as fast as it approached; the body still rises less high than it fell,
    /// because the impact makes it vibrate. An impact slower than the speed of two steps of free fall does
    /// not bounce.
    pub restitution: f64,
    /// Keyframes of the motion of the shape about its center. Default: no keyframes; the collider is at rest.
    pub keys: Vec<Key>,
}

/// An invalid collider of a scene.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
#[error("collider {collider}: {fault}")]
pub struct ColliderError {
    /// Index of the collider, from 0.
    pub collider: usize,
    /// The fault.
    pub fault: ColliderFault,
}

/// Fault of a collider.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ColliderFault {
    /// A number is not finite or out of its range.
    #[error("{name} is {value}; {range}")]
    OutOfRange {
        /// Field of the collider or its shape.
        name: &'static str,
        /// Value of the field.
        value: f64,
        /// Valid range of the field, as a clause.
        range: &'static str,
    },
    /// The normal of a plane is zero.
    #[error("the plane's normal is zero; give the direction of the free side")]
    ZeroNormal,
    /// The keyframes are invalid.
    #[error(transparent)]
    Motion(#[from] MotionError),
}

impl Collider {
    /// Creates a collider at rest with the default friction and restitution.
    pub fn new(shape: Shape) -> Self {
        Self { shape, friction: 0.5, restitution: 0.0, keys: Vec::new() }
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

    /// Checks the numbers and the keyframes.
    ///
    /// # Errors
    /// Fails for a number out of its range, for a plane with a normal of zero, and for invalid keyframes, for
    /// example if they are not in order.
    pub fn validate(&self) -> Result<(), ColliderFault> {
        ValidCollider::new(self).map(drop)
    }

    fn check_numbers(&self) -> Result<(), ColliderFault> {
        let check = |name, values: &[f64], range, valid: fn(f64) -> bool| {
            let invalid = values.iter().find(|value| !valid(**value));
            invalid.map_or(Ok(()), |&value| Err(ColliderFault::OutOfRange { name, value, range }))
        };
        let finite = |name, values: &[f64]| check(name, values, "it must be finite", f64::is_finite);
        let positive = |name, values: &[f64]| {
            finite(name, values)?;
            check(name, values, "it must be greater than 0", |value| value > 0.0)
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
        }
        finite("friction", &[self.friction])?;
        finite("restitution", &[self.restitution])?;
        check("friction", &[self.friction], "its range is 0 and above", |value| value >= 0.0)?;
        check("restitution", &[self.restitution], "its range is 0 to 1", |value| (0.0..=1.0).contains(&value))
    }
}

/// Validated colliders of a scene, for all of its bodies. Without colliders there are no contacts.
#[derive(Clone, Debug, Default)]
pub struct Colliders(Vec<ValidCollider>);

/// Validated collider and its motion.
#[derive(Clone, Debug)]
struct ValidCollider {
    collider: Collider,
    /// Motion; `None` for a collider at rest.
    motion: Option<Motion>,
}

impl ValidCollider {
    fn new(collider: &Collider) -> Result<Self, ColliderFault> {
        collider.check_numbers()?;
        let is_moving = !collider.keys.is_empty();
        let motion = is_moving.then(|| Motion::new(collider.keys.clone())).transpose()?;
        Ok(Self { collider: collider.clone(), motion })
    }
}

impl Colliders {
    /// Validates colliders. Their order changes results at rounding level where they overlap.
    ///
    /// # Errors
    /// Returns the fault of the first invalid collider.
    pub fn new(colliders: &[Collider]) -> Result<Self, ColliderError> {
        let validate =
            |(collider, input)| ValidCollider::new(input).map_err(|fault| ColliderError { collider, fault });
        colliders.iter().enumerate().map(validate).collect::<Result<_, _>>().map(Self)
    }

    /// Returns whether the set is empty.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns the descriptions of the colliders.
    pub(crate) fn list(&self) -> impl Iterator<Item = &Collider> {
        self.0.iter().map(|collider| &collider.collider)
    }

    /// Returns the shape of each collider at `time` (in seconds), in the frame of a body.
    pub(crate) fn at(&self, time: f64, frame: BodyFrame) -> impl Iterator<Item = PosedShape> {
        self.0.iter().map(move |ValidCollider { collider, motion }| {
            let pose = motion.as_ref().map_or_else(Pose::identity, |motion| motion.pose(time));
            collider.shape.posed(&pose, frame)
        })
    }

    /// Returns whether any collider may move.
    pub(crate) fn any_moves(&self) -> bool {
        self.0.iter().any(|collider| collider.motion.is_some())
    }

    /// Returns whether a collider that moves during a step comes within `distance` of a point in the frame of a body,
    /// in cells.
    pub(crate) fn moves_near(
        &self,
        step: Interval,
        frame: BodyFrame,
        point: &Point3<f64>,
        distance: f64,
    ) -> bool {
        self.during(step, frame).any(|PosedCollider { shape_before, shape, .. }| {
            shape != shape_before
                && [shape_before, shape].iter().any(|shape| shape.signed_distance(point).distance <= distance)
        })
    }

    /// Returns each collider during one step, in the frame of a body.
    pub(super) fn during(&self, step: Interval, frame: BodyFrame) -> impl Iterator<Item = PosedCollider> {
        self.0.iter().map(move |ValidCollider { collider, motion }| {
            let poses = motion.as_ref().map(|m| (m.pose(step.start), m.pose(step.end)));
            let (start, end) = poses.unwrap_or((Pose::identity(), Pose::identity()));
            PosedCollider {
                shape_before: collider.shape.posed(&start, frame),
                shape: collider.shape.posed(&end, frame),
                friction: collider.friction,
                restitution: collider.restitution,
                motion: poses.map(|_| SurfaceMotion {
                    center: Point3::from((collider.shape.center() - frame.origin) / frame.cell_size),
                    rotation_to_start: start.rotation * end.rotation.transpose(),
                    translation_at_start: start.translate / frame.cell_size,
                    translation_at_end: end.translate / frame.cell_size,
                    rate: 1.0 / step.dt,
                }),
            }
        })
    }
}

/// Collider during a step, in the local frame of a body. Lengths are in cells.
#[derive(Clone, Copy, Debug)]
pub(super) struct PosedCollider {
    /// The shape at the start of the step.
    pub(super) shape_before: PosedShape,
    /// The shape at the end of the step.
    pub(super) shape: PosedShape,
    pub(super) friction: f64,
    pub(super) restitution: f64,
    /// Motion during the step; `None` for a collider at rest.
    motion: Option<SurfaceMotion>,
}

/// Rigid motion of a collider during a step.
#[derive(Clone, Copy, Debug)]
struct SurfaceMotion {
    /// Center of the shape at time 0, in cells.
    center: Point3<f64>,
    /// Rotation from the orientation at the end of the step to the orientation at its start.
    rotation_to_start: Matrix3<f64>,
    /// Translation from time 0 to the start of the step, in cells.
    translation_at_start: Vector3<f64>,
    /// Translation from time 0 to the end of the step, in cells.
    translation_at_end: Vector3<f64>,
    /// `1 / dt`, in 1/s.
    rate: f64,
}

impl PosedCollider {
    /// Returns the velocity of the point of the collider that is at `p` at the end of the step, averaged over
    /// the step, in cells per second.
    pub(super) fn velocity_at(&self, p: &Point3<f64>) -> Vector3<f64> {
        self.motion.as_ref().map_or_else(Vector3::zeros, |motion| {
            let end = p - motion.center;
            let rotated = motion.rotation_to_start * (end - motion.translation_at_end);
            let start = rotated + motion.translation_at_start;
            (end - start) * motion.rate
        })
    }
}
