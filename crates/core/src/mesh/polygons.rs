//! The arrays of a mesh.

use std::sync::{Arc, OnceLock};

use nalgebra::{Matrix3, Point3};

use super::csr::Csr;
use super::description::{OpenSurface, Topology};
use super::triangles;
use super::union_find::UnionFind;
use super::volume::{signed_volume, volume_moments};

/// A surface mesh: vertices in `f64` and polygons of any size.
///
/// Each polygon is also available as triangles, of a convex polygon a fan from its first corner:
///
/// ```text
///     d---c          face   [a, b, c, d]
///     | / |   ->     triangles [a, b, c], [a, c, d]
///     a---b          counter-clockwise seen from outside
/// ```
///
/// Cloning is cheap: the arrays are shared.
#[derive(Clone, Debug)]
pub struct Mesh {
    pub(super) vertices: Arc<[Point3<f64>]>,
    pub(super) faces: Arc<Faces>,
    /// For each vertex, the first vertex with which it is welded.
    pub(super) weld: Arc<[u32]>,
    /// Whether the mesh is cut: then no face counts as repeated, because both sides of a crack can have it.
    pub(super) is_cut: bool,
    pub(super) bounds: (Point3<f64>, Point3<f64>),
    pub(super) topology: Arc<OnceLock<Topology>>,
    /// The parts of an open surface.
    pub(super) open: Arc<OnceLock<OpenSurface>>,
    /// See [`Mesh::with_groups`] and [`Mesh::with_maps`].
    pub(super) named: Arc<Named>,
}

/// The named groups and maps of a mesh, in the order of their names.
#[derive(Clone, Debug, Default)]
pub(super) struct Named {
    pub(super) groups: Vec<(String, Vec<u32>)>,
    pub(super) maps: Vec<(String, Vec<f32>)>,
}

/// The polygons of a mesh, and their triangles.
#[derive(Debug)]
pub(super) struct Faces {
    /// The corners of each polygon, as vertex indices.
    pub(super) polygons: Csr<u32>,
    pub(super) triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Returns the vertices in input order, including vertices that no face uses.
    pub fn vertices(&self) -> &[Point3<f64>] {
        &self.vertices
    }

    /// Returns the number of faces, including degenerate ones.
    pub fn face_count(&self) -> usize {
        self.faces.polygons.len()
    }

    /// Iterates over the faces in input order. A face is the list of the vertex indices of its corners.
    pub fn faces(&self) -> impl ExactSizeIterator<Item = &[u32]> + Clone {
        self.faces.polygons.rows()
    }

    /// Returns the triangles of the faces, in the order of the faces.
    ///
    /// A face with `n >= 3` corners gives `n - 2` triangles: a fan from its first corner, or ears if the face is
    /// concave and triangles of its fan would lie outside of it.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.faces.triangles
    }

    /// Returns whether the triangles of all faces are fans from their first corners, which programs assume that read
    /// polygons.
    pub fn is_fanned(&self) -> bool {
        triangles::are_fans(&self.faces.triangles, &self.faces.polygons)
    }

    /// Returns the bounding box of the vertices that faces use: its lowest and its highest corner.
    pub fn bounds(&self) -> (Point3<f64>, Point3<f64>) {
        self.bounds
    }

    /// Returns, for each vertex, the first vertex at the same position, shape `(n,)`. Positions are the same if they
    /// differ, along each axis, by at most 4 units in the last place of the greatest coordinate: of `f32` if all
    /// coordinates are values of `f32`, else of `f64`. In a mesh that a crack cuts, vertices on different sides of
    /// the crack are distinct.
    pub fn weld(&self) -> &[u32] {
        &self.weld
    }

    /// Returns the component of each vertex: vertices that faces connect, directly or through others, have the same
    /// number, as have vertices that are welded. A vertex without faces is a component. Shape `(n,)`.
    pub fn component_of_vertices(&self) -> Vec<u32> {
        let (_, labels) = self.face_components();
        self.weld.iter().map(|&first| labels[first as usize]).collect()
    }

    /// Returns the number of labels, and the label of the component of each vertex that [`weld`](Self::weld) gives.
    /// Every other vertex has a label of its own.
    pub(crate) fn face_components(&self) -> (usize, Vec<u32>) {
        let mut sets = UnionFind::new(self.weld.len());
        for edge in self.faces().flat_map(|face| face.windows(2)) {
            sets.unite(self.weld[edge[0] as usize], self.weld[edge[1] as usize]);
        }
        sets.labels()
    }

    /// Returns the vertex indices of the corners of a face.
    pub(crate) fn face(&self, face: usize) -> &[u32] {
        self.faces.polygons.row(face)
    }

    /// Returns the corners of all faces, face by face.
    pub(super) fn corners(&self) -> &[u32] {
        self.faces.polygons.items()
    }

    /// Returns the center of the bounding box.
    pub(super) fn center(&self) -> Point3<f64> {
        nalgebra::center(&self.bounds.0, &self.bounds.1)
    }

    /// Returns the sum of the signed volumes of the tetrahedra from the center of the bounding box to
    /// `triangles`, a subset of the triangles.
    pub(super) fn volume_of(&self, triangles: &[[u32; 3]]) -> f64 {
        let center = self.center();
        signed_volume(triangles, |vertex| self.vertices[vertex as usize] - center)
    }

    /// Returns the second moments of the volume about its center, relative to the volume, of a closed mesh.
    pub(crate) fn second_moments(&self) -> Matrix3<f64> {
        self.volume_moments().2
    }

    /// Returns the volume of a closed mesh, its center, and its second moments about the center, relative to the volume.
    pub(crate) fn volume_moments(&self) -> (f64, Point3<f64>, Matrix3<f64>) {
        let middle = self.center();
        let (volume, center, moments) =
            volume_moments(self.triangles(), |vertex| self.vertices[vertex as usize] - middle);
        (volume, middle + center, moments)
    }
}
