//! Prims of colliders.

use nalgebra::{Matrix3, Matrix4, Point3, Rotation3, Translation3, Unit, Vector3};
use supple::{Shape, Simulation, euler_degrees};

use super::layout::Layout;
use super::name::Names;
use super::prim::{Prim, Stored, Value, token};
use super::surface::mesh_prim;
use crate::space::FileSpace;

/// A collider, and the places of its values in the frames.
#[derive(Debug)]
pub(super) struct ColliderPrim {
    shape: Shape,
    pub(super) matrix: Stored,
    /// The number of points of an animated mesh, and the places of its points and their bounds.
    pub(super) animated: Option<(usize, Stored, Stored)>,
}

/// Bounds of a plane without bodies.
const NO_BODIES: [[f32; 3]; 2] = [[-1.0; 3], [1.0; 3]];

/// Half of the edge length of a plane, as a multiple of the diagonal of the bounds of the bodies.
const PLANE: f64 = 2.0;

impl ColliderPrim {
    pub(super) fn new(shape: &Shape, layout: &mut Layout) -> Self {
        let matrix = layout.add_matrix();
        let points = match shape {
            Shape::Mesh { mesh, .. } if mesh.animation().is_some() => Some(mesh.mesh().vertices().len()),
            _ => None,
        };
        let animated = points.map(|points| (points, layout.add_vectors(points), layout.add_vectors(2)));
        Self { shape: shape.clone(), matrix, animated }
    }

    /// Returns the transformation from the coordinates of the prim to those of the files, of the collider with an index
    /// in a simulation. A program can remove colliders from a simulation; these stay where the scene puts them.
    pub(super) fn matrix(&self, simulation: &Simulation, index: usize, space: FileSpace) -> Matrix4<f64> {
        let collider = (index < simulation.collider_count()).then(|| simulation.collider(index));
        let pose = collider.map(|collider| (collider.translation(), collider.rotation()));
        let (translate, rotate) = pose.unwrap_or_default();
        let center = self.shape.center().coords;
        let moved = Translation3::from(center + Vector3::from(translate)).to_homogeneous()
            * euler_degrees(rotate).to_homogeneous()
            * Translation3::from(-center).to_homogeneous();
        space.matrix() * moved * self.local()
    }

    /// Returns the positions of an animated mesh at a time in seconds, in the coordinates of the prim.
    pub(super) fn positions(&self, time: f64) -> Vec<[f32; 3]> {
        let mut vertices = Vec::new();
        if let Shape::Mesh { mesh, .. } = &self.shape
            && let Some(animation) = mesh.animation()
        {
            animation.positions_at_time(time, &mut vertices);
        }
        vertices.into_iter().map(finite).collect()
    }

    /// Returns the transformation from the coordinates of the prim to the scene, before the collider moves.
    fn local(&self) -> Matrix4<f64> {
        let placed = |rotation: Matrix3<f64>, to: [f64; 3]| {
            Translation3::from(Vector3::from(to)).to_homogeneous() * rotation.to_homogeneous()
        };
        match self.shape {
            Shape::Plane { point, normal } => placed(along(normal.into()), point),
            Shape::Sphere { center, .. } => placed(Matrix3::identity(), center),
            Shape::Box { center, half_extents, rotate } => {
                let scale = Matrix3::from_diagonal(&half_extents.into());
                placed(euler_degrees(rotate) * scale, center)
            }
            Shape::Capsule { a, b, .. } => {
                placed(along(Vector3::from(b) - Vector3::from(a)), self.shape.center().into())
            }
            Shape::Mesh { scale, rotate, translate, .. } => placed(euler_degrees(rotate) * scale, translate),
        }
    }

