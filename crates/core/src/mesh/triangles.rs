//! The triangles of the faces.
//!
//! In the fan of a concave face, triangles can be turned over and lie outside of the face. Such a face is cut into
//! ears.

use nalgebra::{Point3, Vector3};

use super::Csr;
use super::polygon::{Planar, triangulate};

/// Area of a triangle that is turned over, relative to the area of its face, up to which the fan is kept. It is above
/// the rounding error of corners on a straight line, and too small to be seen.
const TURNED: f64 = 1e-9;

/// Triangulates polygons: a polygon with `n >= 3` corners gives `n - 2` triangles, in the order of the polygons. It
/// gives a fan from its first corner, or ears if a triangle of the fan is turned over and no ear is.
pub(super) fn of_polygons(vertices: &[Point3<f64>], polygons: &Csr<u32>) -> Vec<[u32; 3]> {
    let count = polygons.items().len().saturating_sub(2 * polygons.len());
    let mut triangles = Vec::with_capacity(count);
    for corners in polygons.rows().filter(|corners| corners.len() > 2) {
        match ears(vertices, corners) {
            Some(ears) => triangles.extend(ears),
            None => triangles.extend(fan(corners)),
        }
    }
    triangles
}

/// Returns whether `triangles`, the triangulation of `polygons`, are fans from their first corners.
pub(super) fn are_fans(triangles: &[[u32; 3]], polygons: &Csr<u32>) -> bool {
    let faces = polygons.rows().filter(|corners| corners.len() > 2);
    faces.flat_map(fan).eq(triangles.iter().copied())
}

/// Returns the ears of a polygon; `None` if no triangle of its fan is turned over, or one of the ears is.
fn ears(vertices: &[Point3<f64>], corners: &[u32]) -> Option<Vec<[u32; 3]>> {
    if corners.len() < 4 {
        return None;
    }
    let at = |corner: u32| vertices[corner as usize];
    let doubled_area = |triangle: [u32; 3]| {
        let [a, b, c] = triangle.map(at);
        (b - a).cross(&(c - a))
    };
    let normal: Vector3<f64> = fan(corners).map(doubled_area).sum();
    let limit = -TURNED * normal.norm_squared();
    let is_turned = |triangle: [u32; 3]| doubled_area(triangle).dot(&normal) < limit;
    if !fan(corners).any(is_turned) {
        return None;
    }
    let normal = normal.try_normalize(0.0)?;
    let u = normal.cross(&Vector3::ith(normal.iamin(), 1.0)).normalize();
    let v = normal.cross(&u);
    let start = at(corners[0]);
    let planar = |&corner: &u32| -> Planar {
        let offset = at(corner) - start;
        [u.dot(&offset), v.dot(&offset)]
    };
    let ears = triangulate(&corners.iter().map(planar).collect::<Vec<_>>());
    let ears: Vec<_> = ears.into_iter().map(|ear| ear.map(|corner| corners[corner])).collect();
    (!ears.iter().copied().any(is_turned)).then_some(ears)
}

/// Returns the fan of triangles of a polygon, from its first corner.
fn fan(corners: &[u32]) -> impl Iterator<Item = [u32; 3]> {
    corners[1..].windows(2).map(|edge| [corners[0], edge[0], edge[1]])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangles(corners: &[[f64; 3]]) -> Vec<[u32; 3]> {
        let vertices: Vec<_> = corners.iter().copied().map(Point3::from).collect();
        let mut polygons = Csr::with_capacity(1, corners.len());
        polygons.push(0..corners.len() as u32);
        of_polygons(&vertices, &polygons)
    }

    #[test]
    fn convex_faces_give_fans_also_with_corners_on_straight_sides() {
        assert_eq!(
            triangles(&[[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.2], [0.0, 1.0, 0.0]]),
            [[0, 1, 2], [0, 2, 3]]
        );
        // The third corner is beyond the side by rounding.
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, -1e-16, 0.0], [2.0, 1.0, 0.0]];
        assert_eq!(triangles(&corners), [[0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn triangles_of_a_concave_face_are_inside_it_from_any_first_corner() {
        // A U in a plane that is not parallel to the axes.
        let outline =
            [[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [2.0, 3.0], [2.0, 1.0], [1.0, 1.0], [1.0, 3.0], [0.0, 3.0]];
        for first in 0..8 {
            let corners: Vec<[f64; 3]> =
                (0..8).map(|k| outline[(first + k) % 8]).map(|[x, y]| [x, 0.6 * y, 0.8 * y]).collect();
            let area = triangles(&corners).into_iter().map(|triangle| {
                let [a, b, c] = triangle.map(|corner| Point3::from(corners[corner as usize]));
                (b - a).cross(&(c - a)).norm() / 2.0
            });
            assert!((area.sum::<f64>() - 7.0).abs() < 1e-12, "from corner {first}");
        }
    }

    #[test]
    fn faces_without_area_or_that_cross_themselves_give_fans() {
        assert_eq!(triangles(&[[0.0; 3]; 4]), [[0, 1, 2], [0, 2, 3]]);
        // A bow tie.
        let corners = [[0.0; 3], [1.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        assert_eq!(triangles(&corners), [[0, 1, 2], [0, 2, 3]]);
    }
}
