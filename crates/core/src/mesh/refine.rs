//! Divides faces that are large, so that a surface bends between the vertices of its mesh.
//!
//! An edge that is longer than the limit is halved, in all faces that have it, until no edge is too long. A triangle
//! with one, two or three halved edges gives two, three or four triangles (Bank, Sherman & Weiser 1983, "Some
//! refinement algorithms and data structures for regular local mesh refinement": red and green triangles). The
//! surface stays the same.

use std::collections::HashMap;
use std::sync::Arc;

use nalgebra::{Point3, distance_squared};

use super::csr::Csr;
use super::error::MeshError;
use super::polygons::{Faces, Mesh};
use super::triangles;

/// Largest number of faces of a refined mesh.
const MAX_FACES: usize = 4_000_000;

/// Whether faces that are larger than cells are divided before a body is built.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Refine {
    /// The mesh stays as it is. The default.
    #[default]
    Off,
    /// Edges longer than [`Refine::EDGE`] cells are halved until none is.
    Auto,
}

impl Refine {
    /// Greatest length of an edge of a refined mesh, in cells.
    pub const EDGE: f64 = 1.5;

    /// All values, with their names in scenes and in Python.
    pub const NAMED: [(&'static str, Self); 2] = [("off", Self::Off), ("auto", Self::Auto)];

    /// Returns the name of the value in [`Refine::NAMED`].
    pub fn name(self) -> &'static str {
        Self::NAMED[self as usize].0
    }

    /// Returns the refined mesh of a body with cells of this size; `None` if the mesh stays as it is.
    ///
    /// # Errors
    /// As [`Mesh::refined`].
    pub fn apply(self, mesh: &Mesh, cell_size: f64) -> Result<Option<RefinedMesh>, MeshError> {
        match self {
            Self::Off => Ok(None),
            Self::Auto => mesh.refined(Self::EDGE * cell_size),
        }
    }
}

/// A mesh with smaller faces, and where its vertices lie on the original mesh.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct RefinedMesh {
    /// The mesh. The vertices of the original mesh come first and keep their indices; the faces that stay whole come
    /// first, in their order, then the triangles of the others.
    pub mesh: Mesh,
    /// For each new vertex, the corners of a triangle of the original mesh and their weights, which are at least 0 and
    /// have the sum 1. A vertex on an edge has the weight 0 at one corner.
    pub points: Vec<([u32; 3], [f64; 3])>,
    /// For each face, its index in the original mesh, and whether it is only a part of it.
    pub sources: Vec<(u32, bool)>,
}

impl Mesh {
    /// Returns the mesh with faces whose edges are at most `edge` long; `None` if they are so already.
    ///
    /// Edges are halved, and so are between `edge / 2` and `edge` where they were longer. Faces without a long edge or
    /// diagonal stay as they are, others become triangles.
    ///
    /// # Errors
    /// [`MeshError::TooFine`] if the mesh would have more than 4 million faces.
    pub fn refined(&self, edge: f64) -> Result<Option<RefinedMesh>, MeshError> {
        let mut refiner = Refiner::new(self, edge);
        let (mut whole, mut divided) = (Vec::new(), Vec::new());
        let mut of_mesh = self.triangles().iter();
        for (face, corners) in (0..).zip(self.faces()) {
            let triangles = of_mesh.by_ref().take(corners.len().saturating_sub(2)).copied();
            let triangles: Vec<_> = triangles.collect();
            let is_whole = triangles.iter().all(|triangle| !refiner.is_long(*triangle).contains(&true));
            if is_whole {
                whole.push(face);
            } else {
                divided.push((face, triangles));
            }
        }
        if divided.is_empty() {
            return Ok(None);
        }
        let (mut polygons, mut sources) = (Csr::with_capacity(whole.len(), 0), Vec::new());
        for &face in &whole {
            polygons.push(self.face(face as usize).iter().copied());
            sources.push((face, false));
        }
        for (face, triangles) in divided {
            for triangle in refiner.divide(triangles, sources.len())? {
                polygons.push(triangle);
                sources.push((face, true));
            }
        }
        let Refiner { vertices, weld, points, .. } = refiner;
        let triangles = triangles::of_polygons(&vertices, &polygons);
        let mesh = Mesh {
            vertices: vertices.into(),
            faces: Arc::new(Faces { polygons, triangles }),
            weld: weld.into(),
            topology: Arc::default(),
            open: Arc::default(),
            named: Arc::new(self.named.refined(&points)),
            ..self.clone()
        };
        Ok(Some(RefinedMesh { mesh, points, sources }))
    }
}

