//! Prims of colliders.

use nalgebra::{Matrix4, Point3, Vector3};
use supple::{Shape, Simulation};

use super::layout::Layout;
use super::name::Names;
use super::prim::{Prim, Property, Stored, Value, token};
use super::surface::mesh_prim;
use crate::collider::{self, finite};
use crate::space::FileSpace;

/// A collider, and the places of its values in the frames.
#[derive(Debug)]
pub(super) struct ColliderPrim {
    shape: Shape,
    pub(super) matrix: Stored,
    /// The number of points of an animated mesh, and the places of its points and their bounds.
    pub(super) animated: Option<(usize, Stored, Stored)>,
}

/// The transformations of a prim in the frames.
pub(super) struct Transforms<'a> {
    /// That of the first frame in which the collider is shown.
    first: Matrix4<f64>,
    moves: bool,
    /// Offset of each frame.
    starts: &'a [u64],
    is_shown: Vec<bool>,
    /// For each frame, the one whose transformation the prim has.
    posed: Vec<usize>,
}

impl<'a> Transforms<'a> {
    /// `None` if the collider is shown in none of the frames. `matrices`: those of the frames.
    pub(super) fn new(matrices: &[Matrix4<f64>], starts: &'a [u64]) -> Option<Self> {
        let is_shown: Vec<bool> = matrices.iter().map(|matrix| !matrix[0].is_nan()).collect();
        let posed = if matrices.is_empty() { Vec::new() } else { collider::posed_frames(&is_shown)? };
        let first = posed.first().map_or_else(Matrix4::identity, |&frame| matrices[frame]);
        let moves = posed.iter().any(|&frame| matrices[frame] != first);
        Some(Self { first, moves, starts, is_shown, posed })
    }

    /// Adds the transformation, and the visibility if it changes.
    fn add_to(&self, prim: Prim, stored: Stored) -> Prim {
        let (type_name, name) = ("matrix4d", "xformOp:transform");
        let is_always_shown = !self.is_shown.contains(&false);
        let prim = match (self.moves, is_always_shown) {
            (false, _) => prim.constant(type_name, name, Value::Matrix(self.first.into())),
            (true, true) => prim.animated(type_name, name, stored),
            (true, false) => {
                let values =
                    self.posed.iter().map(|&frame| Value::Written(stored.in_frame(self.starts[frame])));
                let every: Vec<usize> = (0..self.posed.len()).collect();
                prim.property(Property::chosen(type_name, name, values.collect(), &every))
            }
        };
        let prim = prim.uniform("token[]", "xformOpOrder", Value::Tokens(vec![name.to_owned()]));
        if is_always_shown {
            return prim;
        }
        let values = ["inherited", "invisible"].map(token).to_vec();
        let of_frame: Vec<usize> = self.is_shown.iter().map(|&is_shown| usize::from(!is_shown)).collect();
        prim.property(Property::chosen("token", "visibility", values, &of_frame))
    }
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
    /// in a simulation. Its numbers are NaN while the collider is disabled.
    pub(super) fn matrix(&self, simulation: &Simulation, index: usize, space: FileSpace) -> Matrix4<f64> {
        let Some(pose) = collider::pose(simulation, index) else { return Matrix4::repeat(f64::NAN) };
        space.matrix() * collider::moved(&self.shape, pose) * collider::local(&self.shape)
    }

    /// Returns the positions of an animated mesh at a time in seconds, in the coordinates of the prim.
    pub(super) fn positions(&self, time: f64) -> Vec<[f32; 3]> {
        collider::animated_positions(&self.shape, time).unwrap_or_default()
    }

    /// Returns the prim. `bounds` are those of all bodies in the first frame.
    pub(super) fn prim(
        &self,
        names: &mut Names,
        transforms: &Transforms<'_>,
        bounds: Option<[[f32; 3]; 2]>,
    ) -> Prim {
        let symmetric = |half: [f64; 3]| {
            let half = half.map(|number| number as f32);
            Value::Vectors3(vec![half.map(|number| -number), half])
        };
        let prim = match &self.shape {
            Shape::Plane { .. } => plane(names, &transforms.first, bounds.unwrap_or(NO_BODIES)),
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
        transforms.add_to(prim, self.matrix).uniform("token", "purpose", token("guide"))
    }
}

/// Returns a square around the bodies.
fn plane(names: &mut Names, matrix: &Matrix4<f64>, bounds: [[f32; 3]; 2]) -> Prim {
    let bounds = bounds.map(|corner| Point3::from(corner.map(f64::from)));
    let points = collider::square(matrix, bounds, PLANE);
    Prim::new("Mesh", "plane", names)
        .uniform("bool", "doubleSided", Value::Bool(true))
        .constant("float3[]", "extent", Value::Vectors3(vec![points[0], points[2]]))
        .constant("int[]", "faceVertexCounts", Value::Integers(vec![4]))
        .constant("int[]", "faceVertexIndices", Value::Integers(vec![0, 1, 2, 3]))
        .constant("point3f[]", "points", Value::Vectors3(points.to_vec()))
        .uniform("token", "subdivisionScheme", token("none"))
}
