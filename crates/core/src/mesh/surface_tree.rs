//! Closest points on a triangle mesh, and on which side of the mesh a point is.
//!
//! The bounding volume hierarchy, its traversal and the projection on one triangle are parry3d's, whose pseudonormals have
//! other bits on other platforms. The side follows from
//! angle-weighted pseudonormals (Bærentzen & Aanæs 2005): at a closest point on a face, an edge or a corner, the sum of
//! the normals of the faces there, at corners weighted by their angles. The sign of its product with the vector from
//! the closest point is right for every closed surface that does not intersect itself.

use std::collections::HashMap;

use nalgebra::{Point3, Vector3};
use parry3d_f64::math::Vector;
use parry3d_f64::query::{PointQueryWithLocation, Ray, RayCast};
use parry3d_f64::shape::{TriMesh, TrianglePointLocation};

/// Barycentric coordinate of a corner below which a point is on the opposite edge.
const ON_EDGE: f64 = 1e-9;

/// Direction of the line by which points are found inside. Edges of meshes are hardly ever in a plane with it.
const CROSSING: [f64; 3] = [0.301, 0.912, 0.279];

/// A triangle mesh for queries of closest points.
#[derive(Clone)]
pub(crate) struct SurfaceTree {
    mesh: TriMesh,
    /// Unit normal of each triangle.
    normals: Vec<Vector3<f64>>,
    /// For each vertex, the sum of the normals of its triangles times their angles there.
    vertex_sums: Vec<Vector3<f64>>,
    /// For each triangle, the sums of the normals at its edges; edge k joins the corners k and k + 1.
    edge_sums: Vec<[Vector3<f64>; 3]>,
}

/// The closest point of a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ClosestPoint {
    pub point: Point3<f64>,
    /// Distance to it, in the unit of the mesh; never negative.
    pub distance: f64,
    /// Angle-weighted pseudonormal at the point, a unit vector to the outside.
    pub normal: Vector3<f64>,
    /// Index of its triangle.
    pub triangle: u32,
}

impl ClosestPoint {
    /// Returns whether `point`, whose closest point this is, is inside the surface.
    pub(crate) fn is_inside(&self, point: &Point3<f64>) -> bool {
        (point - self.point).dot(&self.normal) < 0.0
    }
}

impl SurfaceTree {
    /// Builds the tree of a mesh. Vertices at the same position have to be one vertex, or the pseudonormals at an edge
    /// between them are those of one side. Triangles without area are left out; returns `None` if there is no other.
    pub(crate) fn new(vertices: &[Point3<f64>], triangles: impl Iterator<Item = [u32; 3]>) -> Option<Self> {
        let corner = |v: u32| vertices[v as usize];
        let (triangles, normals): (Vec<[u32; 3]>, Vec<Vector3<f64>>) = triangles
            .filter_map(|triangle| {
                let [a, b, c] = triangle.map(corner);
                let normal = (b - a).cross(&(c - a)).try_normalize(0.0)?;
                Some((triangle, normal))
            })
            .unzip();
        let mut vertex_sums = vec![Vector3::zeros(); vertices.len()];
        let mut sum_of_edge = HashMap::new();
        let edge = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
        for (&[a, b, c], normal) in triangles.iter().zip(&normals) {
            for [at, next, last] in [[a, b, c], [b, c, a], [c, a, b]] {
                let [u, v] = [next, last].map(|other| corner(other) - corner(at));
                let cosine = u.dot(&v) / (u.norm() * v.norm());
                vertex_sums[at as usize] += normal * libm::acos(cosine.clamp(-1.0, 1.0));
                *sum_of_edge.entry(edge([at, next])).or_insert_with(Vector3::zeros) += normal;
            }
        }
        let edges = triangles.iter().map(|&[a, b, c]| [[a, b], [b, c], [c, a]].map(edge));
        let edge_sums = edges.map(|edges| edges.map(|edge| sum_of_edge[&edge])).collect();
        let mesh = TriMesh::new(vertices.iter().map(to_parry).collect(), triangles).ok()?;
        Some(Self { mesh, normals, vertex_sums, edge_sums })
    }

