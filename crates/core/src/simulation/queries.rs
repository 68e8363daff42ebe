//! What a ray meets, and what is nearest to a point: bodies as they are displayed, and colliders.

use nalgebra::{Point3, Vector3};

use super::contact_point::Touched;
use super::world::Simulation;
use crate::contact::PosedShape;
use crate::mesh::SurfaceTree;
use crate::range::{RangeError, in_range};

/// Greatest magnitude of coordinates: its square is far from the greatest number.
const LIMIT: f64 = 1e100;

/// A point of a displayed body or of a collider.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct FoundPoint {
    /// The body or the collider.
    pub of: Touched,
    /// Index of the face of the displayed mesh; `None` on a collider and on a bare lattice.
    pub face: Option<u32>,
    /// Distance along the ray or from the point, in scene units.
    pub distance: f64,
    /// The point, in world space.
    pub point: Point3<f64>,
    /// Unit normal: of a body by the winding of its faces, of a collider outward.
    pub normal: Vector3<f64>,
}

/// The displayed surface of a body.
struct Surface {
    body: usize,
    tree: SurfaceTree,
    /// The face of each triangle; empty for a bare lattice.
    faces: Vec<u32>,
}

impl Simulation {
    /// Returns what each ray meets first: a displayed surface from either side, or an enabled collider. `None` where a
    /// ray meets nothing. A ray that starts in a solid collider meets it there.
    ///
    /// A call evaluates the surfaces of all bodies and builds a tree of each, which takes about 10 ms for 10,000 faces; a
    /// ray takes about a microsecond more. So many rays in one call are fast.
    ///
    /// * `rays`: start and direction of each ray; a direction may have any length but 0.
    /// * `limit`: greatest distance, >= 0; it may be infinite.
    ///
    /// # Errors
    ///
    /// A number that is not finite, or a direction of length 0.
    pub fn raycast(
        &self,
        rays: &[([f64; 3], [f64; 3])],
        limit: f64,
    ) -> Result<Vec<Option<FoundPoint>>, RangeError> {
        if limit != f64::INFINITY {
            in_range("max_distance", limit, limit >= 0.0, "at least 0")?;
        }
        for (start, direction) in rays {
            finite("origin", start)?;
            for &x in direction {
                in_range("direction", x, x.is_finite(), "finite")?;
            }
            let length = Vector3::from(*direction).amax();
            in_range("length of the direction of a ray", length, length > 0.0, "greater than 0")?;
        }
        let (surfaces, colliders) = (self.surfaces(), self.shapes());
        let first = |&(start, direction): &([f64; 3], [f64; 3])| {
            let (start, direction) = (Point3::from(start), Vector3::from(direction));
            // Divided by the greatest coordinate first, so that no square overflows.
            let direction = (direction / direction.amax()).normalize();
            let of_bodies = surfaces.iter().filter_map(|surface| surface.cast(&start, &direction, limit));
            let of_colliders = colliders.iter().filter_map(|(index, shape)| {
                let (distance, normal) = shape.cast(&start, &direction, limit)?;
                let (of, point) = (Touched::Collider(*index), start + direction * distance);
                Some(FoundPoint { of, face: None, distance, point, normal })
            });
            least(of_bodies.chain(of_colliders))
        };
        Ok(rays.iter().map(first).collect())
    }

