//! Shapes of Rapier as shapes of supple's colliders, and as meshes of rigid bodies.

use nalgebra::{Isometry3, Point3};
use rapier3d::math::Vector;
use rapier3d::parry::shape::{Shape as RapierShape, TypedShape};
use supple::{CollisionMesh, Mesh, MeshError, Shape, euler_degrees_near};

use crate::convert::{wide, wide_pose};

/// Sides of the polygons around the axis of a tessellated ball, capsule, cylinder or cone: the polygon is inside the
/// circle by at most 0.5 % of the radius.
const SIDES: u32 = 32;

/// The reason for which a shape has no counterpart.
pub(crate) enum Fault {
    /// The name of a shape that is not supported.
    Unsupported(String),
    /// A mesh that supple does not take.
    Mesh(Box<dyn std::error::Error + Send + Sync>),
}

impl<E: std::error::Error + Send + Sync + 'static> From<E> for Fault {
    fn from(error: E) -> Self {
        Self::Mesh(Box::new(error))
    }
}

/// Appends the counterparts of a shape in a pose: one of each part of a compound.
pub(crate) fn append_shapes(
    shape: &dyn RapierShape,
    pose: &Isometry3<f64>,
    shapes: &mut Vec<Shape>,
) -> Result<(), Fault> {
    let place = |p: Vector| -> [f64; 3] { (pose * Point3::from(wide(p))).into() };
    let rotate = || euler_degrees_near(pose.rotation.to_rotation_matrix().matrix(), [0.0; 3]);
    let center = place(Vector::ZERO);
    shapes.push(match shape.as_typed_shape() {
        TypedShape::Ball(ball) => Shape::Sphere { center, radius: ball.radius.into() },
        TypedShape::Cuboid(cuboid) => {
            Shape::Box { center, half_extents: wide(cuboid.half_extents).into(), rotate: rotate() }
        }
        TypedShape::Capsule(capsule) => {
            let [a, b] = [capsule.segment.a, capsule.segment.b].map(place);
            Shape::Capsule { a, b, radius: capsule.radius.into() }
        }
        TypedShape::HalfSpace(half_space) => {
            Shape::Plane { point: center, normal: (pose.rotation * wide(half_space.normal)).into() }
        }
        TypedShape::Compound(compound) => {
            for (local, part) in compound.shapes() {
                append_shapes(&**part, &(pose * wide_pose(local)), shapes)?;
            }
            return Ok(());
        }
        _ => {
            let mut surface = Surface::default();
            surface.append(shape, &Isometry3::identity())?;
            let mesh = CollisionMesh::new(surface.mesh()?)?;
            let translate = pose.translation.vector.into();
            Shape::Mesh { mesh, scale: 1.0, rotate: rotate(), translate }
        }
    });
    Ok(())
}

/// The surface of a dynamic body.
#[derive(Default)]
pub(crate) struct Surface {
    vertices: Vec<[f64; 3]>,
    faces: Vec<[u32; 3]>,
}

impl Surface {
    /// Appends the surface of a shape in a pose. Closed surfaces are turned so that their faces point outwards.
    pub(crate) fn append(&mut self, shape: &dyn RapierShape, pose: &Isometry3<f64>) -> Result<(), Fault> {
        let typed = shape.as_typed_shape();
        if let TypedShape::Compound(compound) = typed {
            let mut parts = compound.shapes().iter();
            return parts.try_for_each(|(local, part)| self.append(&**part, &(pose * wide_pose(local))));
        }
        let Some((vertices, mut faces)) = tessellated(typed) else {
            return Err(Fault::Unsupported(format!("{:?}", shape.shape_type())));
        };
        let vertices: Vec<[f64; 3]> =
            vertices.into_iter().map(|p| (pose * Point3::from(wide(p))).into()).collect();
        let mesh = Mesh::new(vertices.clone(), &faces)?;
        if mesh.is_closed() && mesh.signed_volume() < 0.0 {
            faces.iter_mut().for_each(|face| face.swap(1, 2));
        }
        let first = self.vertices.len() as u32;
        self.vertices.extend(vertices);
        self.faces.extend(faces.iter().map(|face| face.map(|vertex| vertex + first)));
        Ok(())
    }

    pub(crate) fn mesh(self) -> Result<Mesh, MeshError> {
        Mesh::new(self.vertices, &self.faces)
    }
}

/// Returns the triangles of a shape; `None` if there are none.
fn tessellated(shape: TypedShape<'_>) -> Option<(Vec<Vector>, Vec<[u32; 3]>)> {
    match shape {
        TypedShape::Ball(ball) => Some(ball.to_trimesh(SIDES, SIDES / 2)),
        TypedShape::Cuboid(cuboid) => Some(cuboid.to_trimesh()),
        TypedShape::Capsule(capsule) => Some(capsule.to_trimesh(SIDES, SIDES / 4)),
        TypedShape::Cylinder(cylinder) => Some(cylinder.to_trimesh(SIDES)),
        TypedShape::Cone(cone) => Some(cone.to_trimesh(SIDES)),
        TypedShape::ConvexPolyhedron(polyhedron) => Some(polyhedron.to_trimesh()),
        TypedShape::TriMesh(mesh) => Some((mesh.vertices().to_vec(), mesh.indices().to_vec())),
        TypedShape::HeightField(field) => Some(field.to_trimesh()),
        _ => None,
    }
}