    /// Returns the unit normal of a triangle.
    pub(crate) fn triangle_normal(&self, triangle: u32) -> Vector3<f64> {
        self.normals[triangle as usize]
    }

    /// Returns the vertices of a triangle. Triangles without area were left out.
    fn triangle(&self, triangle: u32) -> [u32; 3] {
        self.mesh.indices()[triangle as usize]
    }

    /// Returns the number of triangles.
    pub(crate) fn len(&self) -> usize {
        self.normals.len()
    }

    /// Returns the closest point at a distance below `limit` among the triangles that `accepts` takes, or `None`.
    pub(crate) fn closest(
        &self,
        point: &Point3<f64>,
        limit: f64,
        accepts: impl Fn(u32) -> bool,
    ) -> Option<ClosestPoint> {
        let target = to_parry(point);
        let project = |triangle: u32, _| {
            if !accepts(triangle) {
                return None;
            }
            let shape = self.mesh.triangle(triangle);
            let (projection, location) = shape.project_local_point_and_get_location(target, false);
            Some(((projection.point - target).length(), (projection.point, location)))
        };
        let distance = |node: &parry3d_f64::partitioning::BvhNode, _| {
            let outside = (node.mins() - target).max(target - node.maxs()).max(Vector::ZERO);
            outside.length()
        };
        let (triangle, (distance, (closest, location))) =
            self.mesh.bvh().find_best(limit, distance, project)?;
        let normal = self.pseudonormal(triangle, location);
        Some(ClosestPoint { point: from_parry(closest).into(), distance, normal, triangle })
    }

    /// Returns whether a closed surface encloses a point: a line from it crosses the surface an odd number of times. In
    /// contrast to [`ClosestPoint::is_inside`], small folds of the surface have no effect on points that are farther
    /// away.
    pub(crate) fn encloses(&self, point: &Point3<f64>) -> bool {
        let ray = Ray::new(to_parry(point), to_parry(&Point3::from(CROSSING)));
        let leaves = self.mesh.bvh().leaves(|node| node.cast_ray(&ray, f64::MAX) != f64::MAX);
        let crosses =
            |triangle: &u32| self.mesh.triangle(*triangle).cast_local_ray(&ray, f64::MAX, false).is_some();
        leaves.filter(crosses).count() % 2 == 1
    }

    /// Returns the vertices of a triangle, and the barycentric weights of a point in it.
    pub(crate) fn barycentric(&self, triangle: u32, point: &Point3<f64>) -> ([u32; 3], [f64; 3]) {
        let corners = self.triangle(triangle);
        let [a, b, c] = corners.map(|v| from_parry(self.mesh.vertices()[v as usize]));
        let normal = (b - a).cross(&(c - a));
        let part = |u: Vector3<f64>, v: Vector3<f64>| u.cross(&v).dot(&normal) / normal.norm_squared();
        let p = point.coords;
        let (second, third) = (part(c - p, a - p), part(a - p, b - p));
        (corners, [1.0 - second - third, second, third])
    }

    /// Returns a lower bound of the distance of a point from the surface: its distance from the bounding box.
    pub(crate) fn bounds_distance(&self, point: &Point3<f64>) -> f64 {
        let (target, bounds) = (to_parry(point), self.mesh.bvh().root_aabb());
        (bounds.mins - target).max(target - bounds.maxs).max(Vector::ZERO).length()
    }

    /// Returns an upper bound of the distance of a point from all points of the surface.
    pub(crate) fn greatest_distance(&self, point: &Point3<f64>) -> f64 {
        let (target, bounds) = (to_parry(point), self.mesh.bvh().root_aabb());
        // More than the distance of the farthest corner of the bounding box, whatever is rounded.
        (target - bounds.mins).abs().max((target - bounds.maxs).abs()).length() * (1.0 + 1e-9)
    }

