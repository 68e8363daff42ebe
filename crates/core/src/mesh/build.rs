//! Builds and scales meshes, and checks their input.

use std::sync::Arc;

use nalgebra::Point3;

use super::csr::Csr;
use super::distinct::distinct;
use super::error::MeshError;
use super::polygons::{Faces, Mesh};
use super::scale::Scale;
use super::weld::is_degenerate;
use super::{triangles, weld};

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
        let mut polygons = Csr::with_capacity(faces.len(), corner_count);
        faces.iter().for_each(|face| polygons.push(face.as_ref().iter().copied()));
        Self::build(vertices.into_iter().map(Point3::from).collect(), polygons, None)
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

    /// Builds a mesh as [`Mesh::new`] does, with the given weld in place of that of equal positions: vertices at
    /// one position can be distinct, such as those on the two sides of a crack.
    ///
    /// * `weld`: for each vertex, the lowest vertex with which it is welded, shape `(n,)`.
    pub(crate) fn from_welded(
        vertices: Vec<Point3<f64>>,
        polygons: Csr<u32>,
        weld: Vec<u32>,
    ) -> Result<Self, MeshError> {
        assert_eq!(weld.len(), vertices.len(), "one welded vertex per vertex");
        Self::build(vertices, polygons, Some(weld))
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
            let vertices = distinct(polygons.items()).len();
            return Err(MeshError::NoExtent { vertices, at: bounds.0.into() });
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
            named: Arc::default(),
        };
        Ok(if is_cut { mesh } else { mesh.or_exactly_welded() })
    }

    /// Returns the mesh with only vertices at equal positions welded if its surface then has fewer open edges.
    /// Details that are finer than the tolerance do not open a closed surface.
    fn or_exactly_welded(self) -> Self {
        let is_exact = |(vertex, &first): (&Point3<f64>, &u32)| self.vertices[first as usize] == *vertex;
        if self.vertices.iter().zip(self.weld.iter()).all(is_exact) || self.is_closed() {
            return self;
        }
        let weld = weld::weld(&self.vertices, 0.0).into();
        let exact = Self { weld, topology: Arc::default(), open: Arc::default(), ..self.clone() };
        if exact.topology().open_edges < self.topology().open_edges { exact } else { self }
    }

    /// Scales the mesh about the origin. An odd number of negative factors mirrors it; the faces then have their
    /// corners in reverse order after the first, so that their outside stays outside.
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
            faces,
            vertices: vertices.into(),
            bounds,
            topology: Arc::default(),
            open: Arc::default(),
            // Keeps the weld of the unscaled mesh, even if rounding makes two positions equal.
            ..self.clone()
        })
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
