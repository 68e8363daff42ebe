//! Shapes of colliders: signed distance and outward normal.

use nalgebra::{Point3, Vector3};

use super::posed::PosedShape;
use crate::dynamics::{Pose, direction};
use crate::state::{BodyFrame, euler_degrees};

/// The shape of a collider, in world space at time 0, lengths in scene units.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A half space; bodies stay on the side that the normal points to.
    Plane {
        /// Any point of the plane.
        point: [f64; 3],
        /// Normal, of any length but zero.
        normal: [f64; 3],
    },
    /// A ball.
    Sphere {
        /// Centre.
        center: [f64; 3],
        /// Radius, > 0.
        radius: f64,
    },
    /// A box.
    Box {
        /// Centre.
        center: [f64; 3],
        /// Half of the edge lengths, each > 0.
        half_extents: [f64; 3],
        /// Euler angles in degrees about the fixed axes x, then y, then z through the centre.
        rotate: [f64; 3],
    },
    /// All points up to `radius` away from the segment from `a` to `b`, which may coincide.
    Capsule {
        /// One end of the segment.
        a: [f64; 3],
        /// Its other end.
        b: [f64; 3],
        /// Radius, > 0.
        radius: f64,
    },
}

/// Distance from a shape's surface, negative inside, and the outward unit normal there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SignedDistance {
    /// Distance, in the unit of the point asked about.
    pub distance: f64,
    /// The gradient of the distance: a unit vector. Where it has none (at the centre of a sphere) the x axis.
    pub normal: Vector3<f64>,
}

impl Shape {
    /// The point about which a moving collider turns: a plane's `point`, otherwise the middle.
    pub fn centre(&self) -> Point3<f64> {
        match self {
            Self::Plane { point, .. } => Point3::from(*point),
            Self::Sphere { center, .. } | Self::Box { center, .. } => Point3::from(*center),
            Self::Capsule { a, b, .. } => nalgebra::center(&Point3::from(*a), &Point3::from(*b)),
        }
    }

    /// Signed distance of a world point from the shape at rest.
    pub fn signed_distance(&self, point: [f64; 3]) -> SignedDistance {
        let world = BodyFrame { origin: Point3::origin(), cell_size: 1.0 };
        self.posed(&Pose::identity(), world).signed_distance(&Point3::from(point))
    }

    /// The shape moved by `pose` about its centre, in the local frame of a body.
    pub(super) fn posed(&self, pose: &Pose, frame: BodyFrame) -> PosedShape {
        let centre = self.centre();
        let local = |p: &[f64; 3]| {
            let moved = pose.apply(&centre, &Point3::from(*p));
            Point3::from((moved - frame.origin) / frame.cell_size)
        };
        match self {
            Self::Plane { point, normal } => {
                let normal = pose.rotation * direction(*normal).unwrap_or_else(Vector3::x);
                PosedShape::Plane { point: local(point), normal }
            }
            Self::Sphere { center, radius } => {
                PosedShape::Sphere { center: local(center), radius: radius / frame.cell_size }
            }
            Self::Box { center, half_extents, rotate } => PosedShape::Box {
                center: local(center),
                half: Vector3::from(*half_extents) / frame.cell_size,
                rotation: pose.rotation * euler_degrees(*rotate),
            },
            Self::Capsule { a, b, radius } => {
                let start = local(a);
                PosedShape::Capsule { a: start, axis: local(b) - start, radius: radius / frame.cell_size }
            }
        }
    }
}
