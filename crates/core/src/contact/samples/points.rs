//! Points of a surface that are dense enough for contacts.

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};

/// Points of a surface, dense enough that a coarse face is felt: its welded vertices, and on edges and in
/// triangles longer than `spacing` further ones, no more than `spacing` apart along and across.
///
/// `weld` maps each vertex to the one that stands for its place; vertices of no triangle are left out. The
/// order is fixed: vertices, points on edges, points within triangles. `spacing` is a length > 0.
pub fn surface_points(
    vertices: &[Point3<f64>],
    triangles: &[[u32; 3]],
    weld: &[u32],
    spacing: f64,
) -> Vec<Point3<f64>> {
    let welded = || triangles.iter().map(|t| t.map(|v| weld[v as usize]));
    let mut used = vec![false; vertices.len()];
    welded().flatten().for_each(|v| used[v as usize] = true);
    let mut points: Vec<_> = vertices.iter().zip(&used).filter(|(_, used)| **used).map(|(p, _)| *p).collect();

    let place = |v: u32| vertices[v as usize];
    let mut long_edges = BTreeMap::new();
    for [a, b, c] in welded() {
        for (p, q) in [(a, b), (b, c), (c, a)] {
            let steps = steps_of((place(p) - place(q)).norm(), spacing);
            if steps > 1 {
                long_edges.insert((p.min(q), p.max(q)), steps);
            }
        }
    }
    for ((p, q), steps) in long_edges {
        points.extend((1..steps).map(|k| between(&place(p), &place(q), k, steps)));
    }
    for [a, b, c] in welded() {
        fill_triangle([place(a), place(b), place(c)], spacing, &mut points);
    }
    points
}

/// Points strictly within a triangle: on lines parallel to its longest edge, `spacing` or less apart, and so
/// far apart on each line. A sliver gets one short row of points and not a square of them.
fn fill_triangle(corners: [Point3<f64>; 3], spacing: f64, points: &mut Vec<Point3<f64>>) {
    let length = |k: usize| (corners[(k + 1) % 3] - corners[k]).norm();
    let longest = (1..3).fold(0, |best, k| if length(k) > length(best) { k } else { best });
    let [a, b, top] = [corners[longest], corners[(longest + 1) % 3], corners[(longest + 2) % 3]];
    let base: Vector3<f64> = b - a;
    if base.norm() <= spacing {
        return;
    }
    let height = base.cross(&(top - a)).norm() / base.norm();
    let rows = steps_of(height, spacing);
    for row in 1..rows {
        let (left, right) = (between(&a, &top, row, rows), between(&b, &top, row, rows));
        let steps = steps_of((right - left).norm(), spacing);
        points.extend((1..steps).map(|k| between(&left, &right, k, steps)));
    }
}

/// The least number of equal steps of at most `spacing` that cover `length`; at least 1.
fn steps_of(length: f64, spacing: f64) -> usize {
    (length / spacing).ceil().max(1.0) as usize
}

fn between(a: &Point3<f64>, b: &Point3<f64>, step: usize, steps: usize) -> Point3<f64> {
    a + (b - a) * (step as f64 / steps as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_triangles_give_their_welded_vertices_alone() {
        let vertices = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0; 3], [9.0; 3]].map(Point3::from);
        // Vertex 3 repeats vertex 0 at a seam, vertex 4 belongs to no face.
        let points = surface_points(&vertices, &[[0, 1, 2], [3, 2, 1]], &[0, 1, 2, 0, 4], 1.5);
        assert_eq!(points, vertices[..3]);
    }

    #[test]
    fn no_place_of_a_coarse_face_is_farther_than_the_spacing() {
        let spacing = 0.3;
        for corners in [
            [[0.0, 0.0, 0.0], [5.0, 0.0, 0.0], [1.0, 4.0, 0.5]],
            [[0.0, 0.0, 0.0], [9.0, 0.1, 0.0], [4.0, 0.2, 0.0]],
            [[0.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 1.0, 0.0]],
        ] {
            let corners = corners.map(Point3::from);
            let points = surface_points(&corners, &[[0, 1, 2]], &[0, 1, 2], spacing);
            for i in 0..=60 {
                for j in 0..=60 - i {
                    let (u, v) = (f64::from(i) / 60.0, f64::from(j) / 60.0);
                    let p = corners[0] + (corners[1] - corners[0]) * u + (corners[2] - corners[0]) * v;
                    let near = points.iter().map(|q| (p - q).norm()).fold(f64::INFINITY, f64::min);
                    assert!(near <= spacing, "{p} is {near} from every sample");
                }
            }
            let mut sorted: Vec<[f64; 3]> = points.iter().map(|&p| p.into()).collect();
            sorted.sort_by(|a, b| a.partial_cmp(b).unwrap());
            sorted.dedup();
            assert_eq!(sorted.len(), points.len(), "each place once");
        }
    }

    #[test]
    fn a_sliver_costs_a_row_and_not_a_square() {
        let corners = [[0.0, 0.0, 0.0], [1000.0, 0.0, 0.0], [500.0, 1e-3, 0.0]].map(Point3::from);
        assert!(surface_points(&corners, &[[0, 1, 2]], &[0, 1, 2], 1.0).len() < 2100);
    }
}
