//! Colliders as surfaces of nodes that move rigidly. An animated mesh is a surface like that of a body.

use std::io;
use std::ops::Range;

use nalgebra::{Matrix4, Point3, Rotation3, UnitQuaternion, Vector3};
use supple::mesh::Mesh;
use supple::{Shape, Simulation, euler_degrees, vertex_normals};

use super::motion::{Pose, near};
use super::{BodyPoints, Materials, Samples, SplitSurface};
use crate::collider::{self, Divisions};
use crate::space::FileSpace;

/// Half of the edge length of the square of a plane, as a multiple of the diagonal of the bounds of the motion.
const PLANE: f64 = 0.75;

/// How finely shapes are divided.
const DIVISIONS: Divisions = Divisions { around: 32, quarter: 8, edge: 1 };

/// Number of vectors of a pose: the translation, and the rotation as axis times angle in radians.
const POSE: usize = 2;

/// A collider of a clip.
#[derive(Debug)]
pub(crate) struct ColliderSurface {
    name: String,
    shape: Shape,
    /// Index of the collider in the simulation.
    index: usize,
    surface: SplitSurface,
    /// The vertices in the coordinates of the shape, the triangles, and the vertices that share a normal.
    vertices: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    weld: Vec<u32>,
    /// Whether it is an animated mesh.
    pub(super) is_animated: bool,
    /// Index of its first vector in a sample.
    first: usize,
}

/// A collider as a node: its surface about the center of the node, and the pose of the node in each frame.
pub(super) struct ColliderNode<'a> {
    pub(super) name: &'a str,
    pub(super) surface: &'a SplitSurface,
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) normals: Vec<[f32; 3]>,
    pub(super) poses: Vec<Pose>,
}

impl ColliderSurface {
    /// Returns the surface of the collider with an index in a simulation; `None` if its mesh has no faces.
    pub(crate) fn new(
        simulation: &Simulation,
        index: usize,
        first: usize,
        materials: &mut Materials,
    ) -> Option<Self> {
        let shape = simulation.collider(index).description().shape.clone();
        let kind = match &shape {
            Shape::Plane { .. } => "plane",
            Shape::Sphere { .. } => "sphere",
            Shape::Box { .. } => "box",
            Shape::Capsule { .. } => "capsule",
            Shape::Mesh { .. } => "mesh",
        };
        let own;
        let (mesh, weld) = match &shape {
            Shape::Mesh { mesh, .. } => (mesh.mesh(), mesh.mesh().weld().to_vec()),
            _ => {
                let (vertices, faces) = collider::faces(&shape, DIVISIONS)?;
                own = Mesh::new(vertices, &faces).ok()?;
                (&own, (0..own.vertices().len() as u32).collect())
            }
        };
        let is_animated = matches!(&shape, Shape::Mesh { mesh, .. } if mesh.animation().is_some());
        Some(Self {
            name: format!("{kind} {index}"),
            index,
            surface: SplitSurface::new(mesh, None, materials),
            vertices: mesh.vertices().iter().copied().map(collider::finite).collect(),
            triangles: mesh.triangles().to_vec(),
            weld,
            is_animated,
            first,
            shape,
        })
    }

    /// Returns the number of its vectors in a sample.
    pub(crate) fn len(&self) -> usize {
        if self.is_animated { 2 * self.surface.len() } else { POSE }
    }

    /// Appends its vectors of the present frame to a sample. `spaces`: the coordinates of the other files, and those of
    /// this one in these. They are NaN while the collider is disabled.
    pub(crate) fn push(&self, simulation: &Simulation, spaces: [FileSpace; 2], sample: &mut Vec<[f32; 3]>) {
        let Some(pose) = collider::pose(simulation, self.index) else {
            sample.extend(std::iter::repeat_n([f32::NAN; 3], self.len()));
            return;
        };
        let Some(mut positions) = collider::animated_positions(&self.shape, simulation.time()) else {
            let (translate, rotate) = pose;
            let angles = spaces[1].angles(spaces[0].angles(rotate));
            let rotation = Rotation3::from_matrix_unchecked(euler_degrees(angles)).scaled_axis();
            sample.extend([self.center(translate, spaces), rotation.cast::<f32>().into()]);
            return;
        };
        positions.resize(self.vertices.len(), [0.0; 3]);
        let matrix = matrix(spaces) * collider::moved(&self.shape, pose) * collider::local(&self.shape);
        let positions = transformed(&matrix, &positions);
        let normals = self.normals(&positions);
        sample.extend(self.surface.positions(&positions));
        sample.extend(self.surface.normals(&normals));
    }

