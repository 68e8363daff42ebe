//! The signed distance from a shape.

use nalgebra::Vector3;

/// Signed distance from a shape's surface, negative inside, and its gradient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SignedDistance {
    /// Distance, in the unit of the point.
    pub distance: f64,
    /// Gradient of the distance, a unit vector. Where the gradient does not exist, this is:
    ///
    /// * at the center of a sphere, and of a capsule with `a` = `b`: the x axis;
    /// * on the segment of a capsule: a direction perpendicular to the segment;
    /// * inside a box, at equal distance from several nearest faces: the normal of the first of these faces
    ///   in the order x, y, z;
    /// * at equal distance from several points of a mesh: the direction of one of them.
    pub normal: Vector3<f64>,
}
