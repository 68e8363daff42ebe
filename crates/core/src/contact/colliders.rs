//! The colliders of a scene, checked, and what a body sees of them during a step.

use nalgebra::{Matrix3, Point3, Vector3};

use super::posed::PosedShape;
use super::{Collider, ColliderError, Shape};
use crate::dynamics::{Motion, Pose};
use crate::state::{BodyFrame, Interval};

/// The checked colliders of a scene, shared by its bodies; an empty set touches nothing.
#[derive(Clone, Debug, Default)]
pub struct Colliders {
    colliders: Vec<Checked>,
}

#[derive(Clone, Debug)]
struct Checked {
    shape: Shape,
    motion: Option<Motion>,
    friction: f64,
    restitution: f64,
}

impl Colliders {
    /// Checks colliders. Their order changes results at rounding level where they overlap.
    ///
    /// # Errors
    /// Numbers out of range and keys that are no motion, by the index of the collider.
    pub fn new(colliders: &[Collider]) -> Result<Self, ColliderError> {
        let mut checked = Vec::with_capacity(colliders.len());
        for (index, collider) in colliders.iter().enumerate() {
            collider.validate(index)?;
            let motion = match collider.keys.is_empty() {
                true => None,
                false => Some(
                    Motion::new(collider.keys.clone())
                        .map_err(|source| ColliderError::Motion { collider: index, source })?,
                ),
            };
            checked.push(Checked {
                shape: collider.shape.clone(),
                motion,
                friction: collider.friction,
                restitution: collider.restitution,
            });
        }
        Ok(Self { colliders: checked })
    }

    /// Number of colliders.
    pub fn len(&self) -> usize {
        self.colliders.len()
    }

    /// Whether there is no collider.
    pub fn is_empty(&self) -> bool {
        self.colliders.is_empty()
    }

    /// Each collider's shape at a time in seconds, as a body sees it.
    pub(super) fn at(&self, time: f64, frame: BodyFrame) -> impl Iterator<Item = PosedShape> {
        self.colliders.iter().map(move |collider| {
            let pose = collider.motion.as_ref().map_or_else(Pose::identity, |motion| motion.pose(time));
            collider.shape.posed(&pose, frame)
        })
    }

    /// Each collider during a step, as a body sees it.
    pub(super) fn during(&self, step: Interval, frame: BodyFrame) -> impl Iterator<Item = PosedCollider> {
        self.colliders.iter().map(move |collider| {
            let poses = collider.motion.as_ref().map(|m| (m.pose(step.start), m.pose(step.end)));
            let (start, end) = poses.unwrap_or((Pose::identity(), Pose::identity()));
            let centre = Point3::from((collider.shape.centre() - frame.origin) / frame.cell_size);
            PosedCollider {
                before: collider.shape.posed(&start, frame),
                shape: collider.shape.posed(&end, frame),
                friction: collider.friction,
                restitution: collider.restitution,
                surface: poses.map(|_| SurfaceMotion {
                    centre,
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
    pub(super) before: PosedShape,
    /// The shape at the end of the step.
    pub(super) shape: PosedShape,
    pub(super) friction: f64,
    pub(super) restitution: f64,
    surface: Option<SurfaceMotion>,
}

#[derive(Clone, Copy, Debug)]
struct SurfaceMotion {
    centre: Point3<f64>,
    /// Turns an offset from the centre at the end of the step into that at its start.
    back: Matrix3<f64>,
    start: Vector3<f64>,
    end: Vector3<f64>,
    rate: f64,
}

impl PosedCollider {
    /// Mean velocity over the step of the collider's material that ends it at `p`.
    pub(super) fn velocity_at(&self, p: &Point3<f64>) -> Vector3<f64> {
        self.surface.as_ref().map_or_else(Vector3::zeros, |motion| {
            let end = p - motion.centre;
            let start = motion.back * (end - motion.end) + motion.start;
            (end - start) * motion.rate
        })
    }
}
