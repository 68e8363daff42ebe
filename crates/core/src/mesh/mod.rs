//! The surface mesh: vertices, polygons, topology, volume.
//!
//! This file defines [`Mesh`]. The other files, in the order of the data flow:
//!
//! * `scale`: factors by which a model is scaled; `refine` divides large faces.
//! * `weld`: finds vertices at equal positions.
//! * `triangles`: the triangles of the faces. `polygon` triangulates a polygon in a plane.
//! * `topology`: describes a mesh. `duplicates` finds repeated faces; `measure` computes volume and area.
//! * `interior`: which points are inside; `winding_tree` computes winding numbers.
//! * `surface_tree`: closest points on a mesh.
//! * `animation`: positions of the vertices at several times.
//! * `csr`, `union_find`: data structures, also for the modules that depend on this module.

mod animation;
mod csr;
mod duplicates;
mod error;
mod interior;
mod measure;
mod needles;
mod polygon;
mod refine;
mod scale;
mod surface_tree;
mod topology;
mod triangles;
mod union_find;
mod weld;
mod winding_tree;

use std::sync::{Arc, OnceLock};

use nalgebra::Point3;

pub(crate) use animation::mix;
pub use animation::{AnimationError, MeshAnimation};
pub(crate) use csr::Csr;
pub use error::MeshError;
pub use interior::Interior;
pub(crate) use interior::OpenSurface;
pub(crate) use measure::{RelativeMeasure, signed_volume};
pub(crate) use needles::flip_needles;
pub(crate) use polygon::{Planar, distance_squared, planar_area, polygon_area, triangulate};
pub use refine::{Refine, RefinedMesh};
pub use scale::Scale;
pub(crate) use surface_tree::{ClosestPoint, SurfaceTree};
pub use topology::{Component, Topology};
pub(crate) use union_find::UnionFind;
pub(crate) use winding_tree::WindingTree;

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
    vertices: Arc<[Point3<f64>]>,
    faces: Arc<Faces>,
    /// For each vertex, the first vertex with which it is welded.
    weld: Arc<[u32]>,
    /// Whether the mesh is cut: then no face counts as repeated, because both sides of a crack can have it.
    is_cut: bool,
    bounds: (Point3<f64>, Point3<f64>),
    topology: Arc<OnceLock<Topology>>,
    /// The parts of an open surface.
    open: Arc<OnceLock<OpenSurface>>,
}

/// The polygons of a mesh, and their triangles.
#[derive(Debug)]
struct Faces {
    /// The corners of each polygon, as vertex indices.
    polygons: Csr<u32>,
    triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// Builds a mesh from vertices, shape `(n, 3)`, and faces. A face lists its corners as vertex indices,
    /// counted from 0.
    ///
    /// ```
    /// let vertices = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
    /// let mesh = supple::Mesh::new(vertices, &faces)?;
    /// assert!(mesh.is_closed());
    /// assert!((mesh.volume() - 1.0 / 6.0).abs() < 1e-15);
    /// # Ok::<(), supple::MeshError>(())
    /// ```
    ///
    /// # Errors
    /// If an index is out of range, if a coordinate is not finite or outside the range of `f32`, if no face
    /// has three distinct corners, if all vertices of the faces are at one point, or if there are more than
    /// 2^32 - 2 vertices or corners. Any other input is accepted and described by [`Mesh::topology`].
    pub fn new<F: AsRef<[u32]>>(vertices: Vec<[f64; 3]>, faces: &[F]) -> Result<Self, MeshError> {
        let corner_count = faces.iter().map(|face| face.as_ref().len()).sum();
        check_count("corners of faces", corner_count)?;
        let mut offsets = Vec::with_capacity(faces.len() + 1);
        let mut corners = Vec::with_capacity(corner_count);
        offsets.push(0);
        for face in faces {
            corners.extend_from_slice(face.as_ref());
            offsets.push(corners.len() as u32);
        }
        Self::from_flat(vertices.into_iter().map(Point3::from).collect(), offsets, corners)
    }

    /// Builds a mesh as [`Mesh::new`] does, from faces in one array. The corners of face `f` are
    /// `corners[offsets[f]..offsets[f + 1]]`.
    ///
    /// # Errors
    /// Fails in the same cases as [`Mesh::new`].
    ///
    /// # Panics
    /// If `offsets` does not begin with 0, is not sorted, or does not end with the number of corners.
    pub fn from_flat(
        vertices: Vec<Point3<f64>>,
        offsets: Vec<u32>,
        corners: Vec<u32>,
    ) -> Result<Self, MeshError> {
        Self::build(vertices, Csr::from_parts(offsets, corners), None)
    }

    /// Builds a mesh as [`Mesh::from_flat`] does, with the given weld in place of that of equal positions: vertices at
    /// one position can be distinct, such as those on the two sides of a crack.
    ///
    /// * `weld`: for each vertex, the lowest vertex with which it is welded, shape `(n,)`.
    pub(crate) fn from_welded(
        vertices: Vec<Point3<f64>>,
        offsets: Vec<u32>,
        corners: Vec<u32>,
        weld: Vec<u32>,
    ) -> Result<Self, MeshError> {
        assert_eq!(weld.len(), vertices.len(), "one welded vertex per vertex");
        Self::build(vertices, Csr::from_parts(offsets, corners), Some(weld))
    }

