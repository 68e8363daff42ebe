//! Where a ray meets a shape.

use nalgebra::{Point3, Vector3};

use super::distance::SignedDistance;
use super::shape::PosedShape;

/// Greatest number of steps of Newton's method. A ray that passes a curved shape needs the most.
const MAX_STEPS: usize = 100;
/// Distance from a shape that counts as on it, as a share of the path of the ray.
const TOLERANCE: f64 = 1e-12;

impl PosedShape<'_> {
    /// Returns where a ray first meets the shape at a distance of at most `limit`: the distance along the unit vector
    /// `direction`, and the outward normal there. A ray from inside of a solid meets it at its start. The sides of an open
    /// mesh count alike.
    ///
    /// All shapes but meshes are convex, so that their distance along a ray is a convex function: Newton's method comes
    /// from the start of the ray to the first point without passing it.
    pub(crate) fn cast(
        &self,
        start: &Point3<f64>,
        direction: &Vector3<f64>,
        limit: f64,
    ) -> Option<(f64, Vector3<f64>)> {
        if let Self::Mesh(mesh) = self {
            let SignedDistance { distance, normal } = self.signed_distance(start);
            if mesh.is_closed() && distance < 0.0 {
                return Some((0.0, normal));
            }
            let length = limit.min(mesh.greatest_distance(start));
            let (fraction, normal) = mesh.first_hit(start, &(start + direction * length))?;
            return Some((fraction * length, normal));
        }
        let mut path = 0.0;
        for _ in 0..MAX_STEPS {
            let SignedDistance { distance, normal } = self.signed_distance(&(start + direction * path));
            if distance <= TOLERANCE * path {
                return Some((path, normal));
            }
            let speed = -normal.dot(direction);
            path += if speed > 0.0 { distance / speed } else { f64::INFINITY };
            if path > limit || path.is_infinite() {
                return None;
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::super::shape::Shape;
    use super::*;
    use crate::motion::Pose;
    use crate::state::BodyFrame;

    fn cast(shape: &Shape, start: [f64; 3], direction: [f64; 3], limit: f64) -> Option<(f64, Vector3<f64>)> {
        let direction = Vector3::from(direction).normalize();
        shape.posed(&Pose::identity(), BodyFrame::WORLD).cast(&start.into(), &direction, limit)
    }

    #[test]
    fn rays_meet_convex_shapes_where_they_must() {
        let far = f64::INFINITY;
        let plane = Shape::Plane { point: [0.0, 1.0, 0.0], normal: [0.0, 1.0, 0.0] };
        let (distance, normal) = cast(&plane, [0.0, 3.0, 0.0], [1.0, -1e-3, 0.0], far).unwrap();
        assert!((distance - 2.0 * (1.0 + 1e6_f64).sqrt()).abs() < 1e-6 && normal == Vector3::y());
        assert!(cast(&plane, [0.0, 3.0, 0.0], [1.0, 1e-9, 0.0], far).is_none());
        assert!(cast(&plane, [0.0, 3.0, 0.0], [0.0, -1.0, 0.0], 1.9).is_none());
        assert_eq!(cast(&plane, [0.0, 0.5, 0.0], [0.0, 1.0, 0.0], far).unwrap().0, 0.0);
        let ball = Shape::Sphere { center: [5.0, 0.0, 0.0], radius: 2.0 };
        for height in [0.0, 1.0, 1.9999, 2.0001] {
            let found = cast(&ball, [0.0, height, 0.0], [1.0, 0.0, 0.0], far);
            let expected = (4.0 - height * height).max(0.0).sqrt();
            match found {
                Some((distance, normal)) => {
                    assert!((distance - 5.0 + expected).abs() < 1e-6, "{height}: {distance}");
                    assert!((normal - Vector3::new(-expected, height, 0.0) / 2.0).norm() < 1e-5);
                }
                None => assert!(height > 2.0),
            }
        }
        let block = Shape::Box { center: [0.0; 3], half_extents: [1.0, 2.0, 3.0], rotate: [0.0, 0.0, 90.0] };
        let (distance, normal) = cast(&block, [-10.0, 0.5, 2.0], [1.0, 0.0, 0.0], far).unwrap();
        assert!((distance - 8.0).abs() < 1e-9 && (normal + Vector3::x()).norm() < 1e-9);
        assert!(cast(&block, [-10.0, 1.5, 2.0], [1.0, 0.0, 0.0], far).is_none());
        let rod = Shape::Capsule { a: [0.0; 3], b: [0.0, 4.0, 0.0], radius: 0.5 };
        let (distance, _) = cast(&rod, [0.0, 10.0, 0.0], [0.0, -1.0, 0.0], far).unwrap();
        assert!((distance - 5.5).abs() < 1e-9);
    }
}
