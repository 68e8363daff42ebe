//! Collider shapes, and their signed distance functions (SDFs) in the frame of a body.

use nalgebra::{Matrix3, Point3, Vector3};

use super::collision_mesh::{CollisionMesh, CollisionSurface, PosedMesh};
use super::distance::SignedDistance;
use super::fault::ColliderFault;
use crate::mesh::Scale;
use crate::motion::{Pose, direction, euler_degrees};
use crate::state::BodyFrame;

/// Shape of a collider in world space at time 0, with lengths in scene units.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Half space; bodies stay on the side to which the normal points.
    Plane {
        /// Any point of the plane.
        point: [f64; 3],
        /// Normal, of any length greater than zero.
        normal: [f64; 3],
    },
    /// Ball.
    Sphere {
        /// Center.
        center: [f64; 3],
        /// Radius, > 0.
        radius: f64,
    },
    /// Box.
    Box {
        /// Center.
        center: [f64; 3],
        /// Half of the edge lengths, each > 0.
        half_extents: [f64; 3],
        /// Euler angles in degrees: rotations about the fixed axes x, then y, then z through the center.
        rotate: [f64; 3],
    },
    /// All points within `radius` of the segment from `a` to `b`; `a` and `b` may coincide.
    Capsule {
        /// First end of the segment.
        a: [f64; 3],
        /// Second end of the segment.
        b: [f64; 3],
        /// Radius, > 0.
        radius: f64,
    },
    /// A mesh: a solid if it is closed, a thin shell if it is open.
    Mesh {
        /// The mesh.
        mesh: CollisionMesh,
        /// Factor of the lengths of the mesh, > 0, applied first, about the origin.
        scale: f64,
        /// Euler angles in degrees: rotations about the fixed axes x, then y, then z through the origin.
        rotate: [f64; 3],
        /// Displacement, applied last.
        translate: [f64; 3],
    },
}

impl Shape {
    /// Returns a mesh that is scaled, then rotated and moved. Factors that differ by axis scale its vertices.
    ///
    /// # Errors
    /// As [`CollisionMesh::scaled`].
    pub fn mesh(
        mesh: CollisionMesh,
        scale: impl Into<Scale>,
        rotate: [f64; 3],
        translate: [f64; 3],
    ) -> Result<Self, ColliderFault> {
        Ok(match scale.into() {
            Scale::Uniform(scale) => Self::Mesh { mesh, scale, rotate, translate },
            scale => Self::Mesh { mesh: mesh.scaled(scale)?, scale: 1.0, rotate, translate },
        })
    }

    /// Returns the center of rotation of a moving collider: a plane's `point`, the center of other shapes. The center
    /// of a mesh is the center of its bounding box before it is rotated.
    pub fn center(&self) -> Point3<f64> {
        match self {
            Self::Plane { point, .. } => Point3::from(*point),
            Self::Sphere { center, .. } | Self::Box { center, .. } => Point3::from(*center),
            Self::Capsule { a, b, .. } => nalgebra::center(&Point3::from(*a), &Point3::from(*b)),
            Self::Mesh { mesh, scale, rotate, translate } => {
                let center = euler_degrees(*rotate) * (mesh.center().coords * *scale);
                Point3::from(center + Vector3::from(*translate))
            }
        }
    }

    /// Returns the radius of a ball or a rod that samples of a surface can pass on all sides, in scene units: that of a
    /// sphere or a capsule, or the second half extent of a box. `None` for other shapes.
    pub(super) fn narrow_radius(&self) -> Option<f64> {
        match self {
            Self::Plane { .. } | Self::Mesh { .. } => None,
            Self::Sphere { radius, .. } | Self::Capsule { radius, .. } => Some(*radius),
            Self::Box { half_extents: [x, y, z], .. } => Some(x.min(*y).max(x.max(*y).min(*z))),
        }
    }

    /// Returns the signed distance of a world-space point from the shape at time 0. For an open mesh it is not
    /// negative.
    pub fn signed_distance(&self, point: [f64; 3]) -> SignedDistance {
        self.posed(&Pose::identity(), BodyFrame::WORLD).signed_distance(&Point3::from(point))
    }

    /// Moves the shape by `pose` about its center, and returns it in the local frame of a body.
    pub(super) fn posed(&self, pose: &Pose, frame: BodyFrame) -> PosedShape<'_> {
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
                thickness: 0.0,
            },
            Self::Capsule { a, b, radius } => {
                let start = local(a);
                PosedShape::Capsule { a: start, axis: local(b) - start, radius: radius / frame.cell_size }
            }
            Self::Mesh { mesh, scale, rotate, translate } => PosedShape::Mesh(PosedMesh {
                surface: mesh.surface(),
                origin: local(translate),
                rotation: pose.rotation * euler_degrees(*rotate),
                scale: scale / frame.cell_size,
                shell: 0.0,
                thickness: 0.0,
            }),
        }
    }
}