    /// Builds a mesh. Vertices at equal positions are welded unless `weld` is given.
    fn build(
        vertices: Vec<Point3<f64>>,
        polygons: Csr<u32>,
        weld: Option<Vec<u32>>,
    ) -> Result<Self, MeshError> {
        check_count("vertices", vertices.len())?;
        check_finite(&vertices)?;
        check_indices(&polygons, vertices.len())?;
        let bounds = bounds(&vertices, polygons.items());
        let extent = bounds.map_or(0.0, |(low, high)| (high - low).amax());
        let is_cut = weld.is_some();
        let weld = weld.unwrap_or_else(|| weld::weld(&vertices, weld::tolerance(&vertices, extent)));
        let triangles = triangles::of_polygons(&vertices, &polygons);
        let no_faces = MeshError::NoFaces { faces: polygons.len(), vertices: vertices.len() };
        let (Some(bounds), false) = (bounds, triangles.is_empty()) else { return Err(no_faces) };
        if bounds.0 == bounds.1 {
            let mut used = polygons.items().to_vec();
            used.sort_unstable();
            used.dedup();
            return Err(MeshError::NoExtent { vertices: used.len(), at: bounds.0.into() });
        }
        if polygons.rows().all(|face| is_degenerate(face, &weld)) {
            return Err(no_faces);
        }
        let mesh = Self {
            vertices: vertices.into(),
            faces: Arc::new(Faces { polygons, triangles }),
            weld: weld.into(),
            is_cut,
            bounds,
            topology: Arc::default(),
            open: Arc::default(),
        };
        Ok(if is_cut { mesh } else { mesh.or_exactly_welded() })
    }

    /// Returns the mesh with only vertices at equal positions welded if its surface then has fewer open edges. Details that
    /// are finer than the tolerance do not open a closed surface.
    fn or_exactly_welded(self) -> Self {
        let is_exact = |(vertex, &first): (&Point3<f64>, &u32)| self.vertices[first as usize] == *vertex;
        if self.vertices.iter().zip(self.weld.iter()).all(is_exact) || self.is_closed() {
            return self;
        }
        let weld = weld::weld(&self.vertices, 0.0).into();
        let exact = Self { weld, topology: Arc::default(), open: Arc::default(), ..self.clone() };
        if exact.topology().open_edges < self.topology().open_edges { exact } else { self }
    }

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
    /// A face with `n >= 3` corners gives `n - 2` triangles: a fan from its first corner, or ears if the face is concave
    /// and triangles of its fan would lie outside of it.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.faces.triangles
    }

    /// Returns whether the triangles of all faces are fans from their first corners, which programs assume that read
    /// polygons.
    pub fn is_fanned(&self) -> bool {
        triangles::are_fans(&self.faces.triangles, &self.faces.polygons)
    }

    /// Returns the triangles of the surface: those of [`Mesh::triangles`], with each repeated face once; see [`Topology`].
    pub(crate) fn surface(&self) -> &[[u32; 3]] {
        self.topology().surface.as_deref().unwrap_or(self.triangles())
    }

    /// Returns the bounding box of the vertices that faces use: its lowest and its highest corner.
    pub fn bounds(&self) -> (Point3<f64>, Point3<f64>) {
        self.bounds
    }

    /// Returns, for each vertex, the first vertex at the same position, shape `(n,)`. Positions are the same if they differ,
    /// along each axis, by at most 4 units in the last place of the greatest coordinate: of `f32` if all coordinates are
    /// values of `f32`, else of `f64`. In a mesh that a crack cuts, vertices on different sides of the crack are distinct.
    pub fn weld(&self) -> &[u32] {
        &self.weld
    }

    /// Returns the description of the surface. It is computed at the first call and cached.
    pub fn topology(&self) -> &Topology {
        self.topology.get_or_init(|| Topology::new(self))
    }

    /// Returns whether the surface is closed. It is closed if, with equal positions welded, the faces use
    /// each edge equally often in both directions.
    pub fn is_closed(&self) -> bool {
        self.topology().open_edges == 0
    }

    /// Returns the rule by which points are inside the surface. It is found at the first call and cached.
    pub fn interior(&self) -> Interior {
        match self.open_surface() {
            None => Interior::Closed,
            Some(OpenSurface { solid: Some(_), .. }) => Interior::WindingNumber,
            Some(OpenSurface { solid: None, .. }) => Interior::Sheet,
        }
    }

    /// Returns the parts of the surface, or `None` if it is closed.
    pub(crate) fn open_surface(&self) -> Option<&OpenSurface> {
        (!self.is_closed()).then(|| self.open.get_or_init(|| OpenSurface::new(self)))
    }

    /// Returns the enclosed volume, in cubed units of length. It is never negative.
    ///
    /// For an open mesh this is the magnitude of the sum of the signed volumes of the tetrahedra from the
    /// center of the bounding box to the triangles, which has little meaning.
    pub fn volume(&self) -> f64 {
        self.signed_volume().abs()
    }

    /// Returns the volume as [`Mesh::volume`] does, but negative if the faces are clockwise seen from
    /// outside.
    pub fn signed_volume(&self) -> f64 {
        self.topology().signed_volume
    }

    /// Scales the mesh about the origin. An odd number of negative factors mirrors it; the faces then have their corners
    /// in reverse order after the first, so that their outside stays outside.
    ///
    /// # Errors
    /// If the scale is invalid (see [`Scale`]), or if the scaled mesh has a coordinate outside the range of `f32` or no
    /// extent.
    pub fn scaled(&self, scale: impl Into<Scale>) -> Result<Self, MeshError> {
        let scale: Scale = scale.into();
        if !scale.is_valid() {
            return Err(MeshError::Scale(scale));
        }
        if scale == Scale::Uniform(1.0) {
            return Ok(self.clone());
        }
        let vertices: Vec<_> = self.vertices.iter().map(|vertex| scale.apply(vertex)).collect();
        check_finite(&vertices)?;
        let corners = [self.bounds.0, self.bounds.1].map(|corner| scale.apply(&corner));
        let bounds = (corners[0].inf(&corners[1]), corners[0].sup(&corners[1]));
        if bounds.0 == bounds.1 {
            return Err(MeshError::NoExtent { vertices: vertices.len(), at: bounds.0.into() });
        }
        let faces = if scale.is_mirror() {
            let mut polygons = self.faces.polygons.clone();
            for face in 0..polygons.len() {
                if let Some(after_first) = polygons.row_mut(face).get_mut(1..) {
                    after_first.reverse();
                }
            }
            let triangles = triangles::of_polygons(&vertices, &polygons);
            Arc::new(Faces { polygons, triangles })
        } else {
            self.faces.clone()
        };
        Ok(Self {
            // Keeps the weld of the unscaled mesh, even if rounding makes two positions equal.
            weld: self.weld.clone(),
            is_cut: self.is_cut,
            faces,
            vertices: vertices.into(),
            bounds,
            topology: Arc::default(),
            open: Arc::default(),
        })
    }

    /// Returns the vertex indices of the corners of a face.
    pub(crate) fn face(&self, face: usize) -> &[u32] {
        self.faces.polygons.row(face)
    }

    /// Returns the corners of all faces, face by face.
    fn corners(&self) -> &[u32] {
        self.faces.polygons.items()
    }

    /// Returns the center of the bounding box.
    fn center(&self) -> Point3<f64> {
        nalgebra::center(&self.bounds.0, &self.bounds.1)
    }

    /// Returns the sum of the signed volumes of the tetrahedra from the center of the bounding box to
    /// `triangles`, a subset of the triangles.
    fn volume_of(&self, triangles: &[[u32; 3]]) -> f64 {
        let center = self.center();
        signed_volume(triangles, |vertex| self.vertices[vertex as usize] - center)
    }
}

