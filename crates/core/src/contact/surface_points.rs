//! Returns the points of a surface that are samples for contact: its vertices, and points on large faces.

use std::collections::{BTreeMap, HashSet};

use nalgebra::{Point3, Vector3};

/// Maximum number of samples per lattice vertex, beside the mesh vertices. Only surfaces that overlap themselves
/// many times have more: a plane through a cell has about two.
pub(super) const MAX_SAMPLES: usize = 64;

/// Returns points of a surface that are dense enough to detect contacts of large faces.
///
/// The points are, in this order: the vertices that triangles use, points on the edges longer than
/// `spacing`, and points within the triangles with such an edge. They are at most `spacing` apart along each
/// edge, and within a triangle along and across its longest edge. If these are more than `max_points` points
/// beside the vertices, the spacing is doubled until they are not. Of triangles with the same corners only the
/// first one is filled.
///
/// Vertices at the same position have to be one vertex; `spacing` is a length > 0.
pub(super) fn surface_points(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    mut spacing: f64,
    max_points: usize,
) -> Vec<Point3<f64>> {
    let mut used = vec![false; vertices.len()];
    triangles.iter().flatten().for_each(|&v| used[v as usize] = true);
    let mut points: Vec<_> = vertices.iter().zip(&used).filter(|(_, used)| **used).map(|(p, _)| *p).collect();
    let vertex_count = points.len();
    // A triangle with short edges has no points beside its vertices, for any larger spacing as well.
    let edge = |p: u32, q: u32| (vertices[p as usize] - vertices[q as usize]).norm();
    let is_large =
        |&[a, b, c]: &[u32; 3]| [(a, b), (b, c), (c, a)].iter().any(|&(p, q)| edge(p, q) > spacing);
    let triangles = without_repeated(triangles.iter().copied().filter(is_large));
    while !add_points(vertices, &triangles, spacing, vertex_count + max_points, &mut points) {
        points.truncate(vertex_count);
        spacing *= 2.0;
    }
    points
}

/// Returns the triangles without those with the same corners as an earlier one.
fn without_repeated(triangles: impl Iterator<Item = [u32; 3]>) -> Vec<[u32; 3]> {
    let mut corners = HashSet::new();
    let is_first = |triangle: &[u32; 3]| {
        let mut sorted = *triangle;
        sorted.sort_unstable();
        corners.insert(sorted)
    };
    triangles.filter(is_first).collect()
}

/// Adds the points on long edges and within large triangles. Returns false once there are more than `limit`.
fn add_points(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    spacing: f64,
    limit: usize,
    points: &mut Vec<Point3<f64>>,
) -> bool {
    let position = |v: u32| vertices[v as usize];
    let mut long_edges = BTreeMap::new();
    for &[a, b, c] in triangles {
        for (p, q) in [(a, b), (b, c), (c, a)] {
            let steps = step_count((position(p) - position(q)).norm(), spacing);
            if steps > 1 {
                long_edges.insert((p.min(q), p.max(q)), steps);
            }
        }
    }
    for ((p, q), steps) in long_edges {
        if points.len() + steps - 1 > limit {
            return false;
        }
        points.extend((1..steps).map(|k| between(&position(p), &position(q), k, steps)));
    }
    triangles.iter().all(|triangle| fill_triangle(triangle.map(position), spacing, limit, points))
}