    /// Returns what is nearest to each point: a point of a displayed surface or of an enabled collider. `None` without
    /// any.
    ///
    /// It costs as much as [`raycast`](Self::raycast). The distance is never negative, also inside of a body or a
    /// collider.
    ///
    /// # Errors
    ///
    /// A coordinate that is not finite.
    pub fn nearest(&self, points: &[[f64; 3]]) -> Result<Vec<Option<FoundPoint>>, RangeError> {
        points.iter().try_for_each(|point| finite("point", point))?;
        let (surfaces, colliders) = (self.surfaces(), self.shapes());
        let first = |&point: &[f64; 3]| {
            let point = Point3::from(point);
            let of_bodies = surfaces.iter().filter_map(|surface| surface.nearest(&point));
            let of_colliders = colliders.iter().map(|(index, shape)| {
                let found = shape.signed_distance(&point);
                let nearest = point - found.normal * found.distance;
                FoundPoint {
                    of: Touched::Collider(*index),
                    face: None,
                    distance: found.distance.abs(),
                    point: nearest,
                    normal: found.normal,
                }
            });
            least(of_bodies.chain(of_colliders))
        };
        Ok(points.iter().map(first).collect())
    }

    /// Returns the shapes of the colliders that are enabled now, with their indices.
    fn shapes(&self) -> Vec<(usize, PosedShape<'_>)> {
        self.colliders.surfaces_at(self.time()).collect()
    }

    /// Returns the displayed surfaces of the bodies that have any area.
    fn surfaces(&self) -> Vec<Surface> {
        (0..self.bodies.len()).filter_map(|body| self.surface_of(body)).collect()
    }

    fn surface_of(&self, body: usize) -> Option<Surface> {
        let reference = self.body(body);
        let (vertices, triangles, faces) = match reference.mesh() {
            Some(mesh) => {
                let of_face = |(face, corners): (u32, &[u32])| {
                    std::iter::repeat_n(face, corners.len().saturating_sub(2))
                };
                let faces: Vec<u32> = (0..).zip(mesh.faces()).flat_map(of_face).collect();
                (reference.surface().positions, mesh.triangles().to_vec(), faces)
            }
            None => {
                let quads = reference.lattice().boundary_faces();
                let halves = |(_, [a, b, c, d]): (usize, [u32; 4])| [[a, b, c], [a, c, d]];
                (reference.positions(), quads.flat_map(halves).collect(), Vec::new())
            }
        };
        // The tree leaves out triangles without area, and so does the list of their faces.
        let has_area = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|corner| vertices[corner as usize]);
            (b - a).cross(&(c - a)).try_normalize(0.0).is_some()
        };
        let kept = faces.iter().zip(&triangles).filter(|(_, triangle)| has_area(triangle));
        let faces = kept.map(|(&face, _)| face).collect();
        let tree = SurfaceTree::new(&vertices, triangles.iter().copied())?;
        Some(Surface { body, tree, faces })
    }
}

impl Surface {
    fn face(&self, triangle: u32) -> Option<u32> {
        self.faces.get(triangle as usize).copied()
    }

    fn cast(&self, start: &Point3<f64>, direction: &Vector3<f64>, limit: f64) -> Option<FoundPoint> {
        let length = limit.min(self.tree.greatest_distance(start));
        let (fraction, triangle) = self.tree.cast(start, &(direction * length))?;
        let distance = fraction * length;
        Some(FoundPoint {
            of: Touched::Body(self.body),
            face: self.face(triangle),
            distance,
            point: start + direction * distance,
            normal: self.tree.triangle_normal(triangle),
        })
    }

    fn nearest(&self, point: &Point3<f64>) -> Option<FoundPoint> {
        let closest = self.tree.closest(point, f64::INFINITY, |_| true)?;
        Some(FoundPoint {
            of: Touched::Body(self.body),
            face: self.face(closest.triangle),
            distance: closest.distance,
            point: closest.point,
            normal: closest.normal,
        })
    }
}

/// Returns the point at the least distance, the first of several.
fn least(points: impl Iterator<Item = FoundPoint>) -> Option<FoundPoint> {
    points.min_by(|a, b| a.distance.total_cmp(&b.distance))
}

fn finite(name: &'static str, numbers: &[f64; 3]) -> Result<(), RangeError> {
    numbers
        .iter()
        .try_for_each(|&x| in_range(name, x, x.abs() <= LIMIT, "finite and at most 1e100").map(drop))
}