    /// Returns where the segment from `start` to `start` + `displacement` first meets the surface, from either side:
    /// the fraction of `displacement` in [0, 1], and the triangle.
    pub(crate) fn cast(&self, start: &Point3<f64>, displacement: &Vector3<f64>) -> Option<(f64, u32)> {
        let ray = Ray::new(to_parry(start), to_parry(&Point3::from(*displacement)));
        // Accepts the end of the segment.
        let end = 1.0 + f64::EPSILON;
        let hit = |triangle: u32, _| self.mesh.triangle(triangle).cast_local_ray(&ray, end, false);
        let (triangle, fraction) = self.mesh.bvh().cast_ray(&ray, end, hit)?;
        Some((fraction.min(1.0), triangle))
    }

    /// Returns where the line through `point` crosses triangles: t of `point` + t `direction`, and the triangle, in the
    /// order of the tree.
    pub(crate) fn crossings(&self, point: &Point3<f64>, direction: &Vector3<f64>) -> Vec<(f64, u32)> {
        let bounds = self.mesh.bvh().root_aabb();
        let center = bounds.center();
        // The ray begins before the bounding box.
        let back = (to_parry(point) - center).length() + (bounds.maxs - bounds.mins).length();
        let start = point - direction * back;
        let ray = Ray::new(to_parry(&start), to_parry(&Point3::from(*direction)));
        let leaves = self.mesh.bvh().leaves(|node| node.cast_ray(&ray, f64::MAX) != f64::MAX);
        let cross = |triangle: u32| {
            let t = self.mesh.triangle(triangle).cast_local_ray(&ray, f64::MAX, false)?;
            Some((t - back, triangle))
        };
        leaves.filter_map(cross).collect()
    }

    /// Returns the memory in bytes.
    pub(crate) fn bytes(&self) -> usize {
        let sums = size_of_val(&*self.vertex_sums) + size_of_val(&*self.edge_sums);
        self.mesh.total_memory_size() + size_of_val(&*self.normals) + sums
    }

    /// Returns the unit pseudonormal at a location of a triangle.
    fn pseudonormal(&self, triangle: u32, location: TrianglePointLocation) -> Vector3<f64> {
        let face = self.triangle_normal(triangle);
        let at_vertex = |corner: usize| {
            let vertex = self.mesh.indices()[triangle as usize][corner];
            self.vertex_sums[vertex as usize]
        };
        let on_edge = |edge: usize| self.edge_sums[triangle as usize][edge];
        let sum = match location {
            TrianglePointLocation::OnVertex(corner) => at_vertex(corner as usize),
            TrianglePointLocation::OnEdge(edge, _) => on_edge(edge as usize),
            // The projection of a point on an edge can be in the face, by rounding.
            TrianglePointLocation::OnFace(_, weights) => {
                let mut without = (0..3).filter(|&corner| weights[corner] < ON_EDGE);
                match (without.next(), without.next()) {
                    (None, _) => return face,
                    (Some(corner), None) => on_edge((corner + 1) % 3),
                    (Some(first), Some(second)) => at_vertex(3 - first - second),
                }
            }
            TrianglePointLocation::OnSolid => return face,
        };
        // The sum vanishes where two faces with opposite normals meet.
        sum.try_normalize(1e-6).unwrap_or(face)
    }
}

impl std::fmt::Debug for SurfaceTree {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SurfaceTree").field("triangles", &self.len()).finish_non_exhaustive()
    }
}

fn to_parry(point: &Point3<f64>) -> Vector {
    Vector::new(point.x, point.y, point.z)
}

