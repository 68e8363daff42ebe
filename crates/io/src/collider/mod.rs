//! Places and surfaces of colliders, for the files that show them.
//!
//! ```text
//! coordinates of the shape -> local -> scene before it moves -> moved -> scene
//! ```

mod shapes;

use nalgebra::{Matrix3, Matrix4, Point3, Rotation3, Translation3, Unit, Vector3};
use supple::{Shape, Simulation, euler_degrees};

pub(crate) use shapes::{Divisions, faces};

/// Name of the node of a GLB file whose children are the colliders. No body can have it.
pub(crate) const COLLIDERS: &str = "supple colliders";

/// Returns the transformation from the coordinates of a shape to the scene, before the collider moves. In its coordinates a
/// plane is z = 0, a box has half extents of 1, a capsule is along z, and all but meshes are about the origin.
pub(crate) fn local(shape: &Shape) -> Matrix4<f64> {
    let placed = |rotation: Matrix3<f64>, to: [f64; 3]| {
        Translation3::from(Vector3::from(to)).to_homogeneous() * rotation.to_homogeneous()
    };
    match *shape {
        Shape::Plane { point, normal } => placed(along(normal.into()), point),
        Shape::Sphere { center, .. } => placed(Matrix3::identity(), center),
        Shape::Box { center, half_extents, rotate } => {
            let scale = Matrix3::from_diagonal(&half_extents.into());
            placed(euler_degrees(rotate) * scale, center)
        }
        Shape::Capsule { a, b, .. } => {
            placed(along(Vector3::from(b) - Vector3::from(a)), shape.center().into())
        }
        Shape::Mesh { scale, rotate, translate, .. } => placed(euler_degrees(rotate) * scale, translate),
    }
}

/// Returns the displacement of the center of the collider with an index in a simulation, and its rotation about the center
/// in degrees; `None` while it is disabled. In the data of frames, the numbers of a pose are then NaN, and no file shows the
/// collider. A program can remove colliders from a simulation; these stay where the scene puts them.
pub(crate) fn pose(simulation: &Simulation, index: usize) -> Option<([f64; 3], [f64; 3])> {
    if index >= simulation.collider_count() {
        return Some(Default::default());
    }
    let collider = simulation.collider(index);
    collider.is_enabled().then(|| (collider.translation(), collider.rotation()))
}

/// Returns for each frame the one whose pose a file has in it: the last frame so far in which the collider is shown, before
/// the first of these the first one. `None` if it is shown in no frame.
pub(crate) fn posed_frames(is_shown: &[bool]) -> Option<Vec<usize>> {
    let mut last = is_shown.iter().position(|&is_shown| is_shown)?;
    let posed = is_shown.iter().enumerate().map(|(frame, &is_shown)| {
        last = if is_shown { frame } else { last };
        last
    });
    Some(posed.collect())
}

/// Returns the motion of a collider from where the scene puts it.
pub(crate) fn moved(shape: &Shape, (translate, rotate): ([f64; 3], [f64; 3])) -> Matrix4<f64> {
    let center = shape.center().coords;
    Translation3::from(center + Vector3::from(translate)).to_homogeneous()
        * euler_degrees(rotate).to_homogeneous()
        * Translation3::from(-center).to_homogeneous()
}

/// Returns the positions of an animated mesh at a time in seconds, in its own coordinates; `None` for other shapes.
pub(crate) fn animated_positions(shape: &Shape, time: f64) -> Option<Vec<[f32; 3]>> {
    let Shape::Mesh { mesh, .. } = shape else { return None };
    let mut vertices = Vec::new();
    mesh.animation()?.positions_at_time(time, &mut vertices);
    Some(vertices.into_iter().map(finite).collect())
}

/// Returns the corners of a square of a plane, which has no end, in its coordinates: around the center of bounds, with
/// half of its edges as a multiple of their diagonal. `matrix` is the transformation from its coordinates to those of
/// the bounds.
pub(crate) fn square(matrix: &Matrix4<f64>, [low, high]: [Point3<f64>; 2], multiple: f64) -> [[f32; 3]; 4] {
    let inverse = matrix.try_inverse().unwrap_or_else(Matrix4::identity);
    let center = inverse.transform_point(&nalgebra::center(&low, &high));
    let half = multiple * inverse.transform_vector(&(high - low)).norm();
    [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
        .map(|[x, y]| finite(Point3::new(center.x + x * half, center.y + y * half, 0.0)))
}

/// Returns a point within the range of `f32`.
pub(crate) fn finite(point: Point3<f64>) -> [f32; 3] {
    point.coords.map(|number| number.clamp(f32::MIN.into(), f32::MAX.into()) as f32).into()
}

/// Returns a rotation of the z axis to a direction; no rotation if the direction is zero.
fn along(direction: Vector3<f64>) -> Matrix3<f64> {
    let Some(direction) = Unit::try_new(direction, 0.0) else { return Matrix3::identity() };
    let half_turn = || Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    Rotation3::rotation_between(&Vector3::z_axis(), &direction).unwrap_or_else(half_turn).into_inner()
}
