//! Shapes of colliders, and their signed distance functions in the frame of a body.

use nalgebra::{Matrix3, Point3, Vector3};

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
        /// Center.
        center: [f64; 3],
        /// Radius, > 0.
        radius: f64,
    },
    /// A box.
    Box {
        /// Center.
        center: [f64; 3],
        /// Half of the edge lengths, each > 0.
        half_extents: [f64; 3],
        /// Euler angles in degrees about the fixed axes x, then y, then z through the center.
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
    /// Distance, in the unit of the point.
    pub distance: f64,
    /// The gradient of the distance, a unit vector; the x axis where there is no gradient (at the center of a sphere).
    pub normal: Vector3<f64>,
}

impl Shape {
    /// The point about which a moving collider turns: a plane's `point`, the middle of other shapes.
    pub fn center(&self) -> Point3<f64> {
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

    /// The shape moved by `pose` about its center, in the local frame of a body.
    pub(super) fn posed(&self, pose: &Pose, frame: BodyFrame) -> PosedShape {
        let center = self.center();
        let local = |p: &[f64; 3]| {
            let moved = pose.apply(&center, &Point3::from(*p));
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

/// A shape at one time, in the local frame of a body: lengths in cells.
#[derive(Clone, Copy, Debug)]
pub(crate) enum PosedShape {
    Plane { point: Point3<f64>, normal: Vector3<f64> },
    Sphere { center: Point3<f64>, radius: f64 },
    Box { center: Point3<f64>, half: Vector3<f64>, rotation: Matrix3<f64> },
    Capsule { a: Point3<f64>, axis: Vector3<f64>, radius: f64 },
}

impl PosedShape {
    /// Signed distance of a local point, in cells.
    pub(crate) fn signed_distance(&self, p: &Point3<f64>) -> SignedDistance {
        match self {
            Self::Plane { point, normal } => {
                SignedDistance { distance: normal.dot(&(p - point)), normal: *normal }
            }
            Self::Sphere { center, radius } => around(p - center, *radius),
            Self::Box { center, half, rotation } => {
                let local = box_distance(&rotation.tr_mul(&(p - center)), half);
                SignedDistance { distance: local.distance, normal: rotation * local.normal }
            }
            Self::Capsule { a, axis, radius } => {
                let offset = p - a;
                let square = axis.norm_squared();
                let along = if square > 0.0 { (offset.dot(axis) / square).clamp(0.0, 1.0) } else { 0.0 };
                let from_axis = offset - axis * along;
                if from_axis.norm_squared() > 0.0 || square == 0.0 {
                    around(from_axis, *radius)
                } else {
                    // On the axis every direction across it is as near: take the one by the least axis.
                    let least = axis.iamin();
                    let across = axis.cross(&Vector3::ith(least, 1.0));
                    SignedDistance { distance: -radius, normal: across.normalize() }
                }
            }
        }
    }

    /// The normal of a plane and the distance of the origin below it; `None` for other shapes, whose distance is not
    /// linear.
    pub(crate) fn plane(&self) -> Option<(Vector3<f64>, f64)> {
        match self {
            Self::Plane { point, normal } => Some((*normal, normal.dot(&point.coords))),
            _ => None,
        }
    }

    /// A lower bound of the signed distance over the box `center ± half`, in cells.
    ///
    /// Exact for a plane. Other distances are 1-Lipschitz: they fall by at most the half diagonal of the box.
    pub(crate) fn lower_bound(&self, center: &Point3<f64>, half: &Vector3<f64>) -> f64 {
        let spread = match self {
            Self::Plane { normal, .. } => normal.abs().dot(half),
            _ => half.norm(),
        };
        self.signed_distance(center).distance - spread
    }
}

fn around(offset: Vector3<f64>, radius: f64) -> SignedDistance {
    let length = offset.norm();
    let normal = if length > 0.0 && length.is_finite() { offset / length } else { Vector3::x() };
    SignedDistance { distance: length - radius, normal }
}

/// Signed distance of `p` from the box `±half`: outside from its nearest point, inside from its nearest face
/// (the first in the order x, y, z if several are as near).
fn box_distance(p: &Vector3<f64>, half: &Vector3<f64>) -> SignedDistance {
    let beyond = p.abs() - half;
    let outside = beyond.map(|b| b.max(0.0));
    let length = outside.norm();
    if length > 0.0 {
        let direction = outside.zip_map(p, |o, p| o.copysign(p)) / length;
        let normal = if length.is_finite() { direction } else { Vector3::x() };
        return SignedDistance { distance: length, normal };
    }
    let face = (1..3).fold(0, |best, a| if beyond[a] > beyond[best] { a } else { best });
    SignedDistance { distance: beyond[face], normal: Vector3::ith(face, 1.0_f64.copysign(p[face])) }
}
