//! Colliders: shapes with friction and restitution, at rest or in motion; the checked set of a scene, in the frame of a
//! body.

use nalgebra::{Matrix3, Point3, Vector3};
use thiserror::Error;

use super::shape::{PosedShape, Shape};
use crate::dynamics::{Key, Motion, MotionError, Pose, direction};
use crate::state::{BodyFrame, Interval};

/// Something that bodies cannot enter.
#[derive(Clone, Debug, PartialEq)]
pub struct Collider {
    /// The shape.
    pub shape: Shape,
    /// Coulomb coefficient, >= 0: greatest tangential over normal impulse. Default 0.5; 0 slides freely.
    pub friction: f64,
    /// Speed after over speed before an impact, [0, 1]. Default 0: no bounce. At 1 the surface leaves as fast as it came;
    /// the body rises less high than it fell, since it vibrates after the impact. Impacts slower than two steps of free
    /// fall do not bounce.
    pub restitution: f64,
    /// Motion of the shape about its center. Default: no keys, the collider rests.
    pub keys: Vec<Key>,
}

/// An invalid collider of a scene.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
#[error("collider {collider}: {fault}")]
pub struct ColliderError {
    /// Index of the collider, from 0.
    pub collider: usize,
    /// What is wrong with it.
    pub fault: ColliderFault,
}

/// What is wrong with a collider.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum ColliderFault {
    /// A number is not finite or out of its range.
    #[error("{name} is {value}; {range}")]
    OutOfRange {
        /// Field of the collider or its shape.
        name: &'static str,
        /// The number.
        value: f64,
        /// The range of the field.
        range: &'static str,
    },
    /// A plane without direction.
    #[error("the plane's normal is zero; give the direction of the free side")]
    ZeroNormal,
    /// Invalid keys.
    #[error(transparent)]
    Motion(#[from] MotionError),
}

impl Collider {
    /// A collider at rest with the default friction and restitution.
    pub fn new(shape: Shape) -> Self {
        Self { shape, friction: 0.5, restitution: 0.0, keys: Vec::new() }
    }

    /// The half space below the plane through `point`; `normal` points to the free side.
    pub fn plane(point: [f64; 3], normal: [f64; 3]) -> Self {
        Self::new(Shape::Plane { point, normal })
    }

    /// A ball.
    pub fn sphere(center: [f64; 3], radius: f64) -> Self {
        Self::new(Shape::Sphere { center, radius })
    }

    /// A box, turned by Euler angles in degrees.
    pub fn cuboid(center: [f64; 3], half_extents: [f64; 3], rotate: [f64; 3]) -> Self {
        Self::new(Shape::Box { center, half_extents, rotate })
    }

    /// A capsule about the segment from `a` to `b`.
    pub fn capsule(a: [f64; 3], b: [f64; 3], radius: f64) -> Self {
        Self::new(Shape::Capsule { a, b, radius })
    }

    /// Checks the numbers and the keys.
    ///
    /// # Errors
    /// A number out of its range, a plane without direction, keys that are not in order.
    pub fn validate(&self) -> Result<(), ColliderFault> {
        Checked::new(self).map(drop)
    }

    fn check_numbers(&self) -> Result<(), ColliderFault> {
        let check = |name, values: &[f64], range, valid: fn(f64) -> bool| {
            let wrong = values.iter().find(|value| !valid(**value));
            wrong.map_or(Ok(()), |&value| Err(ColliderFault::OutOfRange { name, value, range }))
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

/// The checked colliders of a scene, shared by its bodies; an empty set touches nothing.
#[derive(Clone, Debug, Default)]
pub struct Colliders(Vec<Checked>);

#[derive(Clone, Debug)]
struct Checked {
    collider: Collider,
    /// `None` at rest.
    motion: Option<Motion>,
}

impl Checked {
    fn new(collider: &Collider) -> Result<Self, ColliderFault> {
        collider.check_numbers()?;
        let moves = !collider.keys.is_empty();
        let motion = moves.then(|| Motion::new(collider.keys.clone())).transpose()?;
        Ok(Self { collider: collider.clone(), motion })
    }
}

impl Colliders {
    /// Checks colliders. Their order changes results at rounding level where they overlap.
    ///
    /// # Errors
    /// The first invalid collider.
    pub fn new(colliders: &[Collider]) -> Result<Self, ColliderError> {
        let checked =
            |(collider, given)| Checked::new(given).map_err(|fault| ColliderError { collider, fault });
        colliders.iter().enumerate().map(checked).collect::<Result<_, _>>().map(Self)
    }

    /// Whether there is no collider.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Each shape at a time in seconds, in the frame of a body.
    pub(crate) fn at(&self, time: f64, frame: BodyFrame) -> impl Iterator<Item = PosedShape> {
        self.0.iter().map(move |Checked { collider, motion }| {
            let pose = motion.as_ref().map_or_else(Pose::identity, |motion| motion.pose(time));
            collider.shape.posed(&pose, frame)
        })
    }

    /// Each collider during a step, in the frame of a body.
    pub(super) fn during(&self, step: Interval, frame: BodyFrame) -> impl Iterator<Item = PosedCollider> {
        self.0.iter().map(move |Checked { collider, motion }| {
            let poses = motion.as_ref().map(|m| (m.pose(step.start), m.pose(step.end)));
            let (start, end) = poses.unwrap_or((Pose::identity(), Pose::identity()));
            PosedCollider {
                shape_before: collider.shape.posed(&start, frame),
                shape: collider.shape.posed(&end, frame),
                friction: collider.friction,
                restitution: collider.restitution,
                motion: poses.map(|_| SurfaceMotion {
                    center: Point3::from((collider.shape.center() - frame.origin) / frame.cell_size),
                    back: start.rotation * end.rotation.transpose(),
                    start: start.translate / frame.cell_size,
                    end: end.translate / frame.cell_size,
                    rate: 1.0 / step.dt,
                }),
            }
        })
    }
}

/// A collider during a step in the local frame of a body: cells, and cells per second.
#[derive(Clone, Copy, Debug)]
pub(super) struct PosedCollider {
    /// The shape at the start of the step.
    pub(super) shape_before: PosedShape,
    /// The shape at the end of the step.
    pub(super) shape: PosedShape,
    pub(super) friction: f64,
    pub(super) restitution: f64,
    /// `None` at rest.
    motion: Option<SurfaceMotion>,
}

#[derive(Clone, Copy, Debug)]
struct SurfaceMotion {
    center: Point3<f64>,
    /// Turns an offset from the center at the end of the step into that at its start.
    back: Matrix3<f64>,
    start: Vector3<f64>,
    end: Vector3<f64>,
    rate: f64,
}

impl PosedCollider {
    /// Mean velocity over the step of the point of the collider that is at `p` at its end.
    pub(super) fn velocity_at(&self, p: &Point3<f64>) -> Vector3<f64> {
        self.motion.as_ref().map_or_else(Vector3::zeros, |motion| {
            let end = p - motion.center;
            let start = motion.back * (end - motion.end) + motion.start;
            (end - start) * motion.rate
        })
    }
}
