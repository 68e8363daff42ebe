//! Splits the long edges beside a crack, so that the cut follows the plane of the crack within large triangles too.

use nalgebra::{Point3, Vector3};

use super::faces::BrokenFaces;
use super::map::Map;
use super::planes::Planes;
use crate::mesh::Mesh;

/// Longest edge beside a crack, in cells. In the space of the cut, the ends of an edge that a crack crosses are moved apart, and
/// its crossings along the plane are off by a fraction of its length.
const LONGEST: f64 = 0.6;

/// Distance from a plane in cells within which edges are split.
const BAND: f64 = 0.9;

/// Margin in cells of the box of an edge. Far greater than rounding errors, so that an edge is near a crack if a part of it is,
/// also along a plane of the grid.
const MARGIN: f64 = 1e-6;

/// Greatest number of times that a triangle is split in turn. More than edges of any length need: it ends the splitting of
/// triangles without an area, whose edges lie on each other, where rounding errors decide which of them are long.
const DEEPEST: u8 = 100;

/// Marks a triangle of the uncut mesh.
const INPUT: u32 = u32::MAX;

/// A triangle of the uncut mesh, or a part of one.
#[derive(Clone, Copy)]
pub(super) struct Triangle {
    /// Welded points.
    pub(super) corners: [u32; 3],
    /// Index of the triangle of the uncut mesh.
    pub(super) source: u32,
    /// Index in [`Refined::weights`].
    weights: u32,
}

/// Triangles whose edges beside cracks are short.
pub(super) struct Refined {
    /// All triangles, in the order of the triangles of the uncut mesh.
    pub(super) triangles: Vec<Triangle>,
    /// For the parts of triangles: the weights of the corners of the triangle of the uncut mesh, at each corner of the
    /// part.
    weights: Vec<[[f64; 3]; 3]>,
}

impl Refined {
    /// Returns the weights of the corners of the triangle of the uncut mesh, at each corner of a triangle.
    pub(super) fn weights(&self, triangle: &Triangle) -> [[f64; 3]; 3] {
        match triangle.weights {
            INPUT => [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            index => self.weights[index as usize],
        }
    }

    /// Returns whether a triangle is a part of a triangle of the uncut mesh.
    pub(super) fn is_part(&self, triangle: &Triangle) -> bool {
        triangle.weights != INPUT
    }

    /// Takes the triangles of a mesh as they are.
    pub(super) fn unchanged(mesh: &Mesh) -> Self {
        let weld = |triangle: &[u32; 3]| triangle.map(|corner| mesh.weld()[corner as usize]);
        let triangle = |(corners, source)| Triangle { corners: weld(corners), source, weights: INPUT };
        Self { triangles: mesh.triangles().iter().zip(0..).map(triangle).collect(), weights: Vec::new() }
    }

    /// Splits triangles until their edges beside cracks are short.
    ///
    /// * `points`: positions of the points; the midpoints of edges are appended.
    /// * `to_cells`: converts a position to cells from the origin of the lattice.
    pub(super) fn new(
        mesh: &Mesh,
        planes: &Planes,
        faces: &BrokenFaces,
        points: &mut Vec<Point3<f64>>,
        to_cells: impl Fn(&Point3<f64>) -> Vector3<f64>,
    ) -> Self {
        let mut refined = Self { triangles: Vec::with_capacity(mesh.triangles().len()), weights: Vec::new() };
        let mut midpoints: Map<(u32, u32), u32> = Map::default();
        let mut work = Vec::new();
        for triangle in Self::unchanged(mesh).triangles {
            work.push((triangle, 0));
            while let Some((triangle, depth)) = work.pop() {
                let weights = refined.weights(&triangle);
                let corners = triangle.corners;
                let cells = corners.map(|corner| to_cells(&points[corner as usize]));
                let is_long = |e: usize| is_long(planes, faces, &cells[e], &cells[(e + 1) % 3]);
                let long = [0, 1, 2].map(is_long);
                let has_equal_corners = corners.iter().enumerate().any(|(i, c)| corners[..i].contains(c));
                if long == [false; 3] || has_equal_corners || depth == DEEPEST {
                    refined.triangles.push(triangle);
                    continue;
                }
                // The points of the split triangle: the corners, and the midpoints of the edges.
                let mut ids = [corners[0], corners[1], corners[2], 0, 0, 0];
                let mut at = [weights[0], weights[1], weights[2], [0.0; 3], [0.0; 3], [0.0; 3]];
                for e in (0..3).filter(|&e| long[e]) {
                    let (a, b) = (corners[e], corners[(e + 1) % 3]);
                    ids[3 + e] = *midpoints.entry((a.min(b), a.max(b))).or_insert_with(|| {
                        points.push(nalgebra::center(&points[a.min(b) as usize], &points[a.max(b) as usize]));
                        points.len() as u32 - 1
                    });
                    at[3 + e] = std::array::from_fn(|c| 0.5 * (weights[e][c] + weights[(e + 1) % 3][c]));
                }
                let length =
                    |a: usize, b: usize| (points[ids[a] as usize] - points[ids[b] as usize]).norm_squared();
                for part in parts(long, length) {
                    refined.weights.push(part.map(|corner| at[corner]));
                    let weights = refined.weights.len() as u32 - 1;
                    let corners = part.map(|corner| ids[corner]);
                    work.push((Triangle { corners, source: triangle.source, weights }, depth + 1));
                }
            }
        }
        refined
    }
}

/// Returns whether an edge, given in cells, is long and beside a crack. The result does not depend on the direction of
/// the edge.
fn is_long(planes: &Planes, faces: &BrokenFaces, a: &Vector3<f64>, b: &Vector3<f64>) -> bool {
    if (a - b).norm_squared() <= LONGEST * LONGEST {
        return false;
    }
    let cell = |point: Vector3<f64>, margin: f64| point.map(|x| (x + margin).floor() as i32).into();
    if !faces.is_near_box(cell(a.inf(b), -MARGIN), cell(a.sup(b), MARGIN)) {
        return false;
    }
    planes.cracks().any(|crack| {
        let (a, b) = (planes.distance(crack, a), planes.distance(crack, b));
        a.min(b) < BAND && a.max(b) > -BAND
    })
}

/// Returns the parts of a triangle whose edges are split where `long` is set. Corner `3 + e` is the midpoint of edge
/// `e`, from corner `e` to the next one.
///
/// * `length`: measures a diagonal; the shorter one is used.
fn parts(long: [bool; 3], length: impl Fn(usize, usize) -> f64) -> Vec<[usize; 3]> {
    let count = long.iter().filter(|&&long| long).count();
    if count == 3 {
        return vec![[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]];
    }
    // The edge that differs from the other two.
    let e = (0..3).find(|&e| long[e] == (count == 1)).unwrap_or(0);
    let (a, b, c) = (e, (e + 1) % 3, (e + 2) % 3);
    if count == 1 {
        return vec![[a, 3 + a, c], [3 + a, b, c]];
    }
    // Edge a is whole; the midpoints lie on the edges b-c and c-a.
    let (m, n) = (3 + b, 3 + c);
    if length(a, m) <= length(b, n) {
        vec![[m, c, n], [a, b, m], [a, m, n]]
    } else {
        vec![[m, c, n], [a, b, n], [b, m, n]]
    }
}
