//! Defines the fracture of `supple.Body`.

use numpy::{PyArray1, PyArray2};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use supple_io::scene::BodyData;

use super::Body;
use crate::{arrays, constraint, error, keys};

/// Returns the error that a bare lattice has no faces.
fn no_mesh() -> PyErr {
    PyValueError::new_err("the body is a bare lattice without a mesh; it has no faces")
}

properties! {
    /// Number of pieces: connected components of the lattice.
    pieces: usize = supple::Body::pieces;
    /// Number of broken joints. A joint is the common face of two cells.
    broken_joints: usize = supple::Body::broken_joints;
    /// Number of steps and cuts in which joints broke.
    ///
    /// While it stays the same, so do faces, lattice, and the lengths of arrays. When it grows, the vertices of the whole
    /// body keep their numbers, in the lattice and in the mesh, and copies follow them. The numbers of copies can
    /// change each time. Restoring a state restores it too.
    topology_version: u64 = supple::Body::topology_version;
}

#[pymethods]
impl Body {
    /// Fracture: a dict with strength or strain, rotation, cracks, noise, seed and surface; None if the body breaks
    /// only where it is cut.
    #[getter]
    fn fracture<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let fracture = self.read(py, |body| body.fracture().copied())?;
        keys::of_body(py, &BodyData { fracture, ..BodyData::default() }, "fracture")
    }

    /// Cut the body along a plane: break all joints between cells on different sides of it. Returns their number.
    ///
    /// plane : Plane, pair (point, normal), or dict with point and normal
    ///     In world space. It is carried to the rest shape by the affine motion that fits the body best, so that it is
    ///     met exactly where the body is not bent. The keyframes of a Plane have no effect.
    ///
    /// Vertices on the cut get copies, so that arrays with one row per lattice vertex or mesh vertex grow: see
    /// topology_version. Raises ValueError for a normal of zero.
    fn cut(&self, plane: &Bound<'_, PyAny>) -> PyResult<usize> {
        let [point, normal] = constraint::plane(plane)?;
        self.with(plane.py(), |body| body.cut(point, normal))?.map_err(error::value)
    }

    /// Triangles of the displayed surface as it is now: (m, 3) int64, read-only. Larger faces are fanned from their
    /// first vertex. The surfaces of cracks come last.
    ///
    /// Raises ValueError for a bare lattice, which has no mesh.
    #[getter]
    fn faces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i64>>> {
        let mesh = self.mesh(py)?.ok_or_else(no_mesh)?;
        Ok(mesh.get().faces(py).clone())
    }

    /// Piece of each vertex of the displayed surface, from 0: (k,) int64, read-only. Pieces are numbered by their
    /// first lattice vertices.
    ///
    /// Raises ValueError for a bare lattice, which has no mesh.
    #[getter]
    fn piece_of_vertex<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i64>>> {
        let pieces = self.read(py, supple::Body::piece_of_mesh_vertices)?.ok_or_else(no_mesh)?;
        Ok(arrays::frozen(PyArray1::from_iter(py, pieces.into_iter().map(i64::from))))
    }
}
