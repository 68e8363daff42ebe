//! Shapes as a body sees them at one time: distances and normals in its own frame.

use nalgebra::{Matrix3, Point3, Vector3};

use super::SignedDistance;

/// A shape at one time, in the local frame of a body: lengths in cells.
#[derive(Clone, Copy, Debug)]
pub(super) enum PosedShape {
    Plane { point: Point3<f64>, normal: Vector3<f64> },
    Sphere { center: Point3<f64>, radius: f64 },
    Box { center: Point3<f64>, half: Vector3<f64>, rotation: Matrix3<f64> },
    Capsule { a: Point3<f64>, axis: Vector3<f64>, radius: f64 },
}

impl PosedShape {
    /// Signed distance of a local point, in cells.
    pub(super) fn signed_distance(&self, p: &Point3<f64>) -> SignedDistance {
        match self {
            Self::Plane { point, normal } => {
                SignedDistance { distance: normal.dot(&(p - point)), normal: *normal }
            }
            Self::Sphere { center, radius } => from_centre(p - center, *radius),
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
                    from_centre(from_axis, *radius)
                } else {
                    // On the axis every direction across it is as near: take the one by the least axis.
                    let least = axis.iamin();
                    let across = axis.cross(&Vector3::ith(least, 1.0));
                    SignedDistance { distance: -radius, normal: across.normalize() }
                }
            }
        }
    }

    /// For a plane, whose distance is linear: its normal, and the distance of the origin below it. None for other
    /// shapes.
    pub(super) fn plane(&self) -> Option<(Vector3<f64>, f64)> {
        match self {
            Self::Plane { point, normal } => Some((*normal, normal.dot(&point.coords))),
            _ => None,
        }
    }

    /// A lower bound of the signed distance over the box `centre ± half`, in cells.
    ///
    /// Exact for a plane; otherwise the distance is 1-Lipschitz, so it cannot fall by more than the box's
    /// half diagonal.
    pub(super) fn lower_bound(&self, centre: &Point3<f64>, half: &Vector3<f64>) -> f64 {
        let reach = match self {
            Self::Plane { normal, .. } => normal.abs().dot(half),
            _ => half.norm(),
        };
        self.signed_distance(centre).distance - reach
    }
}

fn from_centre(offset: Vector3<f64>, radius: f64) -> SignedDistance {
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