    /// Returns the center of its rotation, displaced.
    fn center(&self, displacement: [f64; 3], spaces: [FileSpace; 2]) -> [f32; 3] {
        let center = self.shape.center() + Vector3::from(displacement);
        collider::finite(spaces[1].position(spaces[0].position(center.into())).into())
    }

    fn normals(&self, positions: &[[f32; 3]]) -> Vec<[f32; 3]> {
        let mut normals = vec![[0.0; 3]; positions.len()];
        vertex_normals(&self.triangles, positions, &self.weld, &mut normals);
        // A vertex without faces.
        normals.iter_mut().filter(|normal| **normal == [0.0; 3]).for_each(|normal| *normal = [0.0, 1.0, 0.0]);
        normals
    }

    /// Returns its vectors in a sample.
    pub(super) fn vectors(&self) -> Range<usize> {
        self.first..self.first + self.len()
    }

    /// Returns the points of an animated mesh.
    pub(super) fn points(&self) -> BodyPoints<'_> {
        BodyPoints { name: &self.name, surface: &self.surface, first: self.first }
    }

    /// Returns the node. `bounds` are those of the motion of all bodies in the file.
    pub(super) fn node(
        &self,
        samples: &mut dyn Samples,
        spaces: [FileSpace; 2],
        bounds: [Point3<f64>; 2],
    ) -> io::Result<ColliderNode<'_>> {
        let matrix = matrix(spaces) * collider::local(&self.shape);
        let vertices = match self.shape {
            Shape::Plane { .. } => collider::square(&matrix, bounds, PLANE).to_vec(),
            _ => self.vertices.clone(),
        };
        let center = Vector3::from(self.center([0.0; 3], spaces).map(f64::from));
        let positions = transformed(&(Matrix4::new_translation(&-center) * matrix), &vertices);
        let normals = self.normals(&positions);
        let mut poses: Vec<Pose> = Vec::new();
        let mut vectors = Vec::new();
        for frame in 0..samples.frames() {
            samples.read(frame, self.first..self.first + POSE, &mut vectors)?;
            let [translation, axis] = [0, 1].map(|k| Vector3::from(vectors[k].map(f64::from)));
            let rotation = UnitQuaternion::from_scaled_axis(axis);
            let rotation = poses.last().map_or(rotation, |before| near(rotation, before.rotation));
            poses.push(Pose { rotation, translation, is_shown: samples.is_shown(frame, self.first) });
        }
        Ok(ColliderNode {
            name: &self.name,
            surface: &self.surface,
            positions: self.surface.positions(&positions).collect(),
            normals: self.surface.normals(&normals).collect(),
            poses,
        })
    }
}

/// Returns the bounds of points in all frames.
pub(super) fn bounds_of(
    samples: &mut dyn Samples,
    points: impl Iterator<Item = Range<usize>> + Clone,
) -> io::Result<[Point3<f64>; 2]> {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    let mut vectors = Vec::new();
    for frame in 0..samples.frames() {
        for range in points.clone() {
            samples.read(frame, range, &mut vectors)?;
            for vector in &vectors {
                low = std::array::from_fn(|axis| low[axis].min(vector[axis]));
                high = std::array::from_fn(|axis| high[axis].max(vector[axis]));
            }
        }
    }
    let is_empty = low[0] > high[0];
    Ok([low, high].map(|corner| if is_empty { Point3::origin() } else { corner.map(f64::from).into() }))
}

/// Returns the transformation from the scene to the file.
fn matrix([files, file]: [FileSpace; 2]) -> Matrix4<f64> {
    file.matrix() * files.matrix()
}

fn transformed(matrix: &Matrix4<f64>, points: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let transform = |point: &[f32; 3]| matrix.transform_point(&point.map(f64::from).into());
    points.iter().map(|point| collider::finite(transform(point))).collect()
}