fn from_parry(vector: Vector) -> Vector3<f64> {
    Vector3::new(vector.x, vector.y, vector.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::testing::cuboid;

    /// The unit cube, from 0 to 1 along each axis.
    fn cube() -> SurfaceTree {
        let mesh = cuboid([0.0; 3], [1.0; 3]);
        SurfaceTree::new(mesh.vertices(), mesh.triangles().iter().copied()).unwrap()
    }

    #[test]
    fn closest_points_of_a_cube_are_exact_on_faces_edges_and_corners() {
        let cube = cube();
        let root = |n: f64| n.sqrt().recip();
        for (point, closest, normal) in [
            ([0.3, 0.4, 1.5], [0.3, 0.4, 1.0], [0.0, 0.0, 1.0]),
            ([0.3, 0.4, 0.9], [0.3, 0.4, 1.0], [0.0, 0.0, 1.0]),
            ([0.3, 1.5, 1.4], [0.3, 1.0, 1.0], [0.0, root(2.0), root(2.0)]),
            ([-1.0, -2.0, -3.0], [0.0; 3], [-root(3.0); 3]),
        ] {
            let (point, found) =
                (Point3::from(point), cube.closest(&point.into(), f64::MAX, |_| true).unwrap());
            let closest = Point3::from(closest);
            assert!((found.point - closest).norm() < 1e-15, "{point}: {found:?}");
            assert!((found.normal - Vector3::from(normal)).norm() < 1e-12, "{point}: {found:?}");
            assert!((found.distance - (point - closest).norm()).abs() < 1e-15);
        }
    }

    #[test]
    fn fold_at_an_edge_has_no_effect_on_which_points_are_enclosed() {
        // A flap beside the cube, of two triangles on top of each other that face each other.
        let cube = cuboid([0.0; 3], [1.0; 3]);
        let vertices = [cube.vertices(), &[Point3::new(1.3, 0.5, 0.5)]].concat();
        let triangles = cube.triangles().iter().copied().chain([[1, 7, 8], [7, 1, 8]]);
        let tree = SurfaceTree::new(&vertices, triangles).unwrap();
        for (point, is_inside) in [
            ([0.9, 0.5, 0.5], true),
            ([0.2, 0.1, 0.7], true),
            ([1.4, 0.45, 0.52], false),
            ([1.1, -0.8, 0.3], false),
            ([-0.1, 0.4, 0.4], false),
        ] {
            assert_eq!(tree.encloses(&point.into()), is_inside, "{point:?}");
        }
    }

    #[test]
    fn points_on_edges_have_the_normals_of_the_edges() {
        let cube = cube();
        for axis in 0..3 {
            for (side, part) in (0..4).flat_map(|side| [0.1, 1.0 / 3.0, 0.5, 0.9].map(|part| (side, part))) {
                let mut point = Point3::origin();
                let mut normal = Vector3::zeros();
                for (other, bit) in [((axis + 1) % 3, 1), ((axis + 2) % 3, 2)] {
                    point[other] = f64::from(u8::from(side & bit != 0));
                    normal[other] = 2.0 * point[other] - 1.0;
                }
                point[axis] = part;
                let found = cube.closest(&point, f64::MAX, |_| true).unwrap();
                assert!((found.normal - normal.normalize()).norm() < 1e-9, "{point}: {found:?}");
            }
        }
    }

    #[test]
    fn side_is_right_everywhere_around_a_cube() {
        let cube = cube();
        let range = || (-5..=15).map(|k| f64::from(k) * 0.1 + 0.003);
        for (x, y, z) in range().flat_map(|x| range().flat_map(move |y| range().map(move |z| (x, y, z)))) {
            let is_inside = [x, y, z].iter().all(|c| (0.0..1.0).contains(c));
            let point = Point3::new(x, y, z);
            let closest = cube.closest(&point, f64::MAX, |_| true).unwrap();
            assert_eq!(closest.is_inside(&point), is_inside, "{point}");
        }
    }

    #[test]
    fn limit_and_filter_leave_triangles_out() {
        let cube = cube();
        let above = Point3::new(0.3, 0.4, 1.5);
        assert!(cube.closest(&above, 0.5, |_| true).is_none());
        assert!(cube.closest(&above, 0.5 + 1e-9, |_| true).is_some());
        let down = |triangle| cube.triangle_normal(triangle).z < -0.5;
        assert_eq!(cube.closest(&above, 9.0, down).unwrap().point.z, 0.0);
    }

    #[test]
    fn triangles_without_area_are_left_out() {
        let vertices = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]].map(Point3::from);
        assert!(SurfaceTree::new(&vertices, [[0, 1, 2], [1, 1, 3]].into_iter()).is_none());
        assert_eq!(SurfaceTree::new(&vertices, [[0, 1, 2], [0, 1, 3]].into_iter()).unwrap().len(), 1);
    }
}