/// Returns an error if `count` exceeds the range of 32-bit indices. `what`: name of the items.
fn check_count(what: &'static str, count: usize) -> Result<(), MeshError> {
    // Index tables use `u32::MAX` for "no entry".
    if count < u32::MAX as usize { Ok(()) } else { Err(MeshError::TooLarge { what, count }) }
}

/// Returns an error if a coordinate is not finite in `f32`.
fn check_finite(vertices: &[Point3<f64>]) -> Result<(), MeshError> {
    for (vertex, point) in vertices.iter().enumerate() {
        for (axis, &value) in ['x', 'y', 'z'].into_iter().zip(point.coords.iter()) {
            if !(value as f32).is_finite() {
                return Err(MeshError::NotFinite { vertex, axis, value });
            }
        }
    }
    Ok(())
}

/// Returns an error if a corner of a polygon is not the index of one of `count` vertices.
fn check_indices(polygons: &Csr<u32>, count: usize) -> Result<(), MeshError> {
    match polygons.items().iter().position(|&corner| corner as usize >= count) {
        None => Ok(()),
        Some(corner) => {
            let (face, vertex) = (polygons.row_of(corner), polygons.items()[corner]);
            Err(MeshError::IndexOutOfRange { face, vertex, count })
        }
    }
}

/// Returns the bounding box of the vertices that faces use, or `None` if there are no corners.
fn bounds(vertices: &[Point3<f64>], corners: &[u32]) -> Option<(Point3<f64>, Point3<f64>)> {
    let used = corners.iter().map(|&corner| vertices[corner as usize]);
    let grow =
        |(low, high): (Point3<f64>, Point3<f64>), point: Point3<f64>| (low.inf(&point), high.sup(&point));
    used.fold(None, |bounds, point| Some(grow(bounds.unwrap_or((point, point)), point)))
}

/// Returns whether a face has fewer than three distinct welded corners.
fn is_degenerate(face: &[u32], weld: &[u32]) -> bool {
    let Some(&first) = face.first() else { return true };
    let first = weld[first as usize];
    let mut others = face.iter().map(|&corner| weld[corner as usize]).filter(|&corner| corner != first);
    let Some(second) = others.next() else { return true };
    others.all(|corner| corner == second)
}