/// The vertices so far. Copies of a vertex at a seam have their own midpoints, which are welded like the copies.
struct Refiner {
    /// Greatest length of an edge, squared.
    limit: f64,
    vertices: Vec<Point3<f64>>,
    weld: Vec<u32>,
    points: Vec<([u32; 3], [f64; 3])>,
    /// Number of vertices of the original mesh.
    original: usize,
    /// Vertices in the middle of edges, by the lower and the higher vertex of the edge.
    middles: HashMap<[u32; 2], u32>,
    /// The first of the vertices in the middle of edges between welded vertices.
    welded: HashMap<[u32; 2], u32>,
}

impl Refiner {
    fn new(mesh: &Mesh, edge: f64) -> Self {
        Self {
            limit: edge * edge,
            vertices: mesh.vertices.to_vec(),
            weld: mesh.weld.to_vec(),
            points: Vec::new(),
            original: mesh.vertices.len(),
            middles: HashMap::new(),
            welded: HashMap::new(),
        }
    }

    /// Returns the position of the vertex that a vertex is welded with, so that the copies of an edge are equal.
    fn position(&self, vertex: u32) -> Point3<f64> {
        self.vertices[self.weld[vertex as usize] as usize]
    }

    /// Returns whether the edges from the corners of a triangle to the next ones are too long.
    fn is_long(&self, triangle: [u32; 3]) -> [bool; 3] {
        let [a, b, c] = triangle.map(|corner| self.position(corner));
        [(a, b), (b, c), (c, a)].map(|(p, q)| distance_squared(&p, &q) > self.limit)
    }

    /// Divides triangles of one face. `faces`: number of faces so far.
    fn divide(&mut self, mut triangles: Vec<[u32; 3]>, faces: usize) -> Result<Vec<[u32; 3]>, MeshError> {
        let mut done = Vec::new();
        while let Some(triangle) = triangles.pop() {
            if faces + done.len() + triangles.len() > MAX_FACES {
                return Err(MeshError::TooFine { edge: self.limit.sqrt(), faces: MAX_FACES });
            }
            let long = self.is_long(triangle);
            // Rotates the triangle so that its first edges are the long ones.
            let first = (0..3).find(|&k| long[k] && !long[(k + 2) % 3]).unwrap_or(0);
            let [a, b, c] = [0, 1, 2].map(|k| triangle[(first + k) % 3]);
            match long.iter().filter(|long| **long).count() {
                0 => done.push(triangle),
                1 => {
                    let ab = self.middle(a, b);
                    triangles.extend([[a, ab, c], [ab, b, c]]);
                }
                2 => {
                    let (ab, bc) = (self.middle(a, b), self.middle(b, c));
                    let [p, q] = [ab, bc].map(|middle| self.position(middle));
                    // The shorter diagonal divides the rest.
                    let to_c = distance_squared(&p, &self.position(c));
                    let to_a = distance_squared(&q, &self.position(a));
                    let rest =
                        if to_c <= to_a { [[a, ab, c], [ab, bc, c]] } else { [[a, ab, bc], [a, bc, c]] };
                    triangles.push([ab, b, bc]);
                    triangles.extend(rest);
                }
                _ => {
                    let (ab, bc, ca) = (self.middle(a, b), self.middle(b, c), self.middle(c, a));
                    triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
                }
            }
        }
        Ok(done)
    }

    /// Returns the vertex in the middle of an edge.
    fn middle(&mut self, a: u32, b: u32) -> u32 {
        let [a, b] = [a.min(b), a.max(b)];
        if let Some(&middle) = self.middles.get(&[a, b]) {
            return middle;
        }
        let middle = self.vertices.len() as u32;
        let (p, q) = (self.position(a), self.position(b));
        self.vertices.push(nalgebra::center(&p, &q));
        self.points.push(self.mean(a, b));
        let [i, j] = [a, b].map(|vertex| self.weld[vertex as usize]);
        self.weld.push(*self.welded.entry([i.min(j), i.max(j)]).or_insert(middle));
        self.middles.insert([a, b], middle);
        middle
    }