    /// Returns the prim. `matrix` is its transformation in all frames; `None` if it moves. `first` is its
    /// transformation in the first frame, and `bounds` are those of all bodies then.
    pub(super) fn prim(
        &self,
        names: &mut Names,
        matrix: Option<&Matrix4<f64>>,
        first: &Matrix4<f64>,
        bounds: Option<[[f32; 3]; 2]>,
    ) -> Prim {
        let symmetric = |half: [f64; 3]| {
            let half = half.map(|number| number as f32);
            Value::Vectors3(vec![half.map(|number| -number), half])
        };
        let prim = match &self.shape {
            Shape::Plane { .. } => plane(names, first, bounds.unwrap_or(NO_BODIES)),
            Shape::Sphere { radius, .. } => Prim::new("Sphere", "sphere", names)
                .constant("double", "radius", Value::Double(*radius))
                .constant("float3[]", "extent", symmetric([*radius; 3])),
            Shape::Box { .. } => Prim::new("Cube", "box", names)
                .constant("double", "size", Value::Double(2.0))
                .constant("float3[]", "extent", symmetric([1.0; 3])),
            Shape::Capsule { a, b, radius } => {
                let height = (Vector3::from(*b) - Vector3::from(*a)).norm();
                Prim::new("Capsule", "capsule", names)
                    .uniform("token", "axis", token("Z"))
                    .constant("double", "height", Value::Double(height))
                    .constant("double", "radius", Value::Double(*radius))
                    .constant("float3[]", "extent", symmetric([*radius, *radius, height / 2.0 + radius]))
            }
            Shape::Mesh { mesh, .. } => {
                let prim = mesh_prim("mesh", names, mesh.mesh());
                match self.animated {
                    Some((_, points, bounds)) => {
                        prim.animated("float3[]", "extent", bounds).animated("point3f[]", "points", points)
                    }
                    None => {
                        let (low, high) = mesh.mesh().bounds();
                        let points = mesh.mesh().vertices().iter().copied().map(finite).collect();
                        prim.constant("float3[]", "extent", Value::Vectors3([low, high].map(finite).into()))
                            .constant("point3f[]", "points", Value::Vectors3(points))
                    }
                }
            }
        };
        let prim = match matrix {
            Some(matrix) => prim.constant("matrix4d", "xformOp:transform", Value::Matrix((*matrix).into())),
            None => prim.animated("matrix4d", "xformOp:transform", self.matrix),
        };
        prim.uniform("token[]", "xformOpOrder", Value::Tokens(vec!["xformOp:transform".to_owned()])).uniform(
            "token",
            "purpose",
            token("guide"),
        )
    }
}

/// Returns a square below the bodies: a plane has no end.
fn plane(names: &mut Names, matrix: &Matrix4<f64>, [low, high]: [[f32; 3]; 2]) -> Prim {
    let [low, high] = [low, high].map(|corner| Point3::from(corner.map(f64::from)));
    let inverse = matrix.try_inverse().unwrap_or_else(Matrix4::identity);
    let center = inverse.transform_point(&nalgebra::center(&low, &high));
    let half = PLANE * inverse.transform_vector(&(high - low)).norm();
    let corner = |x: f64, y: f64| finite(Point3::new(center.x + x * half, center.y + y * half, 0.0));
    let points = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    Prim::new("Mesh", "plane", names)
        .uniform("bool", "doubleSided", Value::Bool(true))
        .constant("float3[]", "extent", Value::Vectors3(vec![points[0], points[2]]))
        .constant("int[]", "faceVertexCounts", Value::Integers(vec![4]))
        .constant("int[]", "faceVertexIndices", Value::Integers(vec![0, 1, 2, 3]))
        .constant("point3f[]", "points", Value::Vectors3(points.to_vec()))
        .uniform("token", "subdivisionScheme", token("none"))
}

/// Returns a rotation of the z axis to a direction; no rotation if the direction is zero.
fn along(direction: Vector3<f64>) -> Matrix3<f64> {
    let Some(direction) = Unit::try_new(direction, 0.0) else { return Matrix3::identity() };
    let half_turn = || Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    Rotation3::rotation_between(&Vector3::z_axis(), &direction).unwrap_or_else(half_turn).into_inner()
}

fn finite(point: Point3<f64>) -> [f32; 3] {
    point.coords.map(|number| number.clamp(f32::MIN.into(), f32::MAX.into()) as f32).into()
}