/// Shape at one time in the local frame of a body, with lengths in cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PosedShape<'a> {
    Plane {
        point: Point3<f64>,
        normal: Vector3<f64>,
    },
    Sphere {
        center: Point3<f64>,
        radius: f64,
    },
    /// All points within `thickness` of a box.
    Box {
        center: Point3<f64>,
        half: Vector3<f64>,
        rotation: Matrix3<f64>,
        thickness: f64,
    },
    Capsule {
        a: Point3<f64>,
        axis: Vector3<f64>,
        radius: f64,
    },
    Mesh(PosedMesh<'a>),
}

impl<'a> PosedShape<'a> {
    /// Returns the shape with another surface if it is a mesh.
    pub(super) fn with_surface(self, surface: &'a CollisionSurface) -> Self {
        match self {
            Self::Mesh(mesh) => Self::Mesh(PosedMesh { surface, ..mesh }),
            shape => shape,
        }
    }

    /// Returns all points within `thickness` cells of the shape: its surface moves outwards by the thickness. An open
    /// mesh has at least the thickness of a shell. The side of a sample follows from the surface without the thickness:
    /// see `sides`.
    pub(super) fn thickened(self, thickness: f64) -> Self {
        match self {
            Self::Mesh(mesh) => Self::Mesh(mesh.thickened(thickness)),
            shape if thickness == 0.0 => shape,
            Self::Plane { point, normal } => Self::Plane { point: point + normal * thickness, normal },
            Self::Sphere { center, radius } => Self::Sphere { center, radius: radius + thickness },
            Self::Box { center, half, rotation, .. } => Self::Box { center, half, rotation, thickness },
            Self::Capsule { a, axis, radius } => Self::Capsule { a, axis, radius: radius + thickness },
        }
    }

    /// Returns the signed distance of a point in the local frame, in cells.
    pub(crate) fn signed_distance(&self, p: &Point3<f64>) -> SignedDistance {
        match self {
            Self::Plane { point, normal } => {
                SignedDistance { distance: normal.dot(&(p - point)), normal: *normal }
            }
            Self::Sphere { center, radius } => ball_distance(p - center, *radius),
            Self::Box { center, half, rotation, thickness } => {
                let local = box_distance(&rotation.tr_mul(&(p - center)), half);
                SignedDistance { distance: local.distance - thickness, normal: rotation * local.normal }
            }
            Self::Capsule { a, axis, radius } => {
                let offset = p - a;
                let length_squared = axis.norm_squared();
                let t = if length_squared > 0.0 {
                    (offset.dot(axis) / length_squared).clamp(0.0, 1.0)
                } else {
                    0.0
                };
                let from_axis = offset - axis * t;
                // A point with coordinates of NaN has a distance of NaN.
                if from_axis.norm_squared() != 0.0 || length_squared == 0.0 {
                    ball_distance(from_axis, *radius)
                } else {
                    // On the axis all perpendicular directions are equivalent. Uses the cross product of the
                    // capsule's axis and the coordinate axis in whose direction the capsule's axis has the
                    // component of smallest magnitude.
                    let smallest_axis = axis.iamin();
                    let across = axis.cross(&Vector3::ith(smallest_axis, 1.0));
                    SignedDistance { distance: -radius, normal: across.normalize() }
                }
            }
            Self::Mesh(mesh) => mesh.signed_distance(p),
        }
    }

    /// Returns a plane's normal and offset: the signed distance of `p` is `normal . p - offset`.
    ///
    /// Returns `None` for other shapes, whose distance is not linear.
    pub(crate) fn plane(&self) -> Option<(Vector3<f64>, f64)> {
        match self {
            Self::Plane { point, normal } => Some((*normal, normal.dot(&point.coords))),
            _ => None,
        }
    }

    /// Returns false only if no point of the AABB `center ± half` is within `skin`, in cells. May return true in this
    /// case as well.
    ///
    /// The test is exact for a plane. The other distance functions are 1-Lipschitz: anywhere in the AABB the distance
    /// is at least the distance at its center minus half its diagonal.
    pub(super) fn may_touch(&self, center: &Point3<f64>, half: &Vector3<f64>, skin: f64) -> bool {
        let radius = match self {
            Self::Plane { normal, .. } => normal.abs().dot(half),
            Self::Mesh(mesh) => return mesh.may_touch(center, half, skin),
            _ => half.norm(),
        };
        self.signed_distance(center).distance - radius <= skin
    }
}

/// Returns the signed distance of the point at `offset` from the center of a ball.
fn ball_distance(offset: Vector3<f64>, radius: f64) -> SignedDistance {
    let length = offset.norm();
    let normal = if length > 0.0 && length.is_finite() { offset / length } else { Vector3::x() };
    SignedDistance { distance: length - radius, normal }
}

/// Returns the signed distance of `p` from the box between `-half` and `half`.
///
/// Inside the box this is minus the distance to the nearest face. If several faces are equally near, the
/// first one in the order x, y, z determines the normal.
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