/// Adds points strictly inside a triangle, on lines parallel to its longest edge.
///
/// The points are at most `spacing` apart along the lines and across them. The number of points in a sliver
/// is proportional to its length, not to the square of its length. Returns false once there are more than
/// `limit` points.
fn fill_triangle(
    corners: [Point3<f64>; 3],
    spacing: f64,
    limit: usize,
    points: &mut Vec<Point3<f64>>,
) -> bool {
    let length = |k: usize| (corners[(k + 1) % 3] - corners[k]).norm();
    let longest = (1..3).fold(0, |best, k| if length(k) > length(best) { k } else { best });
    let [a, b, top] = [corners[longest], corners[(longest + 1) % 3], corners[(longest + 2) % 3]];
    let base: Vector3<f64> = b - a;
    if base.norm() <= spacing {
        return true;
    }
    let height = base.cross(&(top - a)).norm() / base.norm();
    let lines = step_count(height, spacing);
    for line in 1..lines {
        let (left, right) = (between(&a, &top, line, lines), between(&b, &top, line, lines));
        let steps = step_count((right - left).norm(), spacing);
        if points.len() + steps - 1 > limit {
            return false;
        }
        points.extend((1..steps).map(|k| between(&left, &right, k, steps)));
    }
    true
}

/// Returns the smallest number of equal steps of at most `spacing` that cover `length`; at least 1.
fn step_count(length: f64, spacing: f64) -> usize {
    (length / spacing).ceil().max(1.0) as usize
}

/// Returns the point at the fraction `step / steps` of the segment from `a` to `b`.
fn between(a: &Point3<f64>, b: &Point3<f64>, step: usize, steps: usize) -> Point3<f64> {
    a + (b - a) * (step as f64 / steps as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_triangles_are_sampled_at_their_vertices_only() {
        let vertices = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [9.0; 3]].map(Point3::from);
        // Vertex 3 belongs to no face.
        let points = surface_points(&vertices, &[[0, 1, 2], [0, 2, 1]], 1.5, 1000);
        assert_eq!(points, vertices[..3]);
    }

    #[test]
    fn every_point_of_a_large_face_has_a_sample_within_the_spacing() {
        let spacing = 0.3;
        for corners in [
            [[0.0, 0.0, 0.0], [5.0, 0.0, 0.0], [1.0, 4.0, 0.5]],
            [[0.0, 0.0, 0.0], [9.0, 0.1, 0.0], [4.0, 0.2, 0.0]],
            [[0.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 1.0, 0.0]],
        ] {
            let corners = corners.map(Point3::from);
            let points = surface_points(&corners, &[[0, 1, 2]], spacing, 10_000);
            for i in 0..=60 {
                for j in 0..=60 - i {
                    let (u, v) = (f64::from(i) / 60.0, f64::from(j) / 60.0);
                    let p = corners[0] + (corners[1] - corners[0]) * u + (corners[2] - corners[0]) * v;
                    let distance = points.iter().map(|q| (p - q).norm()).fold(f64::INFINITY, f64::min);
                    assert!(distance <= spacing, "{p} is {distance} from the nearest sample");
                }
            }
            let mut sorted: Vec<[f64; 3]> = points.iter().map(|&p| p.into()).collect();
            sorted.sort_by(|a, b| a.partial_cmp(b).unwrap());
            sorted.dedup();
            assert_eq!(sorted.len(), points.len(), "duplicate samples");
        }
    }

    #[test]
    fn sample_count_of_a_sliver_is_linear_in_its_length() {
        let corners = [[0.0, 0.0, 0.0], [1000.0, 0.0, 0.0], [500.0, 1e-3, 0.0]].map(Point3::from);
        assert!(surface_points(&corners, &[[0, 1, 2]], 1.0, 10_000).len() < 2100);
    }

    #[test]
    fn equal_triangles_are_sampled_once_and_the_number_of_samples_is_limited() {
        let corners = [[0.0; 3], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0]].map(Point3::from);
        let sample = |faces: &[[u32; 3]], limit| surface_points(&corners, faces, 0.5, limit);
        let one = sample(&[[0, 1, 2]], 10_000);
        assert_eq!(sample(&[[0, 1, 2], [1, 2, 0], [2, 1, 0]], 10_000), one);
        let few = sample(&[[0, 1, 2]], 100);
        assert!(few.len() <= 103 && one.len() > 103, "{} {}", few.len(), one.len());
    }
}