    /// Returns the corners and weights of the point between two vertices.
    fn mean(&self, a: u32, b: u32) -> ([u32; 3], [f64; 3]) {
        let mut sum: Vec<(u32, f64)> = Vec::with_capacity(6);
        for vertex in [a, b] {
            let (corners, weights) = match (vertex as usize).checked_sub(self.original) {
                None => ([vertex; 3], [1.0, 0.0, 0.0]),
                Some(new) => self.points[new],
            };
            for (corner, weight) in corners.into_iter().zip(weights).filter(|(_, weight)| *weight > 0.0) {
                match sum.iter_mut().find(|(known, _)| *known == corner) {
                    Some((_, known)) => *known += 0.5 * weight,
                    None => sum.push((corner, 0.5 * weight)),
                }
            }
        }
        debug_assert!(sum.len() <= 3, "an edge is in one triangle of the original mesh");
        let entry = |k: usize| sum.get(k).copied().unwrap_or((sum[0].0, 0.0));
        ([0, 1, 2].map(|k| entry(k).0), [0, 1, 2].map(|k| entry(k).1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::testing::{BOX_FACES, box_corners, cuboid};

    /// Returns a cube of edge 1 with 8 vertices, or with 24 as modellers write it for flat normals.
    fn cube(has_seams: bool) -> Mesh {
        if !has_seams {
            return cuboid([0.0; 3], [1.0; 3]);
        }
        let corners = box_corners([0.0; 3], [1.0; 3]);
        let vertices = BOX_FACES.as_flattened().iter().map(|&index| corners[index as usize]).collect();
        let faces: Vec<[u32; 4]> = (0..6).map(|face| [0, 1, 2, 3].map(|k| 4 * face + k)).collect();
        Mesh::new(vertices, &faces).unwrap()
    }

    fn longest(mesh: &Mesh) -> f64 {
        let corner = |vertex: u32| mesh.vertices()[vertex as usize];
        let edges = mesh.triangles().iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        edges.map(|edge| nalgebra::distance(&corner(edge[0]), &corner(edge[1]))).fold(0.0, f64::max)
    }

    #[test]
    fn a_refined_cube_is_closed_and_has_its_volume_with_and_without_seams() {
        for edge in [0.9, 0.3, 0.11] {
            for has_seams in [false, true] {
                let refined = cube(has_seams).refined(edge).unwrap().unwrap();
                assert!(refined.mesh.is_closed() && longest(&refined.mesh) <= edge, "{edge}");
                assert!((refined.mesh.signed_volume() - 1.0).abs() < 1e-14);
                assert_eq!(refined.sources.len(), refined.mesh.face_count());
            }
        }
    }

    #[test]
    fn new_vertices_are_the_weighted_means_of_corners_of_their_faces() {
        let mesh = cube(true);
        let refined = mesh.refined(0.2).unwrap().unwrap();
        for (&(corners, weights), vertex) in refined.points.iter().zip(&refined.mesh.vertices()[24..]) {
            let corner = |k: usize| mesh.vertices()[corners[k] as usize].coords * weights[k];
            assert!((vertex.coords - corner(0) - corner(1) - corner(2)).amax() < 1e-15);
            assert_eq!(corners.map(|corner| corner / 4), [corners[0] / 4; 3], "one face of the cube");
        }
        let new = |vertex: &&u32| **vertex >= 24;
        for (face, &(source, is_part)) in refined.mesh.faces().zip(&refined.sources) {
            assert!(is_part);
            for &vertex in face.iter().filter(new) {
                assert_eq!(refined.points[vertex as usize - 24].0[0] / 4, source);
            }
        }
    }

    #[test]
    fn small_faces_stay_whole_and_meshes_of_small_faces_the_same() {
        assert!(cube(false).refined(1.5).unwrap().is_none());
        let vertices = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [9.0, 0.0, 0.0]];
        let mesh = Mesh::new(vertices, &[vec![0, 1, 2, 3], vec![1, 4, 2]]).unwrap();
        let refined = mesh.refined(2.5).unwrap().unwrap();
        assert_eq!((refined.mesh.face(0), refined.sources[0]), (&[0, 1, 2, 3][..], (0, false)));
        assert!(refined.sources[1..].iter().all(|source| *source == (1, true)));
    }

    #[test]
    fn too_many_faces_are_an_error() {
        let error = cube(false).refined(1e-4).unwrap_err();
        assert!(error.to_string().contains("4000000 faces"), "{error}");
    }
}
